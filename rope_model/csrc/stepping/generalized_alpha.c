/* Generalized-alpha method with variable steps for second-order systems with prescribed degrees of freedom.

       alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1),  gamma = 1/2 + alpha_f - alpha_m,
       beta = (1 + alpha_f - alpha_m)^2 / 4
       (1 - alpha_m) b_{n+1} + alpha_m b_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
       q_{n+1} = q_n + h v_n + h^2 ((1/2 - beta) b_n + beta b_{n+1})
       v_{n+1} = v_n + h ((1 - gamma) b_n + gamma b_{n+1})

   a is the acceleration, b the auxiliary one; equilibrium holds at t_{n+1} with a_{n+1}. b_n approximates the
   acceleration at t_n + (alpha_m - alpha_f) h. A change of the step moves that instant, and b must be moved with
   it (re-centring), or the method falls to first order:

       b_n <- b_n + (alpha_m - alpha_f) (h_new - h_old) (a_n - a_{n-1}) / h_old

   Sources: Chung and Hulbert, J. Appl. Mech. 60 (1993); Arnold and Brüls, Multibody Syst. Dyn. 18 (2007), for the
   form with auxiliary accelerations; Brüls and Arnold, J. Comput. Nonlinear Dyn. 3 (2008), for variable steps. */

#include "generalized_alpha.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "chain.h"
#include "ends.h"
#include "formulas.h"
#include "restrict.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"
#include "system.h"

/* Return the change of the accelerations over the trial; where wires rub, without that of unresolved stiff modes. */
static const double *resolved_change(Simulator *sim, const Chain *chain, const System *sys, double c_a,
                                     const double *before) {
    const NodalArrays *now = &sim->work.trial;
    const size_t size = (size_t)now->nodes * DOF;
    for (size_t i = 0; i < size; i++) sim->work.x[i] = now->a[i] - before[i];
    if (sys->wires == NULL) return sim->work.x;
    chain->resolve(sys, sim->work.chain, now, sim->work.x, sim->work.x);
    for (size_t i = 0; i < size; i++) sim->work.x[i] *= c_a;
    return sim->work.x;
}

/* True if the rate of the acceleration over the step `before` may predict a step h. */
static bool rate_known(double h, double before) {
    return 0 < h && h <= GENERALIZED_ALPHA_MAX_GROWTH * before;
}

double recentring(const Coefficients *method, double h, double before) {
    return rate_known(h, before) ? generalized_alpha_recentring_time(method, h, before) : 0;
}

static bool all_finite(const double *x, size_t count) {
    bool finite = true;
    for (size_t i = 0; i < count; i++) finite &= isfinite(x[i]);
    return finite;
}

/* Predict q, v and a at the end of a step h; the acceleration continues at its rate for the time `ahead`. */
static void predict(const NodalArrays *old, double h, double ahead, const PredictionWeights *weights,
                    double *RESTRICT q, double *RESTRICT v, double *RESTRICT a) {
    const NodalArrays nodal = *old;
    const PredictionWeights w = *weights;
    for (int i = 0; i < nodal.nodes * DOF; i++) {
        q[i] = nodal.q[i] + h * nodal.v[i] + w.q_a * nodal.a[i] + w.q_b * nodal.b[i] + w.q_rate * nodal.a_rate[i];
        v[i] = nodal.v[i] + w.v_a * nodal.a[i] + w.v_b * nodal.b[i] + w.v_rate * nodal.a_rate[i];
        a[i] = nodal.a[i] + ahead * nodal.a_rate[i];
    }
}

StepResult generalized_alpha_step(Simulator *sim, State *state, System *sys, double h) {
    const NodalArrays old = state_arrays(state);
    const NodalArrays *now = &sim->work.trial;
    const Coefficients method = {sim->scene.solver.rho_inf};
    const size_t size = (size_t)old.nodes * DOF;
    const double time_shift = recentring(&method, h, state->h);
    const double ahead = rate_known(h, state->h) && !state->rubs ? h : 0;
    const TangentCoefficients c = generalized_alpha_newton_coefficients(&method, h);
    const PredictionWeights prediction = generalized_alpha_prediction_weights(&method, h, time_shift, ahead);
    const AuxiliaryWeights auxiliary = generalized_alpha_auxiliary_weights(&method, time_shift);
    StepResult result = {.t = state->t + h, .h = h, .error = INFINITY};
    predict(&old, h, ahead, &prediction, now->q, now->v, now->a);
    rope_system_prescribed_motion(&sim->scene, state, result.t, 3, (double *[]){now->q, now->v, now->a});
    sys->time = result.t;
    memcpy(now->reaction, old.reaction, sizeof(double) * size);
    const Chain *chain = chain_of(sim, state);
    const Solver *solver = &sim->scene.solver;
    const double tolerance =
        newton_effective_tolerance(solver->newton_tolerance, solver->work_max, NEWTON_BOUNDED_STEP_ERROR);
    result.newton = chain->solve(sys, sim->work.chain, now, &c, tolerance, old.q, result.balance);
    if (result.newton.status == CONVERGED && !all_finite(now->reaction, size)) result.newton.status = NOT_FINITE;
    result.converged = result.newton.status == CONVERGED;
    if (!result.converged) return result;
    for (size_t i = 0; i < size; i++) {
        now->b[i] = auxiliary.a * old.a[i] + auxiliary.b * old.b[i] + auxiliary.a_rate * old.a_rate[i] +
                    auxiliary.a_end * now->a[i];
        now->a_rate[i] = (now->a[i] - old.a[i]) / h;
    }
    const double *change = resolved_change(sim, chain, sys, c.a, old.a);
    result.error = generalized_alpha_local_error(&method, h, chain_norm(sys, change, sys->shortest));
    for (int side = LEFT; side <= RIGHT; side++)
        result.strains[side] =
            generalized_alpha_local_error(&method, h, end_strain(&sim->scene, now->nodes, now->q, change, side));
    return result;
}

void generalized_alpha_restart(Simulator *sim, State *state, const System *sys) {
    const NodalArrays nodal = state_arrays(state);
    NodalArrays present = nodal;
    const size_t size = (size_t)nodal.nodes * DOF;
    const TangentCoefficients c = {.a = 1};
    double unused[ENERGIES];
    double *reaction = sim->work.trial.reaction;
    present.reaction = reaction;
    memset(nodal.a, 0, sizeof(double) * size);
    rope_system_prescribed_motion(&sim->scene, state, state->t, 3, (double *[]){nodal.q, nodal.v, nodal.a});
    for (int again = 0; again < 2; again++) { /* friction of the second pass uses the reactions of the first */
        memcpy(reaction, nodal.reaction, sizeof(double) * size);
        chain_of(sim, state)->newton_step(sys, sim->work.chain, &present, &c, again, sim->work.x, nodal.reaction);
        for (size_t i = 0; i < size; i++) nodal.a[i] += sim->work.x[i];
    }
    memcpy(reaction, nodal.reaction, sizeof(double) * size);
    chain_of(sim, state)->evaluate(sys, nodal.q, nodal.v, nodal.a, reaction, nodal.reaction, unused);
    memcpy(nodal.b, nodal.a, sizeof(double) * size);
    memset(nodal.a_rate, 0, sizeof(double) * size);
    state->h = 0;
}
