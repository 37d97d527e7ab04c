/* rope_model.simulation.rungs: which rung of the model serves, and why.  The estimates are explained there. */
#include <math.h>
#include <stdio.h>

#include "formulas.h"
#include "text.h"

enum { OUT_OF_PLANE = 1, TURNED = 2, ALONG = 4 };

const char *rung_name(int rung) {
    static const char *const names[] = RUNG_WORDS;
    return names[rung];
}

/* what (MESSAGE): the first input of these kinds that is not zero, or "" */
static int moved(const EndMotion ends[2], int kinds, char *what) {
    what[0] = '\0';
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const struct {
            int kind;
            const char *name;
            double value;
        } inputs[] = {
            {OUT_OF_PLANE, "z", end->x[2]}, {OUT_OF_PLANE, "vz", end->v[2]},     {OUT_OF_PLANE, "az", end->a[2]},
            {TURNED, "yaw", end->yaw},      {TURNED, "yaw_rate", end->yaw_rate}, {ALONG, "vx", end->v[0]},
            {ALONG, "ax", end->a[0]},
        };
        for (size_t i = 0; i < sizeof inputs / sizeof inputs[0]; i++)
            if ((inputs[i].kind & kinds) && inputs[i].value != 0) {
                snprintf(what, MESSAGE, "%s.%s = %s", side == LEFT ? "left" : "right", inputs[i].name,
                         ROUNDED(inputs[i].value, 6));
                return 1;
            }
    }
    return 0;
}

static int coupled(const Rope *rope) {
    return 0.5 * (rope->Qb + rope->Qc) != 0 || 0.5 * (rope->Qb - rope->Qc) != 0;
}

/* in the plane while its ends do not turn */
int rung_carries_torque(const Scene *scene) {
    return coupled(&scene->rope) || scene->rope.installed_twist != 0;
}

/* why (MESSAGE) a rope that carries torque does */
static void torque(const Rope *rope, char *why) {
    if (coupled(rope))
        snprintf(why, MESSAGE, "tension and torsion are coupled (Qb = %s, Qc = %s N m)", ROUNDED(rope->Qb, 6),
                 ROUNDED(rope->Qc, 6));
    else
        snprintf(why, MESSAGE, "the rope is twisted by %s rad", ROUNDED(rope->installed_twist, 6));
}

static int turns_freely(const Scene *scene) {
    const Swivel *left = &scene->swivels[LEFT], *right = &scene->swivels[RIGHT];
    return left->mode == FREE_MODE && left->release_time <= 0 && right->mode == FREE_MODE && right->release_time <= 0;
}

static Travel expected(const EndMotion ends[2]) {
    double speed = larger(fabs(ends[LEFT].v[1]), fabs(ends[RIGHT].v[1]));
    double acceleration = larger(fabs(ends[LEFT].a[1]), fabs(ends[RIGHT].a[1]));
    return travel_expected(fabs(ends[LEFT].x[1] - ends[RIGHT].x[1]), speed, acceleration);
}

static int locked(const Scene *scene) {
    return scene->swivels[LEFT].mode == LOCKED_MODE && scene->swivels[RIGHT].mode == LOCKED_MODE;
}

/* estimated error of the vertical end forces against the complete model; infinite where the loop may turn far */
static double force_error(const Scene *scene, int rung, const Travel *travel) {
    double error = 0.0;
    if (rung != TORSIONAL && rung_carries_torque(scene)) {
        if (estimated_yaw(scene) > LARGEST_YAW) return INFINITY;
        error += held_error(scene, travel);
        if (!locked(scene)) error += release_error(scene, travel);
    }
    if (rung == RIGID) error += longitudinal_error(scene, travel) + lean_error(scene, travel);
    return error;
}

void rung_outgrown(const Scene *scene, int rung, const EndMotion ends[2], char *what) {
    double tolerance = scene->model.force_tolerance, error, tension;
    what[0] = '\0';
    if (rung == TORSIONAL) return;
    if (!turns_freely(scene) && moved(ends, TURNED, what)) return;
    if (rung != SPATIAL && moved(ends, OUT_OF_PLANE, what)) return;
    if (rung == RIGID && moved(ends, ALONG, what)) return;
    if (scene->model.rung != AUTO_RUNG) return;
    if (rung == SPATIAL && !turns_freely(scene) && moved(ends, OUT_OF_PLANE, what)) {
        char why[MESSAGE / 2];
        snprintf(why, sizeof why, "%s", what);
        snprintf(what, MESSAGE, "%s while its swivels hold", why);
        return;
    }
    Travel travel = expected(ends);
    error = force_error(scene, rung, &travel);
    if (error > tolerance)
        snprintf(what, MESSAGE, "the ends within the tolerance of %s %%: it errs by an estimated %s %%",
                 ROUNDED(100 * tolerance, 3), ROUNDED(100 * error, 2));
    else if (rung == RIGID && (tension = rigid_lowest_tension(scene, ends)) < 0)
        snprintf(what, MESSAGE, "a rope that goes slack (tension %s N)", ROUNDED(tension, 4));
}

int rung_lowest_able(const Scene *scene, const EndMotion ends[2]) {
    char what[MESSAGE];
    for (int rung = RIGID; rung > TORSIONAL; rung--) {
        rung_outgrown(scene, rung, ends, what);
        if (!what[0]) return rung;
    }
    return TORSIONAL;
}

int rung_chosen(const Scene *scene, const EndMotion ends[2], char *reason) {
    char why[MESSAGE], below[MESSAGE] = "";
    double tolerance = scene->model.force_tolerance;
    if (scene->model.rung != AUTO_RUNG) {
        snprintf(reason, MESSAGE, "as asked for");
        return scene->model.rung;
    }
    if (moved(ends, OUT_OF_PLANE | TURNED, why)) {
        snprintf(reason, MESSAGE, "%.300s where the rope is hung up with its swivels held", why);
        return TORSIONAL;
    }
    int rung = tolerance > 0 ? rung_lowest_able(scene, ends) : TORSIONAL;
    if (!rung_carries_torque(scene) && rung != RIGID) {
        snprintf(reason, MESSAGE, "no torque acts and nothing acts out of plane");
        return PLANAR;
    }
    if (rung == TORSIONAL) {
        torque(&scene->rope, why);
        if (tolerance > 0) rung_outgrown(scene, SPATIAL, ends, below);
        snprintf(reason, MESSAGE, "%.200s%s%.200s", why, below[0] ? "; the spatial rung cannot follow " : "", below);
        return rung;
    }
    Travel travel = expected(ends);
    snprintf(reason, MESSAGE,
             "the %s rung errs by an estimated %s %%, within the tolerance of %s %%, for ends at up to %s m/s, %s "
             "m/s^2 and %s m/s^3",
             rung_name(rung), ROUNDED(100 * force_error(scene, rung, &travel), 2), ROUNDED(100 * tolerance, 3),
             ROUNDED(travel.speed, 6), ROUNDED(travel.acceleration, 6), ROUNDED(travel.jerk, 6));
    return rung;
}
