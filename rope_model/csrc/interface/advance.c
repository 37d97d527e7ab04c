/* Initialisation of a rope, and its advance from one instant of the host to the next.

   The functions of rope.h that change the state work on `next`, which becomes the state when they succeed.  One that
   fails leaves the state of the host's last instant, and refers the frames to it again. */

#include "advance.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "communication_step.h"
#include "curvature.h"
#include "ends.h"
#include "fidelity.h"
#include "fidelity_name.h"
#include "formulas.h"
#include "guards.h"
#include "hang.h"
#include "host_step.h"
#include "loop.h"
#include "messages.h"
#include "partition.h"
#include "rigid.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "shaft.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "stepping.h"
#include "trial_step.h"
#include "wires.h"

RopeStatus accept_next(Simulator *sim) {
    State *before = sim->state;
    sim->state = sim->next;
    sim->next = before;
    sim->computed_groups = 0;
    sim->replay.known = false;
    sim->bottom_known = false;
    sim->initialized = true;
    sim->message[0] = '\0';
    return ROPE_DONE;
}

/* Set the ends at rest, with their suspension points; fail if they cannot rest. */
static RopeStatus hold_ends(const Scene *scene, State *state, const EndMotion ends[2], double points[2][3],
                            char *message) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const EndPath path = end_path_at_rest(state->t, end);
        state->filters[side] = input_filter_at_rest(state->t, end);
        double measures[PATH_MEASURES];
        path_measures(&path, &state->filters[side], measures);
        if (!check_motion(scene, end, measures, side, message)) return ROPE_FAILED;
        double fastest = fabs(end->yaw_rate);
        fastest = fmax(fastest, fmax(fabs(end->vx), fmax(fabs(end->vy), fabs(end->vz))));
        if (fastest > END_PATHS_RESTS_BELOW) return say_moves_at_start(message, side_name(side));
    }
    paths_at_rest(scene, state, ends, scene->model.fidelity == RIGID); /* a rigid rope needs no steps */
    const EndMotion first[2] = {end_path_at(&state->paths[LEFT], state->t),
                                end_path_at(&state->paths[RIGHT], state->t)};
    centreline_suspension_points(&scene->layout, &first[LEFT], &first[RIGHT], points);
    return ROPE_DONE;
}

/* Choose the fidelity; refuse motions that it cannot follow, and bodies that leave the rope no room. */
static RopeStatus choose_model(const Simulator *sim, State *state, const EndMotion ends[2], char *message) {
    const Scene *scene = &sim->scene;
    char why[MESSAGE];
    state->fidelity = choose_fidelity(scene, ends, sim->forces.count, state->fidelity_reason);
    unsupported_motion(scene, state->fidelity, ends, sim->forces.count, why);
    if (why[0]) return say_fixed_model_cannot_follow(message, fidelity_name(state->fidelity), why);
    if (tell_no_room(scene, state->fidelity, &ends[LEFT], &ends[RIGHT], message)) return ROPE_FAILED;
    return ROPE_DONE;
}

/* Divide the rope into elements for the place of its loop. */
static void lay_mesh(const Simulator *sim, State *state) {
    const Scene *scene = &sim->scene;
    const NodalArrays nodal = state_arrays(state);
    const double bottom_s = bottom_arc_length(scene, state->paths, state->t);
    double divider_s[DIVIDERS];
    dividers_on_rope(scene, state->paths, state->t, divider_s);
    partition(&sim->mesh, scene->rope.length, bottom_s, divider_s, nodal.elements, &state->pattern, nodal.lengths);
    arc_lengths(nodal.elements, nodal.lengths, nodal.s);
}

/* Hang the rope between its suspension points, and bring it to rest. */
static RopeStatus bring_to_rest(Simulator *sim, State *state, const EndMotion ends[2], double points[2][3],
                                char *message) {
    const NodalArrays nodal = state_arrays(state);
    if (!hanging_guess(nodal.nodes, nodal.s, points[LEFT], points[RIGHT], nodal.q, message)) return ROPE_FAILED;
    start_director(state, nodal.q);
    state->offsets[RIGHT] = end_conditions_right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = sim->scene.rope.installed_twist;
    state->loop_yaw = ends_yaw(&nodal);
    if (state->fidelity == RIGID) return as_rigid(sim, state, state->t, message);
    return hang(sim, state, ends, message);
}

/* Begin the books of a rope at rest: means, energies, audit, passages and guards. */
static void begin_books(Simulator *sim, State *state) {
    const NodalArrays nodal = state_arrays(state);
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = -vertical_reaction(&nodal, side);
    state->energy_balance.start = energy_balance_total(&state->energy_balance);
    state->event_count = 0;
    begin_audit(sim, state);
    far_bodies(state->nearest);
    set_rise_reference(&sim->scene, state);
    update_passages(&sim->scene, sim->self_contact, state);
    update_guards(&sim->scene, state);
}

