/* Judgement of the corrections of Newton's method. */
#ifndef NEWTON_H
#define NEWTON_H

#include <stdbool.h>

#include "formulas.h"

typedef struct {
    NewtonStatus status;
    int iterations;     /* corrections so far */
    bool applies;       /* true if the latest correction applies */
    double norm;        /* norm of the latest correction that applied */
    double error;       /* error estimate after it */
    double contraction; /* ratio of the latest norms; before the first correction the share of it assumed to remain */
    double sum;         /* sum of the norms of corrections that applied */
} Progress;

/* Judge a correction of this norm; `fresh` is true if its factorization is new. */
Progress newton_judge(Progress before, double norm, double tolerance, bool fresh, const NewtonLimits *limits);
/* Let the iteration end after that number of corrections. */
Progress newton_repeated(Progress progress, int corrections);

#endif
