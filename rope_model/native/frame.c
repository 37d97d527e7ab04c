/* Reference frame of the cross-section: the twin of rope_model.physics.frame, which says what is done and why. */
#include <math.h>

#include "core.h"

enum { CANDIDATES = 800 };

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void tangent_at(int node, const double *slopes, double t[3]) {
    const double *d = slopes + (ptrdiff_t)DOF * node;
    double length = sqrt(dot(d, d));
    for (int axis = 0; axis < 3; axis++)
        t[axis] = d[axis] / length;
}

double frame_pole_margin(const double pole[3], int nodes, const double *slopes) {
    double t[3], least = HUGE_VAL;
    for (int i = 0; i < nodes; i++) {
        tangent_at(i, slopes, t);
        least = fmin(least, dot(t, pole));
    }
    return 1.0 + least;
}

void frame_best_pole(int nodes, const double *slopes, double pole[3]) {
    double poles[CANDIDATES][3], least[CANDIDATES], t[3];
    for (int k = 0; k < CANDIDATES; k++) {
        double z = 1.0 - 2.0 * (k + 0.5) / (double)CANDIDATES;
        double azimuth = (k + 0.5) * PI * (3.0 - sqrt(5.0));
        double radius = sqrt(1.0 - z * z);
        poles[k][0] = radius * cos(azimuth);
        poles[k][1] = z;
        poles[k][2] = radius * sin(azimuth);
        least[k] = HUGE_VAL;
    }
    for (int i = 0; i < nodes; i++) {
        tangent_at(i, slopes, t);
        for (int k = 0; k < CANDIDATES; k++)
            least[k] = fmin(least[k], dot(poles[k], t));
    }
    int best = 0;
    for (int k = 1; k < CANDIDATES; k++)
        if (least[k] > least[best])
            best = k;
    for (int axis = 0; axis < 3; axis++)
        pole[axis] = poles[best][axis];
}

void frame_pole_change_angle(const double old[3], const double new_[3], int nodes, const double *slopes,
                             double *angle) {
    const double period = 4.0 * PI, half = 2.0 * PI;
    double normal[3], t[3], between = dot(old, new_), before = 0.0, correction = 0.0;
    cross(new_, old, normal);
    for (int i = 0; i < nodes; i++) {
        tangent_at(i, slopes, t);
        double area = 2.0 * atan2(dot(t, normal), 1.0 + between + dot(t, old) + dot(t, new_));
        /* continuous along the rope, as numpy.unwrap does it */
        double jump = i > 0 ? area - before : 0.0;
        if (fabs(jump) >= half) {
            double within = fmod(jump + half, period);
            within = (within < 0 ? within + period : within) - half;
            if (within == -half && jump > 0)
                within = half;
            correction += within - jump;
        }
        before = area;
        angle[i] = area + correction;
    }
}

double frame_smallest_rotation_rate(const double pole[3], const double d[3], const double change[3]) {
    double length = sqrt(dot(d, d)), turning[3];
    cross(d, change, turning);
    return -dot(pole, turning) / (length * (length + pole[0] * d[0] + pole[1] * d[1] + pole[2] * d[2]));
}

double frame_counted_on(double angle, double last) {
    return angle + 2 * PI * rint((last - angle) / (2 * PI));
}
