/* Point forces of a host. Formulas: rope_model/physics/point_forces.py. */

#include "point_forces.h"

#include <stddef.h>

#include "contact_balance.h"
#include "formulas.h"
#include "rope.h"
#include "system.h"

/* numbers of a point force: arc length, and force at start and at stop */
enum { ARC_LENGTH, AT_START, AT_STOP = AT_START + 3 };

void elements_at(const System *sys, int index, PointForce *point) {
    const PointForces *forces = sys->forces;
    const double *place = forces->places[index];
    const double fraction = point_forces_time_fraction(forces->start, forces->stop, sys->time);
    while (point->element < sys->elements - 1 && place[ARC_LENGTH] > point->start + sys->lengths[point->element])
        point->start += sys->lengths[point->element++];
    hermite_shape_functions((place[ARC_LENGTH] - point->start) / sys->lengths[point->element],
                            sys->lengths[point->element], point->N);
    for (int i = 0; i < 3; i++)
        point->force[i] = place[AT_START + i] + fraction * (place[AT_STOP + i] - place[AT_START + i]);
}

void nodal_forces(const System *sys, double *R) {
    PointForce point = {0};
    if (sys->forces == NULL) return;
    for (int index = 0; index < sys->forces->count; index++) {
        elements_at(sys, index, &point);
        double *row = R + (size_t)point.element * DOF;
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 3; i++) row[k / 2 * DOF + k % 2 * SLOPE + i] -= point.N[k] * point.force[i];
    }
}

void point_forces_push(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    PointForce point = {0};
    if (sys->forces == NULL) return;
    for (int index = 0; index < sys->forces->count; index++) {
        double place[3];
        double speed[3];
        double load[6];
        elements_at(sys, index, &point);
        at_places(q, point.element, point.N, place);
        at_places(v, point.element, point.N, speed);
        point_load(place, point.force, load);
        for (int k = 0; k < 6; k++) sums[CONTACT_LOAD + k] += load[k];
        sums[CONTACT_MOVED] += elementary_dot(point.force, speed);
    }
}
