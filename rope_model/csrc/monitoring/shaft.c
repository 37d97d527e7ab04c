/* Clearances of the rope from the bodies of its scene, and passages of the rope through itself.

   The clearance from a kind of bodies is the least distance of the rope's surface from them, over the whole
   centre line. A piece of an element is halved as long as the upright box about it is nearer to the body than the
   nearest known point, by BODIES_RESOLUTION or more. A straight leg along a wall fills no such box, so it costs no more
   than its nodes. For a conveyance and its head ropes only the other leg counts, from the lowest node on: the
   rope's own end hangs below them.

   The rope overlaps itself where contact would press it, or presses it (self_contact). The legs pass through each
   other, or one of them through conveyance or head ropes above the other's end, if the turns over the height
   (loop_turns) jump by one, while the loop's yaw, which is counted in time, does not. */

#include "shaft.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "bodies.h"
#include "formulas.h"
#include "loop.h"
#include "rope.h"
#include "self_contact.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"

/* Search for the place nearest to a body, in the part of the rope between two nodes. */
typedef struct {
    Placed placed;
    int first;     /* node */
    int last;      /* node */
    double radius; /* of the rope, m */
    double t;
    Nearest nearest; /* so far */
} NearestSearch;

/* True if contents of the box may be nearer than the nearest place so far. */
static bool may_be_nearer(const NearestSearch *search, const double box[6]) {
    const double least = shaft_min_distance(box, box + 3, &search->placed.body);
    return least - search->radius < search->nearest.clearance - BODIES_RESOLUTION;
}

/* Update the search with a place at arc length s. */
static void probe(NearestSearch *search, double s, const double *place) {
    const double clearance = shaft_distance(place, &search->placed.body) - search->radius;
    const double known = search->nearest.clearance;
    if (!(clearance < known)) return;
    const double touched = clearance <= 0 && 0 < known ? search->t : search->nearest.touched_at;
    search->nearest =
        (Nearest){.clearance = clearance, .time = search->t, .s = s, .y = place[UP], .touched_at = touched};
}

/* Search a piece of this length from s on, between the places and slopes a and b, by bisection. */
static void refine(NearestSearch *search, double s, double length, const double *a, const double *b) {
    double box[6], between[6];
    centreline_enclosing_box(length, a, b, box);
    if (!may_be_nearer(search, box)) return;
    const double half = 0.5 * length;
    centreline_middle(length, a, b, between);
    probe(search, s + half, between);
    refine(search, s, half, a, between);
    refine(search, s + half, half, between, b);
}

/* Begin a search for each body from the known nearest places; return their number. */
static int searches_of(const Scene *scene, const NodalArrays *nodal, double t, const Nearest nearest[KINDS],
                       NearestSearch *searches) {
    const double *const ends[2] = {nodal->q, end_row(nodal->q, nodal->nodes, RIGHT)};
    Placed bodies[MAX_BODIES];
    const int count = placed_bodies(&scene->shaft, ends, bodies);
    const int lowest = count > 0 ? lowest_node(nodal->nodes, nodal->q) : 0;
    for (int n = 0; n < count; n++) {
        const int first = bodies[n].moves_with == LEFT ? lowest : 0;
        const int last = bodies[n].moves_with == RIGHT ? lowest : nodal->elements;
        searches[n] = (NearestSearch){.placed = bodies[n],
                                      .first = first,
                                      .last = last,
                                      .radius = 0.5 * scene->rope.diameter,
                                      .t = t,
                                      .nearest = nearest[bodies[n].kind]};
    }
    return count;
}

static void nearest_of(int count, const NearestSearch *searches, Nearest nearest[KINDS]) {
    for (int n = 0; n < count; n++) {
        Nearest *known = &nearest[searches[n].placed.kind];
        if (searches[n].nearest.clearance < known->clearance) *known = searches[n].nearest;
    }
}

static void search_elements(NearestSearch *search, const NodalArrays *nodal, int first, int last) {
    for (int k = first; k < last; k++) {
        const double *a = nodal->q + (size_t)k * DOF;
        const double *b = a + DOF;
        double box[6];
        if (k < search->first || k >= search->last) continue;
        centreline_enclosing_box(nodal->lengths[k], a, b, box);
        if (!may_be_nearer(search, box)) continue;
        probe(search, nodal->s[k], a);
        probe(search, nodal->s[k + 1], b);
        refine(search, nodal->s[k], nodal->lengths[k], a, b);
    }
}

void shaft_nearer(const Scene *scene, const NodalArrays *nodal, double t, Nearest nearest[KINDS]) {
    NearestSearch searches[MAX_BODIES];
    const int count = searches_of(scene, nodal, t, nearest, searches);
    int first = 0;
    while (count > 0 && first < nodal->elements) {
        double box[6];
        const int last = bodies_group(nodal->elements, nodal->lengths, nodal->q, first, box);
        for (int n = 0; n < count; n++)
            if (first < searches[n].last && searches[n].first < last && may_be_nearer(&searches[n], box))
                search_elements(&searches[n], nodal, first, last);
        first = last;
    }
    nearest_of(count, searches, nearest);
}

void shaft_clearances(const Scene *scene, const NodalArrays *nodal, double t, Nearest nearest[KINDS]) {
    NearestSearch searches[MAX_BODIES];
    far_bodies(nearest);
    const int count = searches_of(scene, nodal, t, nearest, searches);
    for (int n = 0; n < count; n++)
        for (int k = searches[n].first; k <= searches[n].last; k++)
            probe(&searches[n], nodal->s[k], nodal->q + (size_t)k * DOF);
    nearest_of(count, searches, nearest);
    shaft_nearer(scene, nodal, t, nearest);
}

/* Update the largest penetration of the rope into itself. */
static void update_overlap(SelfContactState *self_contact, double diameter, State *state) {
    const NodalArrays nodal = state_arrays(state);
    Crossing *crossing = &state->crossing;
    const System sys = {.elements = nodal.elements, .lengths = nodal.lengths, .self_contact = self_contact};
    find_self_contacts(&sys, nodal.q, nodal.v, 0, 0);
    const double overlap = diameter - self_contact->least_distance;
    if (!(overlap > crossing->overlap)) return;
    if (crossing->overlap == 0) crossing->touched_at = state->t;
    crossing->overlap = overlap;
    crossing->touched_y = self_contact->least_y;
}

void update_passages(const Scene *scene, SelfContactState *self_contact, State *state) {
    const NodalArrays nodal = state_arrays(state);
    Crossing *crossing = &state->crossing;
    state->monitored_at = state->t;
    shaft_nearer(scene, &nodal, state->t, state->nearest);
    const double line = ends_yaw(&nodal);
    double across[2];
    centreline_heading(line, across);
    const bool near = !legs_apart(&nodal, across, scene->rope.diameter, scene->layout.spacing);
    if (near || self_contact->presses) update_overlap(self_contact, scene->rope.diameter, state);
    if (!near && crossing->net == 0 && fabs(state->loop_yaw - line) <= BODIES_TURNED_FAR) return;
    const LoopBottom bottom = loop_bottom(nodal.nodes, nodal.q, nodal.s);
    const LoopTurns turns = loop_turns(&nodal, &bottom);
    const double net = elementary_nearest_whole(
        centreline_turns(centreline_nearest_turn(bottom.yaw, state->loop_yaw), line, turns.number));
    if (net != crossing->net && crossing->number == 0) {
        crossing->since = state->t;
        crossing->y = turns.sharpest_y;
    }
    crossing->number += fabs(net - crossing->net);
    crossing->net = net;
}
