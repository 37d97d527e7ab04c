/* Which elements are near the bodies of a scene: rope_model.simulation.contact.surroundings. */

#include "rope_system.h"

void remember_configuration(const System *s, ClearanceCache *seen, const double *q) {
    memcpy(seen->q, q, sizeof(double) * DOF * (size_t)(s->elements + 1));
    memcpy(seen->lengths, s->lengths, sizeof(double) * (size_t)s->elements);
    seen->free = INFINITY;
}

int clearance_exceeds(const System *s, const ClearanceCache *seen, const double *q, double least) {
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
    around->bodies = placed_bodies(&around->scene->shaft, ends, around->placed);
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
    remember_configuration(s, &around->seen, q);
    around->longest = around->any = 0;
    for (int e = 0; e < s->elements; total += s->lengths[e++]) {
        around->longest = larger(around->longest, s->lengths[e]);
        around->near[e] &= keep;
        around->any |= around->near[e] != 0;
    }
    for (int first = 0, last; first < s->elements; first = last) {
        double box[6];
        last = bodies_group(s->elements, s->lengths, q, first, box);
        for (int k = 0; k < around->bodies; k++)
            if (!(least_distance(s, k, box) >= larger(margin, around->seen.free)))
                more |= look_at(s, q, k, first, last, at, total, margin);
        for (int e = first; e < last; e++) at += s->lengths[e];
    }
    return more;
}

void find_near_bodies(const System *s, const double *q, const double *v, double margin) {
    if (s->around == NULL) return;
    s->around->margin = margin;
    if (!s->around->any && clearance_exceeds(s, &s->around->seen, q, margin)) return;
    place_bodies(s, q, v);
    look(s, q, margin, 0);
}

int add_near_bodies(const System *s, const double *q, double corrections) {
    if (s->around == NULL || correction_motion(corrections, s->around->longest, s->shortest) < s->around->margin)
        return 0;
    s->around->margin = 0;
    return !clearance_exceeds(s, &s->around->seen, q, 0) && look(s, q, 0, ~0u);
}
