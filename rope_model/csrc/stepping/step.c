/* One step: rope_model.simulation.model and rope_model.numerics.generalized_alpha, which see. */

#include <math.h>
#include <string.h>

#include "simulator.h"

const double *end_row(const double *x, int nodes, int side) {
    return x + (side ? (size_t)(nodes - 1) * DOF : 0);
}

const Chain *chain_of(const Simulator *rope, const State *state) {
    return rope->chains + (state->fidelity == RIGID ? PLANAR : state->fidelity) - TORSIONAL;
}

System system_of(const Simulator *rope, State *state) {
    const Rope *data = &rope->scene.rope;
    const Arrays x = state_arrays(state);
    System s = {.elements = x.elements,
                .lengths = x.lengths,
                .frames = rope->frames,
                .around = rope->around->bodies > 0 ? rope->around : NULL,
                .own = rope->own->presses ? rope->own : NULL,
                .forces = rope->forces.number > 0 ? &rope->forces : NULL,
                .time = state->t,
                .wires = state->rubs ? rope->wires : NULL,
                .curved = is_curved(rope, state) ? rope->curved : NULL,
                .latest = rope->latest,
                .shortest = x.lengths[0]};
    element_parameters(data, rope->scene.layout.gravity, s.P);
    const AirLaw law = air_law(&rope->scene.shaft.air, data->diameter, rope->scene.layout.spacing);
    memcpy(s.air, &law, sizeof s.air);
    for (int k = 1; k < x.elements; k++) s.shortest = fmin(s.shortest, x.lengths[k]);
    for (int side = LEFT; side <= RIGHT; side++) {
        const Swivel *swivel = &rope->scene.swivels[side];
        const SwivelState *now = &state->swivels[side];
        s.free[side][SLOPE + 1] = 1;
        s.free[side][ANGLE] = now->phase == SLIP;
        s.inertia[side] = swivel->inertia;
        if (now->phase == SLIP && swivel->mode != FREE_MODE) {
            s.load[side] = -now->sign * swivel->seal_moment;
            s.friction_load[side] = -now->sign * friction_moment(swivel->mu_kinetic, swivel->mean_diameter, 0, 1);
        }
    }
    return s;
}

void refer(Simulator *rope, State *state, const double *q) {
    const System s = system_of(rope, state);
    chain_of(rope, state)->refer(&s, q);
    refer_curved(rope, state, q);
    refer_wires(rope, state, q);
}

double transport_angles(Simulator *rope, State *state, double *q, double *v, double *a, double *b) {
    const System s = system_of(rope, state);
    double (*gained)[3] = rope->strains, turn = 0;
    chain_of(rope, state)->transport(&s, q, v, a, gained);
    for (int k = 0; k < s.elements; k++) {
        const size_t at = (size_t)(k + 1) * DOF + ANGLE;
        turn += gained[k][0];
        q[at] += turn;
        v[at] += gained[k][1];
        a[at] += gained[k][2];
        b[at] += gained[k][2];
    }
    refer_curved(rope, state, q);
    refer_wires(rope, state, q);
    return turn;
}

void prescribed_motion(const Simulator *rope, const State *state, int side, double t, double rows[3][DOF]) {
    held_end(&state->paths[side], t, (side == LEFT ? -0.5 : 0.5) * rope->scene.layout.spacing, YAW_SENSE[side],
             state->offsets[side] + state->swivels[side].angle, rows);
}

void prescribe(const Simulator *rope, const State *state, const System *s, double t, int orders, double *const x[]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const size_t row = side ? (size_t)s->elements * DOF : 0;
        double rows[3][DOF];
        prescribed_motion(rope, state, side, t, rows);
        for (int k = 0; k < orders; k++)
            for (int dof = 0; dof < DOF; dof++)
                if (!s->free[side][dof]) x[k][row + (size_t)dof] = rows[k][dof];
    }
}

/* by how much the accelerations of the trial differ from those before it: Solution.resolve */
static const double *resolved_change(Simulator *rope, const Chain *chain, const System *s, double c_a,
                                     const double *before) {
    const Arrays *now = &rope->trial;
    const size_t size = (size_t)now->nodes * DOF;
    for (size_t i = 0; i < size; i++) rope->x[i] = now->a[i] - before[i];
    if (s->wires == NULL) return rope->x;
    chain->resolve(s, rope->work, now->q, now->v, now->a, rope->x, now->reaction, rope->x);
    for (size_t i = 0; i < size; i++) rope->x[i] *= c_a;
    return rope->x;
}

double largest_of(const System *s, const double *x, double slopes) {
    double largest = 0;
    for (int k = 0; k <= s->elements; k++, x += DOF) {
        const int *free = k == 0 ? s->free[LEFT] : k == s->elements ? s->free[RIGHT] : NULL;
        for (int dof = 0; dof < DOF; dof++) {
            if (free != NULL && !free[dof]) continue;
            if (!isfinite(x[dof])) return INFINITY;
            largest = fmax(largest, fabs(x[dof]) * (dof >= SLOPE && dof < ANGLE ? slopes : 1.));
        }
    }
    return largest;
}

