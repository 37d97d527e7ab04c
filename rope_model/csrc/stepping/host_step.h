/* One communication step. */
#ifndef HOST_STEP_H
#define HOST_STEP_H

#include "communication_step.h"
#include "rope.h"

/* Take the host's step from sim->state to sim->next.  *event becomes true if an event has ended it. */
RopeStatus take_host_step(Simulator *sim, const HostStep *host, int *event);

#endif
