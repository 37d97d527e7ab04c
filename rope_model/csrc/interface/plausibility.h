/* Whether restored bytes can be a state of a rope. */
#ifndef PLAUSIBILITY_H
#define PLAUSIBILITY_H

#include <stdbool.h>

#include "communication_step.h"
#include "simulator.h"
#include "state_structures.h"

/* True if the step can have led from `start` to `state`. */
bool host_step_plausible(const HostStep *host, const State *start, const State *state);
/* True if restored bytes can be a state of this rope.  Overwrites sim->work.trial. */
bool state_plausible(const Simulator *sim, State *state);

#endif
