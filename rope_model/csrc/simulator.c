/* The simulator.  C version of rope_model/simulation/simulator.py, which explains the method. */

#include "rules.h"
#include "simulator.h"

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    message[0] = '\0';
    check_scene(scene, message);
    if (message[0]) return NULL;
    const Mesh mesh = fit_mesh(scene);
    double divider_s[DIVIDERS];
    mesh_dividers(scene, 0, 0, divider_s);
    const int elements = partition_elements(&mesh, scene->rope.length, divider_s, message);
    if (elements == 0) {
        char why[MESSAGE];
        memcpy(why, message, sizeof why);
        if (scene->mesh.kind == AUTO_MESH) say_fit_fails(message, why);
        return NULL;
    }
    Simulator *rope = allocate_simulator(scene, elements, memory, message);
    if (rope == NULL) return NULL;
    rope->mesh = mesh;
    rope->obstacles->bodies = may_touch(&scene->shaft);
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

/* Make `next` the state. */
static int accept(Simulator *rope) {
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

/* Set the ends at rest, with their suspension points; return 0 with a message if they cannot rest. */
static int hold_ends(Simulator *rope, State *state, const EndMotion ends[2], double points[2][3]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const Path path = path_resting(state->t, end);
        state->filters[side] = filter_resting(state->t, end);
        double limits[14];
        filter_limits(&path, &state->filters[side], limits);
        ends_refusal(&rope->scene, end, limits, side, rope->message);
        if (rope->message[0]) return 0;
        double fastest = fabs(end->yaw_rate);
        for (int k = 0; k < 3; k++) fastest = fmax(fastest, fabs((&end->vx)[k]));
        if (fastest > RESTS_BELOW) return say_moves_at_start(rope->message, SIDE_NAMES[side]);
    }
    paths_at_rest(rope, state, ends, rope->scene.model.fidelity == RIGID); /* a rigid rope needs no steps */
    const EndMotion first[2] = {path_at(&state->paths[LEFT], state->t), path_at(&state->paths[RIGHT], state->t)};
    suspension_points(&rope->scene.layout, &first[LEFT], &first[RIGHT], points);
    return 1;
}

static int initialize(Simulator *rope, double t, const EndMotion ends[2]) {
    const Scene *scene = &rope->scene;
    State *state = rope->next;
    char *message = rope->message;
    if (!(fabs(t) <= MAX_START_TIME)) return say_start_time_out_of_range(message, t, MAX_START_TIME);
    memset(state, 0, rope->state_bytes);
    state->elements = rope->elements;
    state->t = state->calm_since = t;
    char why[MESSAGE];
    double points[2][3];
    if (!hold_ends(rope, state, ends, points)) return 0;
    state->fidelity = choose_fidelity(scene, ends, rope->forces.number, state->fidelity_reason);
    unsupported_motion(scene, state->fidelity, ends, rope->forces.number, why);
    if (why[0]) return say_fixed_model_cannot_follow(message, fidelity_name(state->fidelity), why);
    const NodalArrays m = state_arrays(state);
    double divider_s[DIVIDERS];
    model_dividers(rope, state, t, divider_s);
    partition(&rope->mesh, scene->rope.length, model_bottom_s(rope, state, t), divider_s, m.elements, &state->pattern,
              m.lengths);
    arc_lengths(m.elements, m.lengths, m.s);
    hanging_guess(m.nodes, m.s, points[LEFT], points[RIGHT], m.q, message);
    state->offsets[RIGHT] = right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = scene->rope.installed_twist;
    state->step_next = state->last_interval = scene->solver.step_max;
    state->loop_yaw = ends_yaw(&m);
    if (message[0] ||
        !(state->fidelity == RIGID ? as_rigid(rope, state, t, message) : hang(rope, state, ends, message))) {
        tell_no_room(scene, state->fidelity, &ends[LEFT], &ends[RIGHT], message);
        return 0;
    }
    if (start_hysteresis(rope, state)) rope_system_refer(rope, state, m.q);
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = -end_row(m.reaction, m.nodes, side)[1];
    state->energy_balance.start = energy_total(&state->energy_balance);
    state->event_count = 0;
    begin_audit(rope, state);
    far_bodies(state->nearest);
    set_rise_reference(scene, state);
    with_passages(rope, state);
    with_guards(scene, state);
    return accept(rope);
}

/* Refer the frames to the state again after a failure. */
static int conclude(Simulator *rope, int succeeded) {
    if (!succeeded && rope->initialized) rope_system_refer(rope, rope->state, state_arrays(rope->state).q);
    return succeeded;
}

int rope_initialize(Simulator *rope, double t, const EndMotion ends[2]) {
    return conclude(rope, initialize(rope, t, ends));
}

