/* The memory of a rope whose wires rub on each other: rope_model.simulation.wires, which see. */

#include "simulator.h"

/* where in the element the length of rope begins and ends that a point stands for, in parts of 1 */
static const double CELLS[] = WIRE_CELLS;

static double *hysteresis_of(const Simulator *rope, int element) {
    return rope->wires + (ptrdiff_t)element * WIRE_HISTORY;
}

/* of an element of q; without torsion no section turns, however the ends hold theta */
static void look_at_section(const State *state, const Arrays *m, const double *q, int element, int point,
                            double section[WIRE_POINT_STATE]) {
    static const double places[] = WIRE_PLACES;
    section_at(places[point], m->lengths[element], q + (ptrdiff_t)element * DOF, section);
    if (state->fidelity != TORSIONAL) section[ANGLE] = 0;
}

void wires_history(Simulator *rope, State *state, const double *q, double (*strains)[STRAINS]) {
    const Arrays m = state_arrays(state);
    const double stiffness = wire_stiffness(&rope->scene.rope);
    for (int e = 0; e < m.elements; e++) {
        double *at = hysteresis_of(rope, e);
        for (int k = 0; k < WIRE_POINTS; k++, at += WIRE_POINT_STATE) {
            look_at_section(state, &m, q, e, k, at);
            memcpy(at + WIRE_POINT_STATE - 3, m.z + (ptrdiff_t)e * WIRE_Z + 3 * k, 3 * sizeof *at);
        }
        at[0] = slip_curvature(&rope->scene.rope, stiffness, strains[e][0], strains[e][1]);
        at[1] = stiffness;
    }
}

double wires_slip(Simulator *rope, State *state, const double *q) {
    static const double weights[] = WIRE_WEIGHTS;
    const Arrays m = state_arrays(state);
    double dissipated = 0;
    for (int e = 0; state->rubs && e < m.elements; e++) {
        const double *before = hysteresis_of(rope, e), *law = before + WIRE_POINTS * WIRE_POINT_STATE;
        double now[WIRE_POINT_STATE];
        for (int k = 0; k < WIRE_POINTS; k++, before += WIRE_POINT_STATE) {
            look_at_section(state, &m, q, e, k, now);
            const Slid slid = wire_slide(before, now, law[0]);
            memcpy(m.z + (ptrdiff_t)e * WIRE_Z + 3 * k, slid.z, sizeof slid.z);
            dissipated += law[1] * m.lengths[e] * weights[k] * slid.dissipated;
        }
    }
    return dissipated;
}

/* the mean of z over arc lengths from `from` to `to` of elements between nodes at s; z is constant in a point's cell */
static void mean_between(const double *z, const double *s, int elements, double from, double to, double mean[3]) {
    const double close = 1e-9 * s[elements];
    memset(mean, 0, 3 * sizeof *mean);
    for (int e = 0; e < elements && s[e] < to; e++)
        for (int k = 0; s[e + 1] > from && k < WIRE_POINTS; k++) {
            const double l = s[e + 1] - s[e], begin = s[e] + l * CELLS[k], end = s[e] + l * CELLS[k + 1];
            const double *own = z + (ptrdiff_t)e * WIRE_Z + 3 * k;
            const double part = (fmin(end, to) - fmax(begin, from)) / (to - from);
            if (fabs(begin - from) <= close && fabs(end - to) <= close) {
                memcpy(mean, own, 3 * sizeof *mean);
                return;
            }
            for (int i = 0; part > 0 && i < 3; i++) mean[i] += part * own[i];
        }
}

void wires_carry(Simulator *rope, State *state, const double *old_s) {
    const Arrays m = state_arrays(state);
    double *before = rope->wires; /* what it held is of the old mesh */
    if (!state->rubs) return;
    memcpy(before, m.z, sizeof(double) * WIRE_Z * (size_t)m.elements);
    for (int e = 0; e < m.elements; e++)
        for (int k = 0; k < WIRE_POINTS; k++)
            mean_between(before, old_s, m.elements, m.s[e] + m.lengths[e] * CELLS[k],
                         m.s[e] + m.lengths[e] * CELLS[k + 1], m.z + (ptrdiff_t)e * WIRE_Z + 3 * k);
}

int start_hysteresis(const Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    if (state->rubs || state->fidelity == RIGID || rope->wires == NULL) return 0;
    state->rubs = 1;
    memset(m.z, 0, sizeof(double) * WIRE_Z * (size_t)m.elements);
    return 1;
}
