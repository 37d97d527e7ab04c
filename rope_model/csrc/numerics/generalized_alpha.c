/* Generalized-alpha method.  C version of rope_model/numerics/generalized_alpha.py, which explains the method. */

#include "simulator.h"

/* Return the change of the accelerations over the trial, as Solution.resolve of Python does. */
static const double *resolved_change(Simulator *rope, const Chain *chain, const System *s, double c_a,
                                     const double *before) {
    const NodalArrays *now = &rope->trial;
    const size_t size = (size_t)now->nodes * DOF;
    for (size_t i = 0; i < size; i++) rope->x[i] = now->a[i] - before[i];
    if (s->wires == NULL) return rope->x;
    chain->resolve(s, rope->work, now->q, now->v, now->a, rope->x, now->reaction, rope->x);
    for (size_t i = 0; i < size; i++) rope->x[i] *= c_a;
    return rope->x;
}

/* True if the rate of the acceleration over the step `before` may predict a step h. */
static int rate_known(double h, double before) {
    return 0 < h && h <= MAX_GROWTH * before;
}

double recentring(const Coefficients *method, double h, double before) {
    return rate_known(h, before) ? recentring_time(method, h, before) : 0;
}

static void predict(const NodalArrays *old, double h, double ahead, const double w[6], double *RESTRICT q,
                    double *RESTRICT v, double *RESTRICT a) {
    const NodalArrays m = *old;
    for (int i = 0; i < m.nodes * DOF; i++) {
        q[i] = m.q[i] + h * m.v[i] + w[0] * m.a[i] + w[2] * m.b[i] + w[4] * m.a_rate[i];
        v[i] = m.v[i] + w[1] * m.a[i] + w[3] * m.b[i] + w[5] * m.a_rate[i];
        a[i] = m.a[i] + ahead * m.a_rate[i];
    }
}

StepResult generalized_alpha_step(Simulator *rope, State *state, System *s, double h) {
    const NodalArrays old = state_arrays(state), *now = &rope->trial;
    const Coefficients method = {rope->scene.solver.rho_inf};
    const size_t size = (size_t)old.nodes * DOF;
    const double time_shift = recentring(&method, h, state->h);
    const double ahead = rate_known(h, state->h) && !state->rubs ? h : 0;
    double c[3], w[6], aux[4];
    int finite = 1;
    StepResult result = {.t = state->t + h, .h = h, .error = INFINITY};
    prediction_weights(&method, h, time_shift, ahead, w);
    auxiliary_weights(&method, time_shift, aux);
    newton_coefficients(&method, h, c);
    predict(&old, h, ahead, w, now->q, now->v, now->a);
    rope_system_prescribed_motion(rope, state, s, result.t, 3, (double *[]){now->q, now->v, now->a});
    s->time = result.t;
    memcpy(now->reaction, old.reaction, sizeof(double) * size);
    const Chain *chain = chain_of(rope, state);
    const Solver *solver = &rope->scene.solver;
    result.newton = chain->solve(s, rope->work, now->q, now->v, now->a, now->reaction, c,
                                 effective_tolerance(solver->newton_tolerance, solver->work_max, BOUNDED_STEP_ERROR),
                                 old.q, result.balance);
    for (size_t i = 0; i < size; i++) finite &= isfinite(now->reaction[i]) != 0;
    if (result.newton.status == CONVERGED && !finite) result.newton.status = NOT_FINITE;
    result.converged = result.newton.status == CONVERGED;
    if (!result.converged) return result;
    for (size_t i = 0; i < size; i++) {
        now->b[i] = aux[0] * old.a[i] + aux[1] * old.b[i] + aux[2] * old.a_rate[i] + aux[3] * now->a[i];
        now->a_rate[i] = (now->a[i] - old.a[i]) / h;
    }
    const double *change = resolved_change(rope, chain, s, c[2], old.a);
    result.error = local_error(&method, h, rope_system_norm(s, change, s->shortest));
    for (int side = LEFT; side <= RIGHT; side++)
        result.strains[side] = local_error(&method, h, change[(side ? size - DOF : 0) + SLOPE + 1]);
    return result;
}

void generalized_alpha_restart(Simulator *rope, State *state, const System *s) {
    const NodalArrays m = state_arrays(state);
    const size_t size = (size_t)m.nodes * DOF;
    const double c[3] = {0, 0, 1};
    double unused[BALANCE], *known = rope->trial.reaction;
    memset(m.a, 0, sizeof(double) * size);
    rope_system_prescribed_motion(rope, state, s, state->t, 3, (double *[]){m.q, m.v, m.a});
    for (int again = 0; again < 2; again++) { /* friction of the second pass uses the reactions of the first */
        memcpy(known, m.reaction, sizeof(double) * size);
        chain_of(rope, state)->newton_step(s, rope->work, m.q, m.v, m.a, known, c, again, rope->x, m.reaction);
        for (size_t i = 0; i < size; i++) m.a[i] += rope->x[i];
    }
    memcpy(known, m.reaction, sizeof(double) * size);
    chain_of(rope, state)->evaluate(s, m.q, m.v, m.a, known, m.reaction, unused);
    memcpy(m.b, m.a, sizeof(double) * size);
    memset(m.a_rate, 0, sizeof(double) * size);
    state->h = 0;
}
