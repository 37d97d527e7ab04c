/* Permanent curvature along the present shape of a rope: physics.initial_curvature from the left end on. */

#include "curvature.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "rope.h"
#include "simulator.h"
#include "state_structures.h"

bool is_curved(const Simulator *sim, const State *state) {
    return sim->curved != NULL && state->fidelity == TORSIONAL && max_curvature(&sim->scene.rope) > 0;
}

Rope partly_curved(const Rope *whole, double fraction) {
    Rope rope = *whole;
    double *const values[] = CURVATURES_OF(rope);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) *values[k] *= fraction;
    return rope;
}

void carry_director(State *state, const double *before, const double *after) {
    double carried[3];
    carried_director(state->director, before, after, carried);
    memcpy(state->director, carried, sizeof carried);
}

void start_director(State *state, const double *q) {
    static const double plumb[3] = DIRECTOR_PLUMB, start[3] = DIRECTOR_START;
    memcpy(state->director, start, sizeof start);
    carry_director(state, plumb, q + SLOPE);
}

void curved_reference(Simulator *sim, State *state, const double *q) {
    const Rope *data = &sim->scene.rope;
    const NodalArrays nodal = state_arrays(state);
    double e1[3], components[6], found[12], *to = sim->curved, s = 0;
    const int elements = is_curved(sim, state) ? nodal.elements : 0;
    memcpy(e1, state->director, sizeof e1);
    for (int e = 0; e < elements; e++, q += DOF, to += CURVATURE_SIZE) {
        const double material[] = {q[ANGLE], q[DOF + ANGLE], data->EI};
        curvature_components(data, s, nodal.lengths[e], components);
        curvature_vectors(components, nodal.lengths[e], q, e1, found);
        memcpy(to, found, 9 * sizeof *to);
        memcpy(to + 9, material, sizeof material);
        memcpy(e1, found + 9, sizeof e1);
        s += nodal.lengths[e];
    }
}
