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
    Simulator *sim = allocate_simulator(scene, elements, memory, message);
    if (sim == NULL) return NULL;
    sim->mesh = mesh;
    sim->obstacles->bodies = may_touch(&scene->shaft);
    return sim;
}

const char *rope_message(const Simulator *sim) {
    return sim->message;
}

int rope_is_initialized(const Simulator *sim) {
    return sim->initialized;
}

double rope_time(const Simulator *sim) {
    return sim->state->t;
}

int rope_elements(const Simulator *sim) {
    return sim->elements;
}

const char *rope_fidelity(const Simulator *sim) {
    return sim->initialized ? fidelity_name(sim->state->fidelity) : "";
}

const char *rope_fidelity_reason(const Simulator *sim) {
    return sim->initialized ? sim->state->fidelity_reason : "";
}

/* Make `next` the state. */
static int accept(Simulator *sim) {
    State *before = sim->state;
    sim->state = sim->next;
    sim->next = before;
    sim->computed_groups = 0;
    sim->bottom_known = 0;
    sim->initialized = 1;
    sim->message[0] = '\0';
    return 1;
}

int rope_retune(Simulator *sim, const Scene *scene) {
    check_scene(scene, sim->message);
    if (sim->message[0]) return 0;
    sim->scene.solver = scene->solver;
    memcpy(sim->scene.swivels, scene->swivels, sizeof scene->swivels);
    sim->scene.shaft.air = scene->shaft.air;
    sim->computed_groups = 0;
    return 1;
}

/* Set the ends at rest, with their suspension points; return 0 with a message if they cannot rest. */
static int hold_ends(Simulator *sim, State *state, const EndMotion ends[2], double points[2][3]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const Path path = path_resting(state->t, end);
        state->filters[side] = filter_resting(state->t, end);
        double measures[14];
        path_measures(&path, &state->filters[side], measures);
        ends_refusal(&sim->scene, end, measures, side, sim->message);
        if (sim->message[0]) return 0;
        double fastest = fabs(end->yaw_rate);
        for (int k = 0; k < 3; k++) fastest = fmax(fastest, fabs((&end->vx)[k]));
        if (fastest > RESTS_BELOW) return say_moves_at_start(sim->message, SIDE_NAMES[side]);
    }
    paths_at_rest(sim, state, ends, sim->scene.model.fidelity == RIGID); /* a rigid rope needs no steps */
    const EndMotion first[2] = {path_at(&state->paths[LEFT], state->t), path_at(&state->paths[RIGHT], state->t)};
    suspension_points(&sim->scene.layout, &first[LEFT], &first[RIGHT], points);
    return 1;
}

static int initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    const Scene *scene = &sim->scene;
    State *state = sim->next;
    char *message = sim->message;
    if (!(fabs(t) <= MAX_START_TIME)) return say_start_time_out_of_range(message, t, MAX_START_TIME);
    memset(state, 0, sim->state_bytes);
    state->elements = sim->elements;
    state->t = state->calm_since = t;
    char why[MESSAGE];
    double points[2][3];
    if (!hold_ends(sim, state, ends, points)) return 0;
    state->fidelity = choose_fidelity(scene, ends, sim->forces.count, state->fidelity_reason);
    unsupported_motion(scene, state->fidelity, ends, sim->forces.count, why);
    if (why[0]) return say_fixed_model_cannot_follow(message, fidelity_name(state->fidelity), why);
    const NodalArrays nodal = state_arrays(state);
    double divider_s[DIVIDERS];
    model_dividers(sim, state, t, divider_s);
    partition(&sim->mesh, scene->rope.length, model_bottom_s(sim, state, t), divider_s, nodal.elements, &state->pattern,
              nodal.lengths);
    arc_lengths(nodal.elements, nodal.lengths, nodal.s);
    hanging_guess(nodal.nodes, nodal.s, points[LEFT], points[RIGHT], nodal.q, message);
    if (!message[0]) start_director(state, nodal.q);
    state->offsets[RIGHT] = right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = scene->rope.installed_twist;
    state->step_next = state->last_interval = scene->solver.step_max;
    state->loop_yaw = ends_yaw(&nodal);
    if (message[0] ||
        !(state->fidelity == RIGID ? as_rigid(sim, state, t, message) : hang(sim, state, ends, message))) {
        tell_no_room(scene, state->fidelity, &ends[LEFT], &ends[RIGHT], message);
        return 0;
    }
    if (start_hysteresis(sim, state)) rope_system_refer(sim, state, nodal.q);
    for (int side = LEFT; side <= RIGHT; side++)
        state->force_mean[side] = -end_row(nodal.reaction, nodal.nodes, side)[1];
    state->energy_balance.start = energy_total(&state->energy_balance);
    state->event_count = 0;
    begin_audit(sim, state);
    far_bodies(state->nearest);
    set_rise_reference(scene, state);
    update_passages(sim, state);
    update_guards(scene, state);
    return accept(sim);
}

