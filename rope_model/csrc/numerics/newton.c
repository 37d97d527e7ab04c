/* Convergence of Newton's method.  C version of rope_model/numerics/newton.py. */

#include "rope_system.h"

Progress newton_judge(Progress before, double norm, double tolerance, int fresh, const NewtonLimits *limits) {
    const double contraction = before.norm > 0 ? norm / before.norm : 0;
    const int first = before.iterations < 1, sure = !first && contraction < limits->unsure;
    const double guess = first ? before.contraction * norm : norm;
    Progress after = {
        TOO_MANY,    before.iterations + 1, 1, norm, sure ? contraction / (1 - contraction) * norm : guess,
        contraction, before.sum + norm};
    if (!(norm < NEWTON_HUGE)) {
        after.status = NOT_FINITE;
        after.error = INFINITY;
    } else if (!sure && !fresh) { /* a new factorization is due */
        after.applies = 0;
        after.norm = before.norm;
        after.sum = before.sum;
        after.error = after.contraction = INFINITY;
    } else if (!first && contraction >= limits->growing) {
        after.status = DIVERGED;
    } else if (after.error <= tolerance) {
        after.status = CONVERGED;
    }
    return after;
}

Progress newton_repeated(Progress progress, int corrections) {
    if (progress.status == NOT_FINITE) return progress;
    progress.status = progress.iterations < corrections ? TOO_MANY : CONVERGED;
    progress.applies = 1;
    return progress;
}
