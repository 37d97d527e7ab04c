/* Fields and events of the state, and rows of its arrays. */
#ifndef STATE_H
#define STATE_H

#include <stddef.h>

#include "rope.h"
#include "state_structures.h"

/* Return the index at which the row of an end begins in an array (nodes x DOF). */
static inline size_t end_index(int nodes, int side) {
    return side == LEFT ? 0 : (size_t)(nodes - 1) * DOF;
}

/* Return the row of an end in x (nodes x DOF). */
static inline const double *end_row(const double *x, int nodes, int side) {
    return x + end_index(nodes, side);
}

/* Return the vertical reaction at an end, N. */
static inline double vertical_reaction(const NodalArrays *nodal, int side) {
    return end_row(nodal->reaction, nodal->nodes, side)[UP];
}

/* Return the node with the least height. */
static inline int lowest_node(int nodes, const double *q) {
    int lowest = 0;
    for (int k = 1; k < nodes; k++)
        if (q[(ptrdiff_t)DOF * k + UP] < q[(ptrdiff_t)DOF * lowest + UP]) lowest = k;
    return lowest;
}

/* Copy q, v, a, b, a_rate and reaction. */
void copy_fields(const NodalArrays *to, const NodalArrays *from);
void record_event(State *state, int what, int which, double kinetic, double potential);

#endif
