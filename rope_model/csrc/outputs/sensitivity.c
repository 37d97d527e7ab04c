/* Derivatives of the end loads with respect to the motions that the host gave for the last communication step.

   The step is taken again from its start, along paths of the ends that differ by a small multiple of the derivative of
   the path: the same internal steps, with the same numbers of Newton's corrections, transformations and phases of the
   swivels.  The central difference of the loads at its end is the derivative of what the step computes.  The path's own
   derivative is exact, as the input filter treats a small misfit otherwise than one that can be measured. */

#include "sensitivity.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "adaptation.h"
#include "communication_step.h"
#include "ends.h"
#include "formulas.h"
#include "host_step.h"
#include "messages.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "signal_numbers.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "stepping.h"
#include "switching.h"

/* VECTORS: members of EndMotion before the yaw, three of each order */
enum { VECTORS = 9, ANGLE_PATH = 3, AXES = 4, PATHS = 6, POWERS = 6, CUBE = 3, LOADS = 12 };
enum { LEFT_FY = UP, RIGHT_FY = 6 + UP };

/* Largest displacement, m, and rotation, rad, that a change adds to the motion of an end within the step.  The loads'
   response to them exceeds the loads' rounding errors by far, and the rope's stiffness stays the same along them. */
#define LARGEST_MOVE 1e-5
#define LARGEST_TURN 1e-3
/* Duration of a step, s, below which both shrink in proportion to it.  So the speed of the end changes by some 10 mm/s
   at most; over the speed of axial waves, some km/s, that is a strain of a few millionths. */
#define SHORTEST_MOVE 1e-3
/* Relative change (absolute below 1) that makes an input differ from its latest sample: at least one and a half units
   in the last place, so that rounding cannot undo it. */
#define ANOTHER_SAMPLE 4e-16
/* Share of the largest changes where wires rub: they begin to slide, or stick again, after a bend that a larger change
   of an end makes. */
#define SHARE_OF_RUBBING 1e-3
/* Largest change of the acceleration of a rigid rope, m/s^2: its forces are exact, and must not go slack. */
#define RIGID_ACCELERATION 1e-2

/* Changes of the coefficients of the path of one end, x, y, z, yaw and leans. */
typedef struct {
    int side;
    double coefficients[PATHS][POWERS];
} Change;

/* Forces and moments of the rope on both conveyances. */
static void end_loads(const Scene *scene, State *state, double loads[LOADS]) {
    const NodalArrays nodal = state_arrays(state);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *q = end_row(nodal.q, nodal.nodes, side);
        const double *R = end_row(nodal.reaction, nodal.nodes, side);
        frame_conveyance_load(q, R, ends_moment(scene, state, &nodal, side), loads + 6 * side);
    }
}

/* Describe a step that has not been taken: as long as the last, with accelerations held. */
static HostStep coming_step(const State *state, bool at_step_end) {
    HostStep host = {.stop = state->t + state->last_interval};
    host.given_at = at_step_end ? host.stop : state->t;
    host.asked_at = host.given_at;
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndPath held = end_path_at_constant_acceleration(&state->paths[side], state->t);
        host.ends[side] = end_path_at(&held, host.given_at);
    }
    return host;
}

/* Take the host's step from sim->state on, and record it. */
static RopeStatus record(Simulator *sim, const HostStep *host) {
    Replay *replay = &sim->replay;
    int event;
    replay->repeats++;
    replay->count = 0;
    replay->derived = 0;
    rope_system_refer(sim, sim->state, state_arrays(sim->state).q);
    replay->recording = true;
    const RopeStatus done = take_host_step(sim, host, &event);
    replay->recording = false;
    if (!done) return ROPE_FAILED;
    if (replay->count > MAX_TAKEN) return say_too_many_to_differentiate(sim->message, replay->count, MAX_TAKEN);
    const State *end = sim->next;
    memcpy(replay->paths, end->paths, sizeof replay->paths);
    replay->fidelity = end->fidelity;
    replay->after = phases_of(end);
    replay->duration = end->t - sim->state->t;
    replay->known = true;
    return ROPE_DONE;
}

