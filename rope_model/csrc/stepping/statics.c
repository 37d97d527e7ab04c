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
#include "diagnostics.h"
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
    return rope_system_norm(sys, R, 1. / sys->shortest);
}

RopeStatus find_equilibrium(Simulator *sim, State *state, double max_turn, char *message) {
    const NodalArrays nodal = state_arrays(state), *scratch = &sim->trial;
    const System sys = rope_system(sim, state);
    const Chain *chain = chain_of(sim, state);
    const size_t size = (size_t)nodal.nodes * DOF, bytes = sizeof(double) * size;
    double *trial = scratch->q, *zeros = scratch->v, *R = scratch->a, *now = scratch->b, *x = sim->x;
    double balance[ENERGIES], tau = 0.1, previous = 0, turned = 0, relaxed = 1, last = 0;
    const bool shortened = statics_lacks_symmetry(sys.P[P_QS], sys.P[P_QK]) > 0;
    const double largest = fmin(STATICS_MAX_MOVE, 0.5 * bodies_min_body_thickness(&sim->scene));
    int balanced = 0, k;
    sim->turned = false;
    const double rounding = 10 * DBL_EPSILON * sim->scene.rope.Qa * nodal.s[nodal.elements] / sys.shortest;
    memset(zeros, 0, bytes);
    memset(nodal.reaction, 0, bytes);
    NodalArrays rest = nodal;
    rest.v = rest.a = zeros;
    const double slope[3] = {nodal.q[SLOPE], nodal.q[SLOPE + 1], nodal.q[SLOPE + 2]};
    rope_system_prescribed_motion(&sim->scene, state, &sys, state->t, 1, &(double *){nodal.q});
    carry_director(state, slope, nodal.q + SLOPE);
    rope_system_refer(sim, state, nodal.q);
    for (k = 0; k < MAX_ITERATIONS && tau >= 1e-7; k++) {
        sim->corrections++;
        const int64_t solutions = sim->self_contact->solutions;
        const double c[3] = {1, 0, pow(tau, -2)};
        chain->newton_step(&sys, sim->work, &rest, c, 0, x, now);
        previous = imbalance(&sys, now);
        sim->solutions += sim->self_contact->solutions - solutions;
        if (sim->solutions > MAX_SOLUTIONS) return say_winds_about_itself(message, previous, MAX_SOLUTIONS);
        const double move = rope_system_norm(&sys, x, 1), norm = rope_system_norm(&sys, x, sys.shortest);
        if (!isfinite(move)) {
            tau *= 0.1;
            continue;
        }
        const double error = -work_along(&sys, now, x);
        /* The tangent lacks the part of the law without energy; relaxation makes up for it. */
        if (shortened && tau > STATICS_SETTLED && last > 0) relaxed = statics_relaxation(error / last, relaxed);
        const double step = fmin(relaxed, largest / fmax(move, 1e-300));
        last = step < relaxed ? 0 : error; /* how a step that is cut changes the error tells nothing of the tangent */
        for (size_t i = 0; i < size; i++) trial[i] = nodal.q[i] + step * x[i];
        chain->evaluate(&sys, trial, zeros, zeros, now, R, balance);
        const double force = imbalance(&sys, R);
        /* A step may raise the residual's norm, as stretch by moving sideways grows with the cube of the step, but not
           the energy.  Where the tangent is indefinite the correction climbs: a smaller tau adds inertia. */
        const bool climbs = error < 0 && previous > rounding;
        const double uphill = k < STATICS_PATIENCE ? 3 : 1;
        const bool ends_low = work_along(&sys, R, x) <= uphill * error || force <= previous + rounding;
        if (climbs || !isfinite(force) || !ends_low) {
            tau *= 0.3;
            last = 0;
            continue;
        }
        turned += rope_system_transport(sim, state, trial, zeros, zeros, zeros);
        sim->turned = fabs(turned) > max_turn;
        if (sim->turned) break;
        memcpy(nodal.q, trial, bytes);
        memcpy(nodal.reaction, R, bytes);
        balanced += force <= rounding;
        if (balanced > STATICS_BALANCED || (tau > 1e8 && norm < STATICS_REST_TOLERANCE * nodal.s[nodal.elements])) {
            state->offsets[RIGHT] += turned;
            return ROPE_DONE;
        }
        tau *= fmin(10, fmax(1.5, previous / fmax(force, 1e-300)));
        tau = fmin(tau, 1e12);
    }
    return say_no_equilibrium(message, k, previous);
}

RopeStatus hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q,
                         char *message) {
    message[0] = '\0';
    double length = s[nodes - 1];
    double across[3] = {right[0] - left[0], 0.0, right[2] - left[2]};
    double width = hypot(across[0], across[2]);
    if (width == 0) return say_ends_above_each_other(message, fabs(left[1] - right[1]));
    for (int axis = 0; axis < 3; axis++) across[axis] /= width;
    double middle = 0.5 * (length + left[1] - right[1]); /* arc length of the lowest point */
    /* length of the elements there */
    const int e = middle_before(nodes, s, 0, middle);
    const double cell =
        interpolate_midpoints(nodes, s, e, middle, s[e + 1] - s[e], e < nodes - 2 ? s[e + 2] - s[e + 1] : 0.0);
    InitialShape legs = initial_shape(length, middle, width, cell);
    if (minimum(legs.left_leg, legs.right_leg) <= legs.lean)
        return say_rope_too_short(message, length, width, fabs(left[1] - right[1]));
    for (int k = 0; k < nodes; k++) initial_shape_node_row(&legs, left, across, s[k], q + (ptrdiff_t)DOF * k);
    return ROPE_DONE;
}