/* whether the rate of change of the acceleration over a step of length before serves one of length h */
static int rate_known(double h, double before) {
    return 0 < h && h <= LARGEST_GROWTH * before;
}

/* by how much b is moved when a step h follows one of length before */
static double recentring(const Coefficients *method, double h, double before) {
    return rate_known(h, before) ? recentring_time(method, h, before) : 0;
}

static double apart(const Arrays *m) {
    return m->v[1] - end_row(m->v, m->nodes, RIGHT)[1];
}

Trial trial_step(Simulator *rope, State *state, double h) {
    const Arrays old = state_arrays(state), *now = &rope->trial;
    System s = system_of(rope, state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    const size_t size = (size_t)old.nodes * DOF;
    const double moved_by = recentring(&method, h, state->h);
    const double ahead = rate_known(h, state->h) && !state->rubs ? h : 0;
    double c[3], of[6], aux[4], sum = 0;
    Trial trial = {.t = state->t + h, .h = h, .error = INFINITY};
    prediction_weights(&method, h, moved_by, ahead, of);
    auxiliary_weights(&method, moved_by, aux);
    newton_coefficients(&method, h, c);
    for (size_t i = 0; i < size; i++) {
        now->q[i] = old.q[i] + h * old.v[i] + of[0] * old.a[i] + of[2] * old.b[i] + of[4] * old.a_rate[i];
        now->v[i] = old.v[i] + of[1] * old.a[i] + of[3] * old.b[i] + of[5] * old.a_rate[i];
        now->a[i] = old.a[i] + ahead * old.a_rate[i];
    }
    prescribe(rope, state, &s, trial.t, 3, (double *[]){now->q, now->v, now->a});
    s.time = trial.t;
    memcpy(now->reaction, old.reaction, sizeof(double) * size);
    const Chain *chain = chain_of(rope, state);
    trial.newton = chain->solve(&s, rope->work, now->q, now->v, now->a, now->reaction, c,
                                rope->scene.solver.newton_tolerance, trial.balance);
    for (size_t i = 0; i < size; i++) sum += fabs(now->reaction[i]);
    if (trial.newton.status == CONVERGED && !isfinite(sum)) trial.newton.status = NOT_FINITE;
    trial.reached = trial.newton.status == CONVERGED;
    trial.near = s.around != NULL && s.around->any;
    if (!trial.reached) return trial;
    for (size_t i = 0; i < size; i++) {
        now->b[i] = aux[0] * old.a[i] + aux[1] * old.b[i] + aux[2] * old.a_rate[i] + aux[3] * now->a[i];
        now->a_rate[i] = (now->a[i] - old.a[i]) / h;
    }
    const double *change = resolved_change(rope, chain, &s, c[2], old.a);
    trial.place = local_error(&method, h, largest_of(&s, change, s.shortest));
    double largest = 0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const size_t at = (side ? size - DOF : 0) + SLOPE + 1;
        largest = fmax(largest, fabs(local_error(&method, h, change[at])));
    }
    const StepLimits limits = step_limits(&rope->scene, &state->errors, bottom_of(rope, state, state->t), apart(&old),
                                          local_error(&method, 1, 1));
    trial.error = step_error(&limits, h, trial.place, largest);
    return trial;
}

void restart(Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    const System s = system_of(rope, state);
    const size_t size = (size_t)m.nodes * DOF;
    const double c[3] = {0, 0, 1};
    double unused[BALANCE], *known = rope->trial.reaction;
    memset(m.a, 0, sizeof(double) * size);
    prescribe(rope, state, &s, state->t, 3, (double *[]){m.q, m.v, m.a});
    for (int again = 0; again < 2; again++) { /* the second time with friction from the right reactions */
        memcpy(known, m.reaction, sizeof(double) * size);
        chain_of(rope, state)->newton_step(&s, rope->work, m.q, m.v, m.a, known, c, rope->x, m.reaction);
        for (size_t i = 0; i < size; i++) m.a[i] += rope->x[i];
    }
    memcpy(known, m.reaction, sizeof(double) * size);
    chain_of(rope, state)->evaluate(&s, m.q, m.v, m.a, known, m.reaction, unused);
    memcpy(m.b, m.a, sizeof(double) * size);
    memset(m.a_rate, 0, sizeof(double) * size);
    state->h = 0;
    set_powers(rope, state);
    audit_restart(rope, state, &s);
}

double bottom_of(const Simulator *rope, const State *state, double t) {
    const double left = path_height(&state->paths[LEFT], t), right = path_height(&state->paths[RIGHT], t);
    return 0.5 * (rope->scene.rope.length + left - right);
}

