/* Choice of the model's fidelity. Formulas and tables: rope_model/fidelity/fidelity_rules.py. */

#include "fidelity.h"

#include <string.h>

#include "ends.h"
#include "messages.h"
#include "rope.h"
#include "rules.h"

static const char *const INPUTS[] = END_MOTION_NAMES;

/* Write name and value of an input into text (MESSAGE bytes). */
static void input_text(const EndMotion ends[2], int index, char *text) {
    const int side = (index - 1) / END_MOTIONS;
    const int place = (index - 1) % END_MOTIONS;
    say_nonzero_input(text, side_name(side), INPUTS[place], end_value(&ends[side], place));
}

void unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], int forces, char *cause) {
    const EndMotion *left = &ends[LEFT];
    const EndMotion *right = &ends[RIGHT];
    cause[0] = '\0';
    if (fidelity == TORSIONAL) return;
    const int index = (int)fidelity_rules_unsupported_input(scene, fidelity, left, right);
    char why[MESSAGE];
    if (index == 0 && scene->model.fidelity == AUTO_FIDELITY)
        tell_unsupported(scene, fidelity, left, right, forces, cause);
    if (index == 0 && fidelity == RIGID && forces > 0) say_applied_forces(cause);
    if (index == 0) return;
    input_text(ends, index, cause);
    if (fidelity == SPATIAL && fidelity_rules_out_of_plane(index))
        say_while_swivels_hold(cause, memcpy(why, cause, sizeof why));
}

int lowest_sufficient(const Scene *scene, const EndMotion ends[2], int forces) {
    char cause[MESSAGE];
    for (int fidelity = RIGID; fidelity > TORSIONAL; fidelity--) {
        unsupported_motion(scene, fidelity, ends, forces, cause);
        if (!cause[0]) return fidelity;
    }
    return TORSIONAL;
}

int choose_fidelity(const Scene *scene, const EndMotion ends[2], int forces, char *reason) {
    const EndMotion *left = &ends[LEFT];
    const EndMotion *right = &ends[RIGHT];
    char why[MESSAGE];
    char below[MESSAGE] = "";
    if (scene->model.fidelity != AUTO_FIDELITY) {
        say_as_set(reason);
        return scene->model.fidelity;
    }
    if (tell_complete_model(scene, forces, reason)) return TORSIONAL;
    const int index = (int)fidelity_rules_held_input(left, right);
    const int estimated = scene->model.force_tolerance > 0;
    if (index > 0) {
        input_text(ends, index, why);
        say_held_where_initialised(reason, why);
        return TORSIONAL;
    }
    const int fidelity = estimated ? lowest_sufficient(scene, ends, forces) : TORSIONAL;
    if (tell_sufficient(scene, fidelity, left, right, reason))
        return fidelity_rules_carries_torque(scene) || fidelity == RIGID ? fidelity : PLANAR;
    if (estimated) unsupported_motion(scene, SPATIAL, ends, forces, below);
    tell_torque(scene, below[0] ? why : reason);
    if (below[0]) say_torque_and_unsupported(reason, why, below);
    return TORSIONAL;
}
