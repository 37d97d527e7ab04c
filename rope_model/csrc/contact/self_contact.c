/* Contact of the rope with itself: rope_model.simulation.contact.self_contact and physics.rope_on_rope. */

#include "rope_system.h"

static double length_between(const double a[3], const double b[3]) {
    const double across[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(across, across));
}

/* what is in two boxes is no nearer */
static double gap_of(const double a[6], const double b[6]) {
    double gap = -INFINITY;
    for (int i = 0; i < 3; i++) gap = larger(gap, fabs(a[i] - b[i]) - (a[3 + i] + b[3 + i]));
    return gap;
}

/* how many elements to the right may touch this one; own->others says which, seen.free how near the nearest may be */
static int near_elements(const System *s, int element) {
    SelfContactState *own = s->own;
    const double diameter = own->scene->rope.diameter;
    double along = 0;
    int number = 0;
    for (int e = element + 1; e < s->elements; along += s->lengths[e++]) {
        if (along < LEAST_ARC * diameter) continue;
        const double gap = gap_of(own->boxes[element], own->boxes[e]);
        own->seen.free = smaller(own->seen.free, gap);
        if (gap < diameter) own->others[number] = e, own->ways[number++] = along;
    }
    return number;
}

/* where the element is nearest to the point, and how far that is from it */
static double nearest_place(const System *s, const double *q, int element, const double point[3], double *xi) {
    static const double probes[] = PROBE_PLACES;
    const double *a = q + (size_t)element * DOF, l = s->lengths[element];
    double N[4], place[3], least = INFINITY;
    for (int k = 0; k < PROBES; k++) {
        hermite_shape_functions(probes[k], l, N);
        at_places(q, element, N, place);
        const double distance = length_between(place, point);
        if (distance < least) least = distance, *xi = probes[k];
    }
    for (int k = 0; k < CORRECTIONS; k++) *xi = nearer_place(*xi, l, point, a, a + DOF);
    hermite_shape_functions(*xi, l, N);
    at_places(q, element, N, place);
    return length_between(place, point);
}

/* what a place of an element and one of another do to each other is noted, where they press each other */
static void note(const System *s, const double *q, const double *v, const double c[2], const double N[4],
                 SelfContact touch) {
    SelfContactState *own = s->own;
    const int other = touch.elements[1];
    double partner[4], place[2][3], speed[2][3];
    hermite_shape_functions(touch.place, s->lengths[other], partner);
    at_places(q, touch.elements[0], N, place[0]);
    at_places(v, touch.elements[0], N, speed[0]);
    at_places(q, other, partner, place[1]);
    at_places(v, other, partner, speed[1]);
    for (int i = 0; i < 3; i++) place[0][i] -= place[1][i], speed[0][i] -= speed[1][i];
    for (int k = 0; k < 4; k++) touch.N[k] = N[k], touch.N[4 + k] = -partner[k];
    touch.law = self_contact_law(&own->scene->shaft.contact, own->scene->rope.diameter, place[0], speed[0], c[0], c[1]);
    own->touches[own->number++] = touch;
}

/* arc length from the element looked at to the nearest place of one near it */
static double way_to(const System *s, int n) {
    return s->own->ways[n] + s->own->where[n] * s->lengths[s->own->others[n]];
}

/* of the near elements the nearest, if it touches, and those of its strand are left out from now on; or -1 */
static int next_strand(const System *s, int others) {
    SelfContactState *own = s->own;
    const double diameter = own->scene->rope.diameter;
    double least = diameter;
    int nearest = -1;
    for (int n = 0; n < others; n++)
        if (own->distances[n] < least) least = own->distances[n], nearest = n;
    if (nearest < 0) return -1;
    for (int n = 0; n < others; n++)
        if (fabs(way_to(s, n) - way_to(s, nearest)) < LEAST_ARC * diameter) own->distances[n] = INFINITY;
    return nearest;
}

