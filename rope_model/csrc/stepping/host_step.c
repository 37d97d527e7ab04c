/* One communication step: motions of the ends, and steps to its end or to an event. */

#include "host_step.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "adaptation.h"
#include "ends.h"
#include "fidelity.h"
#include "fidelity_name.h"
#include "formulas.h"
#include "guards.h"
#include "messages.h"
#include "rope.h"
#include "rope_system.h"
#include "shaft.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "stepping.h"
#include "switching.h"
#include "trial_step.h"

/* Return the filter of an end with the host's sample, for a step to t. */
static InputFilter follow_end(const State *before, const FilterSettings *settings, int side, double t,
                              const EndMotion *end, double given_at) {
    return filter_sample(&before->filters[side], settings, given_at, t - before->paths[side].stop, end);
}

/* Update the misfit of an end up to the stop of its path. */
static void account_end(const Scene *scene, const State *before, State *state, const FilterSettings *settings, int side,
                        const InputFilter *now) {
    const double bottom_s = bottom_arc_length(scene, before->paths, before->t);
    const double leg = side == LEFT ? bottom_s : scene->rope.length - bottom_s;
    state->filters[side] = add_misfit(now, &state->paths[side], settings, &scene->rope, leg);
}

/* Set the next paths of the ends, and raise the fidelity if they need it. */
static RopeStatus move_ends(Simulator *sim, State *state, double t, const EndMotion ends[2], double given_at) {
    const Scene *scene = &sim->scene;
    const FilterSettings settings = filter_settings(scene, scene->inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(sim->state, &settings, side, t, &ends[side], given_at);
        const EndPath path = filter_path(&sim->state->paths[side], &now, t, settings.observer);
        double measures[PATH_MEASURES];
        path_measures(&path, &now, measures);
        if (!check_motion(scene, &ends[side], measures, side, sim->message)) return ROPE_FAILED;
        if (!check_input_age(&scene->inputs, t, &now, side, sim->message)) return ROPE_FAILED;
        state->paths[side] = path;
        account_end(scene, sim->state, state, &settings, side, &now);
    }
    char why[MESSAGE];
    EndMotion filtered[2] = {ends[LEFT], ends[RIGHT]};
    if (scene->inputs.given != ALL_GIVEN)
        for (int side = LEFT; side <= RIGHT; side++) filtered[side] = end_path_at(&state->paths[side], t);
    unsupported_motion(&sim->scene, state->fidelity, filtered, sim->forces.count, why);
    if (!why[0]) return ROPE_DONE;
    if (sim->scene.model.fidelity != AUTO_FIDELITY)
        return say_fixed_model_cannot_follow(sim->message, fidelity_name(state->fidelity), why);
    if (!raise_fidelity(sim, state, why, sim->message)) return ROPE_FAILED;
    begin_audit(sim, state);
    return ROPE_DONE;
}

/* True if an event has happened since the communication step began, or is due now. */
static bool has_event(const Scene *scene, const State *before, const State *state) {
    bool found = state->event_count > 0 && state->events[state->event_count - 1].t > before->t;
    found |= state->guard.cause != before->guard.cause;
    found |= state->fidelity != RIGID && next_release(scene, state) <= state->t;
    for (int kind = 0; kind < KINDS; kind++)
        found |= state->nearest[kind].clearance <= 0 && before->nearest[kind].clearance > 0;
    return found;
}

/* End the paths of the ends, and their misfits, at t. */
static void cut_paths(const Scene *scene, const State *before, State *state, double t, const EndMotion ends[2],
                      double given_at) {
    const FilterSettings settings = filter_settings(scene, scene->inputs.given);
    for (int side = LEFT; side <= RIGHT; side++) {
        const InputFilter now = follow_end(before, &settings, side, t, &ends[side], given_at);
        state->paths[side].stop = t;
        account_end(scene, before, state, &settings, side, &now);
        /* the path meets the given acceleration at its planned stop only */
        state->filters[side].misfits.acceleration = now.misfits.acceleration;
        state->filters[side].misfits.squares[2] = now.misfits.squares[2];
    }
}

/* Add the impulse of each end's vertical force on a rigid rope from `begin` to the state's time, by Simpson's rule,
   which is exact where an acceleration is a cubic: that of a path.  `before` has the forces at its start. */
static void add_rigid_impulse(const Scene *scene, State *state, double begin, const double before[2],
                              double impulse[2]) {
    const NodalArrays nodal = state_arrays(state);
    const double h = state->t - begin;
    const double middle = begin + 0.5 * h;
    const EndMotion left = end_path_at(&state->paths[LEFT], middle);
    const EndMotion right = end_path_at(&state->paths[RIGHT], middle);
    const RigidTensions between = inextensible_rigid_tensions(&scene->rope, &scene->layout, &left, &right);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double now = vertical_reaction(&nodal, side);
        impulse[side] += h / 6 * (before[side] + 4 * between.at_ends[side] + now);
    }
}

