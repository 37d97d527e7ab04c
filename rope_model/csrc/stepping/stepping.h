/* One step of the rope. */
#ifndef STEPPING_H
#define STEPPING_H

#include "communication_step.h"
#include "state_structures.h"

RopeStatus as_rigid(Simulator *sim, State *state, double t, char *message);         /* Move the rigid model to t. */
RopeStatus step_towards(Simulator *sim, State *state, double t_end, char *message); /* Take one accepted step. */
/* Take the recorded step of the replay again, from a state nearby. */
RopeStatus repeat_step(Simulator *sim, State *state, const TakenStep *step, char *message);

#endif
