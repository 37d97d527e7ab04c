/* Newton's method, how it goes on and how it ended: rope_model.numerics.newton. */
#ifndef NEWTON_H
#define NEWTON_H

/* of NewtonStatus */
enum { TOO_MANY, CONVERGED, DIVERGED, NOT_FINITE };

typedef struct {
    int status, iterations, applies;      /* applies: whether the latest correction does */
    double norm, error, contraction, sum; /* sum: of the norms of all that did */
} Progress;

typedef struct {
    double rounds, per_round, slow, unsure, growing, first;
} Rules;

/* after a correction of this norm; fresh: whether its factorization is new */
Progress newton_judge(Progress before, double norm, double tolerance, int fresh, const Rules *rules);
const char *newton_text(int status);

#endif
