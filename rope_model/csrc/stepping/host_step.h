/* One communication step. */
#ifndef HOST_STEP_H
#define HOST_STEP_H

#include <stdint.h>

#include "rope.h"

/* What the host asked for in a communication step.  All members have eight bytes: none is padding. */
typedef struct {
    double stop;       /* time to advance to, s */
    double given_at;   /* instant of the motions, s */
    double asked_at;   /* the same, as the host gave it: motions held through an event keep their first instant */
    EndMotion ends[2]; /* motions */
    int64_t to_event;  /* true if an event ends it */
    int64_t taken;     /* true if it led from Simulator.start to Simulator.state */
} HostStep;

/* Take the host's step from sim->state to sim->next.  *event becomes true if an event has ended it. */
RopeStatus take_host_step(Simulator *sim, const HostStep *host, int *event);

#endif
