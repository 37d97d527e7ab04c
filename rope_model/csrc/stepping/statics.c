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

/* A search for an equilibrium. */
typedef struct {
    Simulator *sim;
    State *state;
    const Chain *chain;
    System sys;
    NodalArrays rest;    /* arrays of the state, with zeros for v and a */
    double *R;           /* residual before a correction */
    double rounding;     /* unbalanced force that rounding leaves, N */
    double largest_move; /* by a correction, m or rad */
    bool symmetric;     /* false if the tangent lacks a part of the law without energy, for which relaxation makes up */
    double tau;         /* pseudo-time step, s */
    double relaxed;     /* part of the latest correction that was taken */
    double whole_error; /* error before that correction, if it was taken whole; else 0 */
    double turned;      /* change of theta at the right end so far, rad */
    int balanced;       /* corrections that left forces balanced to rounding */
} Search;

static Search begin_search(Simulator *sim, State *state) {
    const NodalArrays nodal = state_arrays(state);
    const double length = nodal.s[nodal.elements];
    Search search = {.sim = sim,
                     .state = state,
                     .chain = chain_of(sim, state),
                     .sys = rope_system(sim, state),
                     .rest = nodal,
                     .R = sim->work.trial.b,
                     .largest_move = fmin(STATICS_MAX_MOVE, 0.5 * bodies_min_body_thickness(&sim->scene)),
                     .tau = STATICS_FIRST_TIME,
                     .relaxed = 1};
    search.rest.v = sim->work.trial.v;
    search.rest.a = sim->work.trial.v;
    memset(sim->work.trial.v, 0, sizeof(double) * DOF * (size_t)nodal.nodes);
    search.rounding = STATICS_ROUNDED * DBL_EPSILON * sim->scene.rope.Qa * length / search.sys.shortest;
    search.symmetric = statics_lacks_symmetry(search.sys.P[P_QS], search.sys.P[P_QK]) == 0;
    sim->search.turned = false;
    return search;
}

/* Solve for a correction x, with the residual before it. */
static Correction solve_correction(Search *search, double *x) {
    Simulator *sim = search->sim;
    const TangentCoefficients c = {.q = 1, .a = pow(search->tau, -2)};
    const int64_t solutions = sim->self_contact->solutions;
    search->chain->newton_step(&search->sys, sim->work.chain, &search->rest, &c, false, x, search->R);
    sim->search.corrections++;
    sim->search.solutions += sim->self_contact->solutions - solutions;
    return (Correction){.force = imbalance(&search->sys, search->R), .error = -work_along(&search->sys, search->R, x)};
}

/* Return the part of a correction to try; `move` is its largest displacement. */
static double part_to_try(Search *search, double error, double move) {
    if (!search->symmetric && search->tau > STATICS_SETTLED && search->whole_error > 0)
        search->relaxed = statics_relaxation(error / search->whole_error, search->relaxed);
    const double part = fmin(search->relaxed, search->largest_move / fmax(move, ELEMENTARY_SMALLEST_DIVISOR));
    /* How a step that is cut changes the error tells nothing of the tangent. */
    search->whole_error = part < search->relaxed ? 0 : error;
    return part;
}

/* Move by a part of x to the trial, and write what forces are unbalanced there into the correction. */
static void try_part(const Search *search, double part, const double *x, Correction *correction) {
    const NodalArrays *trial = &search->sim->work.trial;
    const double *zeros = search->rest.v;
    const size_t size = (size_t)search->rest.nodes * DOF;
    double unused[ENERGIES];
    for (size_t i = 0; i < size; i++) trial->q[i] = search->rest.q[i] + part * x[i];
    search->chain->evaluate(&search->sys, trial->q, zeros, zeros, search->R, trial->a, unused);
    correction->force_left = imbalance(&search->sys, trial->a);
    correction->work_left = work_along(&search->sys, trial->a, x);
}

/* Make the trial the state, unless that turns the right end by more than max_turn. */
static bool take_trial(Search *search, double max_turn) {
    Simulator *sim = search->sim;
    double *zeros = search->rest.v;
    const size_t bytes = sizeof(double) * DOF * (size_t)search->rest.nodes;
    search->turned += rope_system_transport(sim, search->state, sim->work.trial.q, zeros, zeros, zeros);
    sim->search.turned = fabs(search->turned) > max_turn;
    if (sim->search.turned) return false;
    memcpy(search->rest.q, sim->work.trial.q, bytes);
    memcpy(search->rest.reaction, sim->work.trial.a, bytes);
    return true;
}

/* True if the correction that was taken, of this norm, ends the search. */
static bool is_found(const Search *search, double norm) {
    const double length = search->rest.s[search->rest.elements];
    return search->balanced > STATICS_BALANCED ||
           (search->tau > STATICS_NEWTON_TIME && norm < STATICS_REST_TOLERANCE * length);
}

RopeStatus find_equilibrium(Simulator *sim, State *state, double max_turn, char *message) {
    hold(sim, state);
    Search search = begin_search(sim, state);
    Correction correction = {0};
    double *x = sim->work.x;
    int k;
    for (k = 0; k < STATICS_MAX_CORRECTIONS && search.tau >= STATICS_SHORTEST_TIME; k++) {
        correction = solve_correction(&search, x);
        if (sim->search.solutions > STATICS_MAX_CONTACT_SOLUTIONS)
            return say_winds_about_itself(message, correction.force, STATICS_MAX_CONTACT_SOLUTIONS);
        const double move = chain_norm(&search.sys, x, 1);
        const double norm = chain_norm(&search.sys, x, search.sys.shortest);
        if (!isfinite(move)) {
            search.tau *= STATICS_SHRINK_OF_INFINITE;
            continue;
        }
        try_part(&search, part_to_try(&search, correction.error, move), x, &correction);
        if (!accepts(&correction, search.rounding, k < STATICS_PATIENCE ? STATICS_MAX_GAIN : 1)) {
            search.tau *= STATICS_SHRINK;
            search.whole_error = 0;
            continue;
        }
        if (!take_trial(&search, max_turn)) break;
        search.balanced += correction.force_left <= search.rounding;
        if (is_found(&search, norm)) {
            state->offsets[RIGHT] += search.turned;
            return ROPE_DONE;
        }
        search.tau = longer_time(search.tau, &correction);
    }
    return say_no_equilibrium(message, k, correction.force);
}
