/* Nodal values between the nodes, and carried from one partition of the rope to another: the port of
   rope_model.simulation.transfer, which says what is done and why. */
#include <math.h>
#include <string.h>

#include "formulas.h"

enum { GAUSS = 4, CUBIC = 4, LINEAR = 2, MOST_FIELDS = 8 };
/* on [0, 1]; exact for the product of two cubics */
static const double POINTS[GAUSS] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262};
static const double WEIGHTS[GAUSS] = {0.17392742256872693, 0.3260725774312731, 0.3260725774312731, 0.17392742256872693};

/* within which two arc lengths are the same */
static double tolerance_of(int nodes, const double *s) {
    return 1e-9 * s[nodes - 1];
}

/* the element in which x lies: the last whose left node is left of x, or the outermost */
static int element_at(int nodes, const double *s, double x) {
    int low = 0, high = nodes;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (s[middle] < x)
            low = middle + 1;
        else
            high = middle;
    }
    int i = low - 1;
    return i < 0 ? 0 : i > nodes - 2 ? nodes - 2 : i;
}

void transfer_interpolate(int nodes, const double *x, const double *s, int places, const double *at, double *y) {
    double tolerance = tolerance_of(nodes, s);
    int i = 0;
    for (int k = 0; k < places; k++, y += DOF) {
        double x_k = at[k] + tolerance;
        /* places mostly ascend by an element or less */
        if (i < nodes - 2 && s[i + 1] < x_k) i++;
        if (!(s[i] < x_k && x_k <= s[i + 1])) i = element_at(nodes, s, x_k);
        double left_s = s[i], right_s = s[i + 1];
        const double *left = x + (ptrdiff_t)DOF * i, *right = left + DOF;

        /* a node's own place has its values exactly */
        int nearer_left = at[k] - left_s < right_s - at[k];
        if (fabs((nearer_left ? left_s : right_s) - at[k]) <= tolerance) {
            memcpy(y, nearer_left ? left : right, DOF * sizeof *y);
            continue;
        }
        double l = right_s - left_s;
        double xi = fmin(fmax((at[k] - left_s) / l, 0.0), 1.0);
        for (int axis = 0; axis < 3; axis++) {
            double values[2];
            hermite(xi, l, left[axis], left[SLOPE + axis], right[axis], right[SLOPE + axis], values);
            y[axis] = values[0], y[SLOPE + axis] = values[1];
        }
        y[ANGLE] = (1 - xi) * left[ANGLE] + xi * right[ANGLE];
    }
}

/* A (rows x (width + 1)): symmetric, positive definite, each row its diagonal and the `width` entries left of it,
   nearest first; it becomes its Cholesky factor, the diagonal inverted */
static void factorize(int rows, int width, double *A) {
    const ptrdiff_t row = width + 1;
    for (int i = 0; i < rows; i++) {
        int first = i > width ? i - width : 0;
        for (int j = first; j <= i; j++) {
            double sum = A[row * i + (i - j)];
            for (int k = first; k < j; k++) sum -= A[row * i + (i - k)] * A[row * j + (j - k)];
            A[row * i + (i - j)] = i == j ? 1 / sqrt(sum) : sum * A[row * j];
        }
    }
}

/* A x = b for all columns of b (rows x columns), which becomes x; L is what factorize made of A */
static void substitute(int rows, int width, const double *L, int columns, double *b) {
    const ptrdiff_t row = width + 1;
    for (int i = 0; i < rows; i++) {
        double *own = b + (ptrdiff_t)columns * i;
        for (int k = i > width ? i - width : 0; k < i; k++)
            for (int c = 0; c < columns; c++) own[c] -= L[row * i + (i - k)] * b[(ptrdiff_t)columns * k + c];
        for (int c = 0; c < columns; c++) own[c] *= L[row * i];
    }
    for (int i = rows - 1; i >= 0; i--) {
        double *own = b + (ptrdiff_t)columns * i;
        for (int k = i + 1; k < rows && k <= i + width; k++)
            for (int c = 0; c < columns; c++) own[c] -= L[row * k + (k - i)] * b[(ptrdiff_t)columns * k + c];
        for (int c = 0; c < columns; c++) own[c] *= L[row * i];
    }
}

/* integrals of the products of two shares over the elements, as factorize takes them: cubic (2 nodes x CUBIC), linear
   (nodes x LINEAR), both zero before */
static void add_products(int nodes, const double *s, double *cubics, double *lines) {
    for (int e = 0; e < nodes - 1; e++) {
        double l = s[e + 1] - s[e], products[CUBIC * (CUBIC + 1) / 2], *product = products;
        double *rows = cubics + (ptrdiff_t)2 * CUBIC * e, *parts = lines + (ptrdiff_t)LINEAR * e;
        hermite_products(l, products);
        for (int i = 0; i < CUBIC; i++)
            for (int k = 0; k <= i; k++) rows[CUBIC * i + k] += *product++;
        parts[0] += l / 3;
        parts[2] += l / 3;
        parts[3] += l / 6;
    }
}

