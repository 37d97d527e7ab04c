/* The bodies of a scene, and the rope among them: the port of rope_model.simulation.contact.shaft. */
#include "bodies.h"

#include <string.h>

/* elements that are looked at together first */
enum { GROUP = 12 };

static int add(Placed *bodies, int number, int kind, int moves_with, Body body) {
    bodies[number] = (Placed){kind, moves_with, body};
    return number + 1;
}

int shaft_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies) {
    const Divider dividers[] = {shaft->divider_1, shaft->divider_2, shaft->divider_3, shaft->divider_4};
    int n = 0;
    if (shaft->lining.width > 0) n = add(bodies, n, LINING, FIXED, lining_body(&shaft->lining));
    for (int side = LEFT; side <= RIGHT; side++) {
        if (shaft->conveyance.width > 0)
            n = add(bodies, n, CONVEYANCE, side, conveyance_body(&shaft->conveyance, ends[side]));
        if (shaft->head_ropes.diameter > 0)
            n = add(bodies, n, HEAD_ROPES, side, head_ropes_body(&shaft->head_ropes, &shaft->conveyance, ends[side]));
    }
    for (int k = 0; k < 4; k++)
        if (dividers[k].size > 0) n = add(bodies, n, DIVIDER, FIXED, divider_body(&dividers[k]));
    if (shaft->sump.level > -FAR) n = add(bodies, n, FLOOR, FIXED, floor_body(&shaft->sump));
    return n;
}

void shaft_not_near(Nearest nearest[KINDS]) {
    memset(nearest, 0, KINDS * sizeof *nearest);
    for (int kind = 0; kind < KINDS; kind++) nearest[kind].clearance = FAR;
}

/* the part of the rope between two nodes, and its place that is nearest to a body */
typedef struct {
    Placed placed;
    int first, last;
    double radius, t;
    Nearest nearest;
} Search;

/* whether what is in the box may be nearer than what is known */
static int beats(const Search *search, const double box[6]) {
    const double least = body_least_distance(box, box + 3, &search->placed.body);
    return least - search->radius < search->nearest.clearance - RESOLUTION;
}

static void look(Search *search, double s, const double *place) {
    const double clearance = body_distance(place, &search->placed.body) - search->radius;
    const double known = search->nearest.clearance;
    if (!(clearance < known)) return;
    const double touched = clearance <= 0 && 0 < known ? search->t : search->nearest.touched_at;
    search->nearest = (Nearest){clearance, search->t, s, place[1], touched};
}

/* the piece of this length from s on, between the places and slopes a and b */
static void refine(Search *search, double s, double length, const double *a, const double *b) {
    double box[6], between[6];
    enclosing_box(length, a, b, box);
    if (!beats(search, box)) return;
    const double half = 0.5 * length;
    middle_of(length, a, b, between);
    look(search, s + half, between);
    refine(search, s, half, a, between);
    refine(search, s + half, half, between, b);
}

/* one for each body, all from what is known: their number */
static int searches_of(const Scene *scene, const Arrays *m, double t, const Nearest nearest[KINDS], Search *searches) {
    const double *const ends[2] = {m->q, m->q + (size_t)m->elements * DOF};
    Placed bodies[MOST_BODIES];
    const int number = shaft_bodies(&scene->shaft, ends, bodies);
    const int lowest = number > 0 ? shape_lowest_node(m->nodes, m->q) : 0;
    for (int n = 0; n < number; n++) {
        const int first = bodies[n].moves_with == LEFT ? lowest : 0;
        const int last = bodies[n].moves_with == RIGHT ? lowest : m->elements;
        searches[n] = (Search){bodies[n], first, last, 0.5 * scene->rope.diameter, t, nearest[bodies[n].kind]};
    }
    return number;
}

static void take_nearest(int number, const Search *searches, Nearest nearest[KINDS]) {
    for (int n = 0; n < number; n++) {
        Nearest *known = &nearest[searches[n].placed.kind];
        if (searches[n].nearest.clearance < known->clearance) *known = searches[n].nearest;
    }
}

/* of the elements from first to last */
static void look_along(Search *search, const Arrays *m, int first, int last) {
    for (int k = first; k < last; k++) {
        const double *a = m->q + (size_t)k * DOF, *b = a + DOF;
        double box[6];
        if (k < search->first || k >= search->last) continue;
        enclosing_box(m->lengths[k], a, b, box);
        if (!beats(search, box)) continue;
        look(search, m->s[k], a);
        look(search, m->s[k + 1], b);
        refine(search, m->s[k], m->lengths[k], a, b);
    }
}

int shaft_group(int elements, const double *lengths, const double *q, int first, double box[6]) {
    const double *a = q + (size_t)first * DOF, *b = a + DOF;
    double bounds[6] = {a[0], a[1], a[2], a[0], a[1], a[2]};
    int last = first;
    for (; last < elements && last < first + GROUP; last++, a = b, b += DOF)
        for (int i = 0; i < 3; i++) {
            bounds[i] = lowest_on(bounds[i], lengths[last], a[i], a[SLOPE + i], b[i], b[SLOPE + i]);
            bounds[3 + i] = highest_on(bounds[3 + i], lengths[last], a[i], a[SLOPE + i], b[i], b[SLOPE + i]);
        }
    box_between(bounds, box);
    return last;
}

void shaft_nearer(const Scene *scene, const Arrays *m, double t, Nearest nearest[KINDS]) {
    Search searches[MOST_BODIES];
    const int number = searches_of(scene, m, t, nearest, searches);
    for (int first = 0, last; number > 0 && first < m->elements; first = last) {
        double box[6];
        last = shaft_group(m->elements, m->lengths, m->q, first, box);
        for (int n = 0; n < number; n++)
            if (first < searches[n].last && searches[n].first < last && beats(&searches[n], box))
                look_along(&searches[n], m, first, last);
    }
    take_nearest(number, searches, nearest);
}

void shaft_clearances(const Scene *scene, const Arrays *m, double t, Nearest nearest[KINDS]) {
    Search searches[MOST_BODIES];
    shaft_not_near(nearest);
    const int number = searches_of(scene, m, t, nearest, searches);
    for (int n = 0; n < number; n++)
        for (int k = searches[n].first; k <= searches[n].last; k++) look(&searches[n], m->s[k], m->q + (size_t)k * DOF);
    take_nearest(number, searches, nearest);
    shaft_nearer(scene, m, t, nearest);
}
