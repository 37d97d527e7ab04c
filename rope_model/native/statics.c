/* Equilibrium by pseudo-transient continuation: rope_model.simulation.statics, which see. */

#include <math.h>
#include <string.h>

#include "simulator.h"
#include "messages.h"

enum { MAX_ITERATIONS = 2000 };
#define TOLERANCE 1e-11
/* m, or rad */
#define LARGEST_MOVE 0.3

/* residual, and potential energy (J) of rope and dead loads; v and a of the state are zero; turned: what theta has
   gained at the right end */
static double at_rest(const Chain *chain, const System *s, const double *q, const double *rest, const double *known,
                      double turned, double *R) {
    double balance[BALANCE];
    chain->evaluate(s, q, rest, rest, known, R, balance);
    double stored = balance[AXIAL] + balance[COUPLING] + balance[TORSION] + balance[BENDING] + balance[GRAVITY];
    for (int side = LEFT; side <= RIGHT; side++) stored -= s->load[side] * end_row(q, s->elements + 1, side)[ANGLE];
    return stored + s->load[RIGHT] * turned;
}

/* largest unbalanced force (N); infinite when one is not a number */
static double imbalance(const System *s, const double *R) {
    double largest = 0;
    for (int node = 0; node <= s->elements; node++, R += DOF)
        for (int dof = 0; dof < DOF; dof++) {
            if ((node == 0 || node == s->elements) && !s->free[node != 0][dof]) continue;
            if (!isfinite(R[dof])) return INFINITY;
            largest = fmax(largest, fabs(R[dof]) * (dof >= SLOPE && dof < ANGLE ? 1. / s->shortest : 1.));
        }
    return largest;
}

/* of a correction: the largest displacement or turn, and the norm; 0 when a number is not finite */
static int measure(const System *s, const double *x, double *move, double *norm) {
    *move = *norm = 0;
    for (size_t i = 0; i < (size_t)(s->elements + 1) * DOF; i++) {
        if (!isfinite(x[i])) return 0;
        *move = fmax(*move, fabs(x[i]));
        *norm = fmax(*norm, fabs(x[i]) * (i % DOF >= SLOPE && i % DOF < ANGLE ? s->shortest : 1.));
    }
    return 1;
}

int find_equilibrium(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state), *scratch = &rope->trial;
    const System s = system_of(rope, state);
    const Chain *chain = chain_of_state(state);
    const size_t size = (size_t)m.nodes * DOF, bytes = sizeof(double) * size;
    double *trial = scratch->q, *rest = scratch->v, *R = scratch->a, *x = rope->x, *unused = scratch->b;
    memset(rest, 0, bytes);
    memset(R, 0, bytes);
    prescribe(rope, state, &s, state->t, 1, &(double *){m.q});
    refer(rope, state, m.q);
    double energy = at_rest(chain, &s, m.q, rest, R, 0, m.reaction), turned = 0;
    double previous = imbalance(&s, m.reaction), tau = 0.1;
    for (int k = 1; k <= MAX_ITERATIONS && tau >= 1e-7; k++) {
        const double c[3] = {1, 0, pow(tau, -2)};
        double move, norm;
        chain->newton_step(&s, rope->work, m.q, rest, rest, m.reaction, c, x, unused);
        if (!measure(&s, x, &move, &norm)) {
            tau *= 0.1;
            continue;
        }
        const double step = fmin(1, LARGEST_MOVE / fmax(move, 1e-300));
        for (size_t i = 0; i < size; i++) trial[i] = m.q[i] + step * x[i];
        const double more = transport_angles(rope, state, trial, rest, rest, rest);
        const double trial_energy = at_rest(chain, &s, trial, rest, m.reaction, turned + more, R);
        const double force = imbalance(&s, R);
        /* on its way down the rope may well pass larger forces; what it may not do is to gain energy with them */
        if (!isfinite(force) || !(trial_energy < energy + 1e-12 * fabs(energy) || force <= previous + 1e-6)) {
            refer(rope, state, m.q);
            tau *= 0.3;
            continue;
        }
        memcpy(m.q, trial, bytes);
        memcpy(m.reaction, R, bytes);
        energy = trial_energy;
        turned += more;
        if (tau > 1e8 && step == 1 && norm < TOLERANCE * m.s[m.elements]) {
            state->offsets[RIGHT] += turned;
            return 1;
        }
        tau *= fmin(10, fmax(1.5, previous / fmax(force, 1e-300)));
        tau = fmin(tau, 1e12);
        previous = force;
    }
    return say_no_equilibrium(message, MAX_ITERATIONS, previous);
}
