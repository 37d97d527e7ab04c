/* The rope in time: rope_model.simulation.simulator, which see. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulator.h"
#include "text.h"

#define GROW_BELOW 0.1
#define TWIST_STEP 1.
#define FARTHEST_START 1e10
enum { MOST_STEPS = 20000 };

int fails(Simulator *rope, const char *message) {
    if (message != rope->message) snprintf(rope->message, MESSAGE, "%s", message);
    return 0;
}

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    message[0] = '\0';
    check_scene(scene, message);
    if (message[0]) return NULL;
    const Mesh mesh = mesh_fit(&scene->mesh, &scene->rope, &scene->layout);
    const int elements = mesh_elements(&mesh, scene->rope.length, message);
    if (elements == 0) {
        const size_t used = strlen(message);
        if (scene->mesh.kind == AUTO_MESH)
            snprintf(message + used, MESSAGE - used,
                     " (mesh.kind = auto takes them from EI, mass_per_length, spacing and loop_error)");
        return NULL;
    }
    Simulator *rope = with_memory(elements, memory, message);
    if (rope == NULL) return NULL;
    rope->scene = *scene;
    rope->mesh = mesh;
    return rope;
}

const char *rope_message(const Simulator *rope) {
    return rope->message;
}

int rope_is_initialized(const Simulator *rope) {
    return rope->initialized;
}

int rope_has_moved(const Simulator *rope) {
    return rope->initialized && rope->state->counts.steps > 0;
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
    char message[MESSAGE] = "";
    check_scene(scene, message);
    if (message[0]) return fails(rope, message);
    rope->scene.solver = scene->solver;
    memcpy(rope->scene.swivels, scene->swivels, sizeof scene->swivels);
    rope->known = 0;
    return 1;
}

/* the state at rest in equilibrium */
static int equilibrium_in_frame(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state);
    const size_t bytes = sizeof(double) * (size_t)m.nodes * DOF;
    const double offset = state->offsets[RIGHT];
    double balance[BALANCE];
    System s;
    if (!find_equilibrium(rope, state, message)) return 0;
    memset(m.v, 0, bytes);
    memset(m.a, 0, bytes);
    memset(m.b, 0, bytes);
    memset(m.a_rate, 0, bytes);
    state->h = 0;
    s = system_of(rope, state);
    chain_of_state(state)->evaluate(&s, m.q, m.v, m.a, m.reaction, rope->x, balance);
    set_energies(&state->energy_balance, balance, &s, m.v);
    /* a loop that yaws by psi turns the frame of the right end by -2 psi: which tells full turns on a long way */
    state->loop_yaw -= 0.5 * (state->offsets[RIGHT] - offset);
    with_loop_yaw(state);
    return 1;
}

/* the state at rest, its twist put in bit by bit: that decides how the loop yaws */
static int hang(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state);
    double left[3][DOF], right[3][DOF], twist;
    int node, part, parts;
    prescribed_motion(rope, state, LEFT, state->t, left);
    prescribed_motion(rope, state, RIGHT, state->t, right);
    for (node = 0; node < m.nodes; ++node) m.q[(size_t)node * DOF + ANGLE] = left[0][ANGLE];
    twist = right[0][ANGLE] - left[0][ANGLE];
    parts = (int)fmax(ceil(fabs(twist) / TWIST_STEP), 1);
    state->offsets[RIGHT] -= twist;
    for (part = 0; part < parts; ++part) {
        state->offsets[RIGHT] += twist / parts;
        if (!equilibrium_in_frame(rope, state, message)) return 0;
    }
    return 1;
}

