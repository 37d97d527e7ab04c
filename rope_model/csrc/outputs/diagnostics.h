/* Shape of the rope: lowest point, clearance and turns of the legs, tension; s (nodes) are arc lengths of nodes, m. */
#ifndef DIAGNOSTICS_H
#define DIAGNOSTICS_H

#include <stdbool.h>

#include "state_structures.h"

typedef struct {
    double s, position[3], yaw;
} LoopBottom;
typedef struct {
    double number;     /* turns of one side of the rope about the other */
    double sharpest_y; /* height around which they change most, m */
} LoopTurns;
double ends_yaw(const NodalArrays *nodal); /* Return the yaw of the line from the left to the right end. */
LoopBottom loop_bottom(int nodes, const double *q, const double *s);
/* Return the smallest clearance between the legs, m, from `above` the loop's bottom upwards.  `pair`, not negative, has
   the blocks that were nearest in the last call, to speed up the search.  Takes 10 kB of stack. */
double leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                     double diameter, double above, int pair[2]);
/* True if the legs are certainly apart, and within a quarter turn of `across`, the line from left to right. */
bool legs_apart(const NodalArrays *nodal, const double across[2], double diameter, double above);
LoopTurns loop_turns(const NodalArrays *nodal, const LoopBottom *bottom);
/* Ascending arc lengths `places` (points) over the whole rope, denser around the bottom; `loop` is
 * estimates_loop_width(). */
void shape_places(double total, double bottom_s, double loop, int points, double *places);
/* Coordinates xyz (points x 3) of the centre line at arc lengths `places`, which ascend. */
void diagnostics_shape(int nodes, const double *q, const double *s, int points, const double *places, double (*xyz)[3]);
/* Tension (points), N, at arc lengths `places`, which ascend, by the balance of momentum to the left of them. */
void diagnostics_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                         double *tension);
/* Return the last element from k on whose middle is at or before arc length `place`, or k. */
int middle_before(int nodes, const double *s, int k, double place);
/* Interpolate linearly between the middles of element k (`value`) and k + 1 (`next`), as numpy.interp does. */
double interpolate_midpoints(int nodes, const double *s, int k, double place, double value, double next);

#endif
