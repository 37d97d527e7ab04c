/* Changes of the rope's description that leave the rope as it is, and the rigid model:
   rope_model.simulation.mesh.adaptation and rigid, which see. */

#include <math.h>
#include <string.h>

#include "rules.h"
#include "simulator.h"

/* a transformed rope with its energy change in the energy_balance */
static void record_energy_change(Simulator *rope, State *state) {
    const double kinetic = state->energy_balance.kinetic, change = update_energies(rope, state);
    state->energy_balance.transformations += change;
    record_event(state, TRANSFORMED, 0, state->energy_balance.kinetic - kinetic,
                 change - (state->energy_balance.kinetic - kinetic));
    state->counts.transformations += 1;
}

/* the equilibrium of the state with its accelerations, an inertia that stands for `time` holding what is slow, into
   trial; 0 when there is none, and the state is as it was */
static int solve_equilibrium(Simulator *rope, State *state, double time, double tolerance) {
    const Arrays m = state_arrays(state), *now = &rope->trial;
    const System s = system_of(rope, state);
    const size_t bytes = sizeof(double) * (size_t)m.nodes * DOF;
    const double c[3] = {1, 0, pow(time, -2)};
    double balance[BALANCE];
    memcpy(now->q, m.q, FIELDS * bytes);
    const Progress newton =
        chain_of(rope, state)->solve(&s, rope->work, now->q, now->v, now->a, now->reaction, c, tolerance, balance);
    if (newton.status != CONVERGED) return 0;
    slip_wires(rope, state, now->q);
    state->offsets[RIGHT] += transport_angles(rope, state, now->q, m.v, m.a, m.b);
    memcpy(m.q, now->q, bytes);
    return 1;
}

static void on_partition(Simulator *rope, State *state, int direction) {
    const Arrays m = state_arrays(state);
    double *const fields[] = {m.q, m.v, m.a, m.b, m.a_rate}, *old_s = rope->trial.b;
    memcpy(old_s, m.s, sizeof(double) * (size_t)m.nodes);
    mesh_transform(&state->pattern, direction, m.elements, m.lengths);
    mesh_arc_lengths(m.elements, m.lengths, m.s);
    if (state->fidelity == RIGID) /* its shape and energies do not come from the mesh */
        return;
    transfer_fields(m.nodes, old_s, m.s, 5, fields, rope->work); /* the chain's, free between solutions */
    carry_wires(rope, state, old_s);
    memset(m.reaction + DOF, 0, sizeof(double) * DOF * (size_t)(m.nodes - 2));
    refer(rope, state, m.q);
    solve_equilibrium(rope, state, RELAXATION_TIME, rope->scene.solver.newton_tolerance);
    record_energy_change(rope, state);
}

void transform_if_due(Simulator *rope, State *state) {
    int direction;
    while ((direction = (int)transformation_due(&state->pattern, bottom_of(rope, state, state->t), DUE_EARLY)))
        on_partition(rope, state, direction);
}

void with_loop_yaw(State *state) {
    const Arrays x = state_arrays(state);
    const double *d = x.q + (size_t)shape_lowest_node(x.nodes, x.q) * DOF + SLOPE;
    state->loop_yaw = shape_nearest_turn(atan2(-d[2], d[0]), state->loop_yaw);
}

int rigid_state(Simulator *rope, State *state, double t, char *message) {
    state->t = t;
    transform_if_due(rope, state);
    const Arrays m = state_arrays(state);
    const EndMotion ends[2] = {path_at(&state->paths[LEFT], t), path_at(&state->paths[RIGHT], t)};
    rigid_rope(&rope->scene, ends, t, m.nodes, m.s, m.q, m.v, m.a, m.reaction, &state->energy_balance.kinetic,
               &state->energy_balance.gravity, message);
    memcpy(m.b, m.a, sizeof(double) * (size_t)m.nodes * DOF);
    memset(m.a_rate, 0, sizeof(double) * (size_t)m.nodes * DOF);
    state->h = 0;
    return !message[0];
}

