/* Transfer of nodal fields between meshes, and interpolation between nodes; s (nodes) are their arc lengths, m. */
#ifndef TRANSFER_H
#define TRANSFER_H

#include "rope.h"

/* Return the difference below which two arc lengths of a rope are equal, m. */
double place_tolerance(double length);

/* Interpolate x (nodes x DOF) at arc lengths `places`: y (count x DOF). */
void transfer_interpolate(int nodes, const double *x, const double *s, int count, const double *places,
                          double (*y)[DOF]);
/* Return the last element from k on whose middle is at or before arc length `place`, or k. */
int middle_before(int nodes, const double *s, int k, double place);
/* Interpolate linearly between the middles of element k (`value`) and k + 1 (`next`), as numpy.interp does. */
double interpolate_midpoints(int nodes, const double *s, int k, double place, double value, double next);
/* Transfer up to 8 fields x (nodes x DOF) between meshes; `work` has TRANSFER_WORK(fields) numbers a node. */
#define TRANSFER_WORK(fields) (10 + 14 * (fields))
void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work);

#endif
