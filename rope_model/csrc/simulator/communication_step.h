/* One communication step: what the host asked for, and the internal steps that were taken, so that it can be taken
   again with other motions of the ends. */
#ifndef COMMUNICATION_STEP_H
#define COMMUNICATION_STEP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rope.h"
#include "state_structures.h"

/* What the host asked for in a communication step.  All members have eight bytes: none is padding. */
typedef struct {
    double stop;       /* time to advance to, s */
    double given_at;   /* instant of the motions, s */
    double asked_at;   /* the same, as the host gave it: motions held through an event keep their first instant */
    EndMotion ends[2]; /* motions */
    int64_t to_event;  /* true if an event ends it */
    int64_t taken;     /* true if it led from Simulator.start to Simulator.state */
} HostStep;

/* Phases of both swivels, and the senses of their slips. */
typedef struct {
    signed char phase[2];
    signed char sign[2];
} Phases;

/* An internal step. */
typedef struct {
    double h;        /* length, s */
    double t;        /* end, s */
    int corrections; /* of Newton's method */
    Phases during;
    Phases after;
} TakenStep;
enum { MAX_TAKEN = 4096 }; /* internal steps of a communication step that can be differentiated */

/* The last communication step, to be taken again: outputs/sensitivity.c. */
typedef struct {
    bool recording;   /* true while it is recorded */
    bool repeating;   /* true while it is taken again */
    bool known;       /* true if the rest is that of the last step */
    int count;        /* number of internal steps */
    int corrections;  /* of the step that is taken again */
    int fidelity;     /* at its end */
    Phases after;     /* at its end */
    double duration;  /* s */
    TakenStep *steps; /* (MAX_TAKEN) */
    EndPath paths[2];
    bool at_step_end; /* true if the derivatives are those to inputs of the step's end */
    unsigned derived; /* bit i: the derivatives to input i are known */
    size_t repeats;   /* number of communication steps that were recorded or taken again, since the rope was created */
    double derivatives[2 * END_MOTIONS][2 * 6];
} Replay;

#endif
