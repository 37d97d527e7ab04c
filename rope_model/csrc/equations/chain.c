/* Choice between the forms of the chains, their memory, and the norm of their corrections. */

#include "chain.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "formulas.h"
#include "lanes.h"
#include "obstacles.h"
#include "processor.h"
#include "rope.h"
#include "state.h"
#include "system.h"

/* The torsional chain is the largest: a tangent has `most` entries, and a step as many for either end. */
size_t chain_work_bytes(int elements) {
    const size_t n = (size_t)elements;
    const size_t most = DOF * (2 * DOF + 1);
    return sizeof(double) * ((n + MAX_LANES) * most + (n + 1) * 2 * DOF) + sizeof(Vec2) * most * ((n + 1) / SWEEPS + 1);
}

size_t chain_frames_bytes(int elements) {
    return sizeof(double) * ELEMENT_FRAME_SIZE * ((size_t)elements + MAX_LANES - 1);
}

extern const Chain chains_plain[3];
extern const Chain chains_wide[3];
extern const Chain chains_widest[3];

const Chain *fastest_chains(void) {
#if HAS_WIDE_FORMS
    const int lanes = processor_lanes();
    if (lanes > 2) return lanes == 8 ? chains_widest : chains_wide;
#endif
    return chains_plain;
}

double assumed_newton_error(const System *sys, double tolerance, bool predicted) {
    if (sys->wires != NULL) return NEWTON_HUGE; /* kinks: no correction is the last without another */
    const bool touches = near_bodies(sys);
    /* The tangent omits that friction of a swivel depends on the reaction. */
    const bool complete = sys->friction_load[LEFT] == 0 && sys->friction_load[RIGHT] == 0;
    return predicted && tolerance <= NEWTON_SMALL && !touches && complete ? NEWTON_GOOD : NEWTON_UNKNOWN;
}

/* Update the largest size and the sum of each degree of freedom with a row of x. */
static inline void take_row(const double *row, double largest[DOF], double sum[DOF]) {
    for (int dof = 0; dof < DOF; dof++) {
        const double size = fabs(row[dof]);
        largest[dof] = size > largest[dof] ? size : largest[dof];
        sum[dof] += size;
    }
}

double chain_norm(const System *sys, const double *x, double slopes) {
    double largest[DOF] = {0};
    double sum[DOF] = {0};
    for (int node = 1; node < sys->elements; node++) take_row(x + (size_t)node * DOF, largest, sum);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *row = end_row(x, sys->elements + 1, side);
        double free_part[DOF];
        for (int dof = 0; dof < DOF; dof++) free_part[dof] = sys->free[side][dof] ? row[dof] : 0;
        take_row(free_part, largest, sum);
    }
    double norm = 0;
    double all = 0; /* unlike the maximum, the sum keeps NaN */
    for (int dof = 0; dof < DOF; dof++) {
        const bool is_slope = dof >= SLOPE && dof < ANGLE;
        norm = fmax(norm, is_slope ? largest[dof] * slopes : largest[dof]);
        all += sum[dof];
    }
    return all < INFINITY ? norm : INFINITY;
}
