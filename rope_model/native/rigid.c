/* rope_model.simulation.rigid: an inextensible rope without bending stiffness, two straight legs and a half circle. */
#include <math.h>
#include <stdio.h>

#include "core.h"
#include "text.h"

/* u, from the right leg into the left one, and w, of the loop, upwards */
typedef struct {
    double u, w;
} Flow;

/* tensions at the conveyances and at the ends of the half circle, lengths of the legs, mass of the half circle */
typedef struct {
    double tensions[2], below[2], legs[2], arc, radius;
} Pull;

static Flow flow(double v1, double v2) {
    Flow flow = {0.5 * (v1 - v2), 0.5 * (v1 + v2)};
    return flow;
}

static double smaller(double a, double b) { return b < a ? b : a; }

/* points: of suspension; speeds and accelerations upwards */
static Pull pull_of(const Scene *scene, double points[2][3], const double v[2], const double a[2]) {
    double rho = scene->rope.mass_per_length, g = scene->layout.gravity, L = scene->rope.length;
    Pull pull;
    pull.radius = 0.5 * hypot(points[RIGHT][0] - points[LEFT][0], points[RIGHT][2] - points[LEFT][2]);
    double half = PI * pull.radius;
    double l1 = 0.5 * (L - half + (points[LEFT][1] - points[RIGHT][1])), l2 = L - half - l1;
    double u = flow(v[LEFT], v[RIGHT]).u, arc = rho * half;
    Flow rate = flow(a[LEFT], a[RIGHT]);
    double common = 0.5 * (arc * (g + rate.w) + 2 * rho * u * u);
    pull.below[LEFT] = common + 0.5 * arc * rate.u;
    pull.below[RIGHT] = common - 0.5 * arc * rate.u;
    pull.tensions[LEFT] = pull.below[LEFT] + rho * l1 * (g + a[LEFT]);
    pull.tensions[RIGHT] = pull.below[RIGHT] + rho * l2 * (g + a[RIGHT]);
    pull.legs[LEFT] = l1, pull.legs[RIGHT] = l2, pull.arc = arc;
    return pull;
}

static double lowest(const Pull *pull) {
    const double *below = pull->below, *tensions = pull->tensions;
    return smaller(smaller(below[LEFT], below[RIGHT]), smaller(tensions[LEFT], tensions[RIGHT]));
}

/* x: from the nominal point */
static void suspended(const Scene *scene, int side, const double x[3], double point[3]) {
    point[0] = (side == LEFT ? -0.5 : 0.5) * scene->layout.spacing + x[0];
    point[1] = x[1];
    point[2] = x[2];
}

double rigid_lowest_tension(const Scene *scene, const EndMotion ends[2]) {
    double points[2][3], v[2], a[2];
    for (int side = LEFT; side <= RIGHT; side++) {
        suspended(scene, side, ends[side].x, points[side]);
        v[side] = ends[side].v[1], a[side] = ends[side].a[1];
    }
    Pull pull = pull_of(scene, points, v, a);
    return lowest(&pull);
}

void rigid_tensions(const Scene *scene, const Path paths[2], double t, const double dx[2][3], const double dv[2],
                    const double da[2], double tensions[2]) {
    double points[2][3], v[2], a[2];
    for (int side = LEFT; side <= RIGHT; side++) {
        double x[3];
        for (int k = 0; k < 3; k++) {
            double rates[3];
            path_rates(&paths[side], t, k, rates);
            x[k] = rates[0] + dx[side][k];
            if (k == 1) v[side] = rates[1] + dv[side], a[side] = rates[2] + da[side];
        }
        suspended(scene, side, x, points[side]);
    }
    Pull pull = pull_of(scene, points, v, a);
    tensions[LEFT] = pull.tensions[LEFT], tensions[RIGHT] = pull.tensions[RIGHT];
}

/* velocities v (nodes x DOF) of the flow along the rope q (nodes x DOF) */
static void flowing(int nodes, const double *q, Flow flow, double *v) {
    for (int i = 0; i < nodes * DOF; i += DOF) {
        for (int k = 0; k < 3; k++) v[i + k] = -flow.u * q[i + SLOPE + k];
        v[i + 1] += flow.w;
        for (int k = SLOPE; k < DOF; k++) v[i + k] = 0.0;
    }
}

void rigid_rope(const Scene *scene, const Path paths[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message) {
    double rho = scene->rope.mass_per_length, g = scene->layout.gravity;
    double x[2][3], x_t[2][3], x_tt[2][3], points[2][3], up_t[2], up_tt[2];
    message[0] = '\0';
    for (int side = LEFT; side <= RIGHT; side++) {
        for (int k = 0; k < 3; k++) {
            double rates[3];
            path_rates(&paths[side], t, k, rates);
            x[side][k] = rates[0], x_t[side][k] = rates[1], x_tt[side][k] = rates[2];
        }
        suspended(scene, side, x[side], points[side]);
        up_t[side] = x_t[side][1], up_tt[side] = x_tt[side][1];
    }
    Pull pull = pull_of(scene, points, up_t, up_tt);
    if (lowest(&pull) < 0) {
        snprintf(message, MESSAGE,
                 "the rope goes slack: tension %s N at t = %s s, which the rigid rung cannot follow; use a flexible "
                 "one (model.rung = auto, planar or torsional) or a gentler motion",
                 ROUNDED(lowest(&pull), 4), ROUNDED(t, 6));
        return;
    }
    Flow of = flow(up_t[LEFT], up_t[RIGHT]);
    double y1 = x[LEFT][1], y2 = x[RIGHT][1], l1 = pull.legs[LEFT], l2 = pull.legs[RIGHT];
    double v1 = up_t[LEFT], v2 = up_t[RIGHT], u = of.u, w = of.w;
    *kinetic = 0.5 * rho * (l1 * (v1 * v1) + l2 * (v2 * v2)) + 0.5 * pull.arc * (w * w + u * u);
    double middle = y1 - l1 - 2 * pull.radius / PI;
    *gravity = g * (rho * l1 * (y1 - 0.5 * l1) + rho * l2 * (y2 - 0.5 * l2) + pull.arc * middle);

    shape_hanging_guess(nodes, s, points[LEFT], points[RIGHT], q, message);
    if (message[0]) return;
    flowing(nodes, q, of, v);
    for (int i = 0; i < nodes * DOF; i++) a[i] = reaction[i] = 0.0;
    for (int side = LEFT; side <= RIGHT; side++) {
        int end = side == LEFT ? 0 : (nodes - 1) * DOF;
        for (int k = 0; k < 3; k++) v[end + k] = x_t[side][k], a[end + k] = x_tt[side][k];
        reaction[end + 1] = pull.tensions[side];
    }
}

void rigid_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, const double *y,
                   double *tension) {
    Flow rate = flow(arrays->a[1], arrays->a[(arrays->nodes - 1) * DOF + 1]);
    for (int k = 0; k < points; k++)
        tension[k] = arrays->reaction[1] + rho * ((gravity + rate.w) * (y[k] - arrays->q[1]) - rate.u * at[k]);
}