/* what flows in and out at this instant */
void set_powers(const Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    state->power_ends = state->power_swivel = 0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *R = end_row(m.reaction, m.nodes, side), *v = end_row(m.v, m.nodes, side);
        const double moment = swivel_moment(&rope->scene, state, side, R);
        double spin = v[ANGLE];
        for (int k = 0; k < 3; k++) state->power_ends += R[k] * v[k];
        if (state->swivels[side].phase == SLIP) {
            double relative[2];
            swivel_relative(state, side, state->t, 0, spin, relative);
            state->power_swivel -= moment * relative[1];
            spin -= relative[1];
        }
        state->power_ends += moment * spin;
    }
}

/* from the sums over the elements; the inertia of the swivels counts as kinetic energy of the rope */
static void set_energies(EnergyBalance *energy_balance, const double balance[BALANCE], const System *s, const double *q,
                         const double *v) {
    double sums[BALANCE], contact[CONTACT_BALANCE];
    memcpy(sums, balance, sizeof sums);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double rate = end_row(v, s->elements + 1, side)[ANGLE];
        sums[KINETIC] += 0.5 * s->inertia[side] * rate * rate;
    }
    contact_balance(s, q, v, contact);
    *energy_balance = with_energies(energy_balance, sums, contact[CONTACT_ENERGY]);
}

double update_energies(Simulator *rope, State *state) {
    const Arrays m = state_arrays(state);
    const System s = system_of(rope, state);
    const double before = energy_total(&state->energy_balance);
    double balance[BALANCE];
    chain_of(rope, state)->evaluate(&s, m.q, m.v, m.a, m.reaction, rope->x, balance);
    set_energies(&state->energy_balance, balance, &s, m.q, m.v);
    return energy_total(&state->energy_balance) - before;
}

void commit(Simulator *rope, State *state, const Trial *trial) {
    const Arrays m = state_arrays(state), *now = &rope->trial;
    System s = system_of(rope, state);
    const size_t size = (size_t)m.nodes * DOF;
    const double h = trial->t - state->t, before[2] = {state->power_ends, state->power_swivel};
    const double forces[2] = {m.reaction[1], end_row(m.reaction, m.nodes, RIGHT)[1]};
    const Coefficients method = {rope->scene.solver.rho_inf};
    const double moved_by = recentring(&method, trial->h, state->h);
    EnergyBalance *energy = &state->energy_balance;
    const double bottom = bottom_of(rope, state, state->t), speed = apart(&m);
    double losses[2], contact[CONTACT_BALANCE], air[AIR_BALANCE], paces[2], force = 0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const size_t at = (side ? size - DOF : 0) + SLOPE + 1;
        paces[side] = (now->v[at] - m.v[at]) / h;
    }
    /* what the material takes up follows from the strains' differences over the step: the rates at its ends carry the
       integrator's own oscillation, whose square does not average out.  The middle and the mean rate lie in q and v */
    for (size_t i = 0; i < size; i++) {
        const double q = m.q[i];
        m.q[i] = 0.5 * (q + now->q[i]);
        m.v[i] = (now->q[i] - q) / h;
    }
    s.time = state->t + 0.5 * h;
    chain_of(rope, state)->losses(&s, m.q, m.v, losses);
    contact_balance(&s, m.q, m.v, contact);
    state->contact = add_contact(&rope->scene, &state->contact, h, contact + CONTACT_FORCES, longest_near(&s));
    chain_of(rope, state)->air(&s, m.q, m.v, air);
    const double slid = slip_wires(rope, state, now->q);
    state->offsets[RIGHT] += transport_angles(rope, state, now->q, now->v, now->a, now->b);
    memcpy(m.q, now->q, FIELDS * sizeof(double) * size);
    state->t = s.time = trial->t, state->h = trial->h;
    for (int side = LEFT; side <= RIGHT; side++)
        for (int k = 0; k < 3; k++) force = fmax(force, fabs(end_row(m.reaction, m.nodes, side)[k]));
    state->errors = add_errors(&rope->scene, &state->errors, bottom, speed, h, local_error(&method, 1, 1), paces,
                               trial->place, force);
    set_powers(rope, state);
    if (!trial->near) s.around = NULL;
    set_energies(energy, trial->balance, &s, m.q, m.v);
    const double taken[] = {losses[0], losses[1], contact[CONTACT_DISSIPATED], contact[CONTACT_MOVED]};
    const double now_powers[] = {state->power_ends, state->power_swivel};
    *energy = account_of_step(energy, h, before, now_powers, taken, slid, air[0]);
    audit_step(rope, state, &s, h, moved_by, forces);
}

/* simulation.stepping.events.locate */
double locate(double (*f)(void *, double), void *with, double low, double high, double f_low, double f_high,
              double width) {
    Bracket at = {low, high, f_low, f_high, 0, 0};
    while (at.high - at.low > width) {
        const double x = trial_place(&at, width);
        if (!(at.low < x && x < at.high)) break;
        at = narrowed(&at, x, f(with, x));
    }
    return at.high;
}
