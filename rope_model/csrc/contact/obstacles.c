/* Elements near the bodies of a scene.  C version of rope_model/simulation/contact/obstacles.py. */

#include "rope_system.h"

void remember_configuration(const System *s, ClearanceCache *cache, const double *q) {
    memcpy(cache->q, q, sizeof(double) * DOF * (size_t)(s->elements + 1));
    memcpy(cache->lengths, s->lengths, sizeof(double) * (size_t)s->elements);
    cache->free = INFINITY;
}

int clearance_exceeds(const System *s, const ClearanceCache *cache, const double *q, double least) {
    const double *before = cache->q, *l = s->lengths;
    if (!(cache->free > least) || memcmp(cache->lengths, l, sizeof(double) * (size_t)s->elements) != 0) return 0;
    for (int node = 0; node <= s->elements; node++, q += DOF, before += DOF) {
        const double longest = maximum(l[node > 0 ? node - 1 : 0], l[node < s->elements ? node : node - 1]);
        if (!(cache->free - largest_motion(longest, q, before) > least)) return 0; /* also if it is not a number */
    }
    return 1;
}

static void place_bodies(const System *s, const double *q, const double *v) {
    Obstacles *obstacles = s->obstacles;
    const size_t last = (size_t)s->elements * DOF;
    const double *const ends[2] = {q, q + last}, *const speeds[2] = {v, v + last};
    obstacles->bodies = placed_bodies(&obstacles->scene->shaft, ends, obstacles->placed);
    for (int k = 0; k < obstacles->bodies; k++) {
        const int end = obstacles->placed[k].moves_with;
        for (int i = 0; i < 3; i++) obstacles->speeds[k][i] = end == FIXED ? 0 : speeds[end][i];
    }
}

/* Return a lower bound of the distance of the rope's surface in a box from body k. */
static double least_distance(const System *s, int k, const double box[6]) {
    return body_least_distance(box, box + 3, &s->obstacles->placed[k].body) - 0.5 * s->obstacles->scene->rope.diameter;
}

/* Mark elements from first (at arc length along) to last nearer to body k than margin; return true for new ones. */
static int search_elements(const System *s, const double *q, int k, int first, int last, double along, double total,
                           double margin) {
    Obstacles *obstacles = s->obstacles;
    const int side = obstacles->placed[k].moves_with;
    int added = 0;
    for (int e = first; e < last; along += s->lengths[e++]) {
        const double middle = along + 0.5 * s->lengths[e], *x = q + (size_t)e * DOF;
        double box[6];
        if (side != FIXED && (side == LEFT ? middle : total - middle) < OWN_LENGTH) continue;
        enclosing_box(s->lengths[e], x, x + DOF, box);
        const double distance = least_distance(s, k, box);
        obstacles->cache.free = minimum(obstacles->cache.free, distance);
        if (!(distance < margin) || obstacles->near[e] & 1u << k) continue;
        obstacles->near[e] |= 1u << k;
        added = obstacles->any = 1;
    }
    return added;
}

/* Find all elements nearer to a body than margin, besides the marks to keep; return true if there are new ones. */
static int search_bodies(const System *s, const double *q, double margin, unsigned keep) {
    Obstacles *obstacles = s->obstacles;
    double total = 0, along = 0;
    int added = 0;
    remember_configuration(s, &obstacles->cache, q);
    obstacles->longest = obstacles->any = 0;
    for (int e = 0; e < s->elements; total += s->lengths[e++]) {
        obstacles->longest = maximum(obstacles->longest, s->lengths[e]);
        obstacles->near[e] &= keep;
        obstacles->any |= obstacles->near[e] != 0;
    }
    for (int first = 0, last; first < s->elements; first = last) {
        double box[6];
        last = bodies_group(s->elements, s->lengths, q, first, box);
        for (int k = 0; k < obstacles->bodies; k++)
            if (!(least_distance(s, k, box) >= maximum(margin, obstacles->cache.free)))
                added |= search_elements(s, q, k, first, last, along, total, margin);
        for (int e = first; e < last; e++) along += s->lengths[e];
    }
    return added;
}

void find_near_bodies(const System *s, const double *q, const double *v, double margin) {
    if (s->obstacles == NULL) return;
    s->obstacles->margin = margin;
    if (!s->obstacles->any && clearance_exceeds(s, &s->obstacles->cache, q, margin)) return;
    place_bodies(s, q, v);
    search_bodies(s, q, margin, 0);
}

int add_near_bodies(const System *s, const double *q, double corrections) {
    Obstacles *obstacles = s->obstacles;
    if (obstacles == NULL || correction_motion(corrections, obstacles->longest, s->shortest) < obstacles->margin)
        return 0;
    obstacles->margin = 0;
    return !clearance_exceeds(s, &obstacles->cache, q, 0) && search_bodies(s, q, 0, ~0u);
}
