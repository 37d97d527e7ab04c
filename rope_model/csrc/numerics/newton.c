/* Convergence of Newton's method.

   A full correction comes first, then cheap ones with the same factorization.

   The error after correction k is estimated from the contraction theta = d_k / d_{k-1} of the corrections' norms,
   error <= theta / (1 - theta) d_k (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8). A round
   begins with a new factorization and continues with it while the contraction pays; a slow round is followed by
   another. */

#include "newton.h"

#include <math.h>
#include <stdbool.h>

#include "formulas.h"

Progress newton_judge(Progress before, double norm, double tolerance, bool fresh, const NewtonLimits *limits) {
    const double contraction = before.norm > 0 ? norm / before.norm : 0;
    const bool first = before.iterations < 1;
    const bool sure = !first && contraction < limits->unsure;
    const double guess = first ? before.contraction * norm : norm;
    Progress after = {
        .status = TOO_MANY,
        .iterations = before.iterations + 1,
        .applies = true,
        .norm = norm,
        .error = sure ? contraction / (1 - contraction) * norm : guess,
        .contraction = contraction,
        .sum = before.sum + norm,
    };
    if (!(norm < NEWTON_HUGE)) {
        after.status = NOT_FINITE;
        after.error = INFINITY;
    } else if (!sure && !fresh) { /* a new factorization is due */
        after.applies = false;
        after.norm = before.norm;
        after.sum = before.sum;
        after.error = INFINITY;
        after.contraction = INFINITY;
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
    progress.applies = true;
    return progress;
}
