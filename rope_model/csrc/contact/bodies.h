/* Bodies of a scene at their present places. */
#ifndef BODIES_H
#define BODIES_H

#include "formulas.h"
#include "rope.h"

enum { FIXED = -1, MAX_BODIES = 10 };
typedef struct {
    int kind;
    int moves_with; /* LEFT, RIGHT or FIXED */
    Body body;
} Placed;

/* Place the bodies of the shaft for rope ends at `ends`; return their number. */
int placed_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies);
/* Box around a group of elements from `first` on, for shaft_min_distance; return the element after the group. */
int bodies_group(int elements, const double *lengths, const double *q, int first, double box[6]);

#endif
