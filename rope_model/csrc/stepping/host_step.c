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
    const double h = state->t - begin, middle = begin + 0.5 * h;
    const EndMotion left = end_path_at(&state->paths[LEFT], middle), right = end_path_at(&state->paths[RIGHT], middle);
    const RigidTensions between = inextensible_rigid_tensions(&scene->rope, &scene->layout, &left, &right);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double now = end_row(nodal.reaction, nodal.nodes, side)[UP];
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

RopeStatus take_host_step(Simulator *sim, const HostStep *host, int *event) {
    State *state = sim->next;
    const EndMotion *ends = host->ends;
    const double begin = sim->state->t, step_max = sim->scene.solver.step_max;
    const int64_t steps_before = sim->state->counts.steps + sim->state->counts.rejections;
    double t = host->stop;
    *event = 0;
    memcpy(state, sim->state, sim->state_bytes);
    rope_system_adopt(sim, state);
    state->switched = state->event_count = 0;
    sim->newton_limit =
        state->counts.newton + (sim->scene.solver.work_max > 0 ? sim->scene.solver.work_max : INT32_MAX);
    if (!move_ends(sim, state, t, ends, host->given_at)) return ROPE_FAILED;
    const NodalArrays nodal = state_arrays(state);
    const double *audited = state->audit.impulse + AUDIT_END_LOADS;
    const double already[2] = {audited[LEFT], audited[RIGHT]};
    double rigid_impulse[2] = {0, 0};
    const double most = stepping_max_iterations(t - begin, step_max);
    const int64_t newton_before = sim->state->counts.newton;
    while (state->t < t) {
        const double t_before = state->t,
                     before[2] = {nodal.reaction[1], end_row(nodal.reaction, nodal.nodes, RIGHT)[1]};
        char why[MESSAGE];
        const int64_t newton = state->counts.newton - newton_before;
        if ((double)newton >= most) return say_too_much_work(sim->message, t_before, (int)newton, begin, t);
        if (state->counts.steps + state->counts.rejections - steps_before >= STEPPING_MAX_STEPS)
            return say_too_many_steps(sim->message, t_before, STEPPING_MAX_STEPS, begin, t);
        if (!step_towards(sim, state, t, why)) return say_fails_at(sim->message, t_before, why);
        if (state->t >= t || state->t - state->monitored_at >= BODIES_MONITOR_INTERVAL) {
            update_passages(&sim->scene, sim->self_contact, state);
            update_guards(&sim->scene, state);
        }
        if (host->to_event) *event |= has_event(&sim->scene, sim->state, state);
        if (*event && state->t < t && state->t - begin >= SWIVEL_PHASES_CHATTER_TIME) {
            t = state->t; /* last round */
            cut_paths(&sim->scene, sim->state, state, t, ends, host->given_at);
        }
        if (state->fidelity == RIGID) add_rigid_impulse(&sim->scene, state, t_before, before, rigid_impulse);
    }
    set_mean_forces(state, t - begin, already, rigid_impulse);
    if (*event && state->fidelity != RIGID) release_swivels(sim, state);
    audit_interval(sim, state, t - begin, energy_balance_residual(&sim->state->energy_balance));
    state->last_interval = t - begin;
    if (state->counts.given_up > 0 && sim->state->counts.given_up == 0) state->given_up_since = begin;
    return ROPE_DONE;
}