/* Refer the frames to the state again after a failure. */
static int refer_after_failure(Simulator *sim, int succeeded) {
    if (!succeeded && sim->initialized) rope_system_refer(sim, sim->state, state_arrays(sim->state).q);
    return succeeded;
}

int rope_initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    return refer_after_failure(sim, initialize(sim, t, ends));
}

/* Return the filter of an end with the host's sample, for a step to t. */
static InputFilter follow_end(const State *before, const FilterSettings *settings, int side, double t,
                              const EndMotion *end, double given_at) {
    return filter_sample(&before->filters[side], settings, given_at, t - before->paths[side].stop, end);
}

/* Update the misfit of an end up to the stop of its path. */
static void account_end(const Simulator *sim, State *state, const FilterSettings *settings, int side,
                        const InputFilter *now) {
    const double bottom_s = model_bottom_s(sim, sim->state, sim->state->t);
    const double leg = side == LEFT ? bottom_s : sim->scene.rope.length - bottom_s;
    state->filters[side] = add_misfit(now, &state->paths[side], settings, &sim->scene.rope, leg);
}

/* Set the next paths of the ends, and raise the fidelity if they need it; return 0 with a message on failure. */
static int move_ends(Simulator *sim, State *state, double t, const EndMotion ends[2], double given_at) {
    const Scene *scene = &sim->scene;
    const FilterSettings settings = filter_settings(scene, scene->inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(sim->state, &settings, side, t, &ends[side], given_at);
        const Path path = filter_path(&sim->state->paths[side], &now, t, settings.observer);
        double measures[14];
        path_measures(&path, &now, measures);
        ends_refusal(scene, &ends[side], measures, side, sim->message);
        if (!sim->message[0]) stale_input_error(&scene->inputs, t, &now, side, sim->message);
        if (sim->message[0]) return 0;
        state->paths[side] = path;
        account_end(sim, state, &settings, side, &now);
    }
    char why[MESSAGE];
    EndMotion filtered[2] = {ends[LEFT], ends[RIGHT]};
    for (int side = LEFT; side <= RIGHT && scene->inputs.given != ALL_GIVEN; side++)
        filtered[side] = path_at(&state->paths[side], t);
    unsupported_motion(&sim->scene, state->fidelity, filtered, sim->forces.count, why);
    if (!why[0]) return 1;
    if (sim->scene.model.fidelity != AUTO_FIDELITY)
        return say_fixed_model_cannot_follow(sim->message, fidelity_name(state->fidelity), why);
    if (!raise_fidelity(sim, state, why, sim->message)) return 0;
    begin_audit(sim, state);
    return 1;
}

/* True if an event has happened since the communication step began, or is due now. */
static int has_event(const Simulator *sim, const State *state) {
    const State *before = sim->state;
    int found = state->event_count > 0 && state->events[state->event_count - 1].t > before->t;
    found |= state->guard.cause != before->guard.cause;
    found |= state->fidelity != RIGID && next_release(sim, state) <= state->t;
    for (int kind = 0; kind < KINDS; kind++)
        found |= state->nearest[kind].touched_at != before->nearest[kind].touched_at;
    return found;
}

