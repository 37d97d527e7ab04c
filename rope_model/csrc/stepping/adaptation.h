/* Changes of mesh and fidelity during a run. */
#ifndef ADAPTATION_H
#define ADAPTATION_H

#include "formulas.h"
#include "state_structures.h"

/* Transform the mesh as often as due; return the status of Newton's method.  The state is void unless CONVERGED. */
NewtonStatus transform_if_due(Simulator *sim, State *state);
void update_loop_yaw(State *state);
RopeStatus raise_fidelity(Simulator *sim, State *state, const char *why, char *message);

#endif
