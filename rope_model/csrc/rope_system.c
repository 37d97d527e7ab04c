/* Equations of motion of a state.  C version of rope_model/simulation/rope_system.py, which explains the method. */

#include "simulator.h"

System rope_system(const Simulator *rope, State *state) {
    const Rope *data = &rope->scene.rope;
    const NodalArrays x = state_arrays(state);
    System s = {.elements = x.elements,
                .lengths = x.lengths,
                .frames = rope->frames,
                .obstacles = rope->obstacles->bodies > 0 ? rope->obstacles : NULL,
                .self_contact = rope->self_contact->presses ? rope->self_contact : NULL,
                .forces = rope->forces.number > 0 ? &rope->forces : NULL,
                .time = state->t,
                .wires = state->rubs ? rope->wires : NULL,
                .curved = is_curved(rope, state) ? rope->curved : NULL,
                .latest = rope->latest,
                .shortest = x.lengths[0]};
    element_parameters(data, rope->scene.layout.gravity, s.P);
    const AirCoefficients c = air_coefficients(&rope->scene.shaft.air, data->diameter, rope->scene.layout.spacing);
    memcpy(s.air, &c, sizeof s.air);
    for (int k = 1; k < x.elements; k++) s.shortest = fmin(s.shortest, x.lengths[k]);
    for (int side = LEFT; side <= RIGHT; side++) {
        const Swivel *swivel = &rope->scene.swivels[side];
        const SwivelState *now = &state->swivels[side];
        s.free[side][SLOPE] = s.free[side][SLOPE + 2] = swivel->attachment == HINGED;
        s.free[side][SLOPE + 1] = swivel->attachment != CLAMPED;
        s.free[side][ANGLE] = now->phase == SLIP;
        s.inertia[side] = swivel->inertia;
        if (now->phase == SLIP && swivel->mode != FREE_MODE) {
            s.load[side] = -now->sign * swivel->seal_moment;
            s.friction_load[side] = -now->sign * friction_moment(swivel->mu_kinetic, swivel->mean_diameter, 0, 1);
        }
    }
    return s;
}

/* Refer permanent curvature and friction between wires to q. */
static void refer_material(Simulator *rope, State *state, const System *s, const double *q) {
    curved_reference(rope, state, q);
    if (!state->rubs) return;
    chain_of(rope, state)->strains(s, q, rope->strains);
    wires_history(rope, state, q, rope->strains);
}

void rope_system_refer(Simulator *rope, State *state, const double *q) {
    const System s = rope_system(rope, state);
    chain_of(rope, state)->refer(&s, q);
    refer_material(rope, state, &s, q);
}

double rope_system_transport(Simulator *rope, State *state, double *q, double *v, double *a, double *b) {
    const System s = rope_system(rope, state);
    double (*gained)[3] = rope->strains, turn = 0;
    chain_of(rope, state)->transport(&s, q, v, a, gained);
    for (int k = 0; k < s.elements; k++) {
        const size_t theta = (size_t)(k + 1) * DOF + ANGLE;
        turn += gained[k][0];
        q[theta] += turn;
        v[theta] += gained[k][1];
        a[theta] += gained[k][2];
        b[theta] += gained[k][2];
    }
    refer_material(rope, state, &s, q);
    return turn;
}

void rope_system_prescribed_motion(const Simulator *rope, const State *state, const System *s, double t, int orders,
                                   double *const x[]) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const size_t row = side ? (size_t)s->elements * DOF : 0;
        double rows[3][DOF];
        ends_prescribed_motion(&rope->scene, state, side, t, rows);
        for (int k = 0; k < orders; k++)
            for (int dof = 0; dof < DOF; dof++)
                if (!s->free[side][dof]) x[k][row + (size_t)dof] = rows[k][dof];
    }
}

double rope_system_norm(const System *s, const double *x, double slopes) {
    double largest[DOF] = {0}, all = 0;
    int finite = 1;
    for (int k = 0; k <= s->elements; k++, x += DOF) {
        const int *free = k == 0 ? s->free[LEFT] : k == s->elements ? s->free[RIGHT] : NULL;
        for (int dof = 0; dof < DOF; dof++) {
            const double size = free == NULL || free[dof] ? fabs(x[dof]) : 0.;
            finite &= size < INFINITY;
            largest[dof] = size > largest[dof] ? size : largest[dof];
        }
    }
    for (int dof = 0; dof < DOF; dof++) all = fmax(all, largest[dof] * (dof >= SLOPE && dof < ANGLE ? slopes : 1.));
    return finite ? all : INFINITY;
}

double longest_near(const System *s) {
    double longest = 0;
    for (int e = 0; s->obstacles != NULL && s->obstacles->any && e < s->elements; e++)
        if (s->obstacles->near[e]) longest = maximum(longest, s->lengths[e]);
    return longest;
}

void external_sums(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    memset(sums, 0, sizeof(double) * CONTACT_BALANCE);
    self_contact_sums(s, q, v, sums);
    point_forces_push(s, q, v, sums);
    if (s->obstacles == NULL) return;
    find_near_bodies(s, q, v, 0);
    for (int e = 0; s->obstacles->any && e < s->elements; e++)
        if (s->obstacles->near[e]) contact_sums(s, e, q, v, sums);
}

void rope_system_strains(Simulator *rope) {
    const System s = rope_system(rope, rope->state);
    chain_of(rope, rope->state)->strains(&s, state_arrays(rope->state).q, rope->strains);
}

void arc_lengths(int elements, const double *lengths, double *s) {
    s[0] = 0.0;
    for (int k = 0; k < elements; k++) s[k + 1] = s[k] + lengths[k];
}
