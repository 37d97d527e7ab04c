/* The permanent curvature of a rope along its present shape: rope_model.simulation.curvature, which see. */

#include "simulator.h"

int is_curved(const Simulator *rope, const State *state) {
    return rope->scene.rope.initial_curvature > 0 && state->fidelity == TORSIONAL;
}

void curved_reference(Simulator *rope, State *state, const double *q) {
    const Rope *data = &rope->scene.rope;
    const Arrays m = state_arrays(state);
    double e1[3] = DIRECTOR_START, found[12], *to = rope->curved;
    for (int e = 0; is_curved(rope, state) && e < m.elements; e++, q += DOF, to += CURVED) {
        const double of_element[] = {q[ANGLE], q[DOF + ANGLE], data->initial_curvature, data->EI};
        directors(data->initial_curvature_angle, m.lengths[e], q, e1, found);
        memcpy(to, found, 9 * sizeof *to);
        memcpy(to + 9, of_element, sizeof of_element);
        memcpy(e1, found + 9, sizeof e1);
    }
}
