/* Hysteresis by friction between wires.  C version of rope_model/simulation/wires.py, which explains the method. */

#include "simulator.h"

static const double CELLS[] = WIRE_CELLS; /* bounds of the points' cells, element coordinates */

static double *hysteresis_of(const Simulator *rope, int element) {
    return rope->wires + (ptrdiff_t)element * WIRE_HISTORY_SIZE;
}

/* Section of an element at a point.  Sections do not turn without torsion, even if the ends have theta. */
static void read_section(const State *state, const NodalArrays *m, const double *q, int element, int point,
                         double section[WIRE_POINT_STATE_SIZE]) {
    static const double places[] = WIRE_PLACES;
    section_at(places[point], m->lengths[element], q + (ptrdiff_t)element * DOF, section);
    if (state->fidelity != TORSIONAL) section[ANGLE] = 0;
}

void wires_history(Simulator *rope, State *state, const double *q, double (*strains)[STRAINS]) {
    const NodalArrays m = state_arrays(state);
    const double stiffness = wire_stiffness(&rope->scene.rope);
    for (int e = 0; e < m.elements; e++) {
        double *history = hysteresis_of(rope, e);
        for (int k = 0; k < WIRE_POINTS; k++, history += WIRE_POINT_STATE_SIZE) {
            read_section(state, &m, q, e, k, history);
            memcpy(history + WIRE_POINT_STATE_SIZE - 3, m.z + (ptrdiff_t)e * WIRE_Z + 3 * k, 3 * sizeof *history);
        }
        history[0] = slip_curvature(&rope->scene.rope, stiffness, strains[e][0], strains[e][1]);
        history[1] = stiffness;
    }
}

double update_hysteresis(Simulator *rope, State *state, const double *q) {
    static const double weights[] = WIRE_WEIGHTS;
    const NodalArrays m = state_arrays(state);
    double dissipated = 0;
    for (int e = 0; state->rubs && e < m.elements; e++) {
        const double *before = hysteresis_of(rope, e), *law = before + WIRE_POINTS * WIRE_POINT_STATE_SIZE;
        double now[WIRE_POINT_STATE_SIZE];
        for (int k = 0; k < WIRE_POINTS; k++, before += WIRE_POINT_STATE_SIZE) {
            read_section(state, &m, q, e, k, now);
            const BoucWenStep step = bouc_wen_step(before, now, law[0]);
            memcpy(m.z + (ptrdiff_t)e * WIRE_Z + 3 * k, step.z, sizeof step.z);
            dissipated += law[1] * m.lengths[e] * weights[k] * step.dissipated;
        }
    }
    return dissipated;
}

/* Mean of z over arc lengths between `from` and `to`; z is constant in the cell of a point. */
static void mean_between(const double *z, const double *s, int elements, double from, double to, double mean[3]) {
    const double close = 1e-9 * s[elements];
    memset(mean, 0, 3 * sizeof *mean);
    for (int e = 0; e < elements && s[e] < to; e++)
        for (int k = 0; s[e + 1] > from && k < WIRE_POINTS; k++) {
            const double l = s[e + 1] - s[e], begin = s[e] + l * CELLS[k], end = s[e] + l * CELLS[k + 1];
            const double *point_z = z + (ptrdiff_t)e * WIRE_Z + 3 * k;
            const double fraction = (fmin(end, to) - fmax(begin, from)) / (to - from);
            if (fabs(begin - from) <= close && fabs(end - to) <= close) {
                memcpy(mean, point_z, 3 * sizeof *mean);
                return;
            }
            for (int i = 0; fraction > 0 && i < 3; i++) mean[i] += fraction * point_z[i];
        }
}

void wires_carry(Simulator *rope, State *state, const double *old_s) {
    const NodalArrays m = state_arrays(state);
    double *before = rope->wires; /* scratch: its history belongs to the old mesh */
    if (!state->rubs) return;
    memcpy(before, m.z, sizeof(double) * WIRE_Z * (size_t)m.elements);
    for (int e = 0; e < m.elements; e++)
        for (int k = 0; k < WIRE_POINTS; k++)
            mean_between(before, old_s, m.elements, m.s[e] + m.lengths[e] * CELLS[k],
                         m.s[e] + m.lengths[e] * CELLS[k + 1], m.z + (ptrdiff_t)e * WIRE_Z + 3 * k);
}

int start_hysteresis(const Simulator *rope, State *state) {
    const NodalArrays m = state_arrays(state);
    if (state->rubs || state->fidelity == RIGID || rope->wires == NULL) return 0;
    state->rubs = 1;
    memset(m.z, 0, sizeof(double) * WIRE_Z * (size_t)m.elements);
    return 1;
}
