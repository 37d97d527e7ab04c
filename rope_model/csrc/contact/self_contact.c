/* Contact of the rope with itself.

   Bounding boxes give the pairs of candidate elements. Along an element of such a pair the distance changes by no
   more than the arc length, so that far points are skipped and a leg costs a few checks. Contact has no history
   in the state. */

#include "self_contact.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "contact_balance.h"
#include "formulas.h"
#include "obstacles.h"
#include "rope.h"
#include "system.h"

static double length_between(const double a[3], const double b[3]) {
    const double across[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(elementary_dot(across, across));
}

/* Return a lower bound of the distance between points in two boxes. */
static double gap_of(const double a[6], const double b[6]) {
    double gap = -INFINITY;
    for (int i = 0; i < 3; i++) gap = maximum(gap, fabs(a[i] - b[i]) - (a[3 + i] + b[3 + i]));
    return gap;
}

/* Find the elements to the right that may touch this one, and update cache.free; return their number. */
static int near_elements(const System *sys, int element) {
    SelfContactState *self_contact = sys->self_contact;
    double (*boxes)[6] = self_contact->work.boxes;
    const double diameter = self_contact->scene->rope.diameter;
    double along = 0;
    int count = 0;
    for (int e = element + 1; e < sys->elements; along += sys->lengths[e++]) {
        if (along < ROPE_CONTACT_MIN_ARC * diameter) continue;
        const double gap = gap_of(boxes[element], boxes[e]);
        self_contact->cache.free = minimum(self_contact->cache.free, gap);
        if (!(gap < diameter)) continue;
        self_contact->work.neighbours[count++] = (Neighbour){.element = e, .arc_gap = along};
    }
    return count;
}

/* Return the distance of an element from a point; xi is the element coordinate of the nearest place. */
static double nearest_place(const System *sys, const double *q, int element, const double point[3], double *xi) {
    static const double probes[] = PROBE_PLACES;
    const double *a = q + (size_t)element * DOF;
    const double l = sys->lengths[element];
    double N[4];
    double place[3];
    double least = INFINITY;
    for (int k = 0; k < PROBES; k++) {
        hermite_shape_functions(probes[k], l, N);
        at_places(q, element, N, place);
        const double distance = length_between(place, point);
        if (distance < least) *xi = probes[k];
        least = minimum(least, distance);
    }
    for (int k = 0; k < ROPE_CONTACT_CORRECTIONS; k++) *xi = rope_contact_nearer_xi(*xi, l, point, a, a + DOF);
    hermite_shape_functions(*xi, l, N);
    at_places(q, element, N, place);
    return length_between(place, point);
}

/* Add a contact between a place with shape functions N and contact.xi of the other element. */
static void add_self_contact(const System *sys, const double *q, const double *v, const TangentCoefficients *c,
                             const double N[4], SelfContact contact) {
    SelfContactState *self_contact = sys->self_contact;
    const int other = contact.elements[1];
    double partner[4];
    double place[2][3];
    double speed[2][3];
    hermite_shape_functions(contact.xi, sys->lengths[other], partner);
    at_places(q, contact.elements[0], N, place[0]);
    at_places(v, contact.elements[0], N, speed[0]);
    at_places(q, other, partner, place[1]);
    at_places(v, other, partner, speed[1]);
    for (int i = 0; i < 3; i++) place[0][i] -= place[1][i];
    for (int i = 0; i < 3; i++) speed[0][i] -= speed[1][i];
    memcpy(contact.N, N, sizeof partner);
    for (int k = 0; k < 4; k++) contact.N[4 + k] = -partner[k];
    contact.terms = self_contact_law(&self_contact->scene->shaft.contact, self_contact->scene->rope.diameter, place[0],
                                     speed[0], c->q, c->v);
    self_contact->contacts[self_contact->count++] = contact;
}

/* Return the arc length from the present element to the nearest place of a neighbour. */
static double arc_gap(const System *sys, const Neighbour *neighbour) {
    return neighbour->arc_gap + neighbour->xi * sys->lengths[neighbour->element];
}

/* Return the nearest neighbour if it touches, else NULL.  Excludes its strand from later calls. */
static const Neighbour *next_strand(const System *sys, int count) {
    Neighbour *neighbours = sys->self_contact->work.neighbours;
    const double diameter = sys->self_contact->scene->rope.diameter;
    const Neighbour *nearest = NULL;
    double least = diameter;
    for (int n = 0; n < count; n++) {
        if (neighbours[n].distance < least) nearest = &neighbours[n];
        least = minimum(least, neighbours[n].distance);
    }
    if (nearest == NULL) return NULL;
    const double nearest_gap = arc_gap(sys, nearest);
    for (int n = 0; n < count; n++)
        if (fabs(arc_gap(sys, &neighbours[n]) - nearest_gap) < ROPE_CONTACT_MIN_ARC * diameter)
            neighbours[n].distance = INFINITY;
    return nearest;
}

/* Find the contacts of an element with its neighbours. */
static void search_element(const System *sys, const double *q, const double *v, const TangentCoefficients *c,
                           int element, int neighbour_count) {
    SelfContactState *self_contact = sys->self_contact;
    Neighbour *neighbours = self_contact->work.neighbours;
    const double diameter = self_contact->scene->rope.diameter;
    const double l = sys->lengths[element];
    const int count = (int)rope_contact_number_of_points(l, diameter);
    const double weight = l / count;
    for (int k = 0; k < count;) {
        SelfContact contact = {.elements = {element, 0}, .weight = weight};
        double N[4];
        double point[3];
        double least = INFINITY;
        hermite_shape_functions((k + 0.5) / count, l, N);
        at_places(q, element, N, point);
        for (int n = 0; n < neighbour_count; n++) {
            Neighbour *neighbour = &neighbours[n];
            neighbour->distance = nearest_place(sys, q, neighbour->element, point, &neighbour->xi);
            least = minimum(least, neighbour->distance);
        }
        if (least < self_contact->least_distance) self_contact->least_y = point[UP];
        self_contact->least_distance = minimum(self_contact->least_distance, least);
        const int strands = self_contact->presses && least < diameter ? ROPE_CONTACT_MAX_STRANDS : 0;
        for (int strand = 0; strand < strands; strand++) {
            const Neighbour *nearest = next_strand(sys, neighbour_count);
            if (nearest == NULL) break;
            contact.elements[1] = nearest->element;
            contact.xi = nearest->xi;
            add_self_contact(sys, q, v, c, N, contact);
        }
        /* Skip places farther than a diameter.  A distance that is not a number ends the search. */
        k += 1 + (int)rope_contact_points_skipped(least, diameter, weight, count);
    }
}

int find_self_contacts(const System *sys, const double *q, const double *v, double c_q, double c_v) {
    SelfContactState *self_contact = sys->self_contact;
    const TangentCoefficients c = {.q = c_q, .v = c_v};
    self_contact->count = 0;
    self_contact->least_distance = self_contact->scene->rope.diameter;
    if (clearance_exceeds(sys, &self_contact->cache, q, self_contact->scene->rope.diameter)) return 0;
    remember_configuration(sys, &self_contact->cache, q);
    for (int e = 0; e < sys->elements; e++) {
        const double *a = q + (size_t)e * DOF;
        centreline_enclosing_box(sys->lengths[e], a, a + DOF, self_contact->work.boxes[e]);
    }
    for (int e = 0; e < sys->elements; e++) {
        const int neighbour_count = near_elements(sys, e);
        if (neighbour_count > 0) search_element(sys, q, v, &c, e, neighbour_count);
    }
    return self_contact->count;
}

/* Return the entry of q, an r or r', that shape function k of a contact belongs to. */
static size_t row_of(const SelfContact *contact, int k) {
    return (size_t)(contact->elements[k / 4] + k % 4 / 2) * DOF + (size_t)(k % 2 * SLOPE);
}

/* Distribute a force per length to the nodes of both elements. */
static void spread(const SelfContact *contact, const double force[3], double *y) {
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) y[row_of(contact, k) + (size_t)i] += contact->weight * contact->N[k] * force[i];
}

