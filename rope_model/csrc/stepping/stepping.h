/* One step of the rope. */
#ifndef STEPPING_H
#define STEPPING_H

#include "sensitivity.h"
#include "state_structures.h"

int as_rigid(Simulator *sim, State *state, double t, char *message);         /* Move the rigid model to t. */
int step_towards(Simulator *sim, State *state, double t_end, char *message); /* Take one accepted step. */
/* Take the recorded step of the replay again, from a state nearby. */
int repeat_step(Simulator *sim, State *state, const TakenStep *step, char *message);

#endif
