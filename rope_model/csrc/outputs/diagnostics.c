/* The rope for hoist engineers: clearance between its legs, its shape, and the tension along it. */

#include "diagnostics.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "loop.h"
#include "rope.h"
#include "state_structures.h"
#include "transfer.h"

/* LEG: points of one leg for its clearance; BLOCK: points that share a bounding box. */
enum { LEG = SAMPLING_OUTLINE / 2 + 1, BLOCK = 4, BLOCKS = (LEG + BLOCK - 1) / BLOCK };

static double clip(double x, double low, double high) {
    return fmin(fmax(x, low), high);
}

void shape_places(double total, double bottom_s, double loop, int points, double *places) {
    double step = 2.0 / (points - 1);
    for (int k = 0; k < points; k++) {
        double u = k < points - 1 ? k * step - 1.0 : 1.0;
        places[k] =
            clip(centreline_sample_s(bottom_s, u < 0 ? -bottom_s : total - bottom_s, fabs(u), loop), 0.0, total);
    }
}

void diagnostics_shape(int nodes, const double *q, const double *s, int points, const double *places,
                       double (*xyz)[3]) {
    for (int k = 0, i = 0; k < points; k++) {
        while (i < nodes - 2 && s[i + 1] < places[k]) i++;
        const double l = s[i + 1] - s[i];
        const double *a = q + (ptrdiff_t)DOF * i;
        centreline_position_at((places[k] - s[i]) / l, l, a, a + DOF, xyz[k]);
    }
}

void diagnostics_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                         double *tension) {
    const double *s = arrays->s;
    double before[3] = {0, 0, 0};
    double row[1][DOF];
    int i = 0;
    for (int k = 0; k < points; k++) {
        /* Integrate the acceleration, cubic between the nodes, over the elements to the left ... */
        for (; i < arrays->elements - 1 && s[i + 1] <= places[k]; i++) {
            const double *a = arrays->a + (ptrdiff_t)DOF * i;
            const double *b = a + DOF;
            double l = arrays->lengths[i];
            for (int axis = 0; axis < 3; axis++)
                before[axis] += hermite_integral(l, a[axis], a[SLOPE + axis], b[axis], b[SLOPE + axis]);
        }
        /* ... and over the part of the present element. */
        const double *a = arrays->a + (ptrdiff_t)DOF * i;
        const double *b = a + DOF;
        double l = arrays->lengths[i];
        double xi = (places[k] - s[i]) / l;
        double force[3];
        transfer_interpolate(arrays->nodes, arrays->q, s, 1, &places[k], row);
        for (int axis = 0; axis < 3; axis++) {
            double within = hermite_integral_to(xi, l, a[axis], a[SLOPE + axis], b[axis], b[SLOPE + axis]);
            force[axis] = rho * (before[axis] + within) - arrays->reaction[axis];
        }
        force[UP] += rho * gravity * places[k];
        const double *slope = row[0] + SLOPE;
        tension[k] = elementary_dot(force, slope) / sqrt(elementary_dot(slope, slope));
    }
}

/* Copy the points of a leg upwards from where it first reaches `height`; return their number.  `first` is the leg's
   lowest point, `stride` the step to the next, in points. */
static int part_above(double (*first)[3], int stride, double height, double part[LEG][3]) {
    int i = 0;
    int n = 0;
    while (i < LEG && first[stride * i][UP] < height) i++;
    if (i == LEG) return 0;
    const double *below = first[stride * (i > 0 ? i - 1 : 0)];
    const double *above = first[stride * i];
    double rise = above[UP] - below[UP];
    double fraction = rise > 0 ? (height - below[UP]) / rise : 1.0;
    for (int axis = 0; axis < 3; axis++) part[0][axis] = below[axis] + fraction * (above[axis] - below[axis]);
    i += fraction >= 1.0;
    for (n = 1; i < LEG; i++, n++) memcpy(part[n], first[stride * i], sizeof part[n]);
    return n;
}

