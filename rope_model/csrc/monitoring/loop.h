/* Shape of the loop: lowest point, yaw, and turns of its sides; s (nodes) are arc lengths of nodes, m. */
#ifndef LOOP_H
#define LOOP_H

#include <stdbool.h>

#include "state_structures.h"

typedef struct {
    double s;           /* arc length, m */
    double position[3]; /* m */
    double yaw;         /* of the tangent, rad */
} LoopBottom;
typedef struct {
    double number;     /* turns of one side of the rope about the other */
    double sharpest_y; /* height around which they change most, m */
} LoopTurns;
double ends_yaw(const NodalArrays *nodal); /* Return the yaw of the line from the left to the right end. */
LoopBottom loop_bottom(int nodes, const double *q, const double *s);
/* True if the legs are certainly apart, and within a quarter turn of `across`, the line from left to right. */
bool legs_apart(const NodalArrays *nodal, const double across[2], double diameter, double above);
LoopTurns loop_turns(const NodalArrays *nodal, const LoopBottom *bottom);

#endif
