/* Warnings about valid results. Formulas and tables: rope_model/warnings/result_warnings.py. */

#include <stdio.h>
#include <string.h>

#include "ends.h"
#include "formulas.h"
#include "loop.h"
#include "messages.h"
#include "rope.h"
#include "rules.h"
#include "signal_numbers.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"

/* Return the yaw of the loop against the line between its ends. */
static double yaw_of(State *state) {
    const NodalArrays nodal = state_arrays(state);
    return state->loop_yaw - ends_yaw(&nodal);
}

static void neglected_effects(const Scene *scene, State *state, char *message) {
    static const char *const texts[] = LEFT_OUT_TEXTS;
    if (warning_rules_leaves_out(scene, state)) snprintf(message, MESSAGE, "%s", texts[state->fidelity]);
}

static void passed_bodies(const Scene *scene, State *state, char *message) {
    static const char *const words[KINDS] = BODY_WORDS;
    char passages[MESSAGE] = "";
    char before[MESSAGE];
    char passed[MESSAGE];
    double deepest = FAR;
    for (int kind = 0; kind < KINDS; kind++) {
        const Nearest *x = &state->nearest[kind];
        deepest = minimum(deepest, x->clearance);
        if (!(x->clearance <= 0)) continue;
        say_passed_into(passed, words[kind], x->touched_at, -x->clearance, x->time, x->s, x->y);
        memcpy(before, passages, sizeof before);
        if (before[0])
            say_and_another(passages, before, passed);
        else
            memcpy(passages, passed, sizeof passages);
    }
    if (!passages[0]) return;
    if (!bodies_may_touch(&scene->shaft))
        say_rope_passed_into(message, passages);
    else if (deepest > -scene->rope.diameter)
        say_rope_struck(message, passages);
    else
        say_rope_pressed_into(message, passages, scene->shaft.contact.stiffness);
}

static void leg_contact(const Scene *scene, State *state, char *message) {
    tell_touching_legs(scene, state, yaw_of(state), message);
}

/* Return the twist from end to end, rad, by conveyances and swivels turned against the line between the ends. */
static double end_twist(State *state) {
    const NodalArrays nodal = state_arrays(state);
    const double left = end_row(nodal.q, nodal.nodes, LEFT)[ANGLE] - state->offsets[LEFT];
    return end_row(nodal.q, nodal.nodes, RIGHT)[ANGLE] - state->offsets[RIGHT] - left - 2 * ends_yaw(&nodal);
}

static void yaw_at_rest(const Scene *scene, State *state, char *message) {
    const double yaw = yaw_of(state);
    char why[MESSAGE] = "";
    if (!warning_rules_yawed_far_at_rest(scene, state, yaw)) return;
    tell_torque_source(scene, end_twist(state), why);
    say_yawed_at_rest(message, yaw, WARNING_RULES_YAWED_FAR, why);
}

static void unfit_inputs(const Scene *scene, State *state, char *message) {
    char reason[MESSAGE] = "";
    for (int side = LEFT; side <= RIGHT; side++)
        if (tell_inputs_of_end(scene, &state->filters[side], state->last_interval, reason)) {
            say_of_end(message, side_name(side), reason);
            return;
        }
}

void rope_warning(Simulator *sim, int index, char *message) {
    static void (*const by_shape[EXTRAPOLATION + 1])(const Scene *, State *,
                                                     char *) = {[PASSED_BODIES] = passed_bodies,
                                                                [NEGLECTED_EFFECTS] = neglected_effects,
                                                                [LEG_CONTACT] = leg_contact,
                                                                [YAW_AT_REST] = yaw_at_rest,
                                                                [UNFIT_INPUTS] = unfit_inputs};
    message[0] = '\0';
    if (!sim->initialized || index < 0 || index > EXTRAPOLATION) return;
    if (by_shape[index])
        by_shape[index](&sim->scene, sim->state, message);
    else
        tell_by_numbers(index, &sim->scene, sim->state, message);
}