/* as mesh_placement_problem; where the mesh was fitted to the rope, with what it was fitted to */
static void placement_problem(const Simulator *rope, const Pattern *pattern, double bottom, char *message) {
    const Rope *data = &rope->scene.rope;
    mesh_placement_problem(pattern, data->length, bottom, message);
    if (message[0] && rope->scene.mesh.kind == AUTO_MESH)
        snprintf(message, MESSAGE,
                 "the loop at %s m of the rope's %s m is too close to an end: mesh.kind = auto covers what EI = %s "
                 "N m^2 bends, some (EI / rho g)^(1/3) = %s m to either side, and reaches no further than %s m; check "
                 "EI and length, take equal elements (mesh.kind = eem, code 1), or keep the ends closer in height",
                 ROUNDED(bottom, 3), ROUNDED(data->length, 4), ROUNDED(data->EI, 4),
                 ROUNDED(bending_length(&rope->scene), 3), ROUNDED(mesh_centre(pattern), 3));
}

static int start(Simulator *rope, double t, const EndMotion ends[2]) {
    const Scene *scene = &rope->scene;
    State *state = rope->next;
    char message[MESSAGE] = "";
    double points[2][3], bottom;
    Arrays m;
    int side, k;
    if (!(fabs(t) <= FARTHEST_START)) {
        snprintf(rope->message, MESSAGE,
                 "the start time t = %s s is out of range: it must be within %s s of 0, or steps are lost in rounding; "
                 "count from another instant",
                 EXACT(t), ROUNDED(FARTHEST_START, 6));
        return 0;
    }
    memset(state, 0, rope->state_bytes);
    state->elements = rope->elements;
    state->t = t;
    for (side = 0; side < 2; ++side) {
        const EndMotion *end = &ends[side];
        double fastest = fabs(end->yaw_rate);
        state->paths[side] = path_resting(t, end);
        end_refusal(end, &state->paths[side], side, message);
        if (message[0]) return fails(rope, message);
        for (k = 0; k < 3; ++k) fastest = fmax(fastest, fabs(end->v[k]));
        if (fastest > 1e-6) {
            snprintf(rope->message, MESSAGE, "the %s end moves at the start; a run starts from rest: give zero speeds",
                     side == LEFT ? "left" : "right");
            return 0;
        }
        for (k = 0; k < 3; ++k) points[side][k] = end->x[k];
        points[side][0] += (side ? 0.5 : -0.5) * scene->layout.spacing;
    }
    state->fidelity = fidelity_choose(scene, ends, state->fidelity_reason);
    bottom = bottom_of(rope, state, t);
    m = state_arrays(state);
    mesh_partition(&rope->mesh, scene->rope.length, bottom, m.elements, &state->pattern, m.lengths);
    mesh_arc_lengths(m.elements, m.lengths, m.s);
    shape_hanging_guess(m.nodes, m.s, points[LEFT], points[RIGHT], m.q, message);
    if (!message[0]) fidelity_unsupported_motion(scene, state->fidelity, ends, message);
    if (!message[0]) placement_problem(rope, &state->pattern, bottom, message);
    if (message[0]) return fails(rope, message);
    state->offsets[RIGHT] = right_offset(points[LEFT], points[RIGHT]);
    state->swivels[RIGHT].angle = scene->rope.installed_twist;
    state->step_next = state->last_interval = scene->solver.step_max;
    if (!(state->fidelity == RIGID ? rigid_state(rope, state, t, message) : hang(rope, state, message)))
        return fails(rope, message);
    for (side = 0; side < 2; ++side) state->force_mean[side] = -end_row(m.reaction, m.nodes, side)[1];
    state->energy_balance.start = energy_total(&state->energy_balance);
    state->event_count = 0;
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
    return mesh_distance_to_due(&at->state->pattern, bottom_of(at->rope, at->state, time));
}

/* the instant at which the coming steps must end: the host's, a release, or a transformation that a step would carry
   the loop too far past */
static double next_stop(const Simulator *rope, const State *state, double t_end) {
    const double t = state->t, stop = fmin(t_end, next_release(rope, state));
    const double ahead = fmin(stop, t + fmin(state->step_next, rope->scene.solver.step_max));
    Looked at;
    double start, times[2];
    int k;
    at.rope = rope;
    at.state = state;
    start = due_at(&at, t);
    times[0] = 0.5 * (t + ahead);
    times[1] = ahead;
    /* a crossing that falls between these instants is found by the next step, at most one step late */
    for (k = 0; k < 2; ++k) {
        const double then = due_at(&at, times[k]);
        if (0 > start && then >= MESH_LATEST * state->pattern.coarse)
            return fmin(locate(due_at, &at, t, times[k], start, then, 1e-9), stop);
    }
    return stop;
}

