/* Trial steps, and what a step that is accepted changes. */
#ifndef TRIAL_STEP_H
#define TRIAL_STEP_H

#include "generalized_alpha.h"
#include "state_structures.h"

StepResult compute_trial(Simulator *sim, State *state, double h);
void restart_motion(Simulator *sim, State *state);
double largest_end_force(const NodalArrays *nodal); /* Return the largest component, N. */
void commit_trial(Simulator *sim, State *state, const StepResult *trial);
void rope_powers(const Scene *scene, State *state);
double rope_energies(Simulator *sim, State *state); /* Update energies; return the change of their total. */
/* Return the arc length of the loop's lowest point from the heights of the ends at t. */
double bottom_arc_length(const Scene *scene, const EndPath paths[2], double t);
/* Call mesh_dividers with the heights of the ends at t. */
void dividers_on_rope(const Scene *scene, const EndPath paths[2], double t, double *divider_s);
/* Refer frames and angles of q, v, a, b to q. */
void update_angles(Simulator *sim, State *state, double *q, double *v, double *a, double *b);
void begin_audit(const Simulator *sim, State *state);
/* Audit a communication step of length h; residual_before is the residual of the energy balance at its start. */
void audit_interval(const Simulator *sim, State *state, double h, double residual_before);

#endif
