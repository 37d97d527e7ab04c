/* Equations of motion of a state. */
#ifndef ROPE_SYSTEM_H
#define ROPE_SYSTEM_H

#include "contact_balance.h"
#include "state_structures.h"
#include "system.h"

/* Return the equations of a state to which the reference belongs. */
System rope_system(const Simulator *sim, State *state);
void rope_system_refer(Simulator *sim, State *state, const double *q); /* Refer frames, curvature, wires to q. */
/* Let the reference belong to a copy of the state that it belongs to. */
void rope_system_adopt(Simulator *sim, const State *state);
/* Refer frames and angles to q; return the change of theta at the right end. */
double rope_system_transport(Simulator *sim, State *state, double *q, double *v, double *a, double *b);
/* Set prescribed entries at t of q, v and a in x, or of the first `orders` of them. */
void rope_system_prescribed_motion(const Scene *scene, const State *state, double t, int orders, double *const x[]);
void rope_system_strains(Simulator *sim); /* Strains of the present state, into sim->work.strains. */

/* Sum the contact of all elements with bodies and of the rope with itself. */
void external_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);

#endif
