/* rope_model.simulation.rigid: an inextensible rope without bending stiffness, two straight legs and a half circle. */
#include <string.h>

#include "formulas.h"
#include "messages.h"

/* velocities v (nodes x DOF) of the flow along the rope q (nodes x DOF) */
static void flow_velocities(int nodes, const double *q, Flow flow, double *v) {
    for (int i = 0; i < nodes * DOF; i += DOF) {
        for (int k = 0; k < 3; k++) v[i + k] = -flow.u * q[i + SLOPE + k];
        v[i + 1] += flow.w;
        for (int k = SLOPE; k < DOF; k++) v[i + k] = 0.0;
    }
}

void rigid_rope(const Scene *scene, const EndMotion ends[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message) {
    const Pull pull = rigid_pull(&scene->rope, &scene->layout, &ends[LEFT], &ends[RIGHT]);
    double points[2][3], energies[2];
    message[0] = '\0';
    if (rigid_lowest(&pull) < 0) {
        say_rope_goes_slack(message, rigid_lowest(&pull), t);
        return;
    }
    rigid_energies(&scene->rope, &scene->layout, &pull, &ends[LEFT], &ends[RIGHT], energies);
    *kinetic = energies[0], *gravity = energies[1];

    suspension_points(&scene->layout, &ends[LEFT], &ends[RIGHT], points);
    shape_hanging_guess(nodes, s, points[LEFT], points[RIGHT], q, message);
    if (message[0]) return;
    flow_velocities(nodes, q, rigid_flow(ends[LEFT].vy, ends[RIGHT].vy), v);
    for (int i = 0; i < nodes * DOF; i++) a[i] = reaction[i] = 0.0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const int end = side == LEFT ? 0 : (nodes - 1) * DOF;
        memcpy(v + end, &ends[side].vx, 3 * sizeof *v);
        memcpy(a + end, &ends[side].ax, 3 * sizeof *a);
        reaction[end + 1] = pull.tensions[side];
    }
}

void rigid_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, const double *y,
                   double *tension) {
    Flow rate = rigid_flow(arrays->a[1], arrays->a[(arrays->nodes - 1) * DOF + 1]);
    for (int k = 0; k < points; k++)
        tension[k] = rigid_tension_at(rho, gravity, &rate, arrays->reaction[1], y[k] - arrays->q[1], at[k]);
}
