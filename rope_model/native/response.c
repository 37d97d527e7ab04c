/* What is read off the present state: outputs, and how the end forces answer to the ends:
   rope_model.simulation.simulator, which see. */

#include <math.h>
#include <string.h>

#include "messages.h"
#include "simulator.h"

/* The unperturbed step as long as the last: its correction to trial.q; c are its coefficients. */
static void unperturbed_step(Simulator *rope, double c[3]) {
    State *state = rope->state;
    const Arrays m = state_arrays(state);
    const System s = system_of(rope, state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    newton_coefficients(&method, state->last_interval, c);
    chain_of(rope, state)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, rope->trial.q, rope->trial.v);
}

/* The state `spare` with one degree of freedom of an end moved by d[0], d[1], d[2] in q, v, a at the end of that step,
   to which the rope answers: how its equations are linear.  Its residual goes to trial.a. */
static void perturbed_step(Simulator *rope, int side, int dof, const double d[3], const double c[3]) {
    State *moved = rope->spare;
    state_copy(rope, moved, rope->state);
    const Arrays m = state_arrays(moved);
    const System s = system_of(rope, moved);
    const size_t size = (size_t)m.nodes * DOF, at = (side ? size - DOF : 0) + (size_t)dof;
    m.q[at] += d[0];
    m.v[at] += d[1];
    m.a[at] += d[2];
    double *R = rope->trial.a, balance[BALANCE];
    chain_of(rope, moved)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, rope->x, R);
    for (size_t i = 0; i < size; i++) {
        const double y = rope->x[i] - rope->trial.q[i];
        m.q[i] += y;
        m.v[i] += c[1] * y;
        m.a[i] += c[2] * y;
    }
    chain_of(rope, moved)->evaluate(&s, m.q, m.v, m.a, m.reaction, R, balance);
}

/* tensions of the rigid rope at its ends, one of which is moved by d[k] along an axis in its k-th derivative */
static void rigid_answer(const Simulator *rope, int side, int axis, const double d[3], double tensions[2]) {
    const Path *paths = rope->state->paths;
    EndMotion ends[2] = {path_at(&paths[LEFT], rope->state->t), path_at(&paths[RIGHT], rope->state->t)};
    for (int k = 0; k < 3; k++) ((double *)&ends[side])[3 * k + axis] += d[k];
    const Pull pull = rigid_pull(&rope->scene.rope, &rope->scene.layout, &ends[LEFT], &ends[RIGHT]);
    memcpy(tensions, pull.tensions, sizeof pull.tensions);
}

/* kg: how much each end's downward force grows with an upward acceleration held over the last interval */
static void added_masses(Simulator *rope, double masses[2]) {
    const double h = rope->state->last_interval, size = 1e-3;
    const double d[3] = {0.5 * h * h * size, h * size, size}, none[3] = {0};
    double c[3];
    if (rope->state->fidelity != RIGID) unperturbed_step(rope, c);
    for (int side = LEFT; side <= RIGHT; side++) {
        double before[2], after[2];
        if (rope->state->fidelity == RIGID) {
            rigid_answer(rope, side, 1, none, before);
            rigid_answer(rope, side, 1, d, after);
        } else {
            perturbed_step(rope, side, 1, d, c);
            before[side] = end_row(rope->trial.v, rope->trial.nodes, side)[1];
            after[side] = end_row(rope->trial.a, rope->trial.nodes, side)[1];
        }
        masses[side] = (after[side] - before[side]) / size;
    }
}

/* forces and moments of the rope on both conveyances */
static void loads(const Simulator *rope, const State *state, const double *q, const double *R, double loads[12]) {
    const int nodes = rope->trial.nodes;
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *r = end_row(R, nodes, side);
        double *to = loads + 6 * side;
        end_moment(end_row(q, nodes, side) + SLOPE, r + SLOPE, swivel_moment(&rope->scene, state, side, r), to + 3);
        for (int k = 0; k < 3; k++) {
            to[k] = -r[k];
            to[3 + k] = -to[3 + k];
        }
    }
}

