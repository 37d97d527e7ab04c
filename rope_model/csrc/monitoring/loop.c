/* Shape of the loop: lowest point, yaw, and turns of its sides about each other. */

#include "loop.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "rope.h"
#include "state.h"
#include "state_structures.h"

double ends_yaw(const NodalArrays *nodal) {
    return centreline_line_yaw(nodal->q, end_row(nodal->q, nodal->nodes, RIGHT));
}

/* Set result to value and slope of a coordinate at arc length `at` of the quintic through a node and its neighbours. */
static void quintic_about(int node, const double *q, const double *s, int axis, double at, double result[2]) {
    const double first = s[node - 1];
    double values[6];
    for (int k = 0; k < 3; k++) {
        const double *row = q + (ptrdiff_t)DOF * (node - 1 + k);
        values[2 * k] = row[axis];
        values[2 * k + 1] = row[SLOPE + axis];
    }
    hermite_through_three(at - first, s[node] - first, s[node + 1] - first, values, result);
}

/* Return the node nearest to this one that has a neighbour on both sides. */
static int inner_node(int node, int nodes) {
    if (node < 1) return 1;
    return node > nodes - 2 ? nodes - 2 : node;
}

/* Set result to value and slope of a coordinate at arc length `at` of an element.  The quintics about its nodes share
   it by their distance, so that nothing jumps where the rope moves on by a node. */
static void coordinate_at(int nodes, const double *q, const double *s, int element, int axis, double at,
                          double result[2]) {
    const double l = s[element + 1] - s[element];
    const double xi = (at - s[element]) / l;
    double left[2];
    double right[2];
    quintic_about(inner_node(element, nodes), q, s, axis, at, left);
    quintic_about(inner_node(element + 1, nodes), q, s, axis, at, right);
    result[0] = (1 - xi) * left[0] + xi * right[0];
    result[1] = (1 - xi) * left[1] + xi * right[1] + (right[0] - left[0]) / l;
}

/* Return where a sampled height is least, in samples: the lowest point of a parabola through three of them. */
static double lowest_sample(const double height[SAMPLING_FINE]) {
    int lowest = 0;
    for (int k = 1; k < SAMPLING_FINE; k++)
        if (height[k] < height[lowest]) lowest = k;
    if (lowest == 0 || lowest == SAMPLING_FINE - 1) return lowest;
    const double before = height[lowest - 1];
    const double after = height[lowest + 1];
    const double bend = before - 2 * height[lowest] + after;
    return bend > 0 ? lowest + 0.5 * (before - after) / bend : lowest;
}

LoopBottom loop_bottom(int nodes, const double *q, const double *s) {
    const int node = inner_node(lowest_node(nodes, q), nodes);
    const double begin = s[node - 1];
    const double step = (s[node + 1] - begin) / (SAMPLING_FINE - 1);
    double height[SAMPLING_FINE];
    double found[2];
    for (int k = 0; k < SAMPLING_FINE; k++) {
        const double at = begin + k * step;
        coordinate_at(nodes, q, s, at < s[node] ? node - 1 : node, UP, at, found);
        height[k] = found[0];
    }
    LoopBottom bottom;
    double slope[3];
    bottom.s = begin + lowest_sample(height) * step;
    for (int axis = 0; axis < 3; axis++) {
        coordinate_at(nodes, q, s, bottom.s < s[node] ? node - 1 : node, axis, bottom.s, found);
        bottom.position[axis] = found[0];
        slope[axis] = found[1];
    }
    bottom.yaw = atan2(-slope[2], slope[0]);
    return bottom;
}

/* A way up a leg, in SAMPLING_PIECES per element. */
typedef struct {
    const NodalArrays *nodal;
    int point;      /* next point */
    int last;       /* the leg's end */
    double low[3];  /* latest point higher than all before it */
    double high[3]; /* next such point; its height is HUGE_VAL for none */
} Climb;

