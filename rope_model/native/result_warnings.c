/* Warnings about results that are valid: the port of rope_model.simulation.result_warnings, which see. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulator.h"
#include "messages.h"

#define HALF_A_TURN 0.5
#define YAWED_FAR (PI / 6)
#define REST_SPEED 1e-3

double ends_direction(const Arrays *m) {
    const double *left = end_row(m->q, m->nodes, LEFT), *right = end_row(m->q, m->nodes, RIGHT);
    return atan2(left[2] - right[2], right[0] - left[0]);
}

/* of the loop against its ends */
static double yaw_of(State *state) {
    const Arrays m = state_arrays(state);
    return state->loop_yaw - ends_direction(&m);
}

static void neglected_effects(Simulator *rope, char *message) {
    static const char *const texts[] = LEFT_OUT_TEXTS;
    const int fidelity = rope->state->fidelity;
    if (fidelity == RIGID || scene_carries_torque(&rope->scene)) snprintf(message, MESSAGE, "%s", texts[fidelity]);
}

static void passed_bodies(Simulator *rope, char *message) {
    static const char *const words[KINDS] = BODY_WORDS;
    char told[MESSAGE] = "", before[MESSAGE], passed[MESSAGE];
    double deepest = FAR;
    for (int kind = 0; kind < KINDS; kind++) {
        const Nearest *x = &rope->state->nearest[kind];
        deepest = smaller(deepest, x->clearance);
        if (!(x->clearance <= 0)) continue;
        say_passed_into(passed, words[kind], x->touched_at, -x->clearance, x->time, x->s, x->y);
        memcpy(before, told, sizeof before);
        if (before[0])
            say_and_another(told, before, passed);
        else
            memcpy(told, passed, sizeof told);
    }
    if (!told[0]) return;
    if (!shaft_may_touch(&rope->scene.shaft))
        say_rope_passed_into(message, told);
    else if (deepest > -rope->scene.rope.diameter)
        say_rope_struck(message, told);
    else
        say_rope_pressed_into(message, told, rope->scene.shaft.contact.stiffness);
}

static void passed_sides(Simulator *rope, char *message) {
    const Crossing *crossing = &rope->state->crossing;
    if (crossing->number > 0) say_sides_passed(message, crossing->number, crossing->since, crossing->y);
}

static void leg_contact(Simulator *rope, char *message) {
    const double yaw = yaw_of(rope->state);
    if (fabs(yaw) <= TURNED_FAR || rope->state->crossing.number > 0) return;
    const double turns = rope_signal(rope, SIGNAL_LOOP_TURNS), clearance = rope_signal(rope, SIGNAL_LOOP_CLEARANCE);
    if (fabs(turns) >= HALF_A_TURN)
        say_turned_around(message, turns);
    else if (clearance <= 0)
        say_legs_touch(message, clearance, yaw);
}

/* twist of the rope from end to end by conveyances and swivels that have turned against the ends' line */
static double end_twist(State *state) {
    const Arrays m = state_arrays(state);
    const double left = end_row(m.q, m.nodes, LEFT)[ANGLE] - state->offsets[LEFT];
    return end_row(m.q, m.nodes, RIGHT)[ANGLE] - state->offsets[RIGHT] - left - 2 * ends_direction(&m);
}

/* why (MESSAGE): what makes the largest torque, and its cure */
static void torque_source(Simulator *rope, char *why) {
    const Rope *data = &rope->scene.rope;
    const double turned = end_twist(rope->state), coupling = coupling_torque(data, rope->scene.layout.gravity);
    const double installed = twist_torque(data, data->installed_twist), ends = twist_torque(data, turned);
    const double less = ends * (1 - 1e-9); /* the installed twist is part of it */
    if (coupling >= installed && coupling >= less)
        say_torque_of_coupling(why, data->Qb, data->Qc);
    else if (installed >= less)
        say_torque_of_twist(why, data->installed_twist);
    else
        say_torque_of_ends(why, turned);
}

static int rests(const Simulator *rope) {
    const Rope *data = &rope->scene.rope;
    const double rest = 0.5 * data->mass_per_length * data->length * (REST_SPEED * REST_SPEED);
    return rope->state->energy_balance.kinetic < rest;
}

static void yaw_at_rest(Simulator *rope, char *message) {
    State *state = rope->state;
    const double yaw = yaw_of(state);
    char why[MESSAGE];
    if (!rests(rope) || state->fidelity != TORSIONAL || fabs(yaw) <= YAWED_FAR || state->crossing.number > 0) return;
    leg_contact(rope, message);
    if (message[0]) {
        message[0] = '\0';
        return;
    }
    torque_source(rope, why);
    say_yawed_at_rest(message, yaw, YAWED_FAR, why);
}

static void other_rests(Simulator *rope, char *message) {
    const double angle = rope->state->snapped_at;
    if (angle == 0 || !rests(rope)) return;
    say_other_rests(message, angle);
}

static void missing_loads(Simulator *rope, char *message) {
    const Audit *audit = &rope->state->audit;
    const double bound = MISSING_FORCE * audit->force;
    const double of_moment = MISSING_MOMENT * audit->force * rope->scene.layout.spacing;
    if (audit->missing_force > bound)
        say_forces_missing(message, audit->missing_force, bound);
    else if (audit->missing_moment > of_moment)
        say_moments_missing(message, audit->missing_moment, of_moment);
}

static void unresolved_waves(Simulator *rope, char *message) {
    const Audit *audit = &rope->state->audit;
    if (audit->share * FEWEST_STEPS > 1 && audit->force_change > LARGE_CHANGE * audit->force)
        say_waves_unresolved(message, audit->force_change, 1 / audit->share, FEWEST_STEPS,
                             axial_step(&rope->scene.rope));
}

static void unresolved_bend(Simulator *rope, char *message) {
    const double bend = rope->state->audit.bend, elements = bend > 0 ? elements_per_bend(bend) : FEWEST_ELEMENTS;
    if (elements < FEWEST_ELEMENTS) say_bend_unresolved(message, elements, FEWEST_ELEMENTS);
}

static void accuracy_given_up(Simulator *rope, char *message) {
    const State *state = rope->state;
    if (state->counts.given_up > 0)
        say_accuracy_given_up(message, (int)state->counts.given_up, state->given_up_since, rope->scene.solver.work_max);
}

void rope_warning(Simulator *rope, int number, char *message) {
    static void (*const warnings[ROPE_WARNINGS])(Simulator *, char *) = {
        passed_bodies, passed_sides,  neglected_effects, leg_contact,     yaw_at_rest,
        other_rests,   missing_loads, unresolved_waves,  unresolved_bend, accuracy_given_up};
    message[0] = '\0';
    if (rope->initialized) warnings[number](rope, message);
}