static void look_along(const System *s, const double *q, const double *v, const double c[2], int element, int others) {
    SelfContactState *own = s->own;
    const double diameter = own->scene->rope.diameter, l = s->lengths[element];
    const int number = (int)places_of(l, diameter);
    const double weight = l / number;
    for (int k = 0; k < number;) {
        SelfContact touch = {.elements = {element, 0}, .weight = weight};
        double N[4], point[3], least = INFINITY;
        hermite_shape_functions((k + 0.5) / number, l, N);
        at_places(q, element, N, point);
        for (int n = 0; n < others; n++) {
            own->distances[n] = nearest_place(s, q, own->others[n], point, own->where + n);
            if (own->distances[n] < least) least = own->distances[n];
        }
        if (least < own->nearest[0]) own->nearest[0] = least, own->nearest[1] = point[1];
        for (int strand = 0; own->presses && least < diameter && strand < MOST_STRANDS; strand++) {
            const int n = next_strand(s, others);
            if (n < 0) break;
            touch.elements[1] = own->others[n];
            touch.place = own->where[n];
            note(s, q, v, c, N, touch);
        }
        /* what is certainly farther than a diameter is left out; a distance that is not a number ends the look */
        k += 1 + (int)places_skipped(least, diameter, weight, number);
    }
}

int find_self_contacts(const System *s, const double *q, const double *v, double cq, double cv) {
    SelfContactState *own = s->own;
    const double c[2] = {cq, cv};
    own->number = 0;
    own->nearest[0] = own->scene->rope.diameter;
    if (clearance_exceeds(s, &own->seen, q, own->scene->rope.diameter)) return 0;
    remember_configuration(s, &own->seen, q);
    for (int e = 0; e < s->elements; e++) {
        const double *a = q + (size_t)e * DOF;
        enclosing_box(s->lengths[e], a, a + DOF, own->boxes[e]);
    }
    for (int e = 0; e < s->elements; e++) {
        const int others = near_elements(s, e);
        if (others > 0) look_along(s, q, v, c, e, others);
    }
    return own->number;
}

/* The r or r' that shape function k of a contact belongs to. */
static size_t row_of(const SelfContact *touch, int k) {
    return (size_t)(touch->elements[k / 4] + k % 4 / 2) * DOF + (size_t)(k % 2 * SLOPE);
}

static void spread(const SelfContact *touch, const double force[3], double *y) {
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 3; i++) y[row_of(touch, k) + (size_t)i] += touch->weight * touch->N[k] * force[i];
}

void self_contact_take_force(const SelfContactState *own, double *R) {
    for (const SelfContact *at = own->touches; at < own->touches + own->number; at++)
        spread(at, (const double[3]){-at->law.force[0], -at->law.force[1], -at->law.force[2]}, R);
}

void self_contact_times(const SelfContactState *own, const double *x, double *y) {
    static const int upper[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (const SelfContact *at = own->touches; at < own->touches + own->number; at++) {
        double apart[3] = {0}, force[3] = {0};
        for (int k = 0; k < 8; k++)
            for (int i = 0; i < 3; i++) apart[i] += at->N[k] * x[row_of(at, k) + (size_t)i];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) force[i] += at->law.tangent[upper[i][j]] * apart[j];
        spread(at, force, y);
    }
}

void self_contact_sums(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    if (s->own == NULL || !find_self_contacts(s, q, v, 0, 0)) return;
    for (const SelfContact *at = s->own->touches; at < s->own->touches + s->own->number; at++) {
        sums[CONTACT_ENERGY] += at->weight * at->law.sums[CONTACT_ENERGY];
        sums[CONTACT_DISSIPATED] += at->weight * at->law.sums[CONTACT_DISSIPATED];
        /* forces cancel; friction leaves a couple */
        for (int k = CONTACT_LOAD + 3; k < CONTACT_FORCES; k++) sums[k] += at->weight * at->law.sums[k];
        sums[CONTACT_ROPE] += at->weight * at->law.sums[CONTACT_FORCES];
    }
}
