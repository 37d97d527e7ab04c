/* Changes of the rope's description that leave the rope as it is, and the rigid model:
   rope_model.simulation.adaptation and rigid, which see. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulator.h"

#define POLE_MARGIN 0.35
#define POLE_FOLLOWS 0.5
#define RELAXATION_TIME 0.1
/* rigid */
#define SETTLING_TIME 0.1
#define SETTLING_TOLERANCE 1e-7
#define DIFFERENCE 2e-3

static void record_energy_change(Simulator *rope, State *state, int what, int64_t *count) {
    const Arrays m = state_arrays(state);
    const System s = system_of(rope, state);
    const double before = energy_total(&state->energy_balance), kinetic = state->energy_balance.kinetic;
    double balance[BALANCE], change;
    chain_of_state(state)->evaluate(&s, m.q, m.v, m.a, m.reaction, rope->x, balance);
    set_energies(&state->energy_balance, balance, &s, m.v);
    change = energy_total(&state->energy_balance) - before;
    state->energy_balance.transformations += change;
    record_event(state, what, 0, state->energy_balance.kinetic - kinetic,
                 change - (state->energy_balance.kinetic - kinetic));
    *count += 1;
}

/* the equilibrium of the state with its accelerations, an inertia that stands for `time` holding what is slow; 0 when
   there is none, and the state is as it was */
static int solve_equilibrium(Simulator *rope, State *state, double time, double tolerance, int with_reaction) {
    const Arrays m = state_arrays(state), *now = &rope->trial;
    const System s = system_of(rope, state);
    const size_t bytes = sizeof(double) * (size_t)m.nodes * DOF;
    const double c[3] = {1, 0, pow(time, -2)};
    double balance[BALANCE];
    memcpy(now->q, m.q, bytes);
    memcpy(now->v, m.v, bytes);
    memcpy(now->a, m.a, bytes);
    memcpy(now->reaction, m.reaction, bytes);
    if (chain_of_state(state)
            ->solve(&s, rope->work, now->q, now->v, now->a, now->reaction, c, tolerance, balance)
            .status != CONVERGED)
        return 0;
    memcpy(m.q, now->q, bytes);
    if (with_reaction) memcpy(m.reaction, now->reaction, bytes);
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
    memset(m.reaction + DOF, 0, sizeof(double) * DOF * (size_t)(m.nodes - 2));
    solve_equilibrium(rope, state, RELAXATION_TIME, rope->scene.solver.newton_tolerance, 0);
    record_energy_change(rope, state, TRANSFORMED, &state->counts.transformations);
}

void transform_if_due(Simulator *rope, State *state) {
    int direction;
    while ((direction = mesh_transformation_due(&state->pattern, bottom_of(rope, state, state->t), 1e-7)))
        on_partition(rope, state, direction);
}

int lowest_node(const Arrays *x) {
    int node, lowest = 0;
    for (node = 1; node < x->nodes; ++node)
        if (x->q[(size_t)node * DOF + 1] < x->q[(size_t)lowest * DOF + 1]) lowest = node;
    return lowest;
}

void with_loop_yaw(State *state) {
    const Arrays x = state_arrays(state);
    const double *d = x.q + (size_t)lowest_node(&x) * DOF + SLOPE;
    state->loop_yaw = frame_nearest_turn(atan2(-d[2], d[0]), state->loop_yaw);
}

int better_pole(State *state, double pole[3]) {
    const Arrays m = state_arrays(state);
    const double *d = m.q + (size_t)lowest_node(&m) * DOF + SLOPE, *old = state->pole;
    const double length = sqrt(dot(d, d));
    const double across[2] = {d[0] / length, d[2] / length}, size = hypot(across[0], across[1]);
    double margin;
    if (state->fidelity != TORSIONAL) /* nothing is counted from the frame */
        return 0;
    margin = frame_pole_margin(old, m.nodes, m.q + SLOPE);
    if (margin >= POLE_MARGIN && old[0] * across[0] + old[2] * across[1] >= POLE_FOLLOWS * size) return 0;
    /* the lowest tangent suits a loop that hangs in any vertical plane as X suits it at the start */
    pole[0] = across[0] / fmax(size, 1e-12);
    pole[1] = 0;
    pole[2] = across[1] / fmax(size, 1e-12);
    if (frame_pole_margin(pole, m.nodes, m.q + SLOPE) < POLE_MARGIN) frame_best_pole(m.nodes, m.q + SLOPE, pole);
    return frame_pole_margin(pole, m.nodes, m.q + SLOPE) > margin - 0.1 && dot(pole, old) <= 0.99;
}