/* Return the filter of an end with the host's sample, for a step to t. */
static InputFilter follow_end(const State *before, const FilterSettings *settings, int side, double t,
                              const EndMotion *end, double given_at) {
    return filter_sample(&before->filters[side], settings, given_at, t - before->paths[side].stop, end);
}

/* Update the misfit of an end up to the stop of its path. */
static void account_end(const Simulator *rope, State *state, const FilterSettings *settings, int side,
                        const InputFilter *now) {
    const double bottom_s = model_bottom_s(rope, rope->state, rope->state->t);
    const double leg = side == LEFT ? bottom_s : rope->scene.rope.length - bottom_s;
    state->filters[side] = add_misfit(now, &state->paths[side], settings, &rope->scene.rope, leg);
}

/* Set the next paths of the ends, and raise the fidelity if they need it; return 0 with a message on failure. */
static int move_ends(Simulator *rope, State *state, double t, const EndMotion ends[2], double given_at) {
    const Scene *scene = &rope->scene;
    const FilterSettings settings = filter_settings(scene, scene->inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(rope->state, &settings, side, t, &ends[side], given_at);
        const Path path = filter_path(&rope->state->paths[side], &now, t, settings.observer);
        double limits[14];
        filter_limits(&path, &now, limits);
        ends_refusal(scene, &ends[side], limits, side, rope->message);
        if (!rope->message[0]) stale_input_error(&scene->inputs, t, &now, side, rope->message);
        if (rope->message[0]) return 0;
        state->paths[side] = path;
        account_end(rope, state, &settings, side, &now);
    }
    char why[MESSAGE];
    EndMotion filtered[2] = {ends[LEFT], ends[RIGHT]};
    for (int side = LEFT; side <= RIGHT && scene->inputs.given != ALL_GIVEN; side++)
        filtered[side] = path_at(&state->paths[side], t);
    unsupported_motion(&rope->scene, state->fidelity, filtered, rope->forces.number, why);
    if (!why[0]) return 1;
    if (rope->scene.model.fidelity != AUTO_FIDELITY)
        return say_fixed_model_cannot_follow(rope->message, fidelity_name(state->fidelity), why);
    if (!raise_fidelity(rope, state, why, rope->message)) return 0;
    begin_audit(rope, state);
    return 1;
}

/* True if an event has happened since the communication step began, or is due now. */
static int has_event(const Simulator *rope, const State *state) {
    const State *before = rope->state;
    int found = state->event_count > 0 && state->events[state->event_count - 1].t > before->t;
    found |= state->guard.cause != before->guard.cause;
    found |= state->fidelity != RIGID && next_release(rope, state) <= state->t;
    for (int kind = 0; kind < KINDS; kind++)
        found |= state->nearest[kind].touched_at != before->nearest[kind].touched_at;
    return found;
}

/* End the paths of the ends, and their misfits, at t. */
static void cut_paths(const Simulator *rope, State *state, double t, const EndMotion ends[2], double given_at) {
    const FilterSettings settings = filter_settings(&rope->scene, rope->scene.inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(rope->state, &settings, side, t, &ends[side], given_at);
        state->paths[side].stop = t;
        account_end(rope, state, &settings, side, &now);
        /* the path meets the given acceleration at its planned stop only */
        state->filters[side].acceleration = now.acceleration;
        state->filters[side].squares[2] = now.squares[2];
    }
}