static RopeStatus initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    const Scene *scene = &sim->scene;
    State *state = sim->next;
    char *message = sim->message;
    double points[2][3];
    if (!(fabs(t) <= STEPPING_MAX_START_TIME)) return say_start_time_out_of_range(message, t, STEPPING_MAX_START_TIME);
    memset(state, 0, sim->state_bytes);
    state->elements = sim->elements;
    state->t = t;
    state->calm_since = t;
    state->step_next = scene->solver.step_max;
    state->last_interval = scene->solver.step_max;
    if (!hold_ends(scene, state, ends, points, message)) return ROPE_FAILED;
    if (!choose_model(sim, state, ends, message)) return ROPE_FAILED;
    lay_mesh(sim, state);
    if (!bring_to_rest(sim, state, ends, points, message)) return ROPE_FAILED;
    if (start_hysteresis(sim->reference.wires, state)) rope_system_refer(sim, state, state_arrays(state).q);
    begin_books(sim, state);
    memset(&sim->last, 0, sizeof sim->last); /* equal states are saved as equal bytes */
    return accept_next(sim);
}

/* Refer the frames to the state again after a failure. */
static RopeStatus refer_after_failure(Simulator *sim, RopeStatus status) {
    if (status == ROPE_FAILED && sim->initialized) rope_system_refer(sim, sim->state, state_arrays(sim->state).q);
    return status;
}

RopeStatus rope_initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    return refer_after_failure(sim, initialize(sim, t, ends));
}

RopeStatus rope_release_free_swivels(Simulator *sim) {
    if (!sim->initialized) return say_no_state(sim->message);
    if (sim->scene.swivels[LEFT].mode != FREE_MODE && sim->scene.swivels[RIGHT].mode != FREE_MODE) return ROPE_DONE;
    memcpy(sim->next, sim->state, sim->state_bytes);
    if (!release_free_swivels(sim, sim->next, sim->message)) return refer_after_failure(sim, ROPE_FAILED);
    memset(&sim->last, 0, sizeof sim->last); /* equal states are saved as equal bytes */
    return accept_next(sim);
}

/* Advance to the host's stop, or to an event; *event tells which.  Keep the state before as the start. */
static RopeStatus advance_to(Simulator *sim, const HostStep *host, int *event) {
    const double t = host->stop;
    const double begin = sim->state->t;
    const double step_max = sim->scene.solver.step_max;
    const double earliest = begin - sim->scene.inputs.hold_max;
    *event = 0;
    if (!sim->initialized) return say_no_state(sim->message);
    if (fabs(t - begin) < ROPE_MIN_INTERVAL) return ROPE_DONE;
    if (!(isfinite(t) && t > begin)) return say_time_goes_back(sim->message, begin, t);
    if (t - begin > STEPPING_MAX_STEPS * step_max)
        return say_too_far_at_once(sim->message, begin, t, STEPPING_MAX_STEPS, step_max, STEPPING_MAX_STEPS * step_max);
    if (!(earliest <= host->given_at && host->given_at <= t + ROPE_MIN_INTERVAL))
        return say_motions_of_another_time(sim->message, host->given_at, earliest, t);
    if (!take_host_step(sim, host, event)) return ROPE_FAILED;
    State *unused = sim->start;
    sim->start = sim->state;
    sim->state = unused; /* becomes next */
    sim->last = *host;
    return accept_next(sim);
}

/* Describe a step that the host asks for. */
static HostStep step_to(double t, const EndMotion ends[2], double given_at, bool to_event) {
    HostStep host = {.stop = t, .given_at = given_at, .asked_at = given_at, .to_event = to_event, .taken = 1};
    memcpy(host.ends, ends, sizeof host.ends);
    return host;
}

RopeStatus rope_advance_to(Simulator *sim, double t, const EndMotion ends[2], double given_at) {
    const HostStep host = step_to(t, ends, given_at, false);
    int event;
    return refer_after_failure(sim, advance_to(sim, &host, &event));
}

RopeStatus rope_advance_to_event(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event) {
    const InputFilter *filters = sim->state->filters;
    HostStep host = step_to(t, ends, given_at, true);
    bool same = *event != 0;
    for (int side = LEFT; side <= RIGHT; side++) same &= !memcmp(&ends[side], filters[side].given, sizeof ends[side]);
    if (same) host.given_at = fmin(filters[LEFT].given_at, filters[RIGHT].given_at);
    return refer_after_failure(sim, advance_to(sim, &host, event));
}
