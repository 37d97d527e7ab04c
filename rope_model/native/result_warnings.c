/* Warnings about results that are valid: the port of rope_model.simulation.result_warnings, which see. */
#include <math.h>
#include <stdio.h>

#include "simulator.h"
#include "text.h"

#define TURNED_FAR (0.5 * PI)
#define YAWED_FAR (PI / 6)
#define REST_SPEED 1e-3

/* yaw of the line from the left to the right end */
static double direction(const Arrays *m) {
    const double *left = end_row(m->q, m->nodes, LEFT), *right = end_row(m->q, m->nodes, RIGHT);
    return atan2(left[2] - right[2], right[0] - left[0]);
}

/* of the loop against its ends */
static double yaw_of(State *state) {
    const Arrays m = state_arrays(state);
    return state->loop_yaw - direction(&m);
}

static void neglected_effects(Simulator *rope, char *message) {
    static const char *const texts[] = LEFT_OUT_TEXTS;
    const int fidelity = rope->state->fidelity;
    if (fidelity == RIGID || scene_carries_torque(&rope->scene)) snprintf(message, MESSAGE, "%s", texts[fidelity]);
}

static void leg_contact(Simulator *rope, char *message) {
    static const char cure[] =
        "contact is not computed, and a real rope would lie against itself; lower Qb, Qc or installed_twist, free the "
        "swivels, or widen the spacing";
    const double yaw = yaw_of(rope->state);
    if (fabs(yaw) > PI)
        snprintf(message, MESSAGE,
                 "the rope's legs have passed through each other: the loop has yawed by %s rad against its ends, and "
                 "legs cross at half a turn; %s",
                 ROUNDED(yaw, 3), cure);
    else if (fabs(yaw) > TURNED_FAR) {
        const double clearance = rope_signal(rope, SIGNAL_LOOP_CLEARANCE);
        if (clearance <= 0)
            snprintf(message, MESSAGE,
                     "the rope's legs touch (loop.clearance = %s m) with the loop yawed by %s rad; %s",
                     ROUNDED(clearance, 3), ROUNDED(yaw, 3), cure);
    }
}

/* twist of the rope from end to end by conveyances and swivels that have turned against the ends' line */
static double end_twist(State *state) {
    const Arrays m = state_arrays(state);
    const double left = end_row(m.q, m.nodes, LEFT)[ANGLE] - state->offsets[LEFT];
    return end_row(m.q, m.nodes, RIGHT)[ANGLE] - state->offsets[RIGHT] - left - 2 * direction(&m);
}

/* why (MESSAGE): what makes the largest torque, and its cure */
static void torque_source(Simulator *rope, char *why) {
    const Rope *data = &rope->scene.rope;
    const double turned = end_twist(rope->state), coupling = coupling_torque(data, rope->scene.layout.gravity);
    const double installed = twist_torque(data, data->installed_twist), ends = twist_torque(data, turned);
    if (coupling >= installed && coupling >= ends)
        snprintf(why, MESSAGE,
                 "the coupling Qb = %s, Qc = %s N m: give what was measured on this very rope, free the swivels",
                 ROUNDED(data->Qb, 6), ROUNDED(data->Qc, 6));
    else if (installed >= ends)
        snprintf(why, MESSAGE, "installed_twist = %s rad: lower it, free the swivels",
                 ROUNDED(data->installed_twist, 6));
    else
        snprintf(why, MESSAGE, "the ends, which twist the rope by %s rad: turn them back", ROUNDED(turned, 6));
}

static void yaw_at_rest(Simulator *rope, char *message) {
    const Rope *data = &rope->scene.rope;
    State *state = rope->state;
    const double rest = 0.5 * data->mass_per_length * data->length * (REST_SPEED * REST_SPEED), yaw = yaw_of(state);
    char why[MESSAGE];
    if (!(state->energy_balance.kinetic < rest) || state->fidelity != TORSIONAL || fabs(yaw) <= YAWED_FAR) return;
    leg_contact(rope, message);
    if (message[0]) {
        message[0] = '\0';
        return;
    }
    torque_source(rope, why);
    snprintf(
        message, MESSAGE,
        "the loop hangs yawed by %s rad against its ends at rest (bound %s rad), turned mostly by %.300s, or widen "
        "the spacing",
        ROUNDED(yaw, 3), ROUNDED(YAWED_FAR, 3), why);
}

void rope_warning(Simulator *rope, int number, char *message) {
    message[0] = '\0';
    if (!rope->initialized) return;
    if (number == 0)
        neglected_effects(rope, message);
    else if (number == 1)
        leg_contact(rope, message);
    else
        yaw_at_rest(rope, message);
}
