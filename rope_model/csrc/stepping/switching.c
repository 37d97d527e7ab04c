/* Stick and slip of the swivels: location of the phase changes, and the next phase.

   The event function of a swivel is negative while its phase may last: |M| / M_static - 1 while it sticks, the
   rate against the sense of the slip while it slips. The step that would carry it past zero is shortened to end
   there; then the swivel switches and the integrator restarts with consistent accelerations. */

#include "switching.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "ends.h"
#include "events.h"
#include "formulas.h"
#include "generalized_alpha.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "trial_step.h"

/* Event function of one swivel: negative while it may stay in its phase. */
static double excess_of(const Scene *scene, const State *state, int side, double t, const NodalArrays *nodal) {
    const double *q = end_row(nodal->q, nodal->nodes, side);
    const double *v = end_row(nodal->v, nodal->nodes, side);
    const double *R = end_row(nodal->reaction, nodal->nodes, side);
    const double rate = ends_relative(state, side, t, q[ANGLE], v[ANGLE]).rate;
    const double tension = ends_tension(scene, nodal, side);
    return swivel_excess(&scene->swivels[side], &state->swivels[side], tension, R[ANGLE], rate);
}

static double excess(const Scene *scene, const State *state, double t, const NodalArrays *nodal) {
    const double left = excess_of(scene, state, LEFT, t, nodal);
    const double right = excess_of(scene, state, RIGHT, t, nodal);
    return left >= right ? left : right;
}

void release_swivels(Simulator *sim, State *state) {
    bool changed = false;
    for (int side = LEFT; side <= RIGHT; side++) {
        const Swivel *swivel = &sim->scene.swivels[side];
        SwivelState *now = &state->swivels[side];
        if (state->t >= swivel_phases_released_at(swivel, now)) {
            now->phase = swivel_phases_frictionless(swivel) ? SLIP : STICK;
            now->sign = 1;
            changed = true;
        }
    }
    if (!changed) return;
    restart_motion(sim, state);
    const NodalArrays nodal = state_arrays(state);
    if (excess(&sim->scene, state, state->t, &nodal) >= 0) switch_swivels(sim, state);
}

double next_release(const Scene *scene, const State *state) {
    const Swivel *swivels = scene->swivels;
    return fmin(swivel_phases_released_at(&swivels[LEFT], &state->swivels[LEFT]),
                swivel_phases_released_at(&swivels[RIGHT], &state->swivels[RIGHT]));
}

typedef struct {
    Simulator *sim;
    State *state;
    int64_t iterations; /* of Newton's method so far */
    int64_t allowed;    /* largest number of them */
} EventSearch;

static double excess_after(void *data, double h) {
    EventSearch *search = data;
    if (search->iterations >= search->allowed) return -1; /* ends at the earliest time known to be past the event */
    const StepResult trial = compute_trial(search->sim, search->state, h);
    search->iterations += trial.newton.iterations;
    return trial.converged ? excess(&search->sim->scene, search->state, trial.t, &search->sim->work.trial) : INFINITY;
}

Switching switching_step(Simulator *sim, State *state, StepResult *trial) {
    const double at_end = excess(&sim->scene, state, trial->t, &sim->work.trial);
    if (at_end < 0) return STAYS;
    const NodalArrays nodal = state_arrays(state);
    /* Keep iterations for the step to the event and the next one. */
    EventSearch search = {
        .sim = sim, .state = state, .allowed = sim->newton_limit - state->counts.newton - 2 * NEWTON_STEP_ITERATIONS};
    if (search.allowed <= 0) { /* switch at the end of the step */
        state->counts.given_up += 1;
        return SWITCHES;
    }
    double at_start = excess(&sim->scene, state, state->t, &nodal);
    if (at_start >= 0) at_start = SWIVEL_PHASES_JUST_BEFORE;
    const Bracket step = {.high = trial->t - state->t, .f_low = at_start, .f_high = at_end};
    const double h = locate(excess_after, &search, step, SWIVEL_PHASES_EVENT_WIDTH);
    *trial = compute_trial(sim, state, h);
    state->counts.newton += search.iterations + trial->newton.iterations;
    state->counts.given_up += search.iterations >= search.allowed;
    return trial->converged ? SWITCHES : NOT_FOUND;
}

/* Return the next phase of a swivel that cannot stay in its own: stick if friction can hold it, else slip. */
static SwivelState next_phase(Simulator *sim, const State *state, const SwivelState swivels[2], int side) {
    State *trial = sim->spare;
    memcpy(trial, state, sim->state_bytes);
    memcpy(trial->swivels, swivels, sizeof trial->swivels);
    const NodalArrays nodal = state_arrays(trial);
    SwivelState now = swivels[side];
    if (now.phase == SLIP) {
        now = (SwivelState){.angle = swivel_angle(trial, side), .phase = STICK};
        trial->swivels[side] = now;
        rope_system_adopt(sim, trial);
        restart_motion(sim, trial);
        rope_system_adopt(sim, state);
        if (excess_of(&sim->scene, trial, side, trial->t, &nodal) < 0) return now;
    }
    now.phase = SLIP;
    now.sign = copysign(1, -end_row(nodal.reaction, nodal.nodes, side)[ANGLE]);
    return now;
}

void switch_swivels(Simulator *sim, State *state) {
    const NodalArrays nodal = state_arrays(state);
    SwivelState swivels[2];
    bool switches[2];
    bool restarted = false;
    memcpy(swivels, state->swivels, sizeof swivels);
    for (int side = LEFT; side <= RIGHT; side++) {
        switches[side] = excess_of(&sim->scene, state, side, state->t, &nodal) >= 0;
        if (!switches[side]) continue;
        swivels[side] = next_phase(sim, state, swivels, side);
        restarted = swivels[side].phase == STICK; /* next_phase restarted the spare */
    }
    if (restarted) memcpy(state, sim->spare, sim->state_bytes);
    for (int side = LEFT; side <= RIGHT; side++) {
        if (!switches[side]) continue;
        memmove(state->switchings + 1, state->switchings, sizeof(double) * (CHATTER_EVENTS - 1));
        state->switchings[0] = state->t;
        if (state->switched < CHATTER_EVENTS) state->switched += 1;
        state->counts.swivel_events += 1;
        const int slips = swivels[side].sign > 0 ? SLIPS_FORWARD : SLIPS_BACK;
        record_event(state, swivels[side].phase == STICK ? STICKS : slips, side, 0, 0);
    }
    if (restarted) return;
    memcpy(state->swivels, swivels, sizeof swivels);
    restart_motion(sim, state);
}

Phases phases_of(const State *state) {
    Phases phases;
    for (int side = LEFT; side <= RIGHT; side++) {
        phases.phase[side] = (signed char)state->swivels[side].phase;
        phases.sign[side] = (signed char)state->swivels[side].sign;
    }
    return phases;
}

void set_phases(Simulator *sim, State *state, const Phases *phases) {
    bool changed = false;
    for (int side = LEFT; side <= RIGHT; side++) {
        SwivelState *now = &state->swivels[side];
        if (now->phase == phases->phase[side] && now->sign == phases->sign[side]) continue;
        changed = true;
        if (now->phase == SLIP && phases->phase[side] != SLIP) now->angle = swivel_angle(state, side);
        now->phase = phases->phase[side];
        now->sign = phases->sign[side];
    }
    if (changed) restart_motion(sim, state);
}

bool chatters(const State *state) {
    return state->switched == CHATTER_EVENTS &&
           state->switchings[0] - state->switchings[CHATTER_EVENTS - 1] < SWIVEL_PHASES_CHATTER_TIME;
}
