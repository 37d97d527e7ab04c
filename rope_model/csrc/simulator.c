/* The rope in time: rope_model.simulation.simulator, which see. */

#include <math.h>
#include <string.h>

#include "rules.h"
#include "simulator.h"

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    message[0] = '\0';
    check_scene(scene, message);
    if (message[0]) return NULL;
    const Mesh mesh = mesh_fit(scene);
    const int elements = mesh_elements(&mesh, scene->rope.length, message);
    if (elements == 0) {
        char why[MESSAGE];
        memcpy(why, message, sizeof why);
        if (scene->mesh.kind == AUTO_MESH) say_fitted_mesh_fails(message, why);
        return NULL;
    }
    Simulator *rope = with_memory(scene, elements, memory, message);
    if (rope == NULL) return NULL;
    rope->mesh = mesh;
    rope->around->scene = &rope->scene;
    rope->around->bodies = may_touch(&scene->shaft);
    return rope;
}

const char *rope_message(const Simulator *rope) {
    return rope->message;
}

int rope_is_initialized(const Simulator *rope) {
    return rope->initialized;
}

double rope_time(const Simulator *rope) {
    return rope->state->t;
}

int rope_elements(const Simulator *rope) {
    return rope->elements;
}

const char *rope_fidelity(const Simulator *rope) {
    return rope->initialized ? fidelity_name(rope->state->fidelity) : "";
}

const char *rope_fidelity_reason(const Simulator *rope) {
    return rope->initialized ? rope->state->fidelity_reason : "";
}

/* what was worked on becomes the state */
static int accept_next(Simulator *rope) {
    State *before = rope->state;
    rope->state = rope->next;
    rope->next = before;
    rope->known = 0;
    rope->bottom_known = 0;
    rope->initialized = 1;
    rope->message[0] = '\0';
    return 1;
}

int rope_retune(Simulator *rope, const Scene *scene) {
    check_scene(scene, rope->message);
    if (rope->message[0]) return 0;
    rope->scene.solver = scene->solver;
    memcpy(rope->scene.swivels, scene->swivels, sizeof scene->swivels);
    rope->scene.shaft.air = scene->shaft.air;
    rope->known = 0;
    return 1;
}

/* the ends at rest at t; points: where they are; 0 when they cannot be */
static int hold_ends(Simulator *rope, State *state, const EndMotion ends[2], double points[2][3]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        state->paths[side] = path_resting(state->t, end);
        state->following[side] = following_resting(state->t, end);
        double limits[3][4];
        follow_limits(&state->paths[side], &state->following[side], limits);
        end_refusal(&rope->scene.inputs, end, limits, side, rope->message);
        if (rope->message[0]) return 0;
        double fastest = fabs(end->yaw_rate);
        for (int k = 0; k < 3; k++) fastest = fmax(fastest, fabs((&end->vx)[k]));
        if (fastest > RESTS_BELOW) return say_moves_at_start(rope->message, SIDE_NAMES[side]);
    }
    suspension_points(&rope->scene.layout, &ends[LEFT], &ends[RIGHT], points);
    return 1;
}

/* how far the rope lies in itself, where that is further than before */
static void see_overlap(const Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    const double *nearest = rope->own->nearest, diameter = rope->scene.rope.diameter;
    Crossing *crossing = &state->crossing;
    System s = system_of(rope, state);
    s.own = rope->own;
    find_rope_touches(&s, m.q, m.v, 0, 0);
    if (!(diameter - nearest[0] > crossing->overlap)) return;
    if (crossing->overlap == 0) crossing->touched_at = state->t;
    crossing->overlap = diameter - nearest[0];
    crossing->touched_y = nearest[1];
}

/* what the rope came near to, and passed through, at the state's instant */
static void see_passages(const Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    Crossing *crossing = &state->crossing;
    state->looked_at = state->t;
    shaft_nearer(&rope->scene, &m, state->t, state->nearest);
    const double line = shape_direction(&m), above = rope->scene.layout.spacing, diameter = rope->scene.rope.diameter;
    double across[2];
    heading(line, across);
    const int near = !shape_legs_apart(&m, across, diameter, above);
    if (near || rope->own->presses) see_overlap(rope, state);
    if (!near && crossing->net == 0 && fabs(state->loop_yaw - line) <= TURNED_FAR) return;
    const LoopBottom bottom = shape_loop_bottom(m.nodes, m.q, m.s);
    const LoopTurns turns = shape_loop_turns(&m, &bottom);
    const double net = rint(turns_of(shape_nearest_turn(bottom.yaw, state->loop_yaw), line, turns.number));
    if (net != crossing->net && crossing->number == 0) crossing->since = state->t, crossing->y = turns.sharpest_y;
    crossing->number += fabs(net - crossing->net);
    crossing->net = net;
}