void self_contact_take_force(const SelfContactState *self_contact, double *R) {
    for (int n = 0; n < self_contact->count; n++) {
        const double *force = self_contact->contacts[n].terms.force;
        spread(&self_contact->contacts[n], (const double[3]){-force[0], -force[1], -force[2]}, R);
    }
}

void self_contact_times(const SelfContactState *self_contact, const double *x, double *y) {
    static const int upper[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (int n = 0; n < self_contact->count; n++) {
        const SelfContact *contact = &self_contact->contacts[n];
        double separation[3] = {0};
        double force[3] = {0};
        for (int k = 0; k < 8; k++)
            for (int i = 0; i < 3; i++) separation[i] += contact->N[k] * x[row_of(contact, k) + (size_t)i];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) force[i] += contact->terms.tangent[upper[i][j]] * separation[j];
        spread(contact, force, y);
    }
}

void self_contact_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    if (sys->self_contact == NULL || !find_self_contacts(sys, q, v, 0, 0)) return;
    for (int n = 0; n < sys->self_contact->count; n++) {
        const SelfContact *contact = &sys->self_contact->contacts[n];
        sums[CONTACT_ENERGY] += contact->weight * contact->terms.sums[CONTACT_ENERGY];
        sums[CONTACT_DISSIPATED] += contact->weight * contact->terms.sums[CONTACT_DISSIPATED];
        /* The forces cancel, but friction leaves a couple. */
        for (int k = CONTACT_LOAD + 3; k < CONTACT_FORCES; k++) sums[k] += contact->weight * contact->terms.sums[k];
        sums[CONTACT_ROPE] += contact->weight * contact->terms.sums[CONTACT_FORCES];
    }
}
