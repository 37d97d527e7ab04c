/* Clearance between the legs, shape and tension along the rope; s (nodes) are arc lengths of nodes, m. */
#ifndef DIAGNOSTICS_H
#define DIAGNOSTICS_H

#include "loop.h"
#include "state_structures.h"

/* Return the smallest clearance between the legs, m, from `above` the loop's bottom upwards.  `pair`, not negative, has
   the blocks that were nearest in the last call, to speed up the search.  Takes 10 kB of stack. */
double leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                     double diameter, double above, int pair[2]);
/* Ascending arc lengths `places` (points) over the whole rope, denser around the bottom; `loop` is
 * estimates_loop_width(). */
void shape_places(double total, double bottom_s, double loop, int points, double *places);
/* Coordinates xyz (points x 3) of the centre line at arc lengths `places`, which ascend. */
void diagnostics_shape(int nodes, const double *q, const double *s, int points, const double *places, double (*xyz)[3]);
/* Tension (points), N, at arc lengths `places`, which ascend, by the balance of momentum to the left of them. */
void diagnostics_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                         double *tension);

#endif
