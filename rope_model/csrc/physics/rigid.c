/* Rigid rope, the lowest fidelity: physics.inextensible between the ends.

   It has no side forces, torque or waves and serves the design of controllers. The rope must stay taut. */

#include "rigid.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "messages.h"
#include "rope.h"
#include "state.h"
#include "state_structures.h"
#include "transfer.h"

/* Return the length of the elements about arc length `middle`, m. */
static double element_length_at(int nodes, const double *s, double middle) {
    const int e = middle_before(nodes, s, 0, middle);
    return interpolate_midpoints(nodes, s, e, middle, s[e + 1] - s[e], e < nodes - 2 ? s[e + 2] - s[e + 1] : 0.0);
}

/* Set q to the initial shape with a half circle of at least four elements, or with that of the ends if not `widened`.
 */
static RopeStatus shape_between(int nodes, const double *s, const double left[3], const double right[3], bool widened,
                                double *q, char *message) {
    message[0] = '\0';
    double length = s[nodes - 1];
    double across[3] = {right[0] - left[0], 0.0, right[2] - left[2]};
    double width = hypot(across[0], across[2]);
    if (width == 0) return say_ends_above_each_other(message, fabs(left[UP] - right[UP]));
    for (int axis = 0; axis < 3; axis++) across[axis] /= width;
    double middle = 0.5 * (length + left[UP] - right[UP]); /* arc length of the lowest point */
    const double cell = widened ? element_length_at(nodes, s, middle) : 0.0;
    InitialShape legs = initial_shape(length, middle, width, cell);
    if (minimum(legs.left_leg, legs.right_leg) <= legs.lean)
        return say_rope_too_short(message, length, width, fabs(left[UP] - right[UP]));
    for (int k = 0; k < nodes; k++) initial_shape_node_row(&legs, left, across, s[k], q + (ptrdiff_t)DOF * k);
    return ROPE_DONE;
}

RopeStatus hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q,
                         char *message) {
    return shape_between(nodes, s, left, right, true, q, message);
}

/* Velocities v (nodes x DOF) of the flow along the rope q (nodes x DOF). */
static void flow_velocities(int nodes, const double *q, Flow flow, double *v) {
    for (int i = 0; i < nodes * DOF; i += DOF) {
        for (int k = 0; k < 3; k++) v[i + k] = -flow.u * q[i + SLOPE + k];
        v[i + UP] += flow.w;
        for (int k = SLOPE; k < DOF; k++) v[i + k] = 0.0;
    }
}

RopeStatus rigid_rope(const Scene *scene, const EndMotion ends[2], double t, const NodalArrays *nodal,
                      EnergyBalance *energy_balance, char *message) {
    const int nodes = nodal->nodes;
    double *q = nodal->q;
    double *v = nodal->v;
    double *a = nodal->a;
    double *reaction = nodal->reaction;
    const RigidTensions tensions = inextensible_rigid_tensions(&scene->rope, &scene->layout, &ends[LEFT], &ends[RIGHT]);
    double points[2][3];
    double energies[2];
    message[0] = '\0';
    if (inextensible_min_tension(&tensions) < 0)
        return say_rope_goes_slack(message, inextensible_min_tension(&tensions), t);
    inextensible_energies(&scene->rope, &scene->layout, &tensions, &ends[LEFT], &ends[RIGHT], energies);
    energy_balance->kinetic = energies[0];
    energy_balance->gravity = energies[1];
    centreline_suspension_points(&scene->layout, &ends[LEFT], &ends[RIGHT], points);
    if (!shape_between(nodes, nodal->s, points[LEFT], points[RIGHT], false, q, message)) return ROPE_FAILED;
    flow_velocities(nodes, q, inextensible_flow(ends[LEFT].vy, ends[RIGHT].vy), v);
    for (int i = 0; i < nodes * DOF; i++) a[i] = reaction[i] = 0.0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const size_t row = end_index(nodes, side);
        const double speed[3] = {end->vx, end->vy, end->vz};
        const double acceleration[3] = {end->ax, end->ay, end->az};
        memcpy(v + row, speed, sizeof speed);
        memcpy(a + row, acceleration, sizeof acceleration);
        reaction[row + UP] = tensions.at_ends[side];
    }
    return ROPE_DONE;
}

void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension) {
    Flow rate = inextensible_flow(arrays->a[UP], end_row(arrays->a, arrays->nodes, RIGHT)[UP]);
    for (int k = 0; k < points; k++)
        tension[k] = inextensible_tension(rho, gravity, &rate, arrays->reaction[UP], y[k] - arrays->q[UP], places[k]);
}
