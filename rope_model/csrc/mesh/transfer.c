/* Transfer of nodal fields between meshes, and interpolation between nodes.

   A transformation carries q, the velocities and the accelerations to new elements: the new fields are those
   nearest to the old ones in the mean square along the rope. So the momentum stays where two elements merge,
   except for the part that the clamped ends take up. Dropping the middle node alone would lose its excess over
   its neighbours: a blow to the leg at every transformation. */

#include "transfer.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "banded.h"
#include "formulas.h"
#include "rope.h"

enum { CUBIC = 4, LINEAR = 2, MAX_FIELDS = 8 };

/* difference of arc lengths over the rope's length below which they are equal: that of elements that were merged and
   divided exceeds rounding by far */
#define EQUAL_PLACES 1e-9

double place_tolerance(double length) {
    return EQUAL_PLACES * length;
}

/* Return the index of r (part 0) or r' (part 1) of a node in the right sides of add_missing. */
static ptrdiff_t index_of(int fields, int field, int node, int part) {
    return (ptrdiff_t)3 * (fields * (2 * node + part) + field);
}

void transfer_interpolate(int nodes, const double *x, const double *s, int count, const double *places,
                          double (*y)[DOF]) {
    const double tolerance = place_tolerance(s[nodes - 1]);
    int i = 0;
    for (int k = 0; k < count; k++) {
        /* Find the last element whose left node is left of the place.  Places mostly ascend. */
        while (i < nodes - 2 && s[i + 1] < places[k] + tolerance) i++;
        while (i > 0 && s[i] >= places[k] + tolerance) i--;
        const double left_s = s[i];
        const double right_s = s[i + 1];
        const double *left = x + (ptrdiff_t)DOF * i;
        const double *right = left + DOF;

        /* A place at a node has the node's values exactly. */
        const int nearer_left = places[k] - left_s < right_s - places[k];
        const double l = right_s - left_s;
        if (fabs((nearer_left ? left_s : right_s) - places[k]) <= tolerance)
            memcpy(y[k], nearer_left ? left : right, sizeof y[k]);
        else
            hermite_node_values(minimum(maximum((places[k] - left_s) / l, 0.0), 1.0), l, left, y[k]);
    }
}

int middle_before(int nodes, const double *s, int k, double place) {
    while (k < nodes - 2 && 0.5 * (s[k + 1] + s[k + 2]) <= place) k++;
    return k;
}

double interpolate_midpoints(int nodes, const double *s, int k, double place, double value, double next) {
    double middle = 0.5 * (s[k] + s[k + 1]);
    if (k == nodes - 2 || place <= middle) return value;
    return (next - value) / (0.5 * (s[k + 1] + s[k + 2]) - middle) * (place - middle) + value;
}

/* Add integrals of products of two shape functions to band (2 nodes x CUBIC), as solve_banded takes them. */
static void cubic_products(int nodes, const double *s, double *band) {
    for (int e = 0; e < nodes - 1; e++, band += 2 * CUBIC) {
        double products[CUBIC * (CUBIC + 1) / 2];
        double *product = products;
        hermite_shape_products(s[e + 1] - s[e], products);
        for (int i = 0; i < CUBIC; i++)
            for (int k = 0; k <= i; k++) band[CUBIC * (i - k) + k] += *product++;
    }
}

/* Add integrals of products of two linear functions, for theta, to band (nodes x LINEAR). */
static void linear_products(int nodes, const double *s, double *band) {
    for (int e = 0; e < nodes - 1; e++, band += LINEAR) {
        const double l = s[e + 1] - s[e];
        band[0] += l / 3;
        band[1] += l / 6;
        band[2] += l / 3;
    }
}

/* Add integrals of N times (x at old_s - y at new_s) to r (2 nodes x 3 per field) and theta (nodes x fields). */
static void add_missing(int nodes, int fields, const double *const *x, const double *old_s, const double *const *y,
                        const double *new_s, double *r, double *theta) {
    const double tolerance = place_tolerance(old_s[nodes - 1]);
    int old = 0;
    for (int e = 0; e < nodes - 1; e++) {
        const double end = new_s[e + 1];
        const double l = end - new_s[e];
        double from = new_s[e];
        while (old < nodes - 2 && old_s[old + 1] <= from + tolerance) old++;
        if (old_s[old + 1] >= end - tolerance) continue; /* within an old element */
        /* Between neighbours among old and new nodes, both fields are polynomials. */
        for (int k = old; from < end - tolerance; k++) {
            const double to = k < nodes - 2 ? fmin(old_s[k + 1], end) : end;
            const double old_l = old_s[k + 1] - old_s[k];
            for (int f = 0; f < fields; f++) {
                double load[2 * DOF];
                double *part = load;
                hermite_missing_load(from, to, new_s[e], l, old_s[k], old_l, x[f] + (ptrdiff_t)DOF * k,
                                     y[f] + (ptrdiff_t)DOF * e, load);
                for (int i = 0; i < CUBIC; i++) {
                    double *row = r + index_of(fields, f, e + i / 2, i % 2);
                    for (int axis = 0; axis < 3; axis++) row[axis] += *part++;
                }
                theta[(ptrdiff_t)fields * e + f] += part[0];
                theta[(ptrdiff_t)fields * (e + 1) + f] += part[1];
            }
            from = to;
        }
    }
}

void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work) {
    const ptrdiff_t n = nodes;
    const int inner = nodes - 2; /* the ends keep their values */
    double *cubics = work;
    double *lines = cubics + 2 * CUBIC * n;
    double *r = lines + LINEAR * n;
    double *theta = r + 6 * n * fields;
    const double *before[MAX_FIELDS];
    const double *after[MAX_FIELDS];
    double *y[MAX_FIELDS];
    memset(work, 0, sizeof *work * (size_t)((2 * CUBIC + LINEAR + DOF * fields) * n));
    for (int f = 0; f < fields; f++) {
        before[f] = x[f];
        y[f] = theta + n * fields + DOF * n * f;
        after[f] = y[f];
        transfer_interpolate(nodes, x[f], old_s, nodes, new_s, (double (*)[DOF])y[f]);
    }
    add_missing(nodes, fields, before, old_s, after, new_s, r, theta);
    cubic_products(nodes, new_s, cubics);
    linear_products(nodes, new_s, lines);
    cubics += (ptrdiff_t)2 * CUBIC;
    lines += LINEAR;
    solve_banded(2 * inner, CUBIC - 1, cubics, 3 * fields, r + (ptrdiff_t)6 * fields);
    solve_banded(inner, LINEAR - 1, lines, fields, theta + fields);
    for (int f = 0; f < fields; f++) {
        for (int k = 1; k <= inner; k++) {
            double *node = y[f] + (ptrdiff_t)DOF * k;
            for (int axis = 0; axis < 3; axis++) {
                node[axis] += r[index_of(fields, f, k, 0) + axis];
                node[SLOPE + axis] += r[index_of(fields, f, k, 1) + axis];
            }
            node[ANGLE] += theta[(ptrdiff_t)fields * k + f];
        }
        memcpy(x[f], y[f], sizeof *work * (size_t)(DOF * n));
    }
}
