/* The simulator.

   It advances a State from one instant of the host to the next. In between it chooses its
   own steps, which end at the instants where a swivel is released or changes between stick and slip. A
   transformation of the mesh waits for a step's end, unless the step would carry the loop MESH_PATTERN_MAX_OVERSHOOT l
   beyond the limit. A step that does not converge or whose error is too large is rejected, halved and repeated.
   When the smallest step fails too, the run returns the reason and keeps the state of the host's last instant. */

#include "simulator.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "allocation.h"
#include "curvature.h"
#include "diagnostics.h"
#include "ends.h"
#include "fidelity.h"
#include "formulas.h"
#include "guards.h"
#include "hang.h"
#include "host_step.h"
#include "messages.h"
#include "parameter_table.h"
#include "partition.h"
#include "point_forces.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "shaft.h"
#include "signal_numbers.h"
#include "signals.h"
#include "state.h"
#include "state_structures.h"
#include "statics.h"
#include "stepping.h"
#include "system.h"
#include "trial_step.h"
#include "wires.h"

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    message[0] = '\0';
    if (!check_scene(scene, message)) return NULL;
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
    sim->obstacles->bodies = bodies_may_touch(&scene->shaft);
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
static RopeStatus accept(Simulator *sim) {
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

RopeStatus rope_retune(Simulator *sim, const Scene *scene) {
    if (!check_scene(scene, sim->message)) return ROPE_FAILED;
    sim->scene.solver = scene->solver;
    memcpy(sim->scene.swivels, scene->swivels, sizeof scene->swivels);
    sim->scene.shaft.air = scene->shaft.air;
    sim->computed_groups = 0;
    sim->replay.known = false;
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
        input_filter_path_measures(&path, &state->filters[side], measures);
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

static RopeStatus initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    const Scene *scene = &sim->scene;
    State *state = sim->next;
    char *message = sim->message;
    if (!(fabs(t) <= STEPPING_MAX_START_TIME)) return say_start_time_out_of_range(message, t, STEPPING_MAX_START_TIME);
    memset(state, 0, sim->state_bytes);
    state->elements = sim->elements;
    state->t = state->calm_since = t;
    char why[MESSAGE];
    double points[2][3];
    if (!hold_ends(scene, state, ends, points, message)) return ROPE_FAILED;
    state->fidelity = choose_fidelity(scene, ends, sim->forces.count, state->fidelity_reason);
    unsupported_motion(scene, state->fidelity, ends, sim->forces.count, why);
    if (why[0]) return say_fixed_model_cannot_follow(message, fidelity_name(state->fidelity), why);
    if (tell_no_room(scene, state->fidelity, &ends[LEFT], &ends[RIGHT], message)) return ROPE_FAILED;
    const NodalArrays nodal = state_arrays(state);
    double divider_s[DIVIDERS];
    dividers_on_rope(&sim->scene, state->paths, t, divider_s);
    partition(&sim->mesh, scene->rope.length, bottom_arc_length(&sim->scene, state->paths, t), divider_s,
              nodal.elements, &state->pattern, nodal.lengths);
    arc_lengths(nodal.elements, nodal.lengths, nodal.s);
    if (!hanging_guess(nodal.nodes, nodal.s, points[LEFT], points[RIGHT], nodal.q, message)) return ROPE_FAILED;
    start_director(state, nodal.q);
    state->offsets[RIGHT] = end_conditions_right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = scene->rope.installed_twist;
    state->step_next = state->last_interval = scene->solver.step_max;
    state->loop_yaw = ends_yaw(&nodal);
    if (!(state->fidelity == RIGID ? as_rigid(sim, state, t, message) : hang(sim, state, ends, message)))
        return ROPE_FAILED;
    if (start_hysteresis(sim->wires, state)) rope_system_refer(sim, state, nodal.q);
    for (int side = LEFT; side <= RIGHT; side++)
        state->force_mean[side] = -end_row(nodal.reaction, nodal.nodes, side)[1];
    state->energy_balance.start = energy_balance_total(&state->energy_balance);
    state->event_count = 0;
    begin_audit(sim, state);
    far_bodies(state->nearest);
    set_rise_reference(scene, state);
    update_passages(&sim->scene, sim->self_contact, state);
    update_guards(scene, state);
    memset(&sim->last, 0, sizeof sim->last); /* equal states are saved as equal bytes */
    return accept(sim);
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
    return accept(sim);
}

/* Advance to the host's stop, or to an event; *event tells which.  Keep the state before as the start. */
static RopeStatus advance_to(Simulator *sim, const HostStep *host, int *event) {
    const double t = host->stop, begin = sim->state->t, step_max = sim->scene.solver.step_max;
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
    return accept(sim);
}

/* Describe a step that the host asks for. */
static HostStep asked(double t, const EndMotion ends[2], double given_at, bool to_event) {
    HostStep host = {.stop = t, .given_at = given_at, .asked_at = given_at, .to_event = to_event, .taken = 1};
    memcpy(host.ends, ends, sizeof host.ends);
    return host;
}

RopeStatus rope_advance_to(Simulator *sim, double t, const EndMotion ends[2], double given_at) {
    const HostStep host = asked(t, ends, given_at, false);
    int event;
    return refer_after_failure(sim, advance_to(sim, &host, &event));
}

RopeStatus rope_advance_to_event(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event) {
    const InputFilter *filters = sim->state->filters;
    HostStep host = asked(t, ends, given_at, true);
    bool same = *event != 0;
    for (int side = LEFT; side <= RIGHT; side++) same &= !memcmp(&ends[side], filters[side].given, sizeof ends[side]);
    if (same) host.given_at = fmin(filters[LEFT].given_at, filters[RIGHT].given_at);
    return refer_after_failure(sim, advance_to(sim, &host, event));
}

/* A saved state: the state, the state before the step that led to it, and what the host asked for in that step. */
size_t rope_state_bytes(const Simulator *sim) {
    return 2 * sim->state_bytes + sizeof sim->last;
}

void rope_save(const Simulator *sim, void *to) {
    char *bytes = to;
    memcpy(bytes, sim->state, sim->state_bytes);
    memcpy(bytes + sim->state_bytes, sim->last.taken ? sim->start : sim->state, sim->state_bytes);
    memcpy(bytes + 2 * sim->state_bytes, &sim->last, sizeof sim->last);
}

RopeStatus rope_restore(Simulator *sim, const void *from, size_t bytes) {
    const char *saved = from;
    State *state = sim->next, *start = sim->spare;
    HostStep last;
    if (bytes != rope_state_bytes(sim))
        return say_wrong_number_of_bytes(sim->message, (int)bytes, (int)rope_state_bytes(sim));
    memcpy(state, saved, sim->state_bytes);
    memcpy(start, saved + sim->state_bytes, sim->state_bytes);
    memcpy(&last, saved + 2 * sim->state_bytes, sizeof last);
    if (!state_plausible(sim, state) ||
        (last.taken && !(state_plausible(sim, start) && host_step_plausible(&last, start, state))))
        return say_no_state_in_bytes(sim->message);
    sim->spare = sim->start;
    sim->start = start;
    sim->last = last;
    rope_system_refer(sim, state, state_arrays(state).q);
    return accept(sim);
}

void rope_apply(Simulator *sim, const PointForces *forces) {
    sim->forces = *forces;
    sim->replay.known = false;
}

void rope_rows(const Simulator *sim, double (*rows)[ROPE_ROW]) {
    const NodalArrays nodal = state_arrays(sim->state);
    for (int node = 0; node < nodal.nodes; node++) {
        const double *q = nodal.q + (size_t)node * DOF, *v = nodal.v + (size_t)node * DOF;
        rows[node][0] = nodal.s[node];
        memcpy(rows[node] + 1, q, ANGLE * sizeof *q);
        memcpy(rows[node] + 1 + ANGLE, v, ANGLE * sizeof *v);
    }
}

RopeStatus rope_displacement(Simulator *sim, const PointForces *forces, double (*moved)[3]) {
    State *state = sim->state;
    memset(moved, 0, sizeof *moved * (size_t)forces->count);
    if (!sim->initialized) return say_no_state(sim->message);
    if (state->fidelity == RIGID) return say_rigid_under_forces(sim->message);
    const NodalArrays nodal = state_arrays(state);
    const Coefficients method = {sim->scene.solver.rho_inf};
    System sys = rope_system(sim, state);
    sys.time = forces->start;
    double c[3], *const answers[2] = {sim->trial.q, sim->x};
    generalized_alpha_newton_coefficients(&method, state->last_interval, c);
    for (int k = 0; k < 2; k++) {
        sys.forces = k == 0 ? NULL : forces;
        chain_of(sim, state)->newton_step(&sys, sim->work, &nodal, c, k, answers[k], sim->trial.v);
    }
    PointForce point = {0};
    for (int index = 0; index < forces->count; index++) {
        double without[3];
        elements_at(&sys, index, &point);
        at_places(answers[0], point.element, point.N, without);
        at_places(answers[1], point.element, point.N, moved[index]);
        for (int i = 0; i < 3; i++) moved[index][i] -= without[i];
    }
    return ROPE_DONE;
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