/* a step towards `stop` that converges and errs little enough, halved as often as it takes; 0 and a message if none */
static int accepted_step(Simulator *rope, State *state, double stop, Trial *trial, double *step_next, int *reaches,
                         char *message) {
    const Solver *solver = &rope->scene.solver;
    double next = fmin(state->step_next, solver->step_max), h;
    double parts = fmax(ceil((stop - state->t) / next - 1e-9), 1);
    int rejected = 0;
    h = (stop - state->t) / parts;
    for (;;) {
        char cause[MESSAGE / 2];
        *trial = trial_step(rope, state, h);
        state->counts.newton += trial->newton.iterations;
        if (trial->reached && trial->error <= solver->tolerance) break;
        rejected = 1;
        state->counts.rejections += 1;
        if (h <= solver->step_min) {
            if (trial->reached)
                snprintf(cause, sizeof cause, "the local error %s exceeds the tolerance %s", ROUNDED(trial->error, 3),
                         ROUNDED(solver->tolerance, 3));
            else
                snprintf(cause, sizeof cause, "%s", newton_text(trial->newton.status));
            snprintf(message, MESSAGE,
                     "a step of %s s, step_min = %s s, fails too: %s. Use shorter elements (coarse_length), a smaller "
                     "step_min, or a gentler motion",
                     ROUNDED(h, 3), ROUNDED(solver->step_min, 6), cause);
            return 0;
        }
        h = fmax(0.5 * h, solver->step_min);
        parts *= 2;
        next = h;
    }
    if (!rejected && trial->error < GROW_BELOW * solver->tolerance) next = fmin(2 * next, solver->step_max);
    *step_next = next;
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
    const double step_min = rope->scene.solver.step_min;
    double stop, step_next, whole;
    int reaches, switching;
    Trial trial;
    if (state->fidelity == RIGID) return rigid_step(rope, state, t_end, message);
    transform_if_due(rope, state);
    release_swivels(rope, state);
    placement_problem(rope, &state->pattern, bottom_of(rope, state, state->t), message);
    if (message[0]) return 0;
    stop = next_stop(rope, state, t_end);
    for (;;) {
        if (!accepted_step(rope, state, stop, &trial, &step_next, &reaches, message)) return 0;
        whole = trial.t - state->t;
        switching = switching_step(rope, state, &trial);
        if (switching >= 0) break;
        /* a shorter one may not reach the event, or find it more easily */
        state->step_next = fmax(0.5 * whole, step_min);
        if (state->step_next > 0.75 * whole) {
            snprintf(message, MESSAGE, "the step to a swivel event fails: %s", newton_text(trial.newton.status));
            return 0;
        }
        state->counts.rejections += 1;
    }
    commit(rope, state, &trial);
    state->step_next = step_next;
    state->counts.steps += 1;
    if (switching) {
        switch_swivels(rope, state);
        if (chatters(state)) {
            snprintf(message, MESSAGE,
                     "a swivel chatters between stick and slip; check its friction, and whether the end is slack");
            return 0;
        }
    } else if (reaches) {
        state->t = stop; /* to the bit, not to rounding */
    }
    with_loop_yaw(state);
    return 1;
}

