/* The state as a block of bytes. Formulas and tables: rope_model/rules/state.py. */

#include <stddef.h>

#include "rules.h"
#include "simulator.h"

void state_copy(const Simulator *sim, State *to, const State *from) {
    memcpy(to, from, sim->state_bytes);
}

void record_event(State *state, int what, int which, double kinetic, double potential) {
    if (state->event_count < LOGGED_EVENTS)
        state->events[state->event_count++] = (Event){state->t, kinetic, potential, what, which};
}

static int all_finite(const double *x, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(x[i])) return 0;
    return 1;
}

static int within(int64_t x, int64_t least, int64_t most) {
    return least <= x && x <= most;
}

/* True if the pattern belongs to the mesh, at any place of the loop, and the elements have its lengths. */
static int partition_plausible(const Simulator *sim, const State *state, const NodalArrays *nodal) {
    const double length = sim->scene.rope.length, rounding = 1e-12 * length;
    const Pattern *pattern = &state->pattern;
    double *lengths = sim->trial.q, *s = sim->trial.v;
    double divider_s[DIVIDERS];
    Pattern expected;
    mesh_dividers(&sim->scene, 0, 0, divider_s);
    partition(&sim->mesh, length, 0.5 * length, divider_s, nodal->elements, &expected, lengths);
    if (expected.coarse > 0) {
        const int outer = expected.counts[0] + expected.counts[SEGMENTS - 1];
        const int first = pattern->counts[0], least = (int)min_outer(expected.counts + 1);
        if (!within(first, least, outer - least)) return 0;
        for (int i = 0; i < DIVIDERS; i++) /* place of a divider in this window */
            if (isfinite(divider_s[i])) divider_s[i] = expected.coarse * (pattern->windows[i] + 0.5 * WINDOW);
        partition_transform(&expected, first - expected.counts[0], divider_s, nodal->elements, lengths);
    }
    if (memcmp(pattern, &expected, sizeof expected) != 0) return 0;
    arc_lengths(nodal->elements, lengths, s);
    for (int k = 0; k < nodal->elements; k++)
        if (!(fabs(nodal->lengths[k] - lengths[k]) <= rounding && fabs(nodal->s[k] - s[k]) <= rounding)) return 0;
    return fabs(nodal->s[nodal->elements] - s[nodal->elements]) <= rounding;
}

/* True if the path ends at t, with a motion that an end may have. */
static int path_plausible(const Path *path, double t) {
    const double distant = 1e5;
    if (!(path->start <= path->stop && fabs(path->stop - t) <= 1e-9 * fmax(1, fabs(t)))) return 0;
    double motion[3][4], leans[2][3];
    path_motion(path, path->stop, motion);
    for (int k = 0; k < 12; k++)
        if (!(fabs(motion[k / 4][k % 4]) <= distant)) return 0;
    path_lean_motion(path, path->stop, leans);
    for (int k = 0; k < 6; k++)
        if (!(fabs(leans[k / 3][k % 3]) <= distant)) return 0;
    return 1;
}

static int happenings_plausible(const State *state) {
    const int64_t *counts = &state->counts.steps;
    if (!within(state->switched, 0, CHATTER_EVENTS) || !within(state->event_count, 0, LOGGED_EVENTS)) return 0;
    for (int k = 0; k < state->event_count; k++)
        if (!within(state->events[k].what, TRANSFORMED, RAISED) || !within(state->events[k].which, 0, RIGID) ||
            !all_finite(&state->events[k].t, 3))
            return 0;
    for (size_t k = 0; k < sizeof(Counts) / sizeof(int64_t); k++)
        if (!within(counts[k], 0, (int64_t)1 << 50)) return 0;
    return 1;
}

int state_plausible(const Simulator *sim, State *state) {
    if (state->elements != sim->elements || !within(state->fidelity, TORSIONAL, RIGID) ||
        state->rubs != (sim->wires != NULL && state->fidelity != RIGID) ||
        memchr(state->fidelity_reason, '\0', MESSAGE) == NULL)
        return 0;
    if (sim->scene.model.fidelity != AUTO_FIDELITY && state->fidelity != sim->scene.model.fidelity) return 0;
    const NodalArrays nodal = state_arrays(state);
    /* The doubles before the swivels are contiguous, and so are all arrays. */
    if (!all_finite(&state->t, offsetof(State, swivels) / sizeof(double)) ||
        !all_finite(nodal.q,
                    (size_t)(nodal.z - nodal.q) + (sim->wires != NULL ? WIRE_Z * (size_t)nodal.elements : 0)) ||
        !all_finite(&state->energy_balance.kinetic,
                    (offsetof(State, counts) - offsetof(State, energy_balance)) / sizeof(double)))
        return 0;
    if (!all_finite((const double *)(const void *)state->filters, sizeof state->filters / (sizeof(double)))) return 0;
    if (!(state->h >= 0 && state->step_next > 0 && state->last_interval > 0)) return 0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const SwivelState *swivel = &state->swivels[side];
        if (!within(swivel->phase, LOCKED, SLIP) || !isfinite(swivel->angle) || !(fabs(swivel->sign) <= 1) ||
            !path_plausible(&state->paths[side], state->t))
            return 0;
    }
    return partition_plausible(sim, state, &nodal) && happenings_plausible(state);
}

int host_step_plausible(const HostStep *host, const State *start, const State *state) {
    static const double bounds[] = END_MOTION_BOUNDS;
    enum { OF_END = sizeof(EndMotion) / sizeof(double) };
    for (int k = 0; k < 2 * OF_END; k++)
        if (!(fabs(end_value(&host->ends[k / OF_END], k % OF_END)) <= bounds[k % OF_END])) return 0;
    return start->t < state->t && state->t <= host->stop && host->stop < INFINITY && host->given_at <= host->stop &&
           host->given_at > -INFINITY && host->asked_at <= host->stop && host->asked_at > -INFINITY;
}
