/* Values of the rope's outputs. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include "rope.h"

typedef struct {
    int index;
    void (*compute)(Simulator *, double *); /* writes the values of the group into (SIGNALS) */
} SignalGroup;
SignalGroup group_of(int signal);

#endif