static void point_of(const NodalArrays *nodal, int point, double place[3]) {
    const int element = point / SAMPLING_PIECES;
    const int piece = point % SAMPLING_PIECES;
    const double *a = nodal->q + (ptrdiff_t)DOF * element;
    if (piece == 0)
        memcpy(place, a, 3 * sizeof *place);
    else
        centreline_position_at((double)piece / SAMPLING_PIECES, nodal->lengths[element], a, a + DOF, place);
}

static void climb_on(Climb *leg) {
    const int step = leg->last == 0 ? -1 : 1;
    double place[3];
    memcpy(leg->low, leg->high, sizeof leg->low);
    leg->high[UP] = HUGE_VAL;
    while ((leg->last - leg->point) * step >= 0 && leg->high[UP] == HUGE_VAL) {
        point_of(leg->nodal, leg->point, place);
        if (place[UP] > leg->low[UP]) memcpy(leg->high, place, sizeof leg->high);
        leg->point += step;
    }
}

/* Interpolate a coordinate at a height between low and high. */
static double climb_at(const Climb *leg, double height, int axis) {
    const double fraction = (height - leg->low[UP]) / (leg->high[UP] - leg->low[UP]);
    return leg->low[axis] + fraction * (leg->high[axis] - leg->low[axis]);
}

bool legs_apart(const NodalArrays *nodal, const double across[2], double diameter, double above) {
    const int lowest = lowest_node(nodal->nodes, nodal->q);
    const double *left = nodal->q;
    const double *low = left + (ptrdiff_t)DOF * lowest;
    const double *right = end_row(left, nodal->nodes, RIGHT);
    double normal[3];
    bool apart = 0 < lowest && lowest < nodal->elements;
    int k = 0;
    centreline_plane_between(left, right, low, across, normal);
    for (const double *q = left; q < low; q += DOF, k++)
        apart &= centreline_side_gap(-1.0, nodal->lengths[k], q, q + DOF, left[UP], low, normal, diameter, above) >= 0;
    for (const double *q = low; q < right; q += DOF, k++)
        apart &= centreline_side_gap(1.0, nodal->lengths[k], q + DOF, q, right[UP], low, normal, diameter, above) >= 0;
    return apart && centreline_min_slope(nodal->lengths[lowest - 1], low - DOF, low, across) > 0 &&
           centreline_min_slope(nodal->lengths[lowest], low, low + DOF, across) > 0;
}

static double point_s(const NodalArrays *nodal, int point) {
    const int element = point / SAMPLING_PIECES;
    return nodal->s[element] + nodal->lengths[element] * (point % SAMPLING_PIECES) / SAMPLING_PIECES;
}

LoopTurns loop_turns(const NodalArrays *nodal, const LoopBottom *bottom) {
    const int last = SAMPLING_PIECES * nodal->elements;
    int next = 1;
    while (next < last && point_s(nodal, next) < bottom->s) next++;
    Climb left = {.nodal = nodal, .point = next - 1, .last = 0};
    Climb right = {.nodal = nodal, .point = next, .last = last};
    memcpy(left.high, bottom->position, sizeof left.high);
    memcpy(right.high, bottom->position, sizeof right.high);
    climb_on(&left);
    climb_on(&right);
    double across[2];
    double angle = 0;
    double sharpest = -1;
    double below = bottom->position[UP];
    LoopTurns turns = {0, below};
    centreline_heading(bottom->yaw, across);
    double height = fmin(left.high[UP], right.high[UP]);
    while (height < HUGE_VAL) {
        const double next_across[2] = {climb_at(&right, height, 0) - climb_at(&left, height, 0),
                                       climb_at(&right, height, 2) - climb_at(&left, height, 2)};
        const double turned = centreline_angle_between(across, next_across);
        if (fabs(turned) > sharpest) turns.sharpest_y = 0.5 * (below + height);
        sharpest = fmax(sharpest, fabs(turned));
        angle -= turned;
        below = height;
        memcpy(across, next_across, sizeof across);
        if (left.high[UP] <= height) climb_on(&left);
        if (right.high[UP] <= height) climb_on(&right);
        height = fmin(left.high[UP], right.high[UP]);
    }
    turns.number = angle / (2 * PI);
    return turns;
}