/* what the fields have in the element to the right of a node: r (3) and theta of each */
static void field_values(const double *const *fields, int number, int node, double xi, const double shares[CUBIC],
                         double (*values)[4]) {
    for (int f = 0; f < number; f++) {
        const double *left = fields[f] + (ptrdiff_t)DOF * node, *right = left + DOF;
        for (int axis = 0; axis < 3; axis++)
            values[f][axis] = shares[0] * left[axis] + shares[1] * left[SLOPE + axis] + shares[2] * right[axis] +
                              shares[3] * right[SLOPE + axis];
        values[f][3] = (1 - xi) * left[ANGLE] + xi * right[ANGLE];
    }
}

/* what the fields y at the nodes new_s have less than x at old_s, times the shares, along the rope: r (2 nodes x 3 of
   each field), theta (nodes x fields), both zero before; without elements that become one there is nothing */
static void add_missing(int nodes, int fields, const double *const *x, const double *old_s, const double *const *y,
                        const double *new_s, double *r, double *theta) {
    const double tolerance = tolerance_of(nodes, old_s);
    int old = 0;
    for (int e = 0; e < nodes - 1; e++) {
        double from = new_s[e], end = new_s[e + 1], l = end - from;
        while (old < nodes - 2 && old_s[old + 1] <= from + tolerance) old++;
        if (old_s[old + 1] >= end - tolerance) /* within an old one, and so the same */
            continue;
        /* between neighbours among all nodes, old and new, both are polynomials */
        for (int k = old; from < end - tolerance; k++) {
            double to = k < nodes - 2 ? fmin(old_s[k + 1], end) : end, old_l = old_s[k + 1] - old_s[k];
            for (int g = 0; g < GAUSS; g++) {
                double at = from + POINTS[g] * (to - from), weight = WEIGHTS[g] * (to - from);
                double xi = (at - new_s[e]) / l, old_xi = (at - old_s[k]) / old_l;
                double shares[CUBIC], old_shares[CUBIC], before[MOST_FIELDS][4], after[MOST_FIELDS][4];
                hermite_shares(xi, l, shares);
                hermite_shares(old_xi, old_l, old_shares);
                field_values(x, fields, k, old_xi, old_shares, before);
                field_values(y, fields, e, xi, shares, after);
                for (int f = 0; f < fields; f++) {
                    double missing = weight * (before[f][3] - after[f][3]);
                    theta[(ptrdiff_t)fields * e + f] += (1 - xi) * missing;
                    theta[(ptrdiff_t)fields * (e + 1) + f] += xi * missing;
                    for (int i = 0; i < CUBIC; i++)
                        for (int axis = 0; axis < 3; axis++)
                            r[(ptrdiff_t)3 * (fields * (2 * e + i) + f) + axis] +=
                                weight * shares[i] * (before[f][axis] - after[f][axis]);
                }
            }
            from = to;
        }
    }
}

void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work) {
    const ptrdiff_t n = nodes;
    const int inner = nodes - 2; /* the ends keep their values */
    double *cubics = work, *lines = cubics + 2 * CUBIC * n, *r = lines + LINEAR * n, *theta = r + 6 * n * fields;
    const double *before[MOST_FIELDS], *after[MOST_FIELDS];
    double *y[MOST_FIELDS];
    memset(work, 0, sizeof *work * (size_t)((2 * CUBIC + LINEAR + DOF * fields) * n));
    for (int f = 0; f < fields; f++) {
        before[f] = x[f];
        after[f] = y[f] = theta + n * fields + DOF * n * f;
        transfer_interpolate(nodes, x[f], old_s, nodes, new_s, y[f]);
    }
    add_missing(nodes, fields, before, old_s, after, new_s, r, theta);
    add_products(nodes, new_s, cubics, lines);
    cubics += (ptrdiff_t)2 * CUBIC;
    lines += LINEAR;
    factorize(2 * inner, CUBIC - 1, cubics);
    factorize(inner, LINEAR - 1, lines);
    substitute(2 * inner, CUBIC - 1, cubics, 3 * fields, r + (ptrdiff_t)6 * fields);
    substitute(inner, LINEAR - 1, lines, fields, theta + fields);
    for (int f = 0; f < fields; f++) {
        for (int k = 1; k <= inner; k++) {
            double *node = y[f] + (ptrdiff_t)DOF * k;
            for (int axis = 0; axis < 3; axis++) {
                node[axis] += r[(ptrdiff_t)3 * (fields * (2 * k) + f) + axis];
                node[SLOPE + axis] += r[(ptrdiff_t)3 * (fields * (2 * k + 1) + f) + axis];
            }
            node[ANGLE] += theta[(ptrdiff_t)fields * k + f];
        }
        memcpy(x[f], y[f], sizeof *work * (size_t)(DOF * n));
    }
}
