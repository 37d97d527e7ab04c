/* One step of the rope: step-size control, swivel events and transformations.

   Steps end at the instants where a swivel is released or changes between stick and slip.  A transformation of the mesh
   waits for a step's end, unless the step would carry the loop MESH_PATTERN_MAX_OVERSHOOT l beyond the limit.  A step
   that does not converge or whose error is too large is rejected, halved and repeated, down to the smallest step. */

#include "stepping.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "adaptation.h"
#include "communication_step.h"
#include "ends.h"
#include "events.h"
#include "formulas.h"
#include "generalized_alpha.h"
#include "messages.h"
#include "rigid.h"
#include "rope.h"
#include "rules.h"
#include "simulator.h"
#include "state_structures.h"
#include "switching.h"
#include "trial_step.h"

static const char *const NEWTON_MESSAGES[] = NEWTON_TEXTS; /* messages of a Newton status */

typedef struct {
    const Scene *scene;
    const State *state;
} DueContext;

static double due_at(void *data, double time) {
    const DueContext *context = data;
    return mesh_pattern_distance_past_limit(&context->state->pattern,
                                            bottom_arc_length(context->scene, context->state->paths, time));
}

/* Return the end of the coming steps: the host's, a release, or a transformation that a step would pass too far. */
static double next_stop(const Scene *scene, const State *state, double t_end) {
    const double t = state->t;
    const double stop = fmin(t_end, next_release(scene, state));
    const double ahead = fmin(stop, t + fmin(state->step_next, scene->solver.step_max));
    const double times[2] = {0.5 * (t + ahead), ahead};
    DueContext context = {.scene = scene, .state = state};
    const double at_start = due_at(&context, t);
    /* The next step finds a crossing between these times, at most one step late. */
    for (int k = 0; k < 2; k++) {
        const double value = due_at(&context, times[k]);
        const bool passes = at_start < 0 && value >= MESH_PATTERN_MAX_OVERSHOOT * state->pattern.coarse;
        if (!passes) continue;
        const Bracket crossing = {.low = t, .high = times[k], .f_low = at_start, .f_high = value};
        return fmin(locate(due_at, &context, crossing, SWIVEL_PHASES_EVENT_WIDTH), stop);
    }
    return stop;
}

/* Return the number of steps, at least one, that the iterations left to this advance allow. */
static int64_t steps_left(int64_t newton_limit, const State *state) {
    const int64_t left = (newton_limit - state->counts.newton) / NEWTON_STEP_ITERATIONS;
    return left > 1 ? left : 1;
}

/* A step that is accepted, unless a swivel switches within it. */
typedef struct {
    StepResult trial;
    double step_next; /* length of the step behind it, s */
    bool reaches;     /* true if it leads to the stop */
} Candidate;

/* Refuse a step of the smallest length, which neither converges nor keeps to the tolerance. */
static RopeStatus refuse_smallest_step(const Solver *solver, double h, const StepResult *trial, char *message) {
    char why[MESSAGE];
    if (!trial->converged) return say_step_fails(message, h, solver->step_min, NEWTON_MESSAGES[trial->newton.status]);
    say_error_too_large(why, trial->error_ratio / solver->tolerance);
    return say_step_fails(message, h, solver->step_min, why);
}

/* Try steps towards `stop`, halved until one converges within the tolerance, or exceeds it if the iterations left allow
   no more steps.  Fail if none does. */
static RopeStatus find_candidate(Simulator *sim, State *state, double stop, Candidate *candidate, char *message) {
    StepResult *trial = &candidate->trial;
    const Solver *solver = &sim->scene.solver;
    double next = fmin(state->step_next, solver->step_max);
    double parts = step_control_substeps(stop - state->t, next, (double)steps_left(sim->newton_limit, state));
    double h = (stop - state->t) / parts;
    bool rejected = false;
    for (;;) {
        *trial = compute_trial(sim, state, h);
        state->counts.newton += trial->newton.iterations;
        if (trial->converged && trial->error_ratio <= STEP_CONTROL_ACCEPT_BELOW * solver->tolerance) break;
        if (trial->converged && stop - state->t > 0.5 * h * (double)steps_left(sim->newton_limit, state)) {
            next = h;
            break;
        }
        rejected = true;
        state->counts.rejections += 1;
        if (h <= solver->step_min) return refuse_smallest_step(solver, h, trial, message);
        h = fmax(0.5 * h, solver->step_min);
        parts = 2;
        next = h;
    }
    const AcceptedStep accepted = {.h = h, .t = trial->t, .error = trial->error_ratio, .rejected = rejected};
    const NextStep following = next_step(solver, &accepted, next, state->calm_since);
    state->calm_since = following.calm_since;
    state->counts.given_up += following.given_up > 0 || trial->newton.error > solver->newton_tolerance;
    candidate->step_next = following.length;
    candidate->reaches = parts == 1;
    return ROPE_DONE;
}

