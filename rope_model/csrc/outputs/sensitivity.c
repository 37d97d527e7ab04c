/* Derivatives of the end loads.  C version of rope_model/simulation/outputs/sensitivity.py and RopeSimulator.answer. */

#include "messages.h"
#include "simulator.h"

/* Unperturbed step as long as the last: correction to trial.q, residual to trial.v, coefficients to c. */
static void unperturbed_step(Simulator *sim, double c[3]) {
    State *state = sim->state;
    if (state->fidelity == RIGID) return;
    const NodalArrays nodal = state_arrays(state);
    const System sys = rope_system(sim, state);
    const Coefficients method = {sim->scene.solver.rho_inf};
    newton_coefficients(&method, state->last_interval, c);
    chain_of(sim, state)
        ->newton_step(&sys, sim->work, nodal.q, nodal.v, nodal.a, nodal.reaction, c, 0, sim->trial.q, sim->trial.v);
}

/* Linear response of the rope to a move of one degree of freedom of an end by d[0], d[1], d[2] in q, v, a at the end of
   that step: state to `spare`, residual to trial.a. */
static void answer(Simulator *sim, int side, int dof, const double d[3], const double c[3]) {
    State *moved = sim->spare;
    state_copy(sim, moved, sim->state);
    const NodalArrays nodal = state_arrays(moved);
    const System sys = rope_system(sim, moved);
    const size_t size = (size_t)nodal.nodes * DOF, row = side ? size - DOF : 0, moving = row + (size_t)dof;
    if (dof < DOF) {
        nodal.q[moving] += d[0];
        nodal.v[moving] += d[1];
        nodal.a[moving] += d[2];
    } else { /* the leans of a clamp follow the DOF */
        double leans[2][3], n[3][3], *const end[3] = {nodal.q + row, nodal.v + row, nodal.a + row};
        path_lean_motion(&moved->paths[side], moved->t, leans);
        for (int k = 0; k < 3; k++) leans[dof - DOF][k] += d[k];
        clamp_axis(leans[0], leans[1], n);
        for (int k = 0; k < 9; k++) end[k / 3][SLOPE + k % 3] = (side ? -1 : 1) * n[k / 3][k % 3];
    }
    double *R = sim->trial.a, balance[BALANCE];
    chain_of(sim, moved)->newton_step(&sys, sim->work, nodal.q, nodal.v, nodal.a, nodal.reaction, c, 0, sim->x, R);
    for (size_t i = 0; i < size; i++) {
        const double y = sim->x[i] - sim->trial.q[i];
        nodal.q[i] += y;
        nodal.v[i] += c[1] * y;
        nodal.a[i] += c[2] * y;
    }
    chain_of(sim, moved)->evaluate(&sys, nodal.q, nodal.v, nodal.a, nodal.reaction, R, balance);
}

/* Forces and moments of the rope on both conveyances. */
static void end_loads(const Simulator *sim, const State *state, const double *q, const double *R, double loads[12]) {
    const int nodes = sim->trial.nodes;
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *r = end_row(R, nodes, side);
        conveyance_load(end_row(q, nodes, side), r, ends_moment(&sim->scene, state, side, r), loads + 6 * side);
    }
}

/* Change of the end loads when an end moves by d as in `answer`; c is from unperturbed_step. */
static void change_of_loads(Simulator *sim, int side, int dof, const double d[3], const double c[3],
                            double change[12]) {
    const State *state = sim->state;
    memset(change, 0, sizeof(double) * 12);
    if (state->fidelity == RIGID) { /* has no side forces and no moments */
        const EndMotion ends[2] = {path_at(&state->paths[LEFT], state->t), path_at(&state->paths[RIGHT], state->t)};
        double gained[2];
        tension_change(&sim->scene, ends, side, dof, d, gained);
        for (int end = LEFT; end <= RIGHT; end++) change[6 * end + 1] -= gained[end];
        return;
    }
    double before[12];
    end_loads(sim, state, state_arrays(sim->state).q, sim->trial.v, before);
    answer(sim, side, dof, d, c);
    end_loads(sim, sim->spare, state_arrays(sim->spare).q, sim->trial.a, change);
    for (int k = 0; k < 12; k++) change[k] -= before[k];
}

/* Growth of each end's downward force per upward acceleration held over the last interval, kg. */
void added_mass_signals(Simulator *sim, double *values) {
    const double h = sim->state->last_interval, size = 1e-3;
    const double d[3] = {0.5 * h * h * size, h * size, size};
    double c[3], change[12];
    unperturbed_step(sim, c);
    for (int side = LEFT; side <= RIGHT; side++) {
        change_of_loads(sim, side, 1, d, c, change);
        values[side == LEFT ? SIGNAL_LEFT_ADDED_MASS : SIGNAL_RIGHT_ADDED_MASS] = -change[6 * side + 1] / size;
    }
}

int rope_load_derivative(Simulator *sim, int input, int at_step_end, double derivative[12]) {
    /* perturbations in m, m/s, m/s^2 or rad, rad/s, rad/s^2: far above rounding, too small to bend the rope */
    static const double sizes[3] = {1e-7, 1e-5, 1e-3};
    enum { OF_END = sizeof(EndMotion) / sizeof(double) };
    if (input < 0 || input >= 2 * OF_END) return say_no_such_input(sim->message, 2 * OF_END - 1);
    if (!sim->initialized) return say_no_state(sim->message);
    static const int orders[OF_END] = INPUT_ORDERS, dofs[OF_END] = INPUT_DOFS;
    const int side = input / OF_END, order = orders[input % OF_END], dof = dofs[input % OF_END];
    State *state = sim->state;
    const FilterSettings settings = filter_settings(&sim->scene, sim->scene.inputs.given);
    const double h = fmax(state->last_interval, MIN_AIM_TIME);
    double sample[3] = {0}, d[3], c[3];
    sample[order] = sizes[order] * (dof == ANGLE && side == LEFT ? -1 : 1);
    if (dof == ANGLE && order == 1) sample[2] = sample[1] / fmax(h, MIN_MEAN_TIME); /* a path derives it */
    if (dof > ANGLE)
        lean_moves(h, at_step_end ? 0 : h, sample[0], d);
    else
        sample_moves(&settings, h, at_step_end ? 0 : h, sample, state->filters[side].explained[dof < ANGLE ? dof : 3],
                     d);
    memset(derivative, 0, sizeof(double) * 12);
    /* The rigid rope does not depend on yaw and leans, friction not on the yaw. */
    if (dof >= ANGLE && state->fidelity == RIGID) return 1;
    if (dof == ANGLE && state->swivels[side].phase == SLIP) return 1;
    if (dof > ANGLE && sim->scene.swivels[side].attachment != CLAMPED) return 1;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) return 1; /* the input is not used */
    unperturbed_step(sim, c);
    change_of_loads(sim, side, dof, d, c, derivative);
    for (int k = 0; k < 12; k++) {
        derivative[k] /= sizes[order];
        if (!isfinite(derivative[k])) return say_no_finite_derivative(sim->message);
    }
    return 1;
}
