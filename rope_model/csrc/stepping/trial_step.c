/* Trial steps, and the books of a step that is accepted: energies, losses, powers of the ends, momentum audit, errors.
 */

#include "trial_step.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "chain.h"
#include "contact_balance.h"
#include "ends.h"
#include "formulas.h"
#include "generalized_alpha.h"
#include "obstacles.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"
#include "wires.h"

/* components of a load: force and moment */
enum { FORCE_X, FORCE_Y, FORCE_Z, MOMENT_X, MOMENT_Y, MOMENT_Z };

/* Return the relative vertical speed of the ends, m/s. */
static double relative_end_speed(const NodalArrays *nodal) {
    return nodal->v[UP] - end_row(nodal->v, nodal->nodes, RIGHT)[UP];
}

/* Load of conveyances, bodies and air on the rope: force and moment about the origin, vertical forces of the ends. */
static void load_on(const Scene *scene, const Chain *chain, State *state, const System *sys, double load[AUDIT_LOADS]) {
    const NodalArrays nodal = state_arrays(state);
    double contact[CONTACT_BALANCE], air[AIR_BALANCE];
    external_sums(sys, nodal.q, nodal.v, contact);
    chain->air(sys, nodal.q, nodal.v, air);
    for (int k = 0; k < 6; k++) load[k] = contact[CONTACT_LOAD + k] + air[AIR_FX + k];
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *q = end_row(nodal.q, nodal.nodes, side);
        const double *R = end_row(nodal.reaction, nodal.nodes, side);
        double one[6];
        audit_end_load(q, R, ends_moment(scene, state, &nodal, side), one);
        for (int k = 0; k < 6; k++) load[k] += one[k];
        load[AUDIT_END_LOADS + side] = R[UP];
    }
    /* A planar rope has no load across its plane. */
    if (state->fidelity == PLANAR) {
        load[FORCE_Z] = 0;
        load[MOMENT_X] = 0;
        load[MOMENT_Y] = 0;
    }
}

static void restart_audit(const Scene *scene, const Chain *chain, State *state, const System *sys) {
    Audit *audit = &state->audit;
    load_on(scene, chain, state, sys, audit->load);
    memcpy(audit->auxiliary, audit->load, sizeof audit->load);
    memset(audit->rate, 0, sizeof audit->rate);
}

void begin_audit(const Simulator *sim, State *state) {
    if (state->fidelity == RIGID) return;
    const NodalArrays nodal = state_arrays(state);
    const System sys = rope_system(sim, state);
    restart_audit(&sim->scene, chain_of(sim, state), state, &sys);
    chain_of(sim, state)->momentum(&sys, nodal.q, nodal.v, state->audit.sums);
    memset(state->audit.impulse, 0, sizeof state->audit.impulse);
    state->audit.interval = 0;
}

/* Audit a step of length h; `before` has the vertical reactions of the ends at its start. */
static void audit_step(const Simulator *sim, State *state, const System *sys, double h, double time_shift,
                       const double before[2]) {
    const NodalArrays nodal = state_arrays(state);
    const Scene *scene = &sim->scene;
    const Coefficients method = {scene->solver.rho_inf};
    AuditedStep step = {.h = h, .recentring = time_shift};
    load_on(scene, chain_of(sim, state), state, sys, step.load);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double now = vertical_reaction(&nodal, side);
        step.force = fmax(step.force, fabs(now));
        step.force_change = fmax(step.force_change, fabs(now - before[side]));
    }
    step.axial_share = audit_axial_share(&scene->rope, bottom_arc_length(scene, state->paths, state->t), h);
    state->audit = audit_after_step(&state->audit, &method, &step);
}

/* Return the largest square of the change of r' over an element. */
static double largest_bend(const NodalArrays *nodal) {
    double largest = 0;
    for (int k = 0; k < nodal->elements; k++) {
        const double *d = nodal->q + (size_t)k * DOF + SLOPE;
        const double *next = d + DOF;
        const double change[3] = {next[0] - d[0], next[1] - d[1], next[2] - d[2]};
        largest = fmax(largest, elementary_dot(change, change));
    }
    return largest;
}

void audit_interval(const Simulator *sim, State *state, double h, double residual_before) {
    if (state->fidelity == RIGID) return;
    const Rope *rope = &sim->scene.rope;
    const NodalArrays nodal = state_arrays(state);
    const double *left = nodal.q;
    const double *right = end_row(nodal.q, nodal.nodes, RIGHT);
    const System sys = rope_system(sim, state);
    AuditedInterval interval = {.h = h};
    chain_of(sim, state)->momentum(&sys, nodal.q, nodal.v, interval.sums);
    for (int k = 0; k < 3; k++) interval.middle[k] = 0.5 * (left[k] + right[k]);
    interval.residual = energy_balance_residual(&state->energy_balance) - residual_before;
    interval.bend = largest_bend(&nodal);
    state->audit =
        audit_after_interval(&state->audit, &interval, rope->mass_per_length * rope->length, sim->scene.layout.gravity);
}