/* Add `times` the change to a path. */
static void add_change(EndPath *path, const Change *change, double times) {
    for (int k = 0; k < PATHS; k++) {
        double *coefficients = k < AXES ? path->coefficients[k] : path->leans[k - AXES];
        for (int power = 0; power < POWERS; power++) coefficients[power] += times * change->coefficients[k][power];
    }
}

/* Take the recorded step again, with `times` the change added to the paths. */
static RopeStatus repeat(Simulator *sim, const Change *change, double times, double loads[LOADS]) {
    Replay *replay = &sim->replay;
    State *state = sim->next;
    replay->repeats++;
    memcpy(state, sim->state, sim->state_bytes);
    memcpy(state->paths, replay->paths, sizeof replay->paths);
    add_change(&state->paths[change->side], change, times);
    rope_system_refer(sim, state, state_arrays(state).q);
    if (state->fidelity != replay->fidelity && !raise_fidelity(sim, state, "", sim->message)) return ROPE_FAILED;
    for (int k = 0; k < replay->count; k++)
        if (!repeat_step(sim, state, &replay->steps[k], sim->message)) return ROPE_FAILED;
    set_phases(sim, state, &replay->after);
    end_loads(&sim->scene, state, loads);
    return ROPE_DONE;
}

static double power_of(double x, int exponent) {
    double y = 1;
    for (int k = 0; k < exponent; k++) y *= x;
    return y;
}

/* Return the factor that makes a change as large as a difference may be; 0 if nothing changes. */
static double largest_factor(const Replay *replay, bool has_wires, const Change *change) {
    const double duration = replay->duration;
    /* of the scene: a rigid rope, whose wires do not rub yet, may become flexible within the step */
    const double share = has_wires ? SHARE_OF_RUBBING : 1;
    double size = 0; /* bound of the change over the largest one */
    for (int k = 0; k < PATHS; k++)
        for (int power = 0; power < POWERS; power++)
            size = fmax(size, fabs(change->coefficients[k][power]) * power_of(duration, power) /
                                  (k < ANGLE_PATH ? LARGEST_MOVE : LARGEST_TURN));
    if (size == 0) return 0;
    if (replay->fidelity == RIGID) return RIGID_ACCELERATION * duration * duration / (LARGEST_MOVE * size);
    return share * fmin(1, duration / SHORTEST_MOVE) / size;
}

/* Differentiate the loads at the end of the recorded step along a change. */
static RopeStatus derivative_along(Simulator *sim, const Change *change, double derivative[LOADS]) {
    const double factor = largest_factor(&sim->replay, sim->reference.wires != NULL, change);
    double loads[2][LOADS];
    memset(derivative, 0, sizeof(double) * LOADS);
    if (factor == 0) return ROPE_DONE;
    sim->replay.repeating = true;
    const bool done = repeat(sim, change, factor, loads[0]) && repeat(sim, change, -factor, loads[1]);
    sim->replay.repeating = false;
    if (!done) return ROPE_FAILED;
    for (int k = 0; k < LOADS; k++) {
        derivative[k] = 0.5 * (loads[0][k] - loads[1][k]) / factor;
        if (!isfinite(derivative[k])) return say_no_finite_derivative(sim->message);
    }
    return ROPE_DONE;
}

/* Return the change of an end's path with an input. */
static Change change_with(const Scene *scene, const State *start, const HostStep *host, int side, int field) {
    const FilterSettings settings = filter_settings(scene, scene->inputs.given);
    const double *latest = start->filters[side].given;
    EndMotion end = host->ends[side];
    double direction[END_MOTIONS] = {0};
    Change change = {.side = side};
    direction[field] = 1;
    /* A motion with a change is no repetition of the latest sample. */
    const double value = end_value(&end, field);
    if (value == latest[field]) set_end_value(&end, field, value + ANOTHER_SAMPLE * fmax(1, fabs(value)));
    derivatives_path_change(&start->paths[side], &start->filters[side], &settings, host->asked_at, host->stop, &end,
                            direction, change.coefficients);
    return change;
}