static int start(Simulator *rope, double t, const EndMotion ends[2]) {
    const Scene *scene = &rope->scene;
    State *state = rope->next;
    char *message = rope->message;
    if (!(fabs(t) <= FARTHEST_START)) return say_start_time_out_of_range(message, t, FARTHEST_START);
    memset(state, 0, rope->state_bytes);
    state->elements = rope->elements;
    state->t = state->calm_since = t;
    char why[MESSAGE];
    double points[2][3];
    if (!hold_ends(rope, state, ends, points)) return 0;
    state->fidelity = fidelity_choose(scene, ends, rope->forces.number, state->fidelity_reason);
    fidelity_unsupported_motion(scene, state->fidelity, ends, rope->forces.number, why);
    if (why[0]) return say_fixed_model_cannot_follow(message, fidelity_name(state->fidelity), why);
    const Arrays m = state_arrays(state);
    mesh_partition(&rope->mesh, scene->rope.length, bottom_of(rope, state, t), m.elements, &state->pattern, m.lengths);
    mesh_arc_lengths(m.elements, m.lengths, m.s);
    shape_hanging_guess(m.nodes, m.s, points[LEFT], points[RIGHT], m.q, message);
    state->offsets[RIGHT] = right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = scene->rope.installed_twist;
    state->step_next = state->last_interval = scene->solver.step_max;
    state->loop_yaw = shape_direction(&m);
    if (message[0] || !(state->fidelity == RIGID ? rigid_state(rope, state, t, message) : hang(rope, state, message))) {
        tell_no_room(scene, state->fidelity, &ends[LEFT], &ends[RIGHT], message);
        return 0;
    }
    begin_rubbing(rope, state);
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = -end_row(m.reaction, m.nodes, side)[1];
    state->energy_balance.start = energy_total(&state->energy_balance);
    state->event_count = 0;
    audit_begin(rope, state);
    shaft_not_near(state->nearest);
    guards_start(scene, state);
    see_passages(rope, state);
    guards_look(scene, state);
    return accept_next(rope);
}

/* what did not succeed has left the frames counted from elsewhere */
static int conclude(Simulator *rope, int succeeded) {
    if (!succeeded && rope->initialized) refer(rope, rope->state, state_arrays(rope->state).q);
    return succeeded;
}

int rope_initialize(Simulator *rope, double t, const EndMotion ends[2]) {
    return conclude(rope, start(rope, t, ends));
}

typedef struct {
    const Simulator *rope;
    const State *state;
} Looked;

static double due_at(void *with, double time) {
    const Looked *at = with;
    return distance_to_due(&at->state->pattern, bottom_of(at->rope, at->state, time));
}

/* the instant at which the coming steps must end: the host's, a release, or a transformation that a step would carry
   the loop too far past */
static double next_stop(const Simulator *rope, const State *state, double t_end) {
    const double t = state->t, stop = fmin(t_end, next_release(rope, state));
    const double ahead = fmin(stop, t + fmin(state->step_next, rope->scene.solver.step_max));
    const double times[2] = {0.5 * (t + ahead), ahead};
    Looked at = {rope, state};
    const double at_start = due_at(&at, t);
    /* a crossing that falls between these instants is found by the next step, at most one step late */
    for (int k = 0; k < 2; k++) {
        const double then = due_at(&at, times[k]);
        if (0 > at_start && then >= MESH_LATEST * state->pattern.coarse)
            return fmin(locate(due_at, &at, t, times[k], at_start, then, EVENT_WIDTH), stop);
    }
    return stop;
}

/* steps that the Newton iterations left to this advance allow for, one at least */
static int64_t steps_left(const Simulator *rope, const State *state) {
    const int64_t left = (rope->work_end - state->counts.newton) / STEP_WORK;
    return left > 1 ? left : 1;
}