RopeStatus as_rigid(Simulator *sim, State *state, double t, char *message) {
    state->t = t;
    transform_if_due(sim, state);
    const NodalArrays nodal = state_arrays(state);
    const EndMotion ends[2] = {end_path_at(&state->paths[LEFT], t), end_path_at(&state->paths[RIGHT], t)};
    const RopeStatus status = rigid_rope(&sim->scene, ends, t, &nodal, &state->energy_balance, message);
    memcpy(nodal.b, nodal.a, sizeof(double) * (size_t)nodal.nodes * DOF);
    memset(nodal.a_rate, 0, sizeof(double) * (size_t)nodal.nodes * DOF);
    state->h = 0;
    return status;
}

/* Record an internal step that ends at the state's time. */
static void record_step(Replay *replay, const State *state, double h, int corrections, Phases during) {
    if (!replay->recording) return;
    if (replay->count < MAX_TAKEN)
        replay->steps[replay->count] =
            (TakenStep){.h = h, .t = state->t, .corrections = corrections, .during = during, .after = phases_of(state)};
    replay->count++;
}

static RopeStatus rigid_step(Simulator *sim, State *state, double t_end, char *message) {
    const double h = t_end - state->t;
    const double before = state->power_ends;
    if (!as_rigid(sim, state, t_end, message)) return ROPE_FAILED;
    rope_powers(&sim->scene, state);
    state->energy_balance.work_ends += 0.5 * h * (before + state->power_ends);
    const NodalArrays nodal = state_arrays(state);
    state->errors.time += h;
    state->errors.force = fmax(state->errors.force, largest_end_force(&nodal));
    state->counts.steps += 1;
    record_step(&sim->replay, state, h, 0, phases_of(state));
    return ROPE_DONE;
}

RopeStatus step_towards(Simulator *sim, State *state, double t_end, char *message) {
    if (state->fidelity == RIGID) return rigid_step(sim, state, t_end, message);
    const NewtonStatus transformed = transform_if_due(sim, state);
    if (transformed != CONVERGED)
        return say_transformation_fails(message, sim->scene.solver.step_min, NEWTON_MESSAGES[transformed]);
    release_swivels(sim, state);
    const Phases during = phases_of(state);
    const double stop = next_stop(&sim->scene, state, t_end);
    Candidate candidate;
    StepResult *trial = &candidate.trial;
    double end; /* of the candidate, before it is shortened to an event */
    Switching switching;
    for (;;) {
        if (!find_candidate(sim, state, stop, &candidate, message)) return ROPE_FAILED;
        end = trial->t;
        switching = switching_step(sim, state, trial);
        if (switching != NOT_FOUND) break;
        /* A shorter step may not reach the event, or locate it more easily. */
        state->step_next = fmax(0.5 * (end - state->t), sim->scene.solver.step_min);
        if (state->step_next > STEPPING_SHORTER * (end - state->t))
            return say_step_to_event_fails(message, NEWTON_MESSAGES[trial->newton.status]);
        state->counts.rejections += 1;
    }
    commit_trial(sim, state, trial);
    state->step_next = candidate.step_next;
    state->counts.steps += 1;
    if (candidate.reaches && trial->t == end) state->t = stop; /* without rounding error */
    if (switching == SWITCHES) {
        switch_swivels(sim, state);
        if (chatters(state)) return say_swivel_chatters(message);
    }
    record_step(&sim->replay, state, trial->h, trial->newton.iterations, during);
    update_loop_yaw(state);
    return ROPE_DONE;
}

RopeStatus repeat_step(Simulator *sim, State *state, const TakenStep *step, char *message) {
    if (state->fidelity == RIGID) return as_rigid(sim, state, step->t, message);
    const NewtonStatus transformed = transform_if_due(sim, state);
    if (transformed != CONVERGED)
        return say_transformation_fails(message, sim->scene.solver.step_min, NEWTON_MESSAGES[transformed]);
    set_phases(sim, state, &step->during);
    sim->replay.corrections = step->corrections;
    const StepResult trial = compute_trial(sim, state, step->h);
    if (!trial.converged)
        return say_step_fails(message, step->h, sim->scene.solver.step_min, NEWTON_MESSAGES[trial.newton.status]);
    commit_trial(sim, state, &trial);
    state->t = step->t;
    set_phases(sim, state, &step->after);
    return ROPE_DONE;
}