/* True if the rope can follow a change of an input as it is: a lower fidelity leaves motions out. */
static bool follows(const Scene *scene, int fidelity, const HostStep *host, int side, int field) {
    EndMotion ends[2] = {host->ends[LEFT], host->ends[RIGHT]};
    if (fidelity == RIGID) return field < VECTORS && field % 3 == UP;
    set_end_value(&ends[side], field, end_value(&ends[side], field) + 1);
    return fidelity == TORSIONAL || fidelity_rules_unsupported_input(scene, fidelity, &ends[LEFT], &ends[RIGHT]) == 0;
}

/* The step whose loads are differentiated, and the state to return to. */
typedef struct {
    State *present;
    HostStep host;
} Differentiated;

/* Go back to the start of the last step, and record it unless that has been done. */
static RopeStatus go_back(Simulator *sim, bool at_step_end, Differentiated *step) {
    step->present = sim->state;
    step->host = sim->last.taken ? sim->last : coming_step(sim->state, at_step_end);
    if (sim->last.taken) sim->state = sim->start;
    if (!sim->last.taken && sim->replay.at_step_end != at_step_end) sim->replay.known = false;
    sim->replay.at_step_end = at_step_end;
    return sim->replay.known || record(sim, &step->host);
}

/* Return to the present state; complete the message of a failure. */
static RopeStatus return_from(Simulator *sim, const Differentiated *step, RopeStatus status) {
    sim->state = step->present;
    rope_system_refer(sim, sim->state, state_arrays(sim->state).q);
    if (status == ROPE_DONE) return ROPE_DONE;
    char why[MESSAGE];
    memcpy(why, sim->message, sizeof why);
    return say_no_derivative(sim->message, why);
}

/* Decrease of each end's upward force per upward acceleration that grows over the step from 0 on, kg.

   NaN where a step cannot be taken again, as one of more than MAX_TAKEN internal steps: outputs are read without a
   status, together with others that are valid, and any number would look like a mass.  A host that couples by added
   mass must refuse it; rope_message has the reason. */
void added_mass_signals(Simulator *sim, double *values) {
    double derivatives[2][LOADS] = {{0}};
    Differentiated step;
    RopeStatus done = go_back(sim, true, &step);
    for (int side = LEFT; side <= RIGHT && done; side++) {
        Change change = {.side = side};
        change.coefficients[UP][CUBE] = 1 / (6 * sim->replay.duration);
        done = derivative_along(sim, &change, derivatives[side]);
    }
    return_from(sim, &step, done);
    values[SIGNAL_LEFT_ADDED_MASS] = done ? -derivatives[LEFT][LEFT_FY] : NAN;
    values[SIGNAL_RIGHT_ADDED_MASS] = done ? -derivatives[RIGHT][RIGHT_FY] : NAN;
}

size_t rope_repeated_steps(const Simulator *sim) {
    return sim->replay.repeats;
}

RopeStatus rope_load_derivative(Simulator *sim, int input, int at_step_end, double derivative[LOADS]) {
    if (input < 0 || input >= 2 * END_MOTIONS) return say_no_such_input(sim->message, 2 * END_MOTIONS - 1);
    if (!sim->initialized) return say_no_state(sim->message);
    const int side = input / END_MOTIONS;
    const int field = input % END_MOTIONS;
    Replay *replay = &sim->replay;
    Differentiated step;
    RopeStatus done = go_back(sim, at_step_end, &step);
    if (done && !(replay->derived & 1u << input)) {
        Change change = {.side = side};
        if (follows(&sim->scene, replay->fidelity, &step.host, side, field))
            change = change_with(&sim->scene, sim->state, &step.host, side, field);
        done = derivative_along(sim, &change, replay->derivatives[input]);
        if (done) replay->derived |= 1u << input;
    }
    if (done) memcpy(derivative, replay->derivatives[input], sizeof(double) * LOADS);
    return return_from(sim, &step, done);
}
