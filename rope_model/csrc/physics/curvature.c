/* Permanent curvature along the present shape of a rope: physics.initial_curvature from the left end on. */

#include "curvature.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "rope.h"
#include "state_structures.h"

bool is_curved(const double *curved, const Rope *rope, int fidelity) {
    return curved != NULL && fidelity == TORSIONAL && max_curvature(rope) > 0;
}

Rope partly_curved(const Rope *whole, double fraction) {
    Rope rope = *whole;
    double *const values[] = CURVATURES_OF(rope);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) *values[k] *= fraction;
    return rope;
}

void carry_director(State *state, const double *before, const double *after) {
    double carried[3];
    initial_curvature_carried_director(state->director, before, after, carried);
    memcpy(state->director, carried, sizeof carried);
}

void start_director(State *state, const double *q) {
    static const double plumb[3] = DIRECTOR_PLUMB;
    static const double start[3] = DIRECTOR_START;
    memcpy(state->director, start, sizeof start);
    carry_director(state, plumb, q + SLOPE);
}

void curved_reference(double *curved, const Rope *rope, State *state, const double *q) {
    const NodalArrays nodal = state_arrays(state);
    double e1[3];
    double components[6];
    double found[12];
    double *to = curved;
    double s = 0;
    const int elements = is_curved(curved, rope, state->fidelity) ? nodal.elements : 0;
    memcpy(e1, state->director, sizeof e1);
    for (int e = 0; e < elements; e++, q += DOF, to += CURVED_SIZE) {
        const double material[] = {q[ANGLE], q[DOF + ANGLE], rope->EI};
        curvature_components(rope, s, nodal.lengths[e], components);
        curvature_vectors(components, nodal.lengths[e], q, e1, found);
        memcpy(to, found, 9 * sizeof *to);
        memcpy(to + 9, material, sizeof material);
        memcpy(e1, found + 9, sizeof e1);
        s += nodal.lengths[e];
    }
}
