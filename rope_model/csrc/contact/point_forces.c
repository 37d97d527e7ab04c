/* Forces that a host puts on places of the rope: rope_model.simulation.contact.point_forces, which see. */

#include "simulator.h"

/* a place with a force: its element, which begins at `start`, the shares of that element's nodes, the force now */
typedef struct {
    int element;
    double start, shares[4], force[3];
} Pushed;

/* goes on to a place, which is not before the one it was at */
static void go_on(const System *s, int number, Pushed *at) {
    const PointForces *forces = s->forces;
    const double *place = forces->places[number];
    const double part = part_of_time(forces->start, forces->stop, s->time);
    while (at->element < s->elements - 1 && place[0] > at->start + s->lengths[at->element])
        at->start += s->lengths[at->element++];
    hermite_shares((place[0] - at->start) / s->lengths[at->element], s->lengths[at->element], at->shares);
    for (int i = 0; i < 3; i++) at->force[i] = place[1 + i] + part * (place[4 + i] - place[1 + i]);
}

void add_point_forces(const System *s, double *R) {
    Pushed at = {0};
    for (int number = 0; s->forces != NULL && number < s->forces->number; number++) {
        go_on(s, number, &at);
        double *row = R + (size_t)at.element * DOF;
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 3; i++) row[k / 2 * DOF + k % 2 * SLOPE + i] -= at.shares[k] * at.force[i];
    }
}

void add_point_balance(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    Pushed at = {0};
    for (int number = 0; s->forces != NULL && number < s->forces->number; number++) {
        double place[3], speed[3], load[6];
        go_on(s, number, &at);
        place_on(q, at.element, at.shares, place);
        place_on(v, at.element, at.shares, speed);
        point_load(place, at.force, load);
        for (int k = 0; k < 6; k++) sums[CONTACT_LOAD + k] += load[k];
        sums[CONTACT_MOVED] += dot(at.force, speed);
    }
}

void rope_apply(Simulator *rope, const PointForces *forces) {
    rope->forces = *forces;
}

void rope_rows(const Simulator *rope, double (*rows)[13]) {
    const Arrays m = state_arrays(rope->state);
    for (int node = 0; node < m.nodes; node++) {
        const double *q = m.q + (size_t)node * DOF, *v = m.v + (size_t)node * DOF;
        rows[node][0] = m.s[node];
        for (int k = 0; k < ANGLE; k++) rows[node][1 + k] = q[k], rows[node][1 + ANGLE + k] = v[k];
    }
}

void rope_displacement(Simulator *rope, const PointForces *forces, double (*moved)[3]) {
    State *state = rope->state;
    const Arrays m = state_arrays(state);
    const Coefficients method = {rope->scene.solver.rho_inf};
    System s = system_of(rope, state);
    s.time = forces->start;
    double c[3], *const answers[2] = {rope->trial.q, rope->x};
    newton_coefficients(&method, state->last_interval, c);
    for (int k = 0; k < 2; k++) {
        s.forces = k == 0 ? NULL : forces;
        chain_of(rope, state)->newton_step(&s, rope->work, m.q, m.v, m.a, m.reaction, c, answers[k], rope->trial.v);
    }
    Pushed at = {0};
    for (int number = 0; number < forces->number; number++) {
        double without[3];
        go_on(&s, number, &at);
        place_on(answers[0], at.element, at.shares, without);
        place_on(answers[1], at.element, at.shares, moved[number]);
        for (int i = 0; i < 3; i++) moved[number][i] -= without[i];
    }
}
