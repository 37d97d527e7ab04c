/* Whether the rope's motion is that of its forces: rope_model.simulation.outputs.audit, which see. */

#include <math.h>
#include <string.h>

#include "simulator.h"

/* what conveyances, bodies and air put on the rope: force and moment about the origin */
static void loads_on(const Simulator *rope, State *state, const System *s, double load[6]) {
    const Arrays m = state_arrays(state);
    double contact[CONTACT_BALANCE], air[AIR_BALANCE];
    contact_balance(s, m.q, m.v, contact);
    chain_of(rope, state)->air(s, m.q, m.v, air);
    for (int k = 0; k < 6; k++) load[k] = contact[CONTACT_LOAD + k] + air[1 + k];
    for (int side = LEFT; side <= RIGHT; side++) {
        const double *q = end_row(m.q, m.nodes, side), *R = end_row(m.reaction, m.nodes, side);
        double one[6];
        end_load(q, R, swivel_moment(&rope->scene, state, side, R), one);
        for (int k = 0; k < 6; k++) load[k] += one[k];
    }
    /* what goes across its plane a planar rope does not feel */
    if (state->fidelity == PLANAR) load[2] = load[3] = load[4] = 0;
}

void audit_restart(const Simulator *rope, State *state, const System *s) {
    Audit *audit = &state->audit;
    loads_on(rope, state, s, audit->load);
    memcpy(audit->auxiliary, audit->load, sizeof audit->load);
    memset(audit->rate, 0, sizeof audit->rate);
}

void audit_begin(const Simulator *rope, State *state) {
    if (state->fidelity == RIGID) return;
    const Arrays m = state_arrays(state);
    const System s = system_of(rope, state);
    audit_restart(rope, state, &s);
    chain_of(rope, state)->momentum(&s, m.q, m.v, state->audit.sums);
    memset(state->audit.impulse, 0, sizeof state->audit.impulse);
}

/* before: the ends' vertical reactions at the step's start */
void audit_step(const Simulator *rope, State *state, const System *s, double h, double moved_by,
                const double before[2]) {
    const Arrays m = state_arrays(state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    double load[6], force = 0, change = 0;
    loads_on(rope, state, s, load);
    for (int side = LEFT; side <= RIGHT; side++) {
        const double now = end_row(m.reaction, m.nodes, side)[1];
        force = fmax(force, fabs(now));
        change = fmax(change, fabs(now - before[side]));
    }
    state->audit = audit_after_step(&state->audit, &method, h, moved_by, load, force, change,
                                    axial_share(&rope->scene.rope, bottom_of(rope, state, state->t), h));
}

/* the largest square of the change of r' over an element */
static double largest_bend(const Arrays *m) {
    double largest = 0;
    for (int k = 0; k < m->elements; k++) {
        const double *d = m->q + (size_t)k * DOF + SLOPE, *next = d + DOF;
        const double change[3] = {next[0] - d[0], next[1] - d[1], next[2] - d[2]};
        largest = fmax(largest, dot(change, change));
    }
    return largest;
}

/* h: of the communication step, at the start of which the balance of energy had this residual */
void audit_interval(const Simulator *rope, State *state, double h, double residual_before) {
    const Arrays m = state_arrays(state);
    const double *left = m.q, *right = end_row(m.q, m.nodes, RIGHT);
    double sums[MOMENTUM], about[3];
    if (state->fidelity == RIGID) return;
    const System s = system_of(rope, state);
    chain_of(rope, state)->momentum(&s, m.q, m.v, sums);
    for (int k = 0; k < 3; k++) about[k] = 0.5 * (left[k] + right[k]);
    state->audit = audit_after_interval(&state->audit, h, rope->scene.rope.mass_per_length * rope->scene.rope.length,
                                        rope->scene.layout.gravity, sums, about,
                                        energy_residual(&state->energy_balance) - residual_before, largest_bend(&m));
}
