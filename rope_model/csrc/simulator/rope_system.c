/* Equations of motion of a state: its elements (physics.element) chained by block_elimination.inc.

   A System is made for one state and one set of boundary conditions; a change of any of them makes a new one. */

#include "rope_system.h"

#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "contact_balance.h"
#include "contact_element.h"
#include "curvature.h"
#include "ends.h"
#include "formulas.h"
#include "obstacles.h"
#include "point_forces.h"
#include "rope.h"
#include "rules.h"
#include "self_contact.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"
#include "wires.h"

/* Add boundary conditions and swivel of an end to the equations. */
static void set_end(System *sys, const Scene *scene, const State *state, int side) {
    const Swivel *swivel = &scene->swivels[side];
    const SwivelState *now = &state->swivels[side];
    ends_freedom(scene, state, side, sys->free[side]);
    sys->inertia[side] = swivel->inertia;
    sys->plumb[side] = swivel->attachment == PLUMB;
    sys->load[side] = swivel_phases_slip_constant(swivel, now);
    sys->friction_load[side] = swivel_phases_slip_per_tension(swivel, now);
}

static System system_of(const Simulator *sim, State *state) {
    const Scene *scene = &sim->scene;
    const Rope *rope = &scene->rope;
    const Air *air = &scene->shaft.air;
    const NodalArrays nodal = state_arrays(state);
    System sys = {.elements = nodal.elements,
                  .lengths = nodal.lengths,
                  .frames = sim->reference.frames,
                  .time = state->t,
                  .wire_tangents = sim->work.wire_tangents,
                  .shortest = nodal.lengths[0]};
    for (int k = 1; k < nodal.elements; k++) sys.shortest = fmin(sys.shortest, nodal.lengths[k]);
    if (sim->obstacles->bodies > 0) sys.obstacles = sim->obstacles;
    if (sim->self_contact->presses) sys.self_contact = sim->self_contact;
    if (sim->forces.count > 0) sys.forces = &sim->forces;
    if (state->rubs) sys.wires = sim->reference.wires;
    if (is_curved(sim->reference.curved, rope, state->fidelity)) sys.curved = sim->reference.curved;
    element_parameters(rope, scene->layout.gravity, sys.P);
    sys.air_acts = air_acts(air, rope->diameter);
    air_coefficients(air, rope->diameter, scene->layout.spacing, sys.air);
    for (int side = LEFT; side <= RIGHT; side++) set_end(&sys, scene, state, side);
    return sys;
}

System rope_system(const Simulator *sim, State *state) {
#ifdef ROPE_CHECKS /* in tests: a wrong reference would give wrong forces and no message */
    assert(state->fidelity == RIGID || sim->reference.of == state);
#endif
    return system_of(sim, state);
}

void rope_system_adopt(Simulator *sim, const State *state) {
    sim->reference.of = state;
}

/* Refer permanent curvature and friction between wires to q. */
static void refer_material(Simulator *sim, State *state, const System *sys, const double *q) {
    sim->reference.of = state;
    memcpy(sim->reference.left_slope, q + SLOPE, sizeof sim->reference.left_slope);
    curved_reference(sim->reference.curved, &sim->scene.rope, state, q);
    if (!state->rubs) return;
    chain_of(sim, state)->strains(sys, q, state_arrays(state).v, sim->work.strains); /* the history takes no rates */
    wires_history(&sim->scene.rope, state, q, sim->work.strains, sim->reference.wires);
}

void rope_system_refer(Simulator *sim, State *state, const double *q) {
    const System sys = system_of(sim, state);
    chain_of(sim, state)->refer(&sys, q);
    refer_material(sim, state, &sys, q);
}

double rope_system_transport(Simulator *sim, State *state, double *q, double *v, double *a, double *b) {
    const System sys = rope_system(sim, state);
    double turn = 0;
    chain_of(sim, state)->transport(&sys, q, v, a, sim->work.gained);
    for (int k = 0; k < sys.elements; k++) {
        const size_t theta = (size_t)(k + 1) * DOF + ANGLE;
        const double *gained = sim->work.gained[k];
        turn += gained[THETA];
        q[theta] += turn;
        v[theta] += gained[THETA_T];
        a[theta] += gained[THETA_TT];
        b[theta] += gained[THETA_TT];
    }
    carry_director(state, sim->reference.left_slope, q + SLOPE);
    refer_material(sim, state, &sys, q);
    return turn;
}

void rope_system_prescribed_motion(const Scene *scene, const State *state, double t, int orders, double *const x[]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const size_t row = end_index(state->elements + 1, side);
        bool free[DOF];
        double rows[3][DOF];
        ends_freedom(scene, state, side, free);
        ends_prescribed_motion(scene, state, side, t, rows);
        for (int k = 0; k < orders; k++)
            for (int dof = 0; dof < DOF; dof++)
                if (!free[dof]) x[k][row + (size_t)dof] = rows[k][dof];
    }
}

void external_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    memset(sums, 0, sizeof(double) * CONTACT_BALANCE);
    self_contact_sums(sys, q, v, sums);
    point_forces_push(sys, q, v, sums);
    if (sys->obstacles == NULL) return;
    find_near_bodies(sys, q, v, 0);
    if (!sys->obstacles->any) return;
    for (int e = 0; e < sys->elements; e++)
        if (sys->obstacles->near[e]) contact_sums(sys, e, q, v, sums);
}

void rope_system_strains(Simulator *sim) {
    const System sys = rope_system(sim, sim->state);
    const NodalArrays nodal = state_arrays(sim->state);
    chain_of(sim, sim->state)->strains(&sys, nodal.q, nodal.v, sim->work.strains);
}