/* Return the local error of a trial step divided by its tolerance. */
static double relative_error(const Scene *scene, State *state, const StepResult *result) {
    const NodalArrays old = state_arrays(state);
    const Coefficients method = {scene->solver.rho_inf};
    const StepLimits limits = step_limits(scene, &state->errors, bottom_arc_length(scene, state->paths, state->t),
                                          relative_end_speed(&old), generalized_alpha_local_error(&method, 1, 1));
    const double strain = fmax(fabs(result->strains[LEFT]), fabs(result->strains[RIGHT]));
    return step_error(&limits, result->h, result->error, strain);
}

StepResult compute_trial(Simulator *sim, State *state, double h) {
    System sys = rope_system(sim, state);
    sys.corrections = sim->replay.repeating ? sim->replay.corrections : 0;
    StepResult result = generalized_alpha_step(sim, state, &sys, h);
    result.near = near_bodies(&sys);
    result.error_ratio = result.converged ? relative_error(&sim->scene, state, &result) : INFINITY;
    return result;
}

void restart_motion(Simulator *sim, State *state) {
    const System sys = rope_system(sim, state);
    generalized_alpha_restart(sim, state, &sys);
    rope_powers(&sim->scene, state);
    restart_audit(&sim->scene, chain_of(sim, state), state, &sys);
}

void update_angles(Simulator *sim, State *state, double *q, double *v, double *a, double *b) {
    state->offsets[RIGHT] += rope_system_transport(sim, state, q, v, a, b);
}

void rope_powers(const Scene *scene, State *state) {
    const NodalArrays nodal = state_arrays(state);
    state->power_ends = 0;
    state->power_swivel = 0;
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *R = end_row(nodal.reaction, nodal.nodes, side);
        const double *v = end_row(nodal.v, nodal.nodes, side);
        const double moment = ends_moment(scene, state, &nodal, side);
        double spin = v[ANGLE];
        for (int k = 0; k < 3; k++) state->power_ends += R[k] * v[k];
        if (scene->swivels[side].attachment == CLAMPED) state->power_ends += elementary_dot(R + SLOPE, v + SLOPE);
        if (state->swivels[side].phase == SLIP) {
            const double slip = ends_relative(state, side, state->t, 0, spin).rate;
            state->power_swivel -= moment * slip;
            spin -= slip;
        }
        state->power_ends += moment * spin;
    }
}

/* Set the energies from sums over the elements.  The inertia of the swivels adds to the kinetic energy. */
static void set_energies(EnergyBalance *energy_balance, const double balance[ENERGIES], const System *sys,
                         const double *q, const double *v) {
    double sums[ENERGIES], contact[CONTACT_BALANCE];
    memcpy(sums, balance, sizeof sums);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double rate = end_row(v, sys->elements + 1, side)[ANGLE];
        sums[KINETIC] += 0.5 * sys->inertia[side] * rate * rate;
    }
    external_sums(sys, q, v, contact);
    *energy_balance = energy_balance_with_energies(energy_balance, sums, contact[CONTACT_ENERGY]);
}

double rope_energies(Simulator *sim, State *state) {
    const NodalArrays nodal = state_arrays(state);
    const System sys = rope_system(sim, state);
    const double before = energy_balance_total(&state->energy_balance);
    double balance[ENERGIES];
    chain_of(sim, state)->evaluate(&sys, nodal.q, nodal.v, nodal.a, nodal.reaction, NULL, balance);
    set_energies(&state->energy_balance, balance, &sys, nodal.q, nodal.v);
    return energy_balance_total(&state->energy_balance) - before;
}

double largest_end_force(const NodalArrays *nodal) {
    double force = 0;
    for (int side = LEFT; side <= RIGHT; side++)
        for (int k = 0; k < 3; k++) force = fmax(force, fabs(end_row(nodal->reaction, nodal->nodes, side)[k]));
    return force;
}

static Powers powers_of(const State *state) {
    return (Powers){.ends = state->power_ends, .swivel = state->power_swivel};
}

/* Write the mean accelerations of the end strains over a step h from v to the trial's. */
static void strain_accelerations(const Scene *scene, const NodalArrays *trial, const double *v, double h,
                                 double strain_tt[2]) {
    for (int side = LEFT; side <= RIGHT; side++)
        strain_tt[side] = (end_strain(scene, trial->nodes, trial->q, trial->v, side) -
                           end_strain(scene, trial->nodes, trial->q, v, side)) /
                          h;
}

/* Put the middle of the step into q, and the mean rate into v.  Losses follow from these: the rates at the ends of a
   step have the integrator's own oscillation, whose square does not average out. */
static void move_to_middle(const NodalArrays *nodal, const NodalArrays *trial, double h) {
    const size_t size = (size_t)nodal->nodes * DOF;
    for (size_t i = 0; i < size; i++) {
        const double q = nodal->q[i];
        nodal->q[i] = 0.5 * (q + trial->q[i]);
        nodal->v[i] = (trial->q[i] - q) / h;
    }
}

/* Return the losses of a step h whose middle is in the state; those between wires are left out.  Add the contact to
   the sums of its error. */
