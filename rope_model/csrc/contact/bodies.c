/* The bodies of a scene at their present places. Formulas: rope_model/physics/shaft.py. */

#include "bodies.h"

#include <stddef.h>

#include "formulas.h"
#include "rope.h"
#include "state_structures.h"

enum { GROUP = 12 }; /* elements that share a box in the broad phase of contact detection */

static int add(Placed *bodies, int count, int kind, int moves_with, Body body) {
    bodies[count] = (Placed){.kind = kind, .moves_with = moves_with, .body = body};
    return count + 1;
}

int placed_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies) {
    const Divider dividers[] = {shaft->divider_1, shaft->divider_2, shaft->divider_3, shaft->divider_4};
    int n = 0;
    if (shaft->lining.width > 0) n = add(bodies, n, LINING, FIXED, shaft_lining(&shaft->lining));
    for (int side = LEFT; side <= RIGHT; side++) {
        if (shaft->conveyance.width > 0)
            n = add(bodies, n, CONVEYANCE, side, shaft_conveyance(&shaft->conveyance, ends[side]));
        if (shaft->head_ropes.diameter > 0)
            n = add(bodies, n, HEAD_ROPES, side, shaft_head_ropes(&shaft->head_ropes, &shaft->conveyance, ends[side]));
    }
    for (int k = 0; k < 4; k++)
        if (dividers[k].size > 0) n = add(bodies, n, DIVIDER, FIXED, shaft_divider(&dividers[k]));
    if (shaft->sump.level > -FAR) n = add(bodies, n, FLOOR, FIXED, shaft_floor(&shaft->sump));
    return n;
}

int bodies_group(int elements, const double *lengths, const double *q, int first, double box[6]) {
    const double *a = q + (size_t)first * DOF;
    const double *b = a + DOF;
    double bounds[6] = {a[0], a[1], a[2], a[0], a[1], a[2]};
    int last = first;
    for (; last < elements && last < first + GROUP; last++, a = b, b += DOF)
        for (int i = 0; i < 3; i++) {
            bounds[i] = centreline_lower_bound(bounds[i], lengths[last], a[i], a[SLOPE + i], b[i], b[SLOPE + i]);
            bounds[3 + i] =
                centreline_upper_bound(bounds[3 + i], lengths[last], a[i], a[SLOPE + i], b[i], b[SLOPE + i]);
        }
    centreline_box_between(bounds, box);
    return last;
}
