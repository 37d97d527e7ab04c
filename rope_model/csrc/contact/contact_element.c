/* Contact of an element with bodies in the shaft. Formulas and tables: rope_model/physics/contact_element.py. */

#include "contact_element.h"

#include <stddef.h>
#include <string.h>

#include "contact_balance.h"
#include "formulas.h"
#include "obstacles.h"
#include "rope.h"
#include "system.h"

typedef struct {
    const double *a; /* row of the left node */
    const double *b; /* row of the right one */
    double l;
    double diameter;
    const Body *body;
} ContactPair;

/* Integration points of the parts in contact.  A cell has two monotone sides, a side two pieces. */
enum { COORDINATE, WEIGHT, POINT_NUMBERS }; /* numbers of a point: element coordinate, and part of the length */
enum { MAX_PRESSED = 4 * CONTACT_POINTS_CELLS * CONTACT_POINTS };
typedef struct {
    int count;
    double points[MAX_PRESSED][POINT_NUMBERS];
} Pressed;

static Probe probe_at(const ContactPair *pair, double place) {
    return contact_points_probe(place, pair->l, pair->a, pair->b, pair->diameter, pair->body);
}

/* Return the extremum of the depth between two probes, or the second of them. */
static Probe turn_between(const ContactPair *pair, Probe start, Probe stop) {
    if (!(start.rate * stop.rate < 0)) return stop;
    for (int k = 0; k < CONTACT_POINTS_HALVINGS; k++) {
        const Probe middle = probe_at(pair, 0.5 * (start.place + stop.place));
        if (start.rate * middle.rate > 0)
            start = middle;
        else
            stop = middle;
    }
    return probe_at(pair, contact_points_turning(&start, &stop));
}

/* Return the place between two where the depth is `level`. */
static double place_of_depth(const ContactPair *pair, Probe outer, double inner, double level) {
    for (int k = 0; k < CONTACT_POINTS_STEPS; k++) {
        const double place = contact_points_reaching(&outer, inner, level);
        if (place == outer.place) break;
        const Probe found = probe_at(pair, place);
        if (found.depth < level)
            outer = found;
        else
            inner = place;
    }
    return outer.place;
}

/* Return the place between two probes where the depth is `level`, or that of the probe on whose side it is. */
static double place_between(const ContactPair *pair, Probe deeper, Probe other, double level) {
    if (deeper.depth <= level) return deeper.place;
    if (other.depth >= level) return other.place;
    return place_of_depth(pair, other, deeper.place, level);
}

/* Add the integration points between two probes with monotone depth between them. */
static void add_side(const ContactPair *pair, Probe one, Probe two, Pressed *pressed) {
    static const double levels[] = CONTACT_POINTS_LEVELS;
    static const double parts[] = CONTACT_POINTS_PARTS;
    static const double weights[] = CONTACT_POINTS_WEIGHTS;
    const Probe deeper = one.depth > two.depth ? one : two;
    const Probe other = one.depth > two.depth ? two : one;
    double before = deeper.place;
    double place;
    for (int k = 0; k < (int)(sizeof levels / sizeof *levels); k++, before = place) {
        const double level = levels[k] * pair->diameter;
        place = place_between(pair, deeper, other, level);
        if (place == before) continue; /* nothing between the levels */
        for (int n = 0; n < CONTACT_POINTS; n++)
            contact_point(parts[n], weights[n], before, place, pressed->points[pressed->count++]);
    }
}

/* Find the integration points where a body presses an element. */
static void find_pressed(const System *sys, int element, int body, const double *q, Pressed *pressed) {
    const double *a = q + (size_t)element * DOF;
    const ContactPair pair = {.a = a,
                              .b = a + DOF,
                              .l = sys->lengths[element],
                              .diameter = sys->obstacles->scene->rope.diameter,
                              .body = &sys->obstacles->placed[body].body};
    pressed->count = 0;
    if (!(sys->obstacles->near[element] & 1u << body)) return;
    Probe start = probe_at(&pair, 0.0);
    for (int cell = 1; cell <= CONTACT_POINTS_CELLS; cell++) {
        const Probe stop = probe_at(&pair, (double)cell / CONTACT_POINTS_CELLS);
        const Probe turn = turn_between(&pair, start, stop);
        add_side(&pair, start, turn, pressed);
        add_side(&pair, turn, stop, pressed);
        start = stop;
    }
}

/* Contact law at an integration point. */
typedef struct {
    double N[4];
    double weight;
    ContactTerms terms;
} ContactPoint;

static ContactPoint contact_point_of(const System *sys, int element, int body, const double point[POINT_NUMBERS],
                                     const double *q, const double *v, double c_q, double c_v) {
    const Obstacles *obstacles = sys->obstacles;
    ContactPoint found = {.weight = sys->lengths[element] * point[WEIGHT]};
    double r[3], speed[3];
    hermite_shape_functions(point[COORDINATE], sys->lengths[element], found.N);
    at_places(q, element, found.N, r);
    at_places(v, element, found.N, speed);
    found.terms = contact_law(&obstacles->scene->shaft.contact, obstacles->scene->rope.diameter,
                              &obstacles->placed[body].body, obstacles->speeds[body], r, speed, c_q, c_v);
    return found;
}

void contact_residual(const System *sys, int element, const double *q, const double *v, double R[CONTACT_DOF]) {
    Pressed pressed;
    memset(R, 0, sizeof(double) * CONTACT_DOF);
    for (int body = 0; body < sys->obstacles->bodies; body++) {
        find_pressed(sys, element, body, q, &pressed);
        for (int n = 0; n < pressed.count; n++) {
            const ContactPoint point = contact_point_of(sys, element, body, pressed.points[n], q, v, 0, 0);
            for (int k = 0; k < CONTACT_DOF; k++) R[k] -= point.weight * point.N[k / 3] * point.terms.force[k % 3];
        }
    }
}

void contact_tangent(const System *sys, int element, const double *q, const double *v, const TangentCoefficients *c,
                     double tangent[CONTACT_DOF][CONTACT_DOF]) {
    static const int upper[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Pressed pressed;
    memset(tangent, 0, sizeof(double) * CONTACT_DOF * CONTACT_DOF);
    for (int body = 0; body < sys->obstacles->bodies; body++) {
        find_pressed(sys, element, body, q, &pressed);
        for (int index = 0; index < pressed.count; index++) {
            const ContactPoint point = contact_point_of(sys, element, body, pressed.points[index], q, v, c->q, c->v);
            for (int k = 0; k < CONTACT_DOF; k++)
                for (int n = k; n < CONTACT_DOF; n++)
                    tangent[k][n] +=
                        point.weight * point.N[k / 3] * point.N[n / 3] * point.terms.tangent[upper[k % 3][n % 3]];
        }
    }
}

void contact_sums(const System *sys, int element, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    Pressed pressed;
    for (int body = 0; body < sys->obstacles->bodies; body++) {
        find_pressed(sys, element, body, q, &pressed);
        for (int n = 0; n < pressed.count; n++) {
            const ContactPoint point = contact_point_of(sys, element, body, pressed.points[n], q, v, 0, 0);
            for (int k = 0; k < CONTACT_FORCES; k++) sums[k] += point.weight * point.terms.sums[k];
            sums[CONTACT_FORCES + sys->obstacles->placed[body].kind] += point.weight * point.terms.sums[CONTACT_FORCES];
        }
    }
}
