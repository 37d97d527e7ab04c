/* The last communication step, to be taken again with other motions of the ends. */
#ifndef SENSITIVITY_H
#define SENSITIVITY_H

#include <stdbool.h>
#include <stddef.h>

#include "state_structures.h"
#include "switching.h"

/* An internal step: its length and its end, s, Newton's corrections, and the phases in it and after it. */
typedef struct {
    double h, t;
    int corrections;
    Phases during, after;
} TakenStep;
enum { MAX_TAKEN = 4096 }; /* internal steps of a communication step that can be differentiated */

/* The last communication step, to be taken again with other motions of the ends: outputs/sensitivity.c. */
typedef struct {
    bool recording, repeating; /* true while it is recorded, or taken again */
    bool known;                /* true if the rest is that of the last step */
    int count;                 /* number of internal steps */
    int corrections;           /* of the step that is taken again */
    int fidelity;              /* at its end */
    Phases after;              /* at its end */
    double duration;           /* s */
    TakenStep *steps;          /* (MAX_TAKEN) */
    EndPath paths[2];
    bool at_step_end; /* true if the derivatives are those to inputs of the step's end */
    unsigned derived; /* bit i: the derivatives to input i are known */
    size_t repeats;   /* number of communication steps that were recorded or taken again, since the rope was created */
    double derivatives[2 * END_MOTIONS][2 * 6];
} Replay;

void added_mass_signals(Simulator *sim, double *values); /* compute of a SignalGroup */

#endif
