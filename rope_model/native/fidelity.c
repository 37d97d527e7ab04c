/* rope_model.simulation.fidelity: which fidelity of the model serves, and why.  The estimates are explained there. */
#include <math.h>
#include <string.h>

#include "formulas.h"
#include "messages.h"
#include "shaft.h"

/* inputs that act out of the plane, turn a rope whose swivels hold, and move the ends along the plane */
static const int OUT_OF_PLANE[] = {2, 5, 8, -1}, TURNED[] = {9, 10, -1}, ALONG[] = {3, 6, -1};
static const int OUT_OF_PLANE_OR_TURNED[] = {2, 5, 8, 9, 10, -1};

const char *fidelity_name(int fidelity) {
    static const char *const names[] = FIDELITY_WORDS;
    return names[fidelity];
}

/* what (MESSAGE): the first of these inputs, by their places in EndMotion, that is not zero, or "" */
static int nonzero_input(const EndMotion ends[2], const int *places, char *what) {
    static const char *const names[] = END_MOTION_NAMES;
    what[0] = '\0';
    for (int side = LEFT; side <= RIGHT; side++)
        for (const int *k = places; *k >= 0; k++) {
            const double value = end_value(&ends[side], *k);
            if (value != 0) return !say_nonzero_input(what, SIDE_NAMES[side], names[*k], value);
        }
    return 0;
}

static int has_coupling(const Rope *rope) {
    return 0.5 * (rope->Qb + rope->Qc) != 0 || 0.5 * (rope->Qb - rope->Qc) != 0;
}

/* in the plane while its ends do not turn */
int scene_carries_torque(const Scene *scene) {
    return has_coupling(&scene->rope) || scene->rope.installed_twist != 0;
}

/* why (MESSAGE) a rope that carries torque does */
static void torque(const Rope *rope, char *why) {
    if (has_coupling(rope))
        say_coupled(why, rope->Qb, rope->Qc);
    else
        say_twisted(why, rope->installed_twist);
}

static int turns_freely(const Scene *scene) {
    const Swivel *left = &scene->swivels[LEFT], *right = &scene->swivels[RIGHT];
    return left->mode == FREE_MODE && left->release_time <= 0 && right->mode == FREE_MODE && right->release_time <= 0;
}

static Travel expected_travel(const EndMotion ends[2]) {
    double speed = larger(fabs(ends[LEFT].vy), fabs(ends[RIGHT].vy));
    double acceleration = larger(fabs(ends[LEFT].ay), fabs(ends[RIGHT].ay));
    return travel_estimate(fabs(ends[LEFT].y - ends[RIGHT].y), speed, acceleration);
}

static int both_locked(const Scene *scene) {
    return scene->swivels[LEFT].mode == LOCKED_MODE && scene->swivels[RIGHT].mode == LOCKED_MODE;
}

/* estimated error of the vertical end forces against the complete model; infinite where the loop may turn far */
static double force_error(const Scene *scene, int fidelity, const Travel *travel) {
    double error = 0.0;
    if (fidelity != TORSIONAL && scene_carries_torque(scene)) {
        if (estimated_yaw(scene) > LARGEST_YAW) return INFINITY;
        error += held_error(scene, travel);
        if (!both_locked(scene)) error += release_error(scene, travel);
    }
    if (fidelity == RIGID) error += longitudinal_error(scene, travel) + lean_error(scene, travel);
    return error;
}

void fidelity_unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], char *what) {
    double tolerance = scene->model.force_tolerance, error, tension;
    what[0] = '\0';
    if (fidelity == TORSIONAL) return;
    if (!turns_freely(scene) && nonzero_input(ends, TURNED, what)) return;
    if (fidelity != SPATIAL && nonzero_input(ends, OUT_OF_PLANE, what)) return;
    if (fidelity == RIGID && nonzero_input(ends, ALONG, what)) return;
    if (scene->model.fidelity != AUTO_FIDELITY) return;
    if (fidelity == SPATIAL && !turns_freely(scene) && nonzero_input(ends, OUT_OF_PLANE, what)) {
        char why[MESSAGE];
        memcpy(why, what, sizeof why);
        say_while_swivels_hold(what, why);
        return;
    }
    Travel travel = expected_travel(ends);
    error = force_error(scene, fidelity, &travel);
    if (error > tolerance)
        say_errs_too_much(what, 100 * tolerance, 100 * error);
    else if (fidelity == RIGID && (tension = rigid_lowest_tension(scene, ends)) < 0)
        say_would_go_slack(what, tension);
}

int fidelity_lowest_sufficient(const Scene *scene, const EndMotion ends[2]) {
    char what[MESSAGE];
    for (int fidelity = RIGID; fidelity > TORSIONAL; fidelity--) {
        fidelity_unsupported_motion(scene, fidelity, ends, what);
        if (!what[0]) return fidelity;
    }
    return TORSIONAL;
}

int fidelity_choose(const Scene *scene, const EndMotion ends[2], char *reason) {
    char why[MESSAGE], below[MESSAGE] = "";
    double tolerance = scene->model.force_tolerance;
    if (scene->model.fidelity != AUTO_FIDELITY) {
        say_as_asked(reason);
        return scene->model.fidelity;
    }
    if (shaft_may_touch(&scene->shaft)) {
        say_may_touch(reason);
        return TORSIONAL;
    }
    if (guarded(&scene->shaft.guard) > 0) {
        say_guards_watch(reason);
        return TORSIONAL;
    }
    if (scene->shaft.air.density > 0) {
        say_in_air(reason);
        return TORSIONAL;
    }
    if (nonzero_input(ends, OUT_OF_PLANE_OR_TURNED, why)) {
        say_held_where_initialised(reason, why);
        return TORSIONAL;
    }
    int fidelity = tolerance > 0 ? fidelity_lowest_sufficient(scene, ends) : TORSIONAL;
    if (!scene_carries_torque(scene) && fidelity != RIGID) {
        say_no_torque(reason);
        return PLANAR;
    }
    if (fidelity == TORSIONAL) {
        torque(&scene->rope, reason);
        if (tolerance > 0) fidelity_unsupported_motion(scene, SPATIAL, ends, below);
        if (below[0]) {
            memcpy(why, reason, sizeof why);
            say_torque_and_more(reason, why, below);
        }
        return fidelity;
    }
    Travel travel = expected_travel(ends);
    say_errs_little(reason, fidelity_name(fidelity), 100 * force_error(scene, fidelity, &travel), 100 * tolerance,
                    travel.speed, travel.acceleration, travel.jerk);
    return fidelity;
}
