/* Derivatives of the end loads.  C version of rope_model/simulation/outputs/sensitivity.py and RopeSimulator.answer. */

#include "messages.h"
#include "simulator.h"

/* Unperturbed step as long as the last: correction to trial.q, residual to trial.v, coefficients to c. */
static void unperturbed_step(Simulator *rope, double c[3]) {
    State *state = rope->state;
    if (state->fidelity == RIGID) return;
    const NodalArrays m = state_arrays(state);
    const System s = rope_system(rope, state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    newton_coefficients(&method, state->last_interval, c);
    chain_of(rope, state)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, 0, rope->trial.q, rope->trial.v);
}

/* Linear response of the rope to a move of one degree of freedom of an end by d[0], d[1], d[2] in q, v, a at the end of
   that step: state to `spare`, residual to trial.a. */
static void answer(Simulator *rope, int side, int dof, const double d[3], const double c[3]) {
    State *moved = rope->spare;
    state_copy(rope, moved, rope->state);
    const NodalArrays m = state_arrays(moved);
    const System s = rope_system(rope, moved);
    const size_t size = (size_t)m.nodes * DOF, row = side ? size - DOF : 0, moving = row + (size_t)dof;
    if (dof < DOF) {
        m.q[moving] += d[0];
        m.v[moving] += d[1];
        m.a[moving] += d[2];
    } else { /* the leans of a clamp follow the DOF */
        double leans[2][3], n[3][3], *const end[3] = {m.q + row, m.v + row, m.a + row};
        path_lean_motion(&moved->paths[side], moved->t, leans);
        for (int k = 0; k < 3; k++) leans[dof - DOF][k] += d[k];
        clamp_axis(leans[0], leans[1], n);
        for (int k = 0; k < 9; k++) end[k / 3][SLOPE + k % 3] = (side ? -1 : 1) * n[k / 3][k % 3];
    }
    double *R = rope->trial.a, balance[BALANCE];
    chain_of(rope, moved)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, 0, rope->x, R);
    for (size_t i = 0; i < size; i++) {
        const double y = rope->x[i] - rope->trial.q[i];
        m.q[i] += y;
        m.v[i] += c[1] * y;
        m.a[i] += c[2] * y;
    }
    chain_of(rope, moved)->evaluate(&s, m.q, m.v, m.a, m.reaction, R, balance);
}

/* Forces and moments of the rope on both conveyances. */
static void end_loads(const Simulator *rope, const State *state, const double *q, const double *R, double loads[12]) {
    const int nodes = rope->trial.nodes;
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *r = end_row(R, nodes, side);
        conveyance_load(end_row(q, nodes, side), r, ends_moment(&rope->scene, state, side, r), loads + 6 * side);
    }
}

/* Change of the end loads when an end moves by d as in `answer`; c is from unperturbed_step. */
static void change_of_loads(Simulator *rope, int side, int dof, const double d[3], const double c[3],
                            double change[12]) {
    const State *state = rope->state;
    memset(change, 0, sizeof(double) * 12);
    if (state->fidelity == RIGID) { /* has no side forces and no moments */
        const EndMotion ends[2] = {path_at(&state->paths[LEFT], state->t), path_at(&state->paths[RIGHT], state->t)};
        double gained[2];
        tension_change(&rope->scene, ends, side, dof, d, gained);
        for (int end = LEFT; end <= RIGHT; end++) change[6 * end + 1] -= gained[end];
        return;
    }
    double before[12];
    end_loads(rope, state, state_arrays(rope->state).q, rope->trial.v, before);
    answer(rope, side, dof, d, c);
    end_loads(rope, rope->spare, state_arrays(rope->spare).q, rope->trial.a, change);
    for (int k = 0; k < 12; k++) change[k] -= before[k];
}

/* Growth of each end's downward force per upward acceleration held over the last interval, kg. */
void added_mass_signals(Simulator *rope, double *values) {
    const double h = rope->state->last_interval, size = 1e-3;
    const double d[3] = {0.5 * h * h * size, h * size, size};
    double c[3], change[12];
    unperturbed_step(rope, c);
    for (int side = LEFT; side <= RIGHT; side++) {
        change_of_loads(rope, side, 1, d, c, change);
        values[side == LEFT ? SIGNAL_LEFT_ADDED_MASS : SIGNAL_RIGHT_ADDED_MASS] = -change[6 * side + 1] / size;
    }
}

int rope_load_derivative(Simulator *rope, int input, int at_step_end, double derivative[12]) {
    /* perturbations in m, m/s, m/s^2 or rad, rad/s, rad/s^2: far above rounding, too small to bend the rope */
    static const double sizes[3] = {1e-7, 1e-5, 1e-3};
    enum { OF_END = sizeof(EndMotion) / sizeof(double) };
    if (input < 0 || input >= 2 * OF_END) return say_no_such_input(rope->message, 2 * OF_END - 1);
    if (!rope->initialized) return say_no_state(rope->message);
    static const int orders[OF_END] = INPUT_ORDERS, dofs[OF_END] = INPUT_DOFS;
    const int side = input / OF_END, order = orders[input % OF_END], dof = dofs[input % OF_END];
    State *state = rope->state;
    const FilterSettings settings = filter_settings(&rope->scene, rope->scene.inputs.given);
    const double h = state->last_interval;
    double sample[3] = {0}, d[3], c[3];
    sample[order] = sizes[order] * (dof == ANGLE && side == LEFT ? -1 : 1);
    if (dof == ANGLE && order == 1) sample[2] = sample[1] / h; /* a path derives yaw acceleration from rates */
    if (dof > ANGLE)
        lean_moves(h, at_step_end ? 0 : h, sample[0], d);
    else
        sample_moves(&settings, h, at_step_end ? 0 : h, sample, state->filters[side].explained[dof < ANGLE ? dof : 3],
                     d);
    memset(derivative, 0, sizeof(double) * 12);
    /* The rigid rope does not depend on yaw and leans, friction not on the yaw. */
    if (dof >= ANGLE && state->fidelity == RIGID) return 1;
    if (dof == ANGLE && state->swivels[side].phase == SLIP) return 1;
    if (dof > ANGLE && rope->scene.swivels[side].attachment != CLAMPED) return 1;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) return 1; /* the input is not used */
    unperturbed_step(rope, c);
    change_of_loads(rope, side, dof, d, c, derivative);
    for (int k = 0; k < 12; k++) {
        derivative[k] /= sizes[order];
        if (!isfinite(derivative[k])) return say_no_finite_derivative(rope->message);
    }
    return 1;
}
