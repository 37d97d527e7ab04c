/* Rigid rope, the lowest fidelity. */
#ifndef RIGID_H
#define RIGID_H

#include "state_structures.h"

/* Initial shape q of a rope between two suspension points. */
RopeStatus hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q,
                         char *message);
/* Set q, v, a and reaction of the nodes at the arc lengths s of `nodal`, and energies of the balance. */
RopeStatus rigid_rope(const Scene *scene, const EndMotion ends[2], double t, const NodalArrays *nodal,
                      EnergyBalance *energy_balance, char *message);
/* Tension (points), N, at arc lengths `places` with heights y. */
void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension);

#endif
