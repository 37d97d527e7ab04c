/* rope_model.simulation.rigid: an inextensible rope without bending stiffness, two straight legs and a half circle. */
#include <math.h>

#include "formulas.h"
#include "messages.h"

void suspension_point(const Scene *scene, int side, const double x[3], double point[3]) {
    point[0] = (side == LEFT ? -0.5 : 0.5) * scene->layout.spacing + x[0];
    point[1] = x[1];
    point[2] = x[2];
}

double rigid_lowest_tension(const Scene *scene, const EndMotion ends[2]) {
    double points[2][3], v[2], a[2];
    for (int side = LEFT; side <= RIGHT; side++) {
        suspension_point(scene, side, ends[side].x, points[side]);
        v[side] = ends[side].v[1], a[side] = ends[side].a[1];
    }
    Pull pull = rigid_pull(&scene->rope, &scene->layout, points, v, a);
    return rigid_lowest(&pull);
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
        suspension_point(scene, side, x, points[side]);
    }
    Pull pull = rigid_pull(&scene->rope, &scene->layout, points, v, a);
    tensions[LEFT] = pull.tensions[LEFT], tensions[RIGHT] = pull.tensions[RIGHT];
}

/* velocities v (nodes x DOF) of the flow along the rope q (nodes x DOF) */
static void flow_velocities(int nodes, const double *q, Flow flow, double *v) {
    for (int i = 0; i < nodes * DOF; i += DOF) {
        for (int k = 0; k < 3; k++) v[i + k] = -flow.u * q[i + SLOPE + k];
        v[i + 1] += flow.w;
        for (int k = SLOPE; k < DOF; k++) v[i + k] = 0.0;
    }
}

void rigid_rope(const Scene *scene, const Path paths[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message) {
    double x[2][3], x_t[2][3], x_tt[2][3], points[2][3], up[2], up_t[2], up_tt[2], energies[2];
    message[0] = '\0';
    for (int side = LEFT; side <= RIGHT; side++) {
        for (int k = 0; k < 3; k++) {
            double rates[3];
            path_rates(&paths[side], t, k, rates);
            x[side][k] = rates[0], x_t[side][k] = rates[1], x_tt[side][k] = rates[2];
        }
        suspension_point(scene, side, x[side], points[side]);
        up[side] = x[side][1], up_t[side] = x_t[side][1], up_tt[side] = x_tt[side][1];
    }
    Pull pull = rigid_pull(&scene->rope, &scene->layout, points, up_t, up_tt);
    if (rigid_lowest(&pull) < 0) {
        say_rope_goes_slack(message, rigid_lowest(&pull), t);
        return;
    }
    rigid_energies(&scene->rope, &scene->layout, &pull, up, up_t, energies);
    *kinetic = energies[0], *gravity = energies[1];

    shape_hanging_guess(nodes, s, points[LEFT], points[RIGHT], q, message);
    if (message[0]) return;
    flow_velocities(nodes, q, rigid_flow(up_t[LEFT], up_t[RIGHT]), v);
    for (int i = 0; i < nodes * DOF; i++) a[i] = reaction[i] = 0.0;
    for (int side = LEFT; side <= RIGHT; side++) {
        int end = side == LEFT ? 0 : (nodes - 1) * DOF;
        for (int k = 0; k < 3; k++) v[end + k] = x_t[side][k], a[end + k] = x_tt[side][k];
        reaction[end + 1] = pull.tensions[side];
    }
}

void rigid_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, const double *y,
                   double *tension) {
    Flow rate = rigid_flow(arrays->a[1], arrays->a[(arrays->nodes - 1) * DOF + 1]);
    for (int k = 0; k < points; k++)
        tension[k] = rigid_tension_at(rho, gravity, &rate, arrays->reaction[1], y[k] - arrays->q[1], at[k]);
}
