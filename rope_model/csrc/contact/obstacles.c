/* Bodies around a rope for its equations of motion: positions, velocities, and distances from its elements.

   A moving body follows an end of the rope, whose rows in q and v give its position and velocity. Rope below a
   conveyance touches neither it nor its head ropes within CONTACT_UNCHECKED_LENGTH of the suspension. */

#include "obstacles.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "bodies.h"
#include "formulas.h"
#include "rope.h"
#include "state.h"
#include "system.h"

void remember_configuration(const System *sys, ClearanceCache *cache, const double *q) {
    memcpy(cache->q, q, sizeof(double) * DOF * (size_t)(sys->elements + 1));
    memcpy(cache->lengths, sys->lengths, sizeof(double) * (size_t)sys->elements);
    cache->free = INFINITY;
}

bool clearance_exceeds(const System *sys, const ClearanceCache *cache, const double *q, double least) {
    const double *before = cache->q;
    const double *l = sys->lengths;
    if (!(cache->free > least) || memcmp(cache->lengths, l, sizeof(double) * (size_t)sys->elements) != 0) return false;
    for (int node = 0; node <= sys->elements; node++, q += DOF, before += DOF) {
        const double longest = maximum(l[node > 0 ? node - 1 : 0], l[node < sys->elements ? node : node - 1]);
        if (!(cache->free - contact_largest_motion(longest, q, before) > least))
            return false; /* also if it is not a number */
    }
    return true;
}

static void place_bodies(const System *sys, const double *q, const double *v) {
    Obstacles *obstacles = sys->obstacles;
    const int nodes = sys->elements + 1;
    const double *const ends[2] = {q, end_row(q, nodes, RIGHT)};
    const double *const speeds[2] = {v, end_row(v, nodes, RIGHT)};
    obstacles->bodies = placed_bodies(&obstacles->scene->shaft, ends, obstacles->placed);
    for (int k = 0; k < obstacles->bodies; k++) {
        const int end = obstacles->placed[k].moves_with;
        for (int i = 0; i < 3; i++) obstacles->speeds[k][i] = end == FIXED ? 0 : speeds[end][i];
    }
}

/* Return a lower bound of the distance of the rope's surface in a box from body k. */
static double min_distance(const System *sys, int k, const double box[6]) {
    return shaft_min_distance(box, box + 3, &sys->obstacles->placed[k].body) -
           0.5 * sys->obstacles->scene->rope.diameter;
}

/* Mark elements from first (at arc length along) to last nearer to body k than margin; return true for new ones. */
static bool search_elements(const System *sys, const double *q, int k, int first, int last, double along, double total,
                            double margin) {
    Obstacles *obstacles = sys->obstacles;
    const int side = obstacles->placed[k].moves_with;
    bool added = false;
    for (int e = first; e < last; along += sys->lengths[e++]) {
        const double middle = along + 0.5 * sys->lengths[e];
        const double *x = q + (size_t)e * DOF;
        double box[6];
        if (side != FIXED && (side == LEFT ? middle : total - middle) < CONTACT_UNCHECKED_LENGTH) continue;
        centreline_enclosing_box(sys->lengths[e], x, x + DOF, box);
        const double distance = min_distance(sys, k, box);
        obstacles->cache.free = minimum(obstacles->cache.free, distance);
        if (!(distance < margin) || obstacles->near[e] & 1u << k) continue;
        obstacles->near[e] |= 1u << k;
        added = obstacles->any = true;
    }
    return added;
}

/* Find all elements nearer to a body than margin, besides the marks to keep; return true if there are new ones. */
static bool search_bodies(const System *sys, const double *q, double margin, unsigned keep) {
    Obstacles *obstacles = sys->obstacles;
    double total = 0;
    double along = 0;
    bool added = false;
    remember_configuration(sys, &obstacles->cache, q);
    obstacles->longest = 0;
    obstacles->any = false;
    for (int e = 0; e < sys->elements; e++) {
        total += sys->lengths[e];
        obstacles->longest = maximum(obstacles->longest, sys->lengths[e]);
        obstacles->near[e] &= keep;
        obstacles->any |= obstacles->near[e] != 0;
    }
    int first = 0;
    while (first < sys->elements) {
        double box[6];
        const int last = bodies_group(sys->elements, sys->lengths, q, first, box);
        for (int k = 0; k < obstacles->bodies; k++)
            if (!(min_distance(sys, k, box) >= maximum(margin, obstacles->cache.free)))
                added |= search_elements(sys, q, k, first, last, along, total, margin);
        for (int e = first; e < last; e++) along += sys->lengths[e];
        first = last;
    }
    return added;
}

void find_near_bodies(const System *sys, const double *q, const double *v, double margin) {
    if (sys->obstacles == NULL) return;
    sys->obstacles->margin = margin;
    if (!sys->obstacles->any && clearance_exceeds(sys, &sys->obstacles->cache, q, margin)) return;
    place_bodies(sys, q, v);
    search_bodies(sys, q, margin, 0);
}

bool add_near_bodies(const System *sys, const double *q, double corrections) {
    Obstacles *obstacles = sys->obstacles;
    if (obstacles == NULL ||
        contact_correction_motion(corrections, obstacles->longest, sys->shortest) < obstacles->margin)
        return false;
    obstacles->margin = 0;
    return !clearance_exceeds(sys, &obstacles->cache, q, 0) && search_bodies(sys, q, 0, ~0u);
}

double longest_near(const System *sys) {
    double longest = 0;
    if (!near_bodies(sys)) return 0;
    for (int e = 0; e < sys->elements; e++)
        if (sys->obstacles->near[e]) longest = maximum(longest, sys->lengths[e]);
    return longest;
}