/* End the paths of the ends, and their misfits, at t. */
static void cut_paths(const Simulator *sim, State *state, double t, const EndMotion ends[2], double given_at) {
    const FilterSettings settings = filter_settings(&sim->scene, sim->scene.inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(sim->state, &settings, side, t, &ends[side], given_at);
        state->paths[side].stop = t;
        account_end(sim, state, &settings, side, &now);
        /* the path meets the given acceleration at its planned stop only */
        state->filters[side].acceleration_misfit = now.acceleration_misfit;
        state->filters[side].misfit_squares[2] = now.misfit_squares[2];
    }
}

/* Advance to t, or to an event unless `event` is NULL.  An event may end it after CHATTER_TIME, to detect chatter. */
static int advance_to(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event) {
    State *state = sim->next;
    const double begin = sim->state->t, step_max = sim->scene.solver.step_max;
    const double earliest = begin - sim->scene.inputs.hold_max;
    const int64_t steps_before = sim->state->counts.steps + sim->state->counts.rejections;
    if (!sim->initialized) return say_no_state(sim->message);
    if (fabs(t - begin) < ROPE_MIN_INTERVAL) return 1;
    if (!(isfinite(t) && t > begin)) return say_time_goes_back(sim->message, begin, t);
    if (t - begin > MAX_STEPS * step_max)
        return say_too_far_at_once(sim->message, begin, t, MAX_STEPS, step_max, MAX_STEPS * step_max);
    if (!(earliest <= given_at && given_at <= t + ROPE_MIN_INTERVAL))
        return say_motions_of_another_time(sim->message, given_at, earliest, t);
    state_copy(sim, state, sim->state);
    state->switched = state->event_count = 0;
    sim->newton_limit =
        state->counts.newton + (sim->scene.solver.work_max > 0 ? sim->scene.solver.work_max : INT32_MAX);
    if (!move_ends(sim, state, t, ends, given_at)) return 0;
    const NodalArrays nodal = state_arrays(state);
    double impulse[2] = {0, 0};
    const double most = max_iterations(t - begin, step_max);
    const int64_t newton_before = sim->state->counts.newton;
    while (state->t < t) {
        const double t_before = state->t,
                     before[2] = {nodal.reaction[1], end_row(nodal.reaction, nodal.nodes, RIGHT)[1]};
        char why[MESSAGE];
        const int64_t newton = state->counts.newton - newton_before;
        if ((double)newton >= most) return say_too_much_work(sim->message, t_before, (int)newton, begin, t);
        if (state->counts.steps + state->counts.rejections - steps_before >= MAX_STEPS)
            return say_too_many_steps(sim->message, t_before, MAX_STEPS, begin, t);
        if (!step_towards(sim, state, t, why)) return say_fails_at(sim->message, t_before, why);
        if (state->t >= t || state->t - state->monitored_at >= MONITOR_INTERVAL) {
            update_passages(sim, state);
            update_guards(&sim->scene, state);
        }
        if (event != NULL) *event |= has_event(sim, state);
        if (event != NULL && *event && state->t < t && state->t - begin >= CHATTER_TIME) {
            t = state->t; /* last round */
            cut_paths(sim, state, t, ends, given_at);
        }
        for (int side = LEFT; side <= RIGHT; side++)
            impulse[side] -=
                0.5 * (state->t - t_before) * (before[side] + end_row(nodal.reaction, nodal.nodes, side)[1]);
    }
    if (event != NULL && *event && state->fidelity != RIGID) release_swivels(sim, state);
    audit_interval(sim, state, t - begin, energy_residual(&sim->state->energy_balance));
    state->last_interval = t - begin;
    if (state->counts.given_up > 0 && sim->state->counts.given_up == 0) state->given_up_since = begin;
    for (int side = LEFT; side <= RIGHT; side++) state->force_mean[side] = impulse[side] / (t - begin);
    return accept(sim);
}