void express_in(State *state, const double pole[3], double *angle) {
    const Arrays m = state_arrays(state);
    int node;
    frame_pole_change_angle(state->pole, pole, m.nodes, m.q + SLOPE, angle);
    for (node = 0; node < m.nodes; ++node) {
        double *q = m.q + (size_t)node * DOF, *v = m.v + (size_t)node * DOF;
        q[ANGLE] += angle[node];
        v[ANGLE] += smallest_rotation_rate(state->pole, q + SLOPE, v + SLOPE) -
                    smallest_rotation_rate(pole, q + SLOPE, v + SLOPE);
    }
    memcpy(state->pole, pole, sizeof state->pole);
    state->offsets[LEFT] += angle[0];
    state->offsets[RIGHT] += angle[m.nodes - 1];
}

void with_good_pole(Simulator *rope, State *state) {
    double pole[3];
    if (!better_pole(state, pole)) return;
    state_copy(rope, rope->spare, state);
    express_in(state, pole, rope->x);
    if (solve_equilibrium(rope, state, RELAXATION_TIME, rope->scene.solver.newton_tolerance, 1))
        record_energy_change(rope, state, NEW_POLE, &state->counts.pole_changes);
    else /* the old frame serves for another step */
        state_copy(rope, state, rope->spare);
}

int rigid_state(Simulator *rope, State *state, double t, char *message) {
    Arrays m;
    state->t = t;
    transform_if_due(rope, state);
    m = state_arrays(state);
    rigid_rope(&rope->scene, state->paths, t, m.nodes, m.s, m.q, m.v, m.a, m.reaction, &state->energy_balance.kinetic,
               &state->energy_balance.gravity, message);
    memcpy(m.b, m.a, sizeof(double) * (size_t)m.nodes * DOF);
    memset(m.a_rate, 0, sizeof(double) * (size_t)m.nodes * DOF);
    state->h = 0;
    return !message[0];
}

/* q, v, a and the reaction as the equilibria between the moving ends have them; 0 and a message when there is none */
static int flexible_start(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state);
    const size_t size = (size_t)m.nodes * DOF, bytes = sizeof(double) * size;
    const double t = state->t;
    /* b and a_rate are free until the restart */
    double *q = m.b, *reaction = m.a_rate, *to[2] = {m.v, m.a};
    const Path paths[2] = {state->paths[LEFT], state->paths[RIGHT]};
    int side, k, found;
    size_t i;
    for (side = 0; side < 2; ++side) state->paths[side] = path_coasting(&paths[side], t);
    found = find_equilibrium(rope, state, message);
    memcpy(q, m.q, bytes);
    memcpy(reaction, m.reaction, bytes);
    for (k = 0; k < 2 && found; ++k) {
        state->t = k ? t + DIFFERENCE : t - DIFFERENCE;
        memcpy(m.q, q, bytes);
        found = find_equilibrium(rope, state, message);
        memcpy(to[k], m.q, bytes);
    }
    state->t = t;
    memcpy(state->paths, paths, sizeof paths);
    memcpy(m.q, q, bytes);
    memcpy(m.reaction, reaction, bytes);
    for (i = 0; i < size; ++i) {
        const double before = m.v[i], after = m.a[i];
        m.v[i] = (after - before) / (2 * DIFFERENCE);
        m.a[i] = (after - 2 * q[i] + before) / (DIFFERENCE * DIFFERENCE);
    }
    return found;
}

int raise_fidelity(Simulator *rope, State *state, const char *why, char *message) {
    const Arrays m = state_arrays(state);
    const double before = energy_total(&state->energy_balance);
    const int was = state->fidelity;
    EndMotion ends[2];
    double balance[BALANCE];
    System s;
    ends[LEFT] = path_end(&state->paths[LEFT]);
    ends[RIGHT] = path_end(&state->paths[RIGHT]);
    snprintf(state->fidelity_reason, MESSAGE, "the %s model cannot follow %s", fidelity_name(was), why);
    state->fidelity = fidelity_lowest_sufficient(&rope->scene, ends);
    record_event(state, RAISED, state->fidelity, 0, 0);
    if (was != RIGID && !scene_carries_torque(&rope->scene)) {
        restart(rope, state);
        return 1;
    }
    if (was == RIGID && !flexible_start(rope, state, message)) return 0;
    solve_equilibrium(rope, state, SETTLING_TIME, SETTLING_TOLERANCE, 1);
    restart(rope, state);
    s = system_of(rope, state);
    chain_of_state(state)->evaluate(&s, m.q, m.v, m.a, m.reaction, rope->x, balance);
    set_energies(&state->energy_balance, balance, &s, m.v);
    state->energy_balance.transformations += energy_total(&state->energy_balance) - before;
    return 1;
}
