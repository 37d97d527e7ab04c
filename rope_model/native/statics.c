/* Equilibrium by pseudo-transient continuation: rope_model.simulation.statics, which see. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "simulator.h"
#include "text.h"

enum { MAX_ITERATIONS = 2000 };
#define TOLERANCE 1e-11

static int is_free(const System *s, size_t i) {
    const size_t node = i / DOF;
    return (node != 0 && node != (size_t)s->elements) || s->free[node != 0][i % DOF];
}

/* residual, and potential energy (J) of rope and dead loads; v and a of the state are zero; turned: what theta has
   gained at the right end */
static double at_rest(const Chain *chain, const System *s, const double *q, const double *rest, const double *known,
                      double turned, double *R) {
    double balance[BALANCE], stored;
    int side;
    chain->evaluate(s, q, rest, rest, known, R, balance);
    stored = balance[AXIAL] + balance[COUPLING] + balance[TORSION] + balance[BENDING] + balance[GRAVITY];
    for (side = 0; side < 2; ++side) stored -= s->load[side] * end_row(q, s->elements + 1, side)[ANGLE];
    return stored + s->load[RIGHT] * turned;
}

/* largest unbalanced force (N); infinite when one is not a number */
static double imbalance(const System *s, const double *R) {
    const size_t size = (size_t)(s->elements + 1) * DOF;
    double largest = 0;
    size_t i;
    for (i = 0; i < size; ++i) {
        const size_t dof = i % DOF;
        if (!is_free(s, i)) continue;
        if (!isfinite(R[i])) return INFINITY;
        largest = fmax(largest, fabs(R[i]) * (dof >= SLOPE && dof < ANGLE ? 1. / s->shortest : 1.));
    }
    return largest;
}

int find_equilibrium(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state), *scratch = &rope->trial;
    const System s = system_of(rope, state);
    const Chain *chain = chain_of_state(state);
    const size_t size = (size_t)m.nodes * DOF, bytes = sizeof(double) * size;
    double *trial = scratch->q, *rest = scratch->v, *R = scratch->a, *x = rope->x, *unused = scratch->b;
    double energy, tau = 0.1, previous, turned;
    const double largest_move = 0.3;
    int k, side, dof;
    size_t i;
    memset(rest, 0, bytes);
    for (side = 0; side < 2; ++side) {
        double rows[3][DOF];
        double *q = m.q + (side ? size - DOF : 0);
        prescribed_motion(rope, state, side, state->t, rows);
        for (dof = 0; dof < DOF; ++dof)
            if (!s.free[side][dof]) q[dof] = rows[0][dof];
    }
    memset(R, 0, bytes);
    turned = 0;
    refer(rope, state, m.q);
    energy = at_rest(chain, &s, m.q, rest, R, turned, m.reaction);
    previous = imbalance(&s, m.reaction);
    for (k = 1; k <= MAX_ITERATIONS; ++k) {
        const double c[3] = {1, 0, pow(tau, -2)};
        double place = 0, turn = 0, norm = 0, step, force, trial_energy, more;
        int finite = 1;
        chain->newton_step(&s, rope->work, m.q, rest, rest, m.reaction, c, x, unused);
        for (i = 0; i < size; ++i) {
            finite = finite && isfinite(x[i]);
            dof = (int)(i % DOF);
            if (dof < SLOPE)
                place = fmax(place, fabs(x[i]));
            else
                turn = fmax(turn, fabs(x[i]));
            norm = fmax(norm, fabs(x[i]) * (dof >= SLOPE && dof < ANGLE ? s.shortest : 1.));
        }
        if (!finite) {
            tau *= 0.1;
            if (tau < 1e-7) break;
            continue;
        }
        step = fmin(1, largest_move / fmax(fmax(place, turn), 1e-300));
        for (i = 0; i < size; ++i) trial[i] = m.q[i] + step * x[i];
        more = transport_angles(rope, state, trial, rest, rest, rest);
        trial_energy = at_rest(chain, &s, trial, rest, m.reaction, turned + more, R);
        force = imbalance(&s, R);
        /* on its way down the rope may well pass larger forces; what it may not do is to gain energy with them */
        if (!isfinite(force) || !(trial_energy < energy + 1e-12 * fabs(energy) || force <= previous + 1e-6)) {
            refer(rope, state, m.q);
            tau *= 0.3;
            if (tau < 1e-7) break;
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
    snprintf(message, MESSAGE,
             "no equilibrium within %d iterations: %s N are left unbalanced; the rope may have none in this "
             "configuration (too much twist), the elements may be too long for EI, or a unit may be wrong",
             MAX_ITERATIONS, ROUNDED(previous, 3));
    return 0;
}