static void bounds_of(int points, double point[][3], double bounds[6]) {
    for (int axis = 0; axis < 3; axis++) {
        bounds[axis] = bounds[3 + axis] = point[0][axis];
        for (int n = 1; n < points; n++) {
            bounds[axis] = minimum(bounds[axis], point[n][axis]);
            bounds[3 + axis] = maximum(bounds[3 + axis], point[n][axis]);
        }
    }
}

static int at_most(int count, int most) {
    return count < most ? count : most;
}

/* Bounds of each block of a leg, with the first point of the next block. */
static void blocks_of(int points, double point[LEG][3], double bounds[BLOCKS][6]) {
    for (int n = 0; n < points; n += BLOCK) bounds_of(at_most(points - n, BLOCK + 1), point + n, bounds[n / BLOCK]);
}

/* Return the smallest square of a distance between points and pieces of a polygon, or `least` if that is smaller. */
static double nearest_squared(int points, double point[][3], int pieces, double corner[][3], double least) {
    for (int m = 0; m < pieces; m++) {
        const double *a = corner[m];
        const double *b = corner[m + 1];
        const double along[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        for (int n = 0; n < points; n++) least = minimum(least, centreline_squared_distance(point[n], a, along));
    }
    return least;
}

/* Points of one leg. */
typedef struct {
    int count;
    double (*points)[3];
} LegPoints;

/* Return the points of a block, with as many pieces behind them as there are. */
static LegPoints block_of(const LegPoints *leg, int block) {
    const int first = block * BLOCK;
    return (LegPoints){.count = at_most(leg->count - first, BLOCK), .points = leg->points + first};
}

static int pieces_of(const LegPoints *leg, int block) {
    return at_most(leg->count - 1 - block * BLOCK, BLOCK);
}

/* Return the same for the points of two blocks, each with the pieces of the other. */
static double between_squared(const LegPoints *left, int left_block, const LegPoints *right, int right_block,
                              double least) {
    const LegPoints lefts = block_of(left, left_block);
    const LegPoints rights = block_of(right, right_block);
    least = nearest_squared(lefts.count, lefts.points, pieces_of(right, right_block), rights.points, least);
    return nearest_squared(rights.count, rights.points, pieces_of(left, left_block), lefts.points, least);
}

/* Return the smallest square of a distance between the points of a leg and the pieces of the other.  `pair`: nearest
   blocks; the next call starts with them and then skips most others. */
static double smallest_squared(const LegPoints *left, const LegPoints *right, int pair[2]) {
    double left_bounds[BLOCKS][6];
    double right_bounds[BLOCKS][6];
    const int left_top = (left->count - 1) / BLOCK;
    const int right_top = (right->count - 1) / BLOCK;
    double least = between_squared(left, at_most(pair[0], left_top), right, at_most(pair[1], right_top), HUGE_VAL);
    blocks_of(left->count, left->points, left_bounds);
    blocks_of(right->count, right->points, right_bounds);
    for (int m = left_top; m >= 0; m--)
        for (int n = right_top; n >= 0; n--) {
            if (!(centreline_min_squared_distance(left_bounds[m], right_bounds[n]) < least)) continue;
            const double found = between_squared(left, m, right, n, least);
            if (!(found < least)) continue;
            least = found;
            pair[0] = m;
            pair[1] = n;
        }
    return least;
}

double leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                     double diameter, double above, int pair[2]) {
    double places[SAMPLING_OUTLINE];
    double outline[SAMPLING_OUTLINE][3];
    double left[LEG][3];
    double right[LEG][3];
    shape_places(s[nodes - 1], bottom->s, loop, SAMPLING_OUTLINE, places);
    diagnostics_shape(nodes, q, s, SAMPLING_OUTLINE, places, outline);
    double height = bottom->position[UP] + above;
    double (*lowest)[3] = outline + LEG - 1;
    const LegPoints lefts = {.count = part_above(lowest, -1, height, left), .points = left};
    const LegPoints rights = {.count = part_above(lowest, 1, height, right), .points = right};
    if (lefts.count < 2 || rights.count < 2) return HUGE_VAL;
    return sqrt(smallest_squared(&lefts, &rights, pair)) - diameter;
}
