/* Forces that a host puts on places of the rope: rope_model.simulation.contact.point_forces, which see. */

#include "rope_system.h"

void elements_at(const System *s, int number, Pushed *at) {
    const PointForces *forces = s->forces;
    const double *place = forces->places[number];
    const double part = part_of_time(forces->start, forces->stop, s->time);
    while (at->element < s->elements - 1 && place[0] > at->start + s->lengths[at->element])
        at->start += s->lengths[at->element++];
    hermite_shape_functions((place[0] - at->start) / s->lengths[at->element], s->lengths[at->element], at->N);
    for (int i = 0; i < 3; i++) at->force[i] = place[1 + i] + part * (place[4 + i] - place[1 + i]);
}

void nodal_forces(const System *s, double *R) {
    Pushed at = {0};
    for (int number = 0; s->forces != NULL && number < s->forces->number; number++) {
        elements_at(s, number, &at);
        double *row = R + (size_t)at.element * DOF;
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 3; i++) row[k / 2 * DOF + k % 2 * SLOPE + i] -= at.N[k] * at.force[i];
    }
}

void point_forces_push(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    Pushed at = {0};
    for (int number = 0; s->forces != NULL && number < s->forces->number; number++) {
        double place[3], speed[3], load[6];
        elements_at(s, number, &at);
        at_places(q, at.element, at.N, place);
        at_places(v, at.element, at.N, speed);
        point_load(place, at.force, load);
        for (int k = 0; k < 6; k++) sums[CONTACT_LOAD + k] += load[k];
        sums[CONTACT_MOVED] += dot(at.force, speed);
    }
}
