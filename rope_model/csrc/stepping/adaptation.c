/* Changes of mesh and fidelity during a run, which leave the rope's motion as it is; unwrapping of the loop's
   yaw. */

#include "adaptation.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "ends.h"
#include "fidelity.h"
#include "fidelity_name.h"
#include "flexible_start.h"
#include "formulas.h"
#include "messages.h"
#include "newton.h"
#include "partition.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"
#include "transfer.h"
#include "trial_step.h"
#include "wires.h"

/* Error that Newton's method may leave in a transformation that is made again, m and rad: it shows in differences. */
#define REPEATED_ERROR 1e-11

/* Enter the energy change of a transformation into the energy balance. */
static void add_energy_change(Simulator *sim, State *state) {
    const double before = state->energy_balance.kinetic;
    const double change = rope_energies(sim, state);
    const double kinetic = state->energy_balance.kinetic - before;
    state->energy_balance.transformations += change;
    record_event(state, TRANSFORMED, 0, kinetic, change - kinetic);
    state->counts.transformations += 1;
}

/* Equilibrium with the present accelerations, damped by an inertia of time constant `time`; no change on failure. */
static Progress dynamic_equilibrium(Simulator *sim, State *state, double time, double tolerance) {
    const NodalArrays nodal = state_arrays(state);
    const NodalArrays *now = &sim->work.trial;
    const System sys = rope_system(sim, state);
    const size_t bytes = sizeof(double) * (size_t)nodal.nodes * DOF;
    const TangentCoefficients c = {.q = 1, .a = pow(time, -2)};
    double balance[ENERGIES];
    copy_fields(now, &nodal);
    const Progress newton = chain_of(sim, state)->solve(&sys, sim->work.chain, now, &c, tolerance, NULL, balance);
    if (newton.status != CONVERGED) return newton;
    update_hysteresis(sim->reference.wires, state, now->q);
    update_angles(sim, state, now->q, nodal.v, nodal.a, nodal.b);
    memcpy(nodal.q, now->q, bytes);
    return newton;
}

/* Transform the mesh once; return the status of Newton's method. */
static NewtonStatus transform_once(Simulator *sim, State *state, int direction, const double *divider_s) {
    const NodalArrays nodal = state_arrays(state);
    double *const fields[] = {nodal.q, nodal.v, nodal.a, nodal.b, nodal.a_rate};
    double *old_s = sim->work.trial.b;
    memcpy(old_s, nodal.s, sizeof(double) * (size_t)nodal.nodes);
    partition_transform(&state->pattern, direction, divider_s, nodal.elements, nodal.lengths);
    arc_lengths(nodal.elements, nodal.lengths, nodal.s);
    if (state->fidelity == RIGID) return CONVERGED; /* shape and energies do not depend on the mesh */
    transfer_fields(nodal.nodes, old_s, nodal.s, (int)(sizeof fields / sizeof *fields), fields, sim->work.chain);
    wires_carry(state, old_s, sim->reference.wires); /* scratch: its history belongs to the old mesh */
    memset(nodal.reaction + DOF, 0, sizeof(double) * DOF * (size_t)(nodal.nodes - 2));
    rope_system_refer(sim, state, nodal.q);
    const Solver *solver = &sim->scene.solver;
    const double tolerance =
        sim->replay.repeating
            ? REPEATED_ERROR
            : newton_effective_tolerance(solver->newton_tolerance, solver->work_max, NEWTON_BOUNDED_MESH_ERROR);
    double time = STEPPING_RELAXATION_TIME;
    Progress newton;
    for (;;) {
        newton = dynamic_equilibrium(sim, state, time, tolerance);
        if (newton.status == CONVERGED) break;
        if (time <= solver->step_min) return newton.status;
        time = fmax(0.5 * time, solver->step_min);
        state->counts.rejections += 1;
    }
    state->counts.given_up += newton.error > solver->newton_tolerance;
    add_energy_change(sim, state);
    return CONVERGED;
}

NewtonStatus transform_if_due(Simulator *sim, State *state) {
    /* A step that is taken again transforms when the recorded one did. */
    const EndPath *paths = sim->replay.repeating ? sim->replay.paths : state->paths;
    const double bottom_s = bottom_arc_length(&sim->scene, paths, state->t);
    double divider_s[DIVIDERS];
    NewtonStatus status = CONVERGED;
    dividers_on_rope(&sim->scene, paths, state->t, divider_s);
    while (status == CONVERGED) {
        const int direction = (int)mesh_pattern_transformation_due(&state->pattern, bottom_s, MESH_PATTERN_DUE_EARLY);
        if (direction == 0 && !window_due(&state->pattern, divider_s)) break;
        status = transform_once(sim, state, direction, divider_s);
    }
    return status;
}

void update_loop_yaw(State *state) {
    const NodalArrays x = state_arrays(state);
    const double *d = x.q + (size_t)lowest_node(x.nodes, x.q) * DOF + SLOPE;
    state->loop_yaw = centreline_nearest_turn(atan2(-d[2], d[0]), state->loop_yaw);
}

RopeStatus raise_fidelity(Simulator *sim, State *state, const char *why, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const int was = state->fidelity;
    const EndMotion ends[2] = {end_path_at(&state->paths[LEFT], INFINITY), end_path_at(&state->paths[RIGHT], INFINITY)};
    say_cannot_follow(state->fidelity_reason, fidelity_name(was), why);
    state->fidelity = lowest_sufficient(&sim->scene, ends, sim->forces.count);
    state->offsets[LEFT] = 0;
    state->offsets[RIGHT] = end_conditions_right_offset(nodal.q, end_row(nodal.q, nodal.nodes, RIGHT));
    record_event(state, RAISED, state->fidelity, 0, 0);
    rope_system_refer(sim, state, nodal.q);
    if (was != RIGID && !fidelity_rules_carries_torque(&sim->scene)) {
        restart_motion(sim, state);
        return ROPE_DONE;
    }
    if (was == RIGID && !flexible_start(sim, state, message)) return ROPE_FAILED;
    if (dynamic_equilibrium(sim, state, STEPPING_SETTLING_TIME, SETTLING_TOLERANCE).status == CONVERGED)
        memcpy(nodal.reaction, sim->work.trial.reaction, sizeof(double) * (size_t)nodal.nodes * DOF);
    else
        update_angles(sim, state, nodal.q, nodal.v, nodal.a, nodal.b);
    restart_motion(sim, state);
    state->energy_balance.transformations += rope_energies(sim, state);
    if (start_hysteresis(sim->reference.wires, state)) rope_system_refer(sim, state, nodal.q);
    return ROPE_DONE;
}