/* Advance to t, or to an event unless `event` is NULL.  An event may end it after CHATTER_TIME, to detect chatter. */
static int advance_to(Simulator *rope, double t, const EndMotion ends[2], double given_at, int *event) {
    State *state = rope->next;
    const double begin = rope->state->t, step_max = rope->scene.solver.step_max;
    const double earliest = begin - rope->scene.inputs.hold_max;
    const int64_t steps_before = rope->state->counts.steps + rope->state->counts.rejections;
    if (!rope->initialized) return say_no_state(rope->message);
    if (fabs(t - begin) < ROPE_MIN_INTERVAL) return 1;
    if (!(isfinite(t) && t > begin)) return say_time_goes_back(rope->message, begin, t);
    if (t - begin > MAX_STEPS * step_max)
        return say_too_far_at_once(rope->message, begin, t, MAX_STEPS, step_max, MAX_STEPS * step_max);
    if (!(earliest <= given_at && given_at <= t + ROPE_MIN_INTERVAL))
        return say_motions_of_another_time(rope->message, given_at, earliest, t);
    state_copy(rope, state, rope->state);
    state->switched = state->event_count = 0;
    rope->newton_limit =
        state->counts.newton + (rope->scene.solver.work_max > 0 ? rope->scene.solver.work_max : INT32_MAX);
    if (!move_ends(rope, state, t, ends, given_at)) return 0;
    const NodalArrays m = state_arrays(state);
    double impulse[2] = {0, 0};
    const double most = max_iterations(t - begin, step_max);
    const int64_t newton_before = rope->state->counts.newton;
    while (state->t < t) {
        const double t_before = state->t, before[2] = {m.reaction[1], end_row(m.reaction, m.nodes, RIGHT)[1]};
        char why[MESSAGE];
        const int64_t newton = state->counts.newton - newton_before;
        if ((double)newton >= most) return say_too_much_work(rope->message, t_before, (int)newton, begin, t);
        if (state->counts.steps + state->counts.rejections - steps_before >= MAX_STEPS)
            return say_too_many_steps(rope->message, t_before, MAX_STEPS, begin, t);
        if (!step_towards(rope, state, t, why)) return say_fails_at(rope->message, t_before, why);
        if (state->t >= t || state->t - state->monitored_at >= MONITOR_INTERVAL) {
            with_passages(rope, state);
            with_guards(&rope->scene, state);
        }
        if (event != NULL) *event |= has_event(rope, state);
        if (event != NULL && *event && state->t < t && state->t - begin >= CHATTER_TIME) {
            t = state->t; /* last round */
            cut_paths(rope, state, t, ends, given_at);
            if (state->fidelity != RIGID) release_swivels(rope, state);
        }
        for (int side = LEFT; side <= RIGHT; side++)
            impulse[side] -= 0.5 * (state->t - t_before) * (before[side] + end_row(m.reaction, m.nodes, side)[1]);
    }
    audit_interval(rope, state, t - begin, energy_residual(&rope->state->energy_balance));
    state->last_interval = t - begin;
    if (state->counts.given_up > 0 && rope->state->counts.given_up == 0) state->given_up_since = begin;
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = impulse[side] / (t - begin);
    return accept(rope);
}

int rope_advance_to(Simulator *rope, double t, const EndMotion ends[2], double given_at) {
    return conclude(rope, advance_to(rope, t, ends, given_at, NULL));
}

int rope_advance_to_event(Simulator *rope, double t, const EndMotion ends[2], double given_at, int *event) {
    const InputFilter *filters = rope->state->filters;
    int same = *event != 0;
    for (int side = LEFT; side <= RIGHT; side++) same &= !memcmp(&ends[side], filters[side].given, sizeof ends[side]);
    if (same) given_at = fmin(filters[LEFT].given_at, filters[RIGHT].given_at);
    *event = 0;
    return conclude(rope, advance_to(rope, t, ends, given_at, event));
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
    if (!state_plausible(rope, state)) return say_no_state_in_bytes(rope->message);
    rope_system_refer(rope, state, state_arrays(state).q);
    return accept(rope);
}

void rope_apply(Simulator *rope, const PointForces *forces) {
    rope->forces = *forces;
}

void rope_rows(const Simulator *rope, double (*rows)[13]) {
    const NodalArrays m = state_arrays(rope->state);
    for (int node = 0; node < m.nodes; node++) {
        const double *q = m.q + (size_t)node * DOF, *v = m.v + (size_t)node * DOF;
        rows[node][0] = m.s[node];
        memcpy(rows[node] + 1, q, ANGLE * sizeof *q);
        memcpy(rows[node] + 1 + ANGLE, v, ANGLE * sizeof *v);
    }
}

void rope_displacement(Simulator *rope, const PointForces *forces, double (*moved)[3]) {
    State *state = rope->state;
    memset(moved, 0, sizeof *moved * (size_t)forces->number);
    if (!rope->initialized) return;
    const NodalArrays m = state_arrays(state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    System s = rope_system(rope, state);
    s.time = forces->start;
    double c[3], *const answers[2] = {rope->trial.q, rope->x};
    newton_coefficients(&method, state->last_interval, c);
    for (int k = 0; k < 2; k++) {
        s.forces = k == 0 ? NULL : forces;
        chain_of(rope, state)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, k, answers[k], rope->trial.v);
    }
    PointForce point = {0};
    for (int number = 0; number < forces->number; number++) {
        double without[3];
        elements_at(&s, number, &point);
        at_places(answers[0], point.element, point.N, without);
        at_places(answers[1], point.element, point.N, moved[number]);
        for (int i = 0; i < 3; i++) moved[number][i] -= without[i];
    }
}

/* Return a signal; the first call after a change of state computes its group. */
static double value_of(Simulator *rope, int signal) {
    if (!rope->initialized || signal < 0 || signal >= SIGNALS) return NAN;
    const SignalGroup group = group_of(signal);
    if (!(rope->known & 1u << group.number)) group.compute(rope, rope->values);
    rope->known |= 1u << group.number;
    return rope->values[signal];
}

void rope_signals(Simulator *rope, size_t number, const int *signals, double *values) {
    for (size_t k = 0; k < number; k++) values[k] = value_of(rope, signals[k]);
}
