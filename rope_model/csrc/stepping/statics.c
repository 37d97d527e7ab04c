/* Static equilibrium by pseudo-transient continuation.

   Each correction solves (K + M / tau^2) x = -R, an implicit Euler step of an inertia that the iteration is free
   to choose; tau grows as the residual falls, and the method ends as Newton's. Without a residual that falls, tau
   shrinks and the iteration creeps like a real rope: it does not depend on a good first guess. Each shape on the
   way is the reference of the frame for the next, so that no tangent is far from it.

   The tangent is symmetric and leaves out the part of Qk, which has no energy. Near the end of the search this
   multiplies the error by i r, a rotation by 90 degrees, where r may exceed 1; corrections shortened by 1 / (1 +
   r^2) reduce it fastest.

   If a motion costs no energy, such as the rotation of a buckled rod's helix about its axis, corrections along it
   never become small. The search ends when forces have been balanced to rounding often enough for other
   corrections to vanish.

   Source: Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998), switched evolution relaxation. */

#include "statics.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "chain.h"
#include "curvature.h"
#include "formulas.h"
#include "messages.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "simulator.h"
#include "state_structures.h"
#include "system.h"

/* MAX_SOLUTIONS: of all equilibria of a start, some seconds.  A rope that goes on winding about itself takes ever more,
   as each correction has more contacts to solve for: 900 m with strong coupling had 50,000 in 3000 corrections, and as
   large an imbalance as before. */
enum { MAX_ITERATIONS = 10000, MAX_SOLUTIONS = 20000 };

/* Return the work of the residual R along x, which is zero where the rope is held. */
static double work_along(const System *sys, const double *R, const double *x) {
    double work = 0;
    for (size_t i = 0; i < (size_t)(sys->elements + 1) * DOF; i++) work += R[i] * x[i];
    return work;
}

/* Return the largest unbalanced force, N. */
static double imbalance(const System *sys, const double *R) {
    return chain_norm(sys, R, 1. / sys->shortest);
}

/* A correction x: what forces were unbalanced before it, and are after it. */
typedef struct {
    double error;     /* square of the error before it, -R . x, N m */
    double force;     /* largest unbalanced force before it, N */
    double work_left; /* R . x after it, N m */
    double force_left;
} Correction;

/* True if a correction is taken.  It may raise the residual's norm, as stretch by moving sideways grows with the cube
   of the step, but not the energy.  Where the tangent is indefinite the correction climbs: a smaller tau adds inertia.
 */
static bool accepts(const Correction *correction, double rounding, double max_gain) {
    const bool climbs = correction->error < 0 && correction->force > rounding;
    const bool ends_low =
        correction->work_left <= max_gain * correction->error || correction->force_left <= correction->force + rounding;
    return !climbs && isfinite(correction->force_left) && ends_low;
}

/* Return tau after a correction that was taken. */
static double longer_time(double tau, const Correction *correction) {
    const double fall = correction->force / fmax(correction->force_left, ELEMENTARY_SMALLEST_DIVISOR);
    return fmin(tau * fmin(STATICS_LARGEST_GROWTH, fmax(STATICS_LEAST_GROWTH, fall)), STATICS_LONGEST_TIME);
}

/* Put the ends in their places, clear the reactions, and refer the frames to the shape. */
static void hold(Simulator *sim, State *state) {
    const NodalArrays nodal = state_arrays(state);
    const double slope[3] = {nodal.q[SLOPE], nodal.q[SLOPE + 1], nodal.q[SLOPE + 2]};
    memset(nodal.reaction, 0, sizeof(double) * DOF * (size_t)nodal.nodes);
    rope_system_prescribed_motion(&sim->scene, state, state->t, 1, &(double *){nodal.q});
    carry_director(state, slope, nodal.q + SLOPE);
    rope_system_refer(sim, state, nodal.q);
}

