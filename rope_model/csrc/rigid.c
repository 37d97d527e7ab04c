/* Rigid rope, the lowest fidelity: physics.inextensible between the ends, and the transition to a flexible rope.

   It has no side forces, torque or waves and serves the design of controllers. The rope must stay taut.

   The flexible rope that replaces it starts from the equilibrium between the ends of that instant and moves with
   it. */

#include "rigid.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "messages.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"
#include "statics.h"

/* Velocities v (nodes x DOF) of the flow along the rope q (nodes x DOF). */
static void flow_velocities(int nodes, const double *q, Flow flow, double *v) {
    for (int i = 0; i < nodes * DOF; i += DOF) {
        for (int k = 0; k < 3; k++) v[i + k] = -flow.u * q[i + SLOPE + k];
        v[i + 1] += flow.w;
        for (int k = SLOPE; k < DOF; k++) v[i + k] = 0.0;
    }
}

RopeStatus rigid_rope(const Scene *scene, const EndMotion ends[2], double t, const NodalArrays *nodal,
                      EnergyBalance *energy_balance, char *message) {
    const int nodes = nodal->nodes;
    double *q = nodal->q, *v = nodal->v, *a = nodal->a, *reaction = nodal->reaction;
    const RigidTensions tensions = inextensible_rigid_tensions(&scene->rope, &scene->layout, &ends[LEFT], &ends[RIGHT]);
    double points[2][3], energies[2];
    message[0] = '\0';
    if (inextensible_min_tension(&tensions) < 0)
        return say_rope_goes_slack(message, inextensible_min_tension(&tensions), t);
    inextensible_energies(&scene->rope, &scene->layout, &tensions, &ends[LEFT], &ends[RIGHT], energies);
    energy_balance->kinetic = energies[0];
    energy_balance->gravity = energies[1];
    centreline_suspension_points(&scene->layout, &ends[LEFT], &ends[RIGHT], points);
    if (!hanging_guess(nodes, nodal->s, points[LEFT], points[RIGHT], q, message)) return ROPE_FAILED;
    flow_velocities(nodes, q, inextensible_flow(ends[LEFT].vy, ends[RIGHT].vy), v);
    for (int i = 0; i < nodes * DOF; i++) a[i] = reaction[i] = 0.0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const EndMotion *end = &ends[side];
        const int row = side == LEFT ? 0 : (nodes - 1) * DOF;
        const double speed[3] = {end->vx, end->vy, end->vz};
        const double acceleration[3] = {end->ax, end->ay, end->az};
        memcpy(v + row, speed, sizeof speed);
        memcpy(a + row, acceleration, sizeof acceleration);
        reaction[row + 1] = tensions.at_ends[side];
    }
    return ROPE_DONE;
}

void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension) {
    Flow rate = inextensible_flow(arrays->a[1], arrays->a[(arrays->nodes - 1) * DOF + 1]);
    for (int k = 0; k < points; k++)
        tension[k] = inextensible_tension(rho, gravity, &rate, arrays->reaction[1], y[k] - arrays->q[1], places[k]);
}

/* Refer theta of an equilibrium q, which is referred to q, to the rigid rope. */
static void count_from_rigid(Simulator *sim, State *state, const double *rigid, double *q) {
    const size_t size = (size_t)(state->elements + 1) * DOF;
    double *moved = sim->trial.q, *zeros = sim->trial.v;
    memcpy(moved, q, sizeof(double) * size);
    memset(zeros, 0, sizeof(double) * size);
    rope_system_refer(sim, state, rigid);
    rope_system_transport(sim, state, moved, zeros, zeros, zeros);
    for (size_t i = ANGLE; i < size; i += DOF) q[i] -= moved[i] - q[i];
}

RopeStatus flexible_start(Simulator *sim, State *state, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const size_t size = (size_t)nodal.nodes * DOF, bytes = sizeof(double) * size;
    const double t = state->t, offset = state->offsets[RIGHT];
    /* b and a_rate are scratch until the restart. */
    double *q = nodal.b, *reaction = nodal.a_rate, *const all[3] = {nodal.q, nodal.v, nodal.a};
    const EndPath paths[2] = {state->paths[LEFT], state->paths[RIGHT]};
    double director[3];
    memcpy(director, state->director, sizeof director);
    memcpy(sim->spare, state, sim->state_bytes);
    const double *rigid = state_arrays(sim->spare).q;
    for (int side = LEFT; side <= RIGHT; side++)
        state->paths[side] = end_path_at_constant_acceleration(&paths[side], t);
    sim->corrections = sim->solutions = 0;
    RopeStatus found = find_equilibrium(sim, state, INFINITY, message);
    const double turned = state->offsets[RIGHT];
    memcpy(q, nodal.q, bytes);
    memcpy(reaction, nodal.reaction, bytes);
    for (int k = 1; k < 3 && found; k++) { /* equilibria just before and after t */
        state->t = k == 1 ? t - STEPPING_DIFFERENCE : t + STEPPING_DIFFERENCE;
        state->offsets[RIGHT] = turned;
        memcpy(nodal.q, q, bytes);
        found = find_equilibrium(sim, state, INFINITY, message);
        memcpy(all[k], nodal.q, bytes);
    }
    state->t = t;
    state->offsets[RIGHT] = offset;
    memcpy(state->paths, paths, sizeof paths);
    memcpy(nodal.q, q, bytes);
    memcpy(nodal.reaction, reaction, bytes);
    for (int k = 0; k < 3 && found; k++) count_from_rigid(sim, state, rigid, all[k]);
    memcpy(state->director, director, sizeof director);
    rope_system_refer(sim, state, rigid);
    for (size_t i = 0; i < size; i++) {
        const double before = nodal.v[i], after = nodal.a[i];
        nodal.v[i] = (after - before) / (2 * STEPPING_DIFFERENCE);
        nodal.a[i] = (after - 2 * nodal.q[i] + before) / (STEPPING_DIFFERENCE * STEPPING_DIFFERENCE);
    }
    return found;
}
