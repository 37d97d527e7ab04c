/* Reference frame of the cross-section: the port of rope_model.physics.frame, which says what is done and why. */
#include <math.h>

#include "formulas.h"

enum { CANDIDATES = 800 };

static void tangent_at(int node, const double *slopes, double t[3]) {
    const double *d = slopes + (ptrdiff_t)DOF * node;
    double length = sqrt(dot(d, d));
    for (int axis = 0; axis < 3; axis++) t[axis] = d[axis] / length;
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
        spread_over_sphere(k + 0.5, CANDIDATES, poles[k]);
        least[k] = HUGE_VAL;
    }
    for (int i = 0; i < nodes; i++) {
        tangent_at(i, slopes, t);
        for (int k = 0; k < CANDIDATES; k++) least[k] = fmin(least[k], dot(poles[k], t));
    }
    int best = 0;
    for (int k = 1; k < CANDIDATES; k++)
        if (least[k] > least[best]) best = k;
    for (int axis = 0; axis < 3; axis++) pole[axis] = poles[best][axis];
}

void frame_pole_change_angle(const double old[3], const double new_[3], int nodes, const double *slopes,
                             double *angle) {
    const double period = 4.0 * PI, half = 2.0 * PI;
    double t[3], before = 0.0, correction = 0.0;
    for (int i = 0; i < nodes; i++) {
        tangent_at(i, slopes, t);
        double area = pole_change_area(old, new_, t);
        /* continuous along the rope, as numpy.unwrap does it */
        double jump = i > 0 ? area - before : 0.0;
        if (fabs(jump) >= half) {
            double within = fmod(jump + half, period);
            within = (within < 0 ? within + period : within) - half;
            if (within == -half && jump > 0) within = half;
            correction += within - jump;
        }
        before = area;
        angle[i] = area + correction;
    }
}

double frame_nearest_turn(double angle, double last) {
    return angle + 2 * PI * rint((last - angle) / (2 * PI));
}