/* theta of an equilibrium q counted from the rigid rope instead of along q */
static void count_from_rigid(Simulator *rope, State *state, const double *rigid, double *q) {
    const size_t size = (size_t)(state->elements + 1) * DOF;
    double *own = rope->trial.q, *rest = rope->trial.v;
    memcpy(own, q, sizeof(double) * size);
    memset(rest, 0, sizeof(double) * size);
    refer(rope, state, rigid);
    transport_angles(rope, state, own, rest, rest, rest);
    for (size_t at = ANGLE; at < size; at += DOF) q[at] -= own[at] - q[at];
}

/* q, v, a and the reaction as the equilibria between the moving ends have them, all counted from the rigid rope; 0 and
   a message when there is none */
static int flexible_start(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state);
    const size_t size = (size_t)m.nodes * DOF, bytes = sizeof(double) * size;
    const double t = state->t, offset = state->offsets[RIGHT];
    /* b and a_rate are free until the restart */
    double *q = m.b, *reaction = m.a_rate, *const all[3] = {m.q, m.v, m.a};
    const Path paths[2] = {state->paths[LEFT], state->paths[RIGHT]};
    state_copy(rope, rope->spare, state);
    const double *rigid = state_arrays(rope->spare).q;
    for (int side = LEFT; side <= RIGHT; side++) state->paths[side] = path_coasting(&paths[side], t);
    int found = find_equilibrium(rope, state, INFINITY, message);
    const double turned = state->offsets[RIGHT];
    memcpy(q, m.q, bytes);
    memcpy(reaction, m.reaction, bytes);
    for (int k = 1; k < 3 && found; k++) { /* before, and after */
        state->t = k == 1 ? t - DIFFERENCE : t + DIFFERENCE;
        state->offsets[RIGHT] = turned;
        memcpy(m.q, q, bytes);
        found = find_equilibrium(rope, state, INFINITY, message);
        memcpy(all[k], m.q, bytes);
    }
    state->t = t;
    state->offsets[RIGHT] = offset;
    memcpy(state->paths, paths, sizeof paths);
    memcpy(m.q, q, bytes);
    memcpy(m.reaction, reaction, bytes);
    for (int k = 0; k < 3 && found; k++) count_from_rigid(rope, state, rigid, all[k]);
    refer(rope, state, rigid);
    for (size_t i = 0; i < size; i++) {
        const double before = m.v[i], after = m.a[i];
        m.v[i] = (after - before) / (2 * DIFFERENCE);
        m.a[i] = (after - 2 * m.q[i] + before) / (DIFFERENCE * DIFFERENCE);
    }
    return found;
}

int raise_fidelity(Simulator *rope, State *state, const char *why, char *message) {
    const Arrays m = state_arrays(state);
    const int was = state->fidelity;
    const EndMotion ends[2] = {path_at(&state->paths[LEFT], INFINITY), path_at(&state->paths[RIGHT], INFINITY)};
    say_cannot_follow(state->fidelity_reason, fidelity_name(was), why);
    state->fidelity = fidelity_lowest_sufficient(&rope->scene, ends, rope->forces.number);
    state->offsets[LEFT] = 0;
    state->offsets[RIGHT] = right_offset(m.q, end_row(m.q, m.nodes, RIGHT));
    record_event(state, RAISED, state->fidelity, 0, 0);
    refer(rope, state, m.q);
    if (was != RIGID && !carries_torque(&rope->scene)) {
        restart(rope, state);
        return 1;
    }
    if (was == RIGID && !flexible_start(rope, state, message)) return 0;
    if (solve_equilibrium(rope, state, SETTLING_TIME, SETTLING_TOLERANCE))
        memcpy(m.reaction, rope->trial.reaction, sizeof(double) * (size_t)m.nodes * DOF);
    else
        state->offsets[RIGHT] += transport_angles(rope, state, m.q, m.v, m.a, m.b);
    restart(rope, state);
    state->energy_balance.transformations += update_energies(rope, state);
    begin_rubbing(rope, state);
    return 1;
}
