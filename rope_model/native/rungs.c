/* rope_model.simulation.rungs: which rung of the model serves, and why.  The estimates are explained there. */
#include <math.h>
#include <stdio.h>

#include "core.h"
#include "text.h"

/* measured, see rope_model.simulation.rungs */
static const double LEAN = 1.0 / 3, LEAN_GROWTH = 10.0, WHIP = 3e-5, NATURAL_WIDTH = 2.54307, LARGEST_YAW = 1.0;

/* what an estimate needs of a winding: its largest values */
typedef struct {
    double height_difference, speed, acceleration, jerk;
} Travel;

/* what 'auto' expects of the ends */
static const Travel ASSUMED = {0.0, 10.0, 1.0, 1.0};

enum { OUT_OF_PLANE = 1, TURNED = 2, ALONG = 4 };

static double larger(double a, double b) { return b > a ? b : a; }

const char *rung_name(int rung) {
    static const char *const names[] = {"auto", "torsional", "spatial", "planar", "rigid"};
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
            {OUT_OF_PLANE, "z", end->x[2]}, {OUT_OF_PLANE, "vz", end->v[2]}, {OUT_OF_PLANE, "az", end->a[2]},
            {TURNED, "yaw", end->yaw},      {TURNED, "yaw_rate", end->yaw_rate},
            {ALONG, "vx", end->v[0]},       {ALONG, "ax", end->a[0]},
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
int rung_carries_torque(const Scene *scene) { return coupled(&scene->rope) || scene->rope.installed_twist != 0; }

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
    double growth = larger(acceleration / ASSUMED.acceleration, 1.0);
    Travel travel = {fabs(ends[LEFT].x[1] - ends[RIGHT].x[1]), larger(speed, ASSUMED.speed),
                     growth * ASSUMED.acceleration, growth * ASSUMED.jerk};
    return travel;
}

/* lengths of the longer and the shorter leg, the latter at least the loop's spacing */
static double long_leg(const Scene *scene, const Travel *travel) {
    return 0.5 * (scene->rope.length + travel->height_difference);
}

static double short_leg(const Scene *scene, const Travel *travel) {
    return larger(0.5 * (scene->rope.length - travel->height_difference), scene->layout.spacing);
}

/* of the loop of a rope that hangs from legs wherever they like to be */
static double natural_width(const Scene *scene) {
    return NATURAL_WIDTH * cbrt(scene->rope.EI / (scene->rope.mass_per_length * scene->layout.gravity));
}

double rung_coupling_torque(const Rope *rope, double gravity) {
    return fabs(rope->Qc / rope->Qa * rope->mass_per_length * gravity * 0.5 * rope->length);
}

double rung_twist_torque(const Rope *rope, double angle) {
    return fabs((rope->Qd - rope->Qb * rope->Qc / rope->Qa) * angle / rope->length);
}

/* torque of a hanging rope whose ends were fastened unloaded */
static double held_torque(const Rope *rope, double gravity) {
    return rung_coupling_torque(rope, gravity) + rung_twist_torque(rope, rope->installed_twist);
}

/* yaw of the loop under the torque of a held rope: legs like strings under their own weight */
static double loop_yaw(const Scene *scene) {
    const Rope *rope = &scene->rope;
    double g = scene->layout.gravity;
    double width = 0.5 * (scene->layout.spacing + natural_width(scene)); /* the legs close in from one to the other */
    double height = larger(0.5 * rope->length / width, 1.0);
    return 4 * fabs(held_torque(rope, g)) * log(height) / (rope->mass_per_length * g * (width * width));
}

static double longitudinal_error(const Scene *scene, const Travel *travel) {
    double omega = 0.5 * PI * sqrt(scene->rope.Qa / scene->rope.mass_per_length) / long_leg(scene, travel);
    return 8 / (PI * PI) * travel->jerk / (omega * scene->layout.gravity);
}

static double lean_error(const Scene *scene, const Travel *travel) {
    double width = larger(natural_width(scene), scene->layout.spacing);
    double lean = LEAN * width * (1 + LEAN_GROWTH * travel->acceleration / scene->layout.gravity);
    return lean * lean / (4 * short_leg(scene, travel) * long_leg(scene, travel));
}

static double release_error(const Scene *scene, const Travel *travel) {
    const Rope *rope = &scene->rope;
    double g = scene->layout.gravity, Qs = 0.5 * (rope->Qb + rope->Qc);
    if (scene->swivels[LEFT].mode == LOCKED_MODE && scene->swivels[RIGHT].mode == LOCKED_MODE) return 0.0;
    return fabs(Qs) * held_torque(rope, g) / (rope->Qa * rope->rhoJ * g * long_leg(scene, travel));
}

/* infinite where the torque may turn the loop far */
static double torsion_error(const Scene *scene, const Travel *travel) {
    const Rope *rope = &scene->rope;
    double psi = loop_yaw(scene), Qs = 0.5 * (rope->Qb + rope->Qc);
    if (psi > LARGEST_YAW) return INFINITY;
    double flow = travel->speed * travel->speed / (scene->layout.gravity * natural_width(scene));
    double kappa = Qs * Qs / (rope->Qa * rope->Qd);
    double held = kappa * longitudinal_error(scene, travel) + psi * psi * lean_error(scene, travel) +
                  WHIP * (flow * flow);
    return held + release_error(scene, travel);
}

/* estimated error of the vertical end forces against the complete model */
static double force_error(const Scene *scene, int rung, const Travel *travel) {
    double error = 0.0;
    if (rung != TORSIONAL && rung_carries_torque(scene)) error += torsion_error(scene, travel);
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
