/* Contact of the rope with bodies in the shaft: rope_model.simulation.contact.surroundings and
   physics.contact_element. */

#include <string.h>

#include "rope_system.h"

void see(const System *s, Seen *seen, const double *q) {
    memcpy(seen->q, q, sizeof(double) * DOF * (size_t)(s->elements + 1));
    memcpy(seen->lengths, s->lengths, sizeof(double) * (size_t)s->elements);
    seen->free = INFINITY;
}

int still_free(const System *s, const Seen *seen, const double *q, double least) {
    const double *before = seen->q, *l = s->lengths;
    if (!(seen->free > least) || memcmp(seen->lengths, l, sizeof(double) * (size_t)s->elements) != 0) return 0;
    for (int node = 0; node <= s->elements; node++, q += DOF, before += DOF) {
        const double longest = larger(l[node > 0 ? node - 1 : 0], l[node < s->elements ? node : node - 1]);
        if (!(seen->free - largest_motion(longest, q, before) > least)) return 0; /* what is not a number is near */
    }
    return 1;
}

/* the bodies as the ends hold them */
static void place_bodies(const System *s, const double *q, const double *v) {
    Surroundings *around = s->around;
    const size_t last = (size_t)s->elements * DOF;
    const double *const ends[2] = {q, q + last}, *const speeds[2] = {v, v + last};
    around->bodies = shaft_bodies(&around->scene->shaft, ends, around->placed);
    for (int k = 0; k < around->bodies; k++) {
        const int end = around->placed[k].moves_with;
        for (int i = 0; i < 3; i++) around->speeds[k][i] = end == FIXED ? 0 : speeds[end][i];
    }
}

/* what the distance of the surface of what is in a box from body k is at least */
static double least_distance(const System *s, int k, const double box[6]) {
    return body_least_distance(box, box + 3, &s->around->placed[k].body) - 0.5 * s->around->scene->rope.diameter;
}

/* looks for body k among the elements from first, at arc length along, to last; whether more of them are nearer than
   margin; total: the rope's length */
static int look_at(const System *s, const double *q, int k, int first, int last, double along, double total,
                   double margin) {
    Surroundings *around = s->around;
    const int with = around->placed[k].moves_with;
    int more = 0;
    for (int e = first; e < last; along += s->lengths[e++]) {
        const double middle = along + 0.5 * s->lengths[e], *x = q + (size_t)e * DOF;
        double box[6];
        if (with != FIXED && (with == LEFT ? middle : total - middle) < OWN_LENGTH) continue;
        enclosing_box(s->lengths[e], x, x + DOF, box);
        const double distance = least_distance(s, k, box);
        around->seen.free = smaller(around->seen.free, distance);
        if (!(distance < margin) || around->near[e] & 1u << k) continue;
        around->near[e] |= 1u << k;
        more = around->any = 1;
    }
    return more;
}

/* sees, besides those to keep, which elements are nearer than margin; whether there are any */
static int look(const System *s, const double *q, double margin, unsigned keep) {
    Surroundings *around = s->around;
    double total = 0, at = 0;
    int more = 0;
    see(s, &around->seen, q);
    around->longest = around->any = 0;
    for (int e = 0; e < s->elements; total += s->lengths[e++]) {
        around->longest = larger(around->longest, s->lengths[e]);
        around->near[e] &= keep;
        around->any |= around->near[e] != 0;
    }
    for (int first = 0, last; first < s->elements; first = last) {
        double box[6];
        last = shaft_group(s->elements, s->lengths, q, first, box);
        for (int k = 0; k < around->bodies; k++)
            if (!(least_distance(s, k, box) >= larger(margin, around->seen.free)))
                more |= look_at(s, q, k, first, last, at, total, margin);
        for (int e = first; e < last; e++) at += s->lengths[e];
    }
    return more;
}

void look_for_bodies(const System *s, const double *q, const double *v, double margin) {
    if (s->around == NULL) return;
    s->around->margin = margin;
    if (!s->around->any && still_free(s, &s->around->seen, q, margin)) return;
    place_bodies(s, q, v);
    look(s, q, margin, 0);
}

int see_more_bodies(const System *s, const double *q, double corrections) {
    if (s->around == NULL || moved_by(corrections, s->around->longest, s->shortest) < s->around->margin) return 0;
    s->around->margin = 0;
    return !still_free(s, &s->around->seen, q, 0) && look(s, q, 0, ~0u);
}

double longest_near(const System *s) {
    double longest = 0;
    for (int e = 0; s->around != NULL && s->around->any && e < s->elements; e++)
        if (s->around->near[e]) longest = larger(longest, s->lengths[e]);
    return longest;
}

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
    double shares[4], weight;
    Touch law;
} Place;

static Place place_of(const System *s, int element, int k, const double point[2], const double *q, const double *v,
                      double cq, double cv) {
    const Surroundings *around = s->around;
    Place place = {.weight = s->lengths[element] * point[1]};
    double at[3], speed[3];
    hermite_shares(point[0], s->lengths[element], place.shares);
    place_on(q, element, place.shares, at);
    place_on(v, element, place.shares, speed);
    place.law = touch(&around->scene->shaft.contact, around->scene->rope.diameter, &around->placed[k].body,
                      around->speeds[k], at, speed, cq, cv);
    return place;
}

void contact_force(const System *s, int element, const double *q, const double *v, double force[CONTACT_DOF]) {
    Pressed pressed;
    memset(force, 0, sizeof(double) * CONTACT_DOF);
    for (int body = 0; body < s->around->bodies; body++) {
        find_pressed(s, element, body, q, &pressed);
        for (int n = 0; n < pressed.number; n++) {
            const Place at = place_of(s, element, body, pressed.points[n], q, v, 0, 0);
            for (int k = 0; k < CONTACT_DOF; k++) force[k] += at.weight * at.shares[k / 3] * at.law.force[k % 3];
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
                    tangent[k][n] +=
                        at.weight * at.shares[k / 3] * at.shares[n / 3] * at.law.tangent[upper[k % 3][n % 3]];
        }
    }
}

void contact_balance(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]) {
    Pressed pressed;
    memset(sums, 0, sizeof(double) * CONTACT_BALANCE);
    add_rope_balance(s, q, v, sums);
    add_point_balance(s, q, v, sums);
    if (s->around == NULL) return;
    look_for_bodies(s, q, v, 0);
    for (int e = 0; s->around->any && e < s->elements; e++)
        for (int body = 0; s->around->near[e] && body < s->around->bodies; body++) {
            find_pressed(s, e, body, q, &pressed);
            for (int n = 0; n < pressed.number; n++) {
                const Place at = place_of(s, e, body, pressed.points[n], q, v, 0, 0);
                for (int k = 0; k < CONTACT_FORCES; k++) sums[k] += at.weight * at.law.sums[k];
                sums[CONTACT_FORCES + s->around->placed[body].kind] += at.weight * at.law.sums[CONTACT_FORCES];
            }
        }
}
