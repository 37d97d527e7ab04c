/* Rigid rope, the lowest fidelity; s (nodes) are arc lengths of the nodes, m; q, v, a and reaction are nodes x DOF. */
#ifndef RIGID_H
#define RIGID_H

#include "state_structures.h"

RopeStatus rigid_rope(const Scene *scene, const EndMotion ends[2], double t, int nodes, const double *s, double *q,
                      double *v, double *a, double *reaction, double *kinetic, double *gravity, char *message);
/* Tension (points), N, at arc lengths `places` with heights y. */
void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension);
/* Set q, v, a and reaction from equilibria between the moving ends, referred to the rigid rope. */
RopeStatus flexible_start(Simulator *sim, State *state, char *message);

#endif