int rope_advance_to(Simulator *sim, double t, const EndMotion ends[2], double given_at) {
    return refer_after_failure(sim, advance_to(sim, t, ends, given_at, NULL));
}

int rope_advance_to_event(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event) {
    const InputFilter *filters = sim->state->filters;
    int same = *event != 0;
    for (int side = LEFT; side <= RIGHT; side++) same &= !memcmp(&ends[side], filters[side].given, sizeof ends[side]);
    if (same) given_at = fmin(filters[LEFT].given_at, filters[RIGHT].given_at);
    *event = 0;
    return refer_after_failure(sim, advance_to(sim, t, ends, given_at, event));
}

size_t rope_state_bytes(const Simulator *sim) {
    return sim->state_bytes;
}

void rope_save(const Simulator *sim, void *to) {
    memcpy(to, sim->state, sim->state_bytes);
}

int rope_restore(Simulator *sim, const void *from, size_t bytes) {
    State *state = sim->next;
    if (bytes != sim->state_bytes) return say_wrong_number_of_bytes(sim->message, (int)bytes, (int)sim->state_bytes);
    memcpy(state, from, bytes);
    if (!state_plausible(sim, state)) return say_no_state_in_bytes(sim->message);
    rope_system_refer(sim, state, state_arrays(state).q);
    return accept(sim);
}

void rope_apply(Simulator *sim, const PointForces *forces) {
    sim->forces = *forces;
}

void rope_rows(const Simulator *sim, double (*rows)[13]) {
    const NodalArrays nodal = state_arrays(sim->state);
    for (int node = 0; node < nodal.nodes; node++) {
        const double *q = nodal.q + (size_t)node * DOF, *v = nodal.v + (size_t)node * DOF;
        rows[node][0] = nodal.s[node];
        memcpy(rows[node] + 1, q, ANGLE * sizeof *q);
        memcpy(rows[node] + 1 + ANGLE, v, ANGLE * sizeof *v);
    }
}

void rope_displacement(Simulator *sim, const PointForces *forces, double (*moved)[3]) {
    State *state = sim->state;
    memset(moved, 0, sizeof *moved * (size_t)forces->count);
    if (!sim->initialized) return;
    const NodalArrays nodal = state_arrays(state);
    const Coefficients method = {sim->scene.solver.rho_inf};
    System sys = rope_system(sim, state);
    sys.time = forces->start;
    double c[3], *const answers[2] = {sim->trial.q, sim->x};
    newton_coefficients(&method, state->last_interval, c);
    for (int k = 0; k < 2; k++) {
        sys.forces = k == 0 ? NULL : forces;
        chain_of(sim, state)
            ->newton_step(&sys, sim->work, nodal.q, nodal.v, nodal.a, nodal.reaction, c, k, answers[k], sim->trial.v);
    }
    PointForce point = {0};
    for (int index = 0; index < forces->count; index++) {
        double without[3];
        elements_at(&sys, index, &point);
        at_places(answers[0], point.element, point.N, without);
        at_places(answers[1], point.element, point.N, moved[index]);
        for (int i = 0; i < 3; i++) moved[index][i] -= without[i];
    }
}

/* Return a signal; the first call after a change of state computes its group. */
static double value_of(Simulator *sim, int signal) {
    if (!sim->initialized || signal < 0 || signal >= SIGNALS) return NAN;
    const SignalGroup group = group_of(signal);
    if (!(sim->computed_groups & 1u << group.index)) group.compute(sim, sim->values);
    sim->computed_groups |= 1u << group.index;
    return sim->values[signal];
}

void rope_signals(Simulator *sim, size_t count, const int *signals, double *values) {
    for (size_t k = 0; k < count; k++) values[k] = value_of(sim, signals[k]);
}
