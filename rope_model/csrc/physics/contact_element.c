/* An element that touches bodies in the shaft: rope_model.physics.contact_element. */

#include "rope_system.h"

/* an element and a body that it is near */
typedef struct {
    const double *a, *b; /* the rows of its nodes */
    double l, diameter;
    const Body *body;
} Facing;

/* places that the body presses, and their weights; two monotone sides of a cell, two pieces of a side */
enum { MOST_PRESSED = 4 * CONTACT_CELLS * CONTACT_POINTS };
typedef struct {
    int number;
    double points[MOST_PRESSED][2];
} Pressed;

static Probe look_in(const Facing *facing, double place) {
    return contact_probe(place, facing->l, facing->a, facing->b, facing->diameter, facing->body);
}

/* where the depth turns between two probes, or the second of them */
static Probe turn_between(const Facing *facing, Probe start, Probe stop) {
    if (!(start.rate * stop.rate < 0)) return stop;
    for (int k = 0; k < CONTACT_HALVINGS; k++) {
        const Probe middle = look_in(facing, 0.5 * (start.place + stop.place));
        *(start.rate * middle.rate > 0 ? &start : &stop) = middle;
    }
    return look_in(facing, contact_turning(&start, &stop));
}

/* the place between them that is as deep */
static double reach(const Facing *facing, Probe outer, double inner, double level) {
    for (int k = 0; k < CONTACT_STEPS; k++) {
        const double at = contact_reaching(&outer, inner, level);
        if (at == outer.place) break;
        const Probe found = look_in(facing, at);
        if (found.depth < level)
            outer = found;
        else
            inner = at;
    }
    return outer.place;
}

/* what is pressed between two probes, between which the depth is monotone */
static void add_side(const Facing *facing, Probe one, Probe two, Pressed *pressed) {
    static const double levels[] = CONTACT_LEVELS, parts[] = CONTACT_PARTS, weights[] = CONTACT_WEIGHTS;
    const Probe deeper = one.depth > two.depth ? one : two, other = one.depth > two.depth ? two : one;
    double before = deeper.place, at;
    for (int k = 0; k < (int)(sizeof levels / sizeof *levels); k++, before = at) {
        const double level = levels[k] * facing->diameter;
        at = deeper.depth <= level  ? deeper.place
             : other.depth >= level ? other.place
                                    : reach(facing, other, deeper.place, level);
        for (int n = 0; at != before && n < CONTACT_POINTS; n++)
            contact_point(parts[n], weights[n], before, at, pressed->points[pressed->number++]);
    }
}

/* where body k presses an element */
static void find_pressed(const System *s, int element, int k, const double *q, Pressed *pressed) {
    const double *a = q + (size_t)element * DOF;
    const Facing facing = {a, a + DOF, s->lengths[element], s->around->scene->rope.diameter,
                           &s->around->placed[k].body};
    pressed->number = 0;
    if (!(s->around->near[element] & 1u << k)) return;
    Probe start = look_in(&facing, 0.0);
    for (int cell = 1; cell <= CONTACT_CELLS; cell++) {
        const Probe stop = look_in(&facing, (double)cell / CONTACT_CELLS);
        const Probe turn = turn_between(&facing, start, stop);
        add_side(&facing, start, turn, pressed);
        add_side(&facing, turn, stop, pressed);
        start = stop;
    }
}

/* what body k does at a place that it presses */
typedef struct {
    double N[4], weight;
    Touch law;
} Place;

static Place place_of(const System *s, int element, int k, const double point[2], const double *q, const double *v,
                      double cq, double cv) {
    const Surroundings *around = s->around;
    Place place = {.weight = s->lengths[element] * point[1]};
    double at[3], speed[3];
    hermite_shape_functions(point[0], s->lengths[element], place.N);
    at_places(q, element, place.N, at);
    at_places(v, element, place.N, speed);
    place.law = touch(&around->scene->shaft.contact, around->scene->rope.diameter, &around->placed[k].body,
                      around->speeds[k], at, speed, cq, cv);
    return place;
}

void contact_residual(const System *s, int element, const double *q, const double *v, double R[CONTACT_DOF]) {
    Pressed pressed;
    memset(R, 0, sizeof(double) * CONTACT_DOF);
    for (int body = 0; body < s->around->bodies; body++) {
        find_pressed(s, element, body, q, &pressed);
        for (int n = 0; n < pressed.number; n++) {
            const Place at = place_of(s, element, body, pressed.points[n], q, v, 0, 0);
            for (int k = 0; k < CONTACT_DOF; k++) R[k] -= at.weight * at.N[k / 3] * at.law.force[k % 3];
        }
    }
}

void contact_tangent(const System *s, int element, const double *q, const double *v, const double c[3],
                     double tangent[CONTACT_DOF][CONTACT_DOF]) {
    static const int upper[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Pressed pressed;
    memset(tangent, 0, sizeof(double) * CONTACT_DOF * CONTACT_DOF);
    for (int body = 0; body < s->around->bodies; body++) {
        find_pressed(s, element, body, q, &pressed);
        for (int number = 0; number < pressed.number; number++) {
            const Place at = place_of(s, element, body, pressed.points[number], q, v, c[0], c[1]);
            for (int k = 0; k < CONTACT_DOF; k++)
                for (int n = k; n < CONTACT_DOF; n++)
                    tangent[k][n] += at.weight * at.N[k / 3] * at.N[n / 3] * at.law.tangent[upper[k % 3][n % 3]];
        }
    }
}

void contact_sums(const System *s, int element, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    Pressed pressed;
    for (int body = 0; body < s->around->bodies; body++) {
        find_pressed(s, element, body, q, &pressed);
        for (int n = 0; n < pressed.number; n++) {
            const Place at = place_of(s, element, body, pressed.points[n], q, v, 0, 0);
            for (int k = 0; k < CONTACT_FORCES; k++) sums[k] += at.weight * at.law.sums[k];
            sums[CONTACT_FORCES + s->around->placed[body].kind] += at.weight * at.law.sums[CONTACT_FORCES];
        }
    }
}
