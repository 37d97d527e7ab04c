/* Interface for the contact between neighbouring ropes: forces on this rope, the places of its nodes, and its response
   to forces. */

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "chain.h"
#include "formulas.h"
#include "messages.h"
#include "point_forces.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"
#include "system.h"

void rope_apply(Simulator *sim, const PointForces *forces) {
    sim->forces = *forces;
    sim->replay.known = false;
}

void rope_rows(const Simulator *sim, double (*rows)[ROPE_ROW]) {
    const NodalArrays nodal = state_arrays(sim->state);
    for (int node = 0; node < nodal.nodes; node++) {
        const double *q = nodal.q + (size_t)node * DOF;
        const double *v = nodal.v + (size_t)node * DOF;
        rows[node][0] = nodal.s[node];
        memcpy(rows[node] + 1, q, ANGLE * sizeof *q);
        memcpy(rows[node] + 1 + ANGLE, v, ANGLE * sizeof *v);
    }
}

RopeStatus rope_displacement(Simulator *sim, const PointForces *forces, double (*moved)[3]) {
    State *state = sim->state;
    memset(moved, 0, sizeof *moved * (size_t)forces->count);
    if (!sim->initialized) return say_no_state(sim->message);
    if (state->fidelity == RIGID) return say_rigid_under_forces(sim->message);
    const NodalArrays nodal = state_arrays(state);
    const Coefficients method = {sim->scene.solver.rho_inf};
    System sys = rope_system(sim, state);
    sys.time = forces->start;
    const TangentCoefficients c = generalized_alpha_newton_coefficients(&method, state->last_interval);
    double *const corrections[2] = {sim->work.trial.q, sim->work.x};
    for (int k = 0; k < 2; k++) {
        sys.forces = k == 0 ? NULL : forces;
        chain_of(sim, state)->newton_step(&sys, sim->work.chain, &nodal, &c, k > 0, corrections[k], sim->work.trial.v);
    }
    PointForce point = {0};
    for (int index = 0; index < forces->count; index++) {
        double without[3];
        elements_at(&sys, index, &point);
        at_places(corrections[0], point.element, point.N, without);
        at_places(corrections[1], point.element, point.N, moved[index]);
        for (int i = 0; i < 3; i++) moved[index][i] -= without[i];
    }
    return ROPE_DONE;
}
