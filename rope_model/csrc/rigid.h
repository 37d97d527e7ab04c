/* Rigid rope, the lowest fidelity. */
#ifndef RIGID_H
#define RIGID_H

#include "state_structures.h"

/* Set q, v, a and reaction of the nodes at the arc lengths s of `nodal`, and energies of the balance. */
RopeStatus rigid_rope(const Scene *scene, const EndMotion ends[2], double t, const NodalArrays *nodal,
                      EnergyBalance *energy_balance, char *message);
/* Tension (points), N, at arc lengths `places` with heights y. */
void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension);
/* Set q, v, a and reaction from equilibria between the moving ends, referred to the rigid rope. */
RopeStatus flexible_start(Simulator *sim, State *state, char *message);

#endif