RopeStatus find_equilibrium(Simulator *sim, State *state, double max_turn, char *message) {
    const NodalArrays nodal = state_arrays(state);
    hold(sim, state);
    const System sys = rope_system(sim, state);
    const Chain *chain = chain_of(sim, state);
    const size_t size = (size_t)nodal.nodes * DOF;
    const size_t bytes = sizeof(double) * size;
    double *trial = sim->work.trial.q;
    double *zeros = sim->work.trial.v;
    double *R = sim->work.trial.a;
    double *now = sim->work.trial.b;
    double *x = sim->work.x;
    double balance[ENERGIES];
    const bool shortened = statics_lacks_symmetry(sys.P[P_QS], sys.P[P_QK]) > 0;
    const double largest = fmin(STATICS_MAX_MOVE, 0.5 * bodies_min_body_thickness(&sim->scene));
    const double length = nodal.s[nodal.elements];
    const double rounding = STATICS_ROUNDED * DBL_EPSILON * sim->scene.rope.Qa * length / sys.shortest;
    Correction correction = {0};
    double tau = STATICS_FIRST_TIME;
    double turned = 0;
    double relaxed = 1; /* part of a correction that is taken */
    double last = 0;    /* error before the latest correction, if it was taken whole */
    int balanced = 0;
    int k;
    sim->search.turned = false;
    memset(zeros, 0, bytes);
    NodalArrays rest = nodal;
    rest.v = zeros;
    rest.a = zeros;
    for (k = 0; k < MAX_ITERATIONS && tau >= STATICS_SHORTEST_TIME; k++) {
        sim->search.corrections++;
        const int64_t solutions = sim->self_contact->solutions;
        const TangentCoefficients c = {.q = 1, .a = pow(tau, -2)};
        chain->newton_step(&sys, sim->work.chain, &rest, &c, false, x, now);
        correction.force = imbalance(&sys, now);
        sim->search.solutions += sim->self_contact->solutions - solutions;
        if (sim->search.solutions > MAX_SOLUTIONS)
            return say_winds_about_itself(message, correction.force, MAX_SOLUTIONS);
        const double move = chain_norm(&sys, x, 1);
        const double norm = chain_norm(&sys, x, sys.shortest);
        if (!isfinite(move)) {
            tau *= STATICS_SHRINK_OF_INFINITE;
            continue;
        }
        correction.error = -work_along(&sys, now, x);
        /* The tangent lacks the part of the law without energy; relaxation makes up for it. */
        if (shortened && tau > STATICS_SETTLED && last > 0)
            relaxed = statics_relaxation(correction.error / last, relaxed);
        const double step = fmin(relaxed, largest / fmax(move, ELEMENTARY_SMALLEST_DIVISOR));
        /* How a step that is cut changes the error tells nothing of the tangent. */
        last = step < relaxed ? 0 : correction.error;
        for (size_t i = 0; i < size; i++) trial[i] = nodal.q[i] + step * x[i];
        chain->evaluate(&sys, trial, zeros, zeros, now, R, balance);
        correction.force_left = imbalance(&sys, R);
        correction.work_left = work_along(&sys, R, x);
        if (!accepts(&correction, rounding, k < STATICS_PATIENCE ? STATICS_MAX_GAIN : 1)) {
            tau *= STATICS_SHRINK;
            last = 0;
            continue;
        }
        turned += rope_system_transport(sim, state, trial, zeros, zeros, zeros);
        sim->search.turned = fabs(turned) > max_turn;
        if (sim->search.turned) break;
        memcpy(nodal.q, trial, bytes);
        memcpy(nodal.reaction, R, bytes);
        balanced += correction.force_left <= rounding;
        if (balanced > STATICS_BALANCED || (tau > STATICS_NEWTON_TIME && norm < STATICS_REST_TOLERANCE * length)) {
            state->offsets[RIGHT] += turned;
            return ROPE_DONE;
        }
        tau = longer_time(tau, &correction);
    }
    return say_no_equilibrium(message, k, correction.force);
}