/* Set the mean of each end's vertical force on its conveyance over h.  A flexible rope's has the weights of the
   accelerations, which the audit sums from `before` on: the momentum that the rope loses, to rounding. */
static void set_mean_forces(State *state, double h, const double before[2], const double rigid[2]) {
    const double *now = state->audit.impulse + AUDIT_END_LOADS;
    for (int side = LEFT; side <= RIGHT; side++)
        state->force_mean[side] = -(now[side] - before[side] + rigid[side]) / h;
}

/* Make `next` a copy of the state, whose ends move to the host's stop. */
static RopeStatus begin_host_step(Simulator *sim, const HostStep *host) {
    State *state = sim->next;
    const int work_max = sim->scene.solver.work_max;
    memcpy(state, sim->state, sim->state_bytes);
    rope_system_adopt(sim, state);
    state->switched = 0;
    state->event_count = 0;
    sim->newton_limit = state->counts.newton + (work_max > 0 ? work_max : INT32_MAX);
    return move_ends(sim, state, host->stop, host->ends, host->given_at);
}

/* Refuse a communication step to `stop` that takes too much work. */
static RopeStatus check_work(Simulator *sim, const State *state, double stop) {
    const Counts *before = &sim->state->counts;
    const double begin = sim->state->t;
    const int64_t newton = state->counts.newton - before->newton;
    const int64_t steps = state->counts.steps + state->counts.rejections - (before->steps + before->rejections);
    if ((double)newton >= stepping_max_iterations(stop - begin, sim->scene.solver.step_max))
        return say_too_much_work(sim->message, state->t, (int)newton, begin, stop);
    if (steps >= STEPPING_MAX_STEPS) return say_too_many_steps(sim->message, state->t, STEPPING_MAX_STEPS, begin, stop);
    return ROPE_DONE;
}

/* Take one internal step towards `stop`; add what a rigid rope exerts on its ends to rigid_impulse. */
static RopeStatus take_internal_step(Simulator *sim, State *state, double stop, double rigid_impulse[2]) {
    const NodalArrays nodal = state_arrays(state);
    const double t = state->t;
    const double reactions[2] = {vertical_reaction(&nodal, LEFT), vertical_reaction(&nodal, RIGHT)};
    char why[MESSAGE];
    if (!step_towards(sim, state, stop, why)) return say_fails_at(sim->message, t, why);
    if (state->fidelity == RIGID) add_rigid_impulse(&sim->scene, state, t, reactions, rigid_impulse);
    return ROPE_DONE;
}

/* Record passages and guards at the end of the step to `stop`, and on the way every so often. */
static void monitor(Simulator *sim, State *state, double stop) {
    if (state->t < stop && state->t - state->monitored_at < BODIES_MONITOR_INTERVAL) return;
    update_passages(&sim->scene, sim->self_contact, state);
    update_guards(&sim->scene, state);
}

/* Audit a communication step of length h, and remember whether it has given up accuracy. */
static void finish_host_step(Simulator *sim, State *state, double h) {
    audit_interval(sim, state, h, energy_balance_residual(&sim->state->energy_balance));
    state->last_interval = h;
    if (state->counts.given_up > 0 && sim->state->counts.given_up == 0) state->given_up_since = sim->state->t;
}

RopeStatus take_host_step(Simulator *sim, const HostStep *host, int *event) {
    State *state = sim->next;
    const double begin = sim->state->t;
    double stop = host->stop;
    double rigid_impulse[2] = {0, 0};
    *event = 0;
    if (!begin_host_step(sim, host)) return ROPE_FAILED;
    const double *audited = state->audit.impulse + AUDIT_END_LOADS;
    const double audited_before[2] = {audited[LEFT], audited[RIGHT]};
    while (state->t < stop) {
        if (!check_work(sim, state, host->stop)) return ROPE_FAILED;
        if (!take_internal_step(sim, state, stop, rigid_impulse)) return ROPE_FAILED;
        monitor(sim, state, stop);
        if (host->to_event) *event |= has_event(&sim->scene, sim->state, state);
        if (*event && state->t < stop && state->t - begin >= SWIVEL_PHASES_CHATTER_TIME) {
            stop = state->t;
            cut_paths(&sim->scene, sim->state, state, stop, host->ends, host->given_at);
        }
    }
    set_mean_forces(state, stop - begin, audited_before, rigid_impulse);
    if (*event && state->fidelity != RIGID) release_swivels(sim, state);
    finish_host_step(sim, state, stop - begin);
    return ROPE_DONE;
}
