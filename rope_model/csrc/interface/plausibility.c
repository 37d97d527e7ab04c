/* Whether restored bytes can be a state of a rope. Formulas and tables: rope_model/state.py. */

#include "plausibility.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "communication_step.h"
#include "ends.h"
#include "formulas.h"
#include "partition.h"
#include "rope.h"
#include "rules.h"
#include "simulator.h"
#include "state_structures.h"

static bool all_finite(const double *x, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

static bool fields_finite(const NodalArrays *nodal) {
    const size_t size = DOF * (size_t)nodal->nodes;
    return all_finite(nodal->q, size) && all_finite(nodal->v, size) && all_finite(nodal->a, size) &&
           all_finite(nodal->b, size) && all_finite(nodal->a_rate, size) && all_finite(nodal->reaction, size) &&
           all_finite(nodal->lengths, (size_t)nodal->elements) && all_finite(nodal->s, (size_t)nodal->nodes);
}

/* True if all real numbers of the state are finite, those of its events apart. */
static bool reals_finite(const State *state) {
    static const struct {
        size_t offset, count;
    } reals[] = STATE_REALS;
    for (size_t k = 0; k < sizeof reals / sizeof *reals; k++)
        for (size_t i = 0; i < reals[k].count; i++) {
            double x;
            memcpy(&x, (const char *)state + reals[k].offset + i * sizeof x, sizeof x);
            if (!isfinite(x)) return false;
        }
    return true;
}

/* bounds of what a run can reach */
#define ROUNDED_LENGTH 1e-12 /* rounding of a sum of lengths, over the rope's length */
#define ROUNDED_TIME 1e-9    /* of a time, s, or over the time above 1 s */
#define DISTANT 1e5          /* m, rad and their rates */
#define COUNTED ((int64_t)1 << 50)

/* True if all |x| are at most `bound`, and numbers. */
static bool all_below(const double *x, size_t count, double bound) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs(x[i]) <= bound)) return false;
    return true;
}

static bool within(int64_t x, int64_t least, int64_t most) {
    return least <= x && x <= most;
}

/* True if the pattern belongs to the mesh, at any place of the loop, and the elements have its lengths. */
static bool partition_plausible(const Scene *scene, const Mesh *mesh, const State *state, const NodalArrays *nodal,
                                const NodalArrays *scratch) {
    const double length = scene->rope.length;
    const double rounding = ROUNDED_LENGTH * length;
    const Pattern *pattern = &state->pattern;
    double *lengths = scratch->q;
    double *s = scratch->v;
    double divider_s[DIVIDERS];
    Pattern expected;
    mesh_dividers(scene, 0, 0, divider_s);
    partition(mesh, length, 0.5 * length, divider_s, nodal->elements, &expected, lengths);
    if (expected.coarse > 0) {
        const int outer = expected.counts[0] + expected.counts[SEGMENTS - 1];
        const int first = pattern->counts[0];
        const int least = (int)mesh_pattern_min_outer(expected.counts + 1);
        if (!within(first, least, outer - least)) return false;
        for (int i = 0; i < DIVIDERS; i++) /* place of a divider in this window */
            if (isfinite(divider_s[i]))
                divider_s[i] = expected.coarse * (pattern->windows[i] + 0.5 * MESH_PATTERN_WINDOW);
        partition_transform(&expected, first - expected.counts[0], divider_s, nodal->elements, lengths);
    }
    if (memcmp(pattern, &expected, sizeof expected) != 0) return false;
    arc_lengths(nodal->elements, lengths, s);
    for (int k = 0; k < nodal->elements; k++)
        if (!(fabs(nodal->lengths[k] - lengths[k]) <= rounding && fabs(nodal->s[k] - s[k]) <= rounding)) return false;
    return fabs(nodal->s[nodal->elements] - s[nodal->elements]) <= rounding;
}

/* True if the path ends at t, with a motion that an end may have. */
static bool path_plausible(const EndPath *path, double t) {
    double motion[3][4];
    double leans[2][3];
    if (!(path->start <= path->stop && fabs(path->stop - t) <= ROUNDED_TIME * fmax(1, fabs(t)))) return false;
    end_path_motion(path, path->stop, motion);
    end_path_lean_motion(path, path->stop, leans);
    return all_below(motion[0], 3 * 4, DISTANT) && all_below(leans[0], 2 * 3, DISTANT);
}

static bool happenings_plausible(const State *state) {
    static const size_t offsets[] = COUNT_OFFSETS;
    if (!within(state->switched, 0, CHATTER_EVENTS) || !within(state->event_count, 0, LOGGED_EVENTS)) return false;
    for (int k = 0; k < state->event_count; k++) {
        const Event *event = &state->events[k];
        const double reals[] = {event->t, event->kinetic, event->potential};
        if (!within(event->what, TRANSFORMED, RAISED) || !within(event->which, 0, RIGID)) return false;
        if (!all_finite(reals, sizeof reals / sizeof *reals)) return false;
    }
    for (size_t k = 0; k < sizeof offsets / sizeof *offsets; k++) {
        int64_t count;
        memcpy(&count, (const char *)&state->counts + offsets[k], sizeof count);
        if (!within(count, 0, COUNTED)) return false;
    }
    return true;
}

bool state_plausible(const Simulator *sim, State *state) {
    if (state->elements != sim->elements || !within(state->fidelity, TORSIONAL, RIGID) ||
        state->rubs != (sim->reference.wires != NULL && state->fidelity != RIGID) ||
        memchr(state->fidelity_reason, '\0', MESSAGE) == NULL)
        return false;
    if (sim->scene.model.fidelity != AUTO_FIDELITY && state->fidelity != sim->scene.model.fidelity) return false;
    const NodalArrays nodal = state_arrays(state);
    if (!reals_finite(state) || !fields_finite(&nodal)) return false;
    if (sim->reference.wires != NULL && !all_finite(nodal.z, WIRE_Z * (size_t)nodal.elements)) return false;
    if (!(state->h >= 0 && state->step_next > 0 && state->last_interval > 0)) return false;
    for (int side = LEFT; side <= RIGHT; side++) {
        const SwivelState *swivel = &state->swivels[side];
        if (!within(swivel->phase, LOCKED, SLIP) || !(fabs(swivel->sign) <= 1) ||
            !path_plausible(&state->paths[side], state->t))
            return false;
    }
    return partition_plausible(&sim->scene, &sim->mesh, state, &nodal, &sim->work.trial) && happenings_plausible(state);
}

bool host_step_plausible(const HostStep *host, const State *start, const State *state) {
    static const double bounds[] = END_MOTION_BOUNDS;
    for (int side = LEFT; side <= RIGHT; side++)
        for (int k = 0; k < END_MOTIONS; k++)
            if (!(fabs(end_value(&host->ends[side], k)) <= bounds[k])) return false;
    return start->t < state->t && state->t <= host->stop && host->stop < INFINITY && host->given_at <= host->stop &&
           host->given_at > -INFINITY && host->asked_at <= host->stop && host->asked_at > -INFINITY;
}