static StepLosses losses_in_middle(const Scene *scene, const Chain *chain, const System *sys, State *state, double h) {
    const NodalArrays middle = state_arrays(state);
    double material[LOSSES];
    double contact[CONTACT_BALANCE];
    double air[AIR_BALANCE];
    chain->losses(sys, middle.q, middle.v, material);
    external_sums(sys, middle.q, middle.v, contact);
    state->contact = add_contact(scene, &state->contact, h, contact + CONTACT_FORCES, longest_near(sys));
    chain->air(sys, middle.q, middle.v, air);
    return (StepLosses){.damping = material[DAMPING_POWER - ENERGIES],
                        .nonconservative = material[NONCONSERVATIVE_POWER - ENERGIES],
                        .contact = contact[CONTACT_DISSIPATED],
                        .moving_bodies = contact[CONTACT_MOVED],
                        .air = air[GIVEN_TO_AIR]};
}

/* Take the motion of the trial, with its frames. */
static void take_motion(Simulator *sim, State *state, const StepResult *trial) {
    const NodalArrays nodal = state_arrays(state);
    const NodalArrays *moved = &sim->work.trial;
    update_angles(sim, state, moved->q, moved->v, moved->a, moved->b);
    copy_fields(&nodal, moved);
    state->t = trial->t;
    state->h = trial->h;
}

/* Return the transverse motion of the legs `time` after the start; the loop's lowest point is at `bottom_s`. */
static LegsMotion legs_motion(const Scene *scene, const NodalArrays *nodal, double bottom_s, double time) {
    const double lowest = nodal->q[(size_t)lowest_node(nodal->nodes, nodal->q) * DOF + UP];
    const double begins = leg_begins(scene);
    LegsMotion legs = {.bottom_s = bottom_s};
    for (int k = 0; k < nodal->elements; k++) {
        const size_t row = (size_t)k * DOF;
        const double height = 0.5 * (nodal->q[row + UP] + nodal->q[row + DOF + UP]) - lowest;
        if (height < begins) continue;
        const int side = nodal->s[k] < bottom_s ? LEFT : RIGHT;
        const ElementWave wave = leg_waves_element_wave(scene, nodal->q + row, nodal->v + row, nodal->a + row,
                                                        nodal->lengths[k], height, begins);
        legs.shortening[side] += wave.shortening;
        legs.of_c2[side] += wave.of_c2;
        legs.slopes += wave.slopes;
        legs.bent += wave.bent;
        legs.force_acceleration = fmax(legs.force_acceleration, wave.force_acceleration);
        legs.speed = fmax(legs.speed, wave.speed);
        legs.acceleration = fmax(legs.acceleration, wave.acceleration);
        if (wave.travel < time) legs.arrived = fmax(legs.arrived, wave.speed);
        if (!(wave.force_rate > legs.force_rate)) continue;
        legs.force_rate = wave.force_rate;
        legs.length = nodal->lengths[k];
        legs.height = height;
    }
    return legs;
}

void commit_trial(Simulator *sim, State *state, const StepResult *trial) {
    const Scene *scene = &sim->scene;
    const Coefficients method = {scene->solver.rho_inf};
    const NodalArrays nodal = state_arrays(state);
    System sys = rope_system(sim, state);

    /* the start of the step */
    const double h = trial->t - state->t;
    const double time_shift = recentring(&method, trial->h, state->h);
    const double reactions[2] = {vertical_reaction(&nodal, LEFT), vertical_reaction(&nodal, RIGHT)};
    const Powers powers_before = powers_of(state);
    MeasuredStep step = {.h = h,
                         .bottom_s = bottom_arc_length(scene, state->paths, state->t),
                         .end_speed = relative_end_speed(&nodal),
                         .position = trial->error};
    strain_accelerations(scene, &sim->work.trial, nodal.v, h, step.strain_tt);

    /* its middle */
    move_to_middle(&nodal, &sim->work.trial, h);
    sys.time = state->t + 0.5 * h;
    StepLosses losses = losses_in_middle(scene, chain_of(sim, state), &sys, state, h);
    losses.wires = update_hysteresis(sim->reference.wires, state, sim->work.trial.q);

    /* its end */
    take_motion(sim, state, trial);
    sys.time = state->t;
    step.force = largest_end_force(&nodal);
    const double error_constant = generalized_alpha_local_error(&method, 1, 1);
    state->errors = add_errors(scene, &state->errors, &step, error_constant);
    const LegsMotion legs = legs_motion(scene, &nodal, step.bottom_s, state->errors.time);
    state->waves = add_leg_waves(scene, &state->waves, &legs, h, error_constant);
    rope_powers(scene, state);
    const Powers powers_after = powers_of(state);
    if (!trial->near) sys.obstacles = NULL;
    set_energies(&state->energy_balance, trial->balance, &sys, nodal.q, nodal.v);
    state->energy_balance =
        energy_balance_after_step(&state->energy_balance, h, &powers_before, &powers_after, &losses);
    audit_step(sim, state, &sys, h, time_shift, reactions);
}