static int advance(Simulator *rope, double t, const EndMotion ends[2], double within) {
    State *state = rope->next;
    const double start = rope->state->t, step_max = rope->scene.solver.step_max;
    const int64_t before_steps = rope->state->counts.steps + rope->state->counts.rejections;
    double impulse[2] = {0, 0};
    char message[MESSAGE] = "";
    int side;
    if (!rope->initialized) return fails(rope, "the rope has no state yet; call initialize first");
    if (fabs(t - start) < ROPE_SHORTEST_INTERVAL) return 1;
    if (!(isfinite(t) && t > start)) {
        snprintf(rope->message, MESSAGE, "cannot advance from t = %s s to %s s; time must go forward",
                 ROUNDED(start, 6), EXACT(t));
        return 0;
    }
    if (t - start > MOST_STEPS * step_max) {
        snprintf(rope->message, MESSAGE,
                 "cannot advance from t = %s s to %s s at once: that takes more than %d steps of step_max = %s s; "
                 "communicate every %s s or more often",
                 ROUNDED(start, 6), EXACT(t), MOST_STEPS, ROUNDED(step_max, 6), ROUNDED(MOST_STEPS * step_max, 6));
        return 0;
    }
    state_copy(rope, state, rope->state);
    for (side = 0; side < 2; ++side) state->paths[side] = path_to(&rope->state->paths[side], t, &ends[side], within);
    for (side = 0; side < 2; ++side) {
        end_refusal(&ends[side], &state->paths[side], side, message);
        if (message[0]) return fails(rope, message);
    }
    state->switched = state->event_count = 0;
    fidelity_unsupported_motion(&rope->scene, state->fidelity, ends, message);
    if (message[0]) {
        char why[MESSAGE];
        memcpy(why, message, sizeof why);
        message[0] = '\0';
        if (rope->scene.model.fidelity != AUTO_FIDELITY) {
            snprintf(rope->message, MESSAGE,
                     "the %s model cannot follow %.300s; set model.fidelity = auto (or torsional)",
                     fidelity_name(state->fidelity), why);
            return 0;
        }
        if (!raise_fidelity(rope, state, why, message)) return fails(rope, message);
    }
    while (state->t < t) {
        const Arrays m = state_arrays(state);
        const double before_t = state->t;
        double before[2];
        if (state->counts.steps + state->counts.rejections - before_steps >= MOST_STEPS) {
            snprintf(rope->message, MESSAGE,
                     "t = %s s: %d steps did not lead from t = %s s to %s s; communicate more often, or allow longer "
                     "steps by step_max, step_min and tolerance",
                     ROUNDED(before_t, 6), MOST_STEPS, ROUNDED(start, 6), EXACT(t));
            return 0;
        }
        for (side = 0; side < 2; ++side) before[side] = end_row(m.reaction, m.nodes, side)[1];
        if (!step_towards(rope, state, t, message)) {
            snprintf(rope->message, MESSAGE, "t = %s s: %.480s", ROUNDED(before_t, 6), message);
            return 0;
        }
        for (side = 0; side < 2; ++side)
            impulse[side] -= 0.5 * (state->t - before_t) * (before[side] + end_row(m.reaction, m.nodes, side)[1]);
    }
    state->last_interval = t - start;
    for (side = 0; side < 2; ++side) state->force_mean[side] = impulse[side] / (t - start);
    return accept_next(rope);
}

int rope_advance(Simulator *rope, double t, const EndMotion ends[2], double within) {
    return conclude(rope, advance(rope, t, ends, within));
}

size_t rope_state_bytes(const Simulator *rope) {
    return rope->state_bytes;
}

void rope_save(const Simulator *rope, void *to) {
    memcpy(to, rope->state, rope->state_bytes);
}

int rope_restore(Simulator *rope, const void *from, size_t bytes) {
    State *state = rope->next;
    if (bytes != rope->state_bytes) {
        snprintf(rope->message, MESSAGE,
                 "the saved state has %lu bytes, one of this rope %lu; restore it into a rope with the same parameters",
                 (unsigned long)bytes, (unsigned long)rope->state_bytes);
        return 0;
    }
    memcpy(state, from, bytes);
    if (!state_plausible(rope, state))
        return fails(rope, "these bytes are not a state of this rope; save one anew, or restore it into its own rope");
    refer(rope, state, state_arrays(state).q);
    return accept_next(rope);
}