int rope_derivative(Simulator *rope, int input, double derivative[12]) {
    /* m, m/s, m/s^2, and the same in rad: small against what bends the rope, large against rounding */
    static const double sizes[3] = {1e-7, 1e-5, 1e-3};
    if (input < 0 || input >= 22) return say_no_such_input(rope->message);
    if (!rope->initialized) return say_no_state(rope->message);
    const int side = input / 11, place = input % 11;
    const int kind = place < 9 ? place / 3 : place - 9, dof = place < 9 ? place % 3 : ANGLE;
    State *state = rope->state;
    double d[3] = {0};
    d[kind] = sizes[kind] * (dof == ANGLE && side == LEFT ? -1 : 1);
    memset(derivative, 0, sizeof(double) * 12);
    if (dof == ANGLE && state->swivels[side].phase == SLIP) return 1; /* the friction does not know the yaw */
    if (state->fidelity == RIGID) { /* no side forces, no moments, and only heights have speeds */
        if (dof == ANGLE) return 1;
        const double none[3] = {0};
        double rest[2], moved[2];
        rigid_answer(rope, side, dof, none, rest);
        rigid_answer(rope, side, dof, d, moved);
        for (int end = LEFT; end <= RIGHT; end++) derivative[6 * end + 1] = -(moved[end] - rest[end]) / sizes[kind];
        return 1;
    }
    if (dof == ANGLE && kind == 1) /* a path takes its yaw acceleration from the rates */
        d[2] = d[1] / state->last_interval;
    double c[3], before[12];
    unperturbed_step(rope, c);
    loads(rope, state, state_arrays(state).q, rope->trial.v, before);
    perturbed_step(rope, side, dof, d, c);
    loads(rope, rope->spare, state_arrays(rope->spare).q, rope->trial.a, derivative);
    for (int k = 0; k < 12; k++) {
        derivative[k] = (derivative[k] - before[k]) / sizes[kind];
        if (!isfinite(derivative[k])) return say_no_finite_derivative(rope->message);
    }
    return 1;
}

static const LoopBottom *bottom_now(Simulator *rope) {
    if (!rope->bottom_known) {
        const Arrays m = state_arrays(rope->state);
        rope->bottom = shape_loop_bottom(m.nodes, m.q, m.s);
        rope->bottom_known = 1;
    }
    return &rope->bottom;
}

double rope_signal(Simulator *rope, int signal) {
    const int group = signal_group(signal);
    if (!rope->initialized || group < 0) return NAN;
    if (!(rope->known & 1u << group)) {
        const Arrays m = state_arrays(rope->state);
        if (group == ADDED_MASS_SIGNALS) {
            double masses[2];
            added_masses(rope, masses);
            rope->values[SIGNAL_LEFT_ADDED_MASS] = masses[LEFT];
            rope->values[SIGNAL_RIGHT_ADDED_MASS] = masses[RIGHT];
        } else if (group == CONTACT_SIGNALS) {
            const System s = system_of(rope, rope->state);
            double sums[CONTACT_BALANCE] = {0};
            if (rope->state->fidelity != RIGID) contact_balance(&s, m.q, m.v, sums);
            memcpy(rope->values + SIGNAL_CONTACT_LINING, sums + CONTACT_FORCES, sizeof(double) * (KINDS + 1));
        } else {
            if (group == STRESS_SIGNALS || group == ALONG_SIGNALS || group == STATION_SIGNALS) {
                const System s = system_of(rope, rope->state);
                chain_of(rope, rope->state)->strains(&s, m.q, rope->strains);
            }
            signals_of(group, &rope->scene, rope->state, &m, (const double (*)[STRAINS])rope->strains,
                       group == END_SIGNALS || group == ENERGY_SIGNALS || group == ERROR_SIGNALS ||
                               group == AUDIT_SIGNALS
                           ? NULL
                           : bottom_now(rope),
                       rope->values);
        }
        rope->known |= 1u << group;
    }
    return rope->values[signal];
}

void rope_signals(Simulator *rope, size_t number, const int *signals, double *values) {
    for (size_t k = 0; k < number; k++) values[k] = rope_signal(rope, signals[k]);
}