/* a step towards `stop` that converges and errs little enough, halved as often as it takes, or that errs too much where
   the work that is left does not allow for more steps; 0 and a message if none */
static int accepted_step(Simulator *rope, State *state, double stop, Trial *trial, double *step_next, int *reaches,
                         char *message) {
    const Solver *solver = &rope->scene.solver;
    double next = fmin(state->step_next, solver->step_max);
    double parts = parts_of(stop - state->t, next, (double)steps_left(rope, state));
    double h = (stop - state->t) / parts;
    int rejected = 0;
    for (;;) {
        *trial = trial_step(rope, state, h);
        state->counts.newton += trial->newton.iterations;
        if (trial->reached && trial->error <= ACCEPT_BELOW * solver->tolerance) break;
        if (trial->reached && stop - state->t > 0.5 * h * (double)steps_left(rope, state)) {
            next = h;
            break;
        }
        rejected = 1;
        state->counts.rejections += 1;
        if (h <= solver->step_min) {
            char why[MESSAGE];
            if (trial->reached) say_error_too_large(why, trial->error / solver->tolerance);
            return say_step_fails(message, h, solver->step_min,
                                  trial->reached ? why : newton_text(trial->newton.status));
        }
        h = fmax(0.5 * h, solver->step_min);
        parts = 2;
        next = h;
    }
    const NextStep then = next_step(solver, h, next, trial->error, rejected, trial->t, state->calm_since);
    state->calm_since = then.calm_since;
    state->counts.given_up += (int64_t)then.given_up;
    *step_next = then.length;
    *reaches = parts == 1;
    return 1;
}

static int rigid_step(Simulator *rope, State *state, double t_end, char *message) {
    const double h = t_end - state->t, before = state->power_ends;
    if (!rigid_state(rope, state, t_end, message)) return 0;
    set_powers(rope, state);
    state->energy_balance.work_ends += 0.5 * h * (before + state->power_ends);
    state->counts.steps += 1;
    return 1;
}

/* the state after one accepted step; 0 and a message when there is none */
static int step_towards(Simulator *rope, State *state, double t_end, char *message) {
    if (state->fidelity == RIGID) return rigid_step(rope, state, t_end, message);
    transform_if_due(rope, state);
    release_swivels(rope, state);
    const double stop = next_stop(rope, state, t_end);
    double step_next;
    int reaches, switching;
    Trial trial;
    for (;;) {
        if (!accepted_step(rope, state, stop, &trial, &step_next, &reaches, message)) return 0;
        const double whole = trial.t - state->t;
        switching = switching_step(rope, state, &trial);
        if (switching >= 0) break;
        /* a shorter one may not reach the event, or find it more easily */
        state->step_next = fmax(0.5 * whole, rope->scene.solver.step_min);
        if (state->step_next > 0.75 * whole) return say_step_to_event_fails(message, newton_text(trial.newton.status));
        state->counts.rejections += 1;
    }
    commit(rope, state, &trial);
    state->step_next = step_next;
    state->counts.steps += 1;
    if (switching) {
        switch_swivels(rope, state);
        if (chatters(state)) return say_swivel_chatters(message);
    } else if (reaches) {
        state->t = stop; /* to the bit, not to rounding */
    }
    with_loop_yaw(state);
    return 1;
}

/* the ends' next paths, and the fidelity that can follow them; 0 when none can */
static int follow(Simulator *rope, State *state, double t, const EndMotion ends[2], double given_at) {
    const Scene *scene = &rope->scene;
    const Rates rates = follow_rates(scene);
    const double begin = state->t, trusted = scene->inputs.given, bottom = bottom_of(rope, rope->state, begin);
    for (int side = LEFT; side <= RIGHT; side++) {
        const Path *before = &rope->state->paths[side];
        const Following now =
            follow_sample(&state->following[side], &rates, trusted, given_at, t - before->stop, &ends[side]);
        const Path path = follow_path(before, &now, t, rates.observer);
        double limits[3][4];
        follow_limits(&path, &now, limits);
        end_refusal(&scene->inputs, &ends[side], limits, side, rope->message);
        if (!rope->message[0]) end_frozen(&scene->inputs, t, &now, side, rope->message);
        if (rope->message[0]) return 0;
        const double leg = side == LEFT ? bottom : scene->rope.length - bottom;
        state->paths[side] = path;
        state->following[side] = follow_account(&now, &path, &rates, &scene->rope, trusted, leg);
    }
    char why[MESSAGE];
    EndMotion seen[2] = {ends[LEFT], ends[RIGHT]};
    for (int side = LEFT; side <= RIGHT && scene->inputs.given != ALL_GIVEN; side++)
        seen[side] = path_at(&state->paths[side], t);
    fidelity_unsupported_motion(&rope->scene, state->fidelity, seen, rope->forces.number, why);
    if (!why[0]) return 1;
    if (rope->scene.model.fidelity != AUTO_FIDELITY)
        return say_fixed_model_cannot_follow(rope->message, fidelity_name(state->fidelity), why);
    if (!raise_fidelity(rope, state, why, rope->message)) return 0;
    audit_begin(rope, state);
    return 1;
}

static int advance(Simulator *rope, double t, const EndMotion ends[2], double given_at) {
    State *state = rope->next;
    const double begin = rope->state->t, step_max = rope->scene.solver.step_max;
    const int64_t steps_before = rope->state->counts.steps + rope->state->counts.rejections;
    if (!rope->initialized) return say_no_state(rope->message);
    if (fabs(t - begin) < ROPE_SHORTEST_INTERVAL) return 1;
    if (!(isfinite(t) && t > begin)) return say_time_goes_back(rope->message, begin, t);
    if (t - begin > MOST_STEPS * step_max)
        return say_too_far_at_once(rope->message, begin, t, MOST_STEPS, step_max, MOST_STEPS * step_max);
    state_copy(rope, state, rope->state);
    state->switched = state->event_count = 0;
    rope->work_end = state->counts.newton + (rope->scene.solver.work_max > 0 ? rope->scene.solver.work_max : INT32_MAX);
    if (!follow(rope, state, t, ends, given_at)) return 0;
    const Arrays m = state_arrays(state);
    double impulse[2] = {0, 0};
    const double most = most_work(t - begin, step_max);
    const int64_t newton_before = rope->state->counts.newton;
    while (state->t < t) {
        const double t_before = state->t, before[2] = {m.reaction[1], end_row(m.reaction, m.nodes, RIGHT)[1]};
        char why[MESSAGE] = "";
        const int64_t newton = state->counts.newton - newton_before;
        if ((double)newton >= most) return say_too_much_work(rope->message, t_before, (int)newton, begin, t);
        if (state->counts.steps + state->counts.rejections - steps_before >= MOST_STEPS)
            return say_too_many_steps(rope->message, t_before, MOST_STEPS, begin, t);
        if (!step_towards(rope, state, t, why)) return say_fails_at(rope->message, t_before, why);
        if (state->t >= t || state->t - state->looked_at >= LOOK_EVERY) {
            see_passages(rope, state);
            guards_look(&rope->scene, state);
        }
        for (int side = LEFT; side <= RIGHT; side++)
            impulse[side] -= 0.5 * (state->t - t_before) * (before[side] + end_row(m.reaction, m.nodes, side)[1]);
    }
    audit_interval(rope, state, t - begin, energy_residual(&rope->state->energy_balance));
    state->last_interval = t - begin;
    if (state->counts.given_up > 0 && rope->state->counts.given_up == 0) state->given_up_since = begin;
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = impulse[side] / (t - begin);
    return accept_next(rope);
}

int rope_advance(Simulator *rope, double t, const EndMotion ends[2], double given_at) {
    return conclude(rope, advance(rope, t, ends, given_at));
}

size_t rope_state_bytes(const Simulator *rope) {
    return rope->state_bytes;
}

void rope_save(const Simulator *rope, void *to) {
    memcpy(to, rope->state, rope->state_bytes);
}

int rope_restore(Simulator *rope, const void *from, size_t bytes) {
    State *state = rope->next;
    if (bytes != rope->state_bytes) return say_wrong_number_of_bytes(rope->message, (int)bytes, (int)rope->state_bytes);
    memcpy(state, from, bytes);
    if (!state_plausible(rope, state)) return say_bytes_are_no_state(rope->message);
    refer(rope, state, state_arrays(state).q);
    return accept_next(rope);
}
