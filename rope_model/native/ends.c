/* rope_model.simulation.ends: quintic paths between the host's instants, their checks, and the swivels' friction. */
#include <math.h>

#include "formulas.h"
#include "messages.h"

enum { YAW = 3, AXES = 4 };
/* steps that differ by less than this part of themselves are alike */
#define ALIKE 1e-6

Path path_resting(double t, const EndMotion *at) {
    Path path = {t, t, t, {{0}}};
    for (int axis = 0; axis < AXES; axis++) path.c[axis][0] = axis == YAW ? at->yaw : at->x[axis];
    return path;
}

/* the longest of what the path's end misses of the motion */
static double longest_missing_time(const Path *path, const EndMotion *motion) {
    const EndMotion end = path_end(path);
    double longest = missing_time(motion->yaw - end.yaw, motion->yaw_rate - end.yaw_rate);
    for (int axis = 0; axis < YAW; axis++)
        longest = fmax(longest, missing_time(motion->x[axis] - end.x[axis], motion->v[axis] - end.v[axis]));
    return longest;
}

Path path_to(const Path *path, double stop, const EndMotion *given, double within) {
    double start = path->stop, step = stop - start;
    const EndMotion before = end_extrapolate(*given, -step);
    double h = fmax(step, fmin(longest_missing_time(path, &before), fmax(path->aim - start, within)));
    if (h <= step * (1.0 + ALIKE)) h = step;
    EndMotion joined = h > step ? end_extrapolate(*given, h - step) : *given;
    const EndMotion *target = &joined;
    Path next = {start, stop, start + h, {{0}}};
    for (int axis = 0; axis < AXES; axis++) {
        double rates[3];
        path_rates(path, start, axis, rates);
        double x1 = axis == YAW ? target->yaw : target->x[axis], v1 = axis == YAW ? target->yaw_rate : target->v[axis];
        /* FMI gives no yaw acceleration: take the mean over the step */
        double a1 = axis == YAW ? (target->yaw_rate - rates[1]) / h : target->a[axis];
        quintic(h, rates[0], rates[1], rates[2], x1, v1, a1, next.c[axis]);
    }
    return next;
}

Path path_coasting(const Path *path, double t) {
    Path next = {t, HUGE_VAL, HUGE_VAL, {{0}}};
    for (int axis = 0; axis < AXES; axis++) {
        double *c = next.c[axis];
        path_rates(path, t, axis, c);
        c[2] *= 0.5;
    }
    return next;
}

void path_rates(const Path *path, double t, int axis, double rates[3]) {
    quintic_rates(path->c[axis], smaller(t, path->stop) - path->start, rates);
}

EndMotion path_end(const Path *path) {
    EndMotion end;
    double rates[3];
    for (int axis = 0; axis < YAW; axis++) {
        path_rates(path, path->stop, axis, rates);
        end.x[axis] = rates[0], end.v[axis] = rates[1], end.a[axis] = rates[2];
    }
    path_rates(path, path->stop, YAW, rates);
    end.yaw = rates[0], end.yaw_rate = rates[1];
    return end;
}

/* largest on the path, sampled; NaN when the first sample is */
static double peak_acceleration(const Path *path, int axis) {
    double peak = 0.0;
    for (int i = 0; i < 5; i++) {
        double a = fabs(quintic_acceleration(path->c[axis], 0.25 * i * (path->stop - path->start)));
        if (i == 0 || a > peak) peak = a;
    }
    return peak;
}

void end_refusal(const EndMotion *target, const Path *path, int side, char *message) {
    static const char *const names[] = END_MOTION_NAMES;
    static const double bounds[] = END_MOTION_REACH;
    double peaks[AXES];
    int worst = 0;
    message[0] = '\0';
    for (int i = 0; i < (int)(sizeof bounds / sizeof *bounds) && !message[0]; i++) {
        const double value = end_value(target, i);
        if (!isfinite(value))
            say_input_not_finite(message, SIDE_NAMES[side], names[i], value);
        else if (fabs(value) > bounds[i])
            say_input_out_of_range(message, SIDE_NAMES[side], names[i], value, bounds[i]);
    }
    if (message[0]) return;
    for (int axis = 0; axis < AXES; axis++) {
        peaks[axis] = peak_acceleration(path, axis);
        if (peaks[axis] > peaks[worst]) worst = axis;
    }
    if (!(peaks[worst] <= HARDEST))
        say_inputs_do_not_fit(message, SIDE_NAMES[side], worst == YAW ? "yaw" : names[worst], peaks[worst],
                              worst == YAW ? "rad/s^2" : "m/s^2", HARDEST);
}

double swivel_friction(const Swivel *swivel, double mu, double tension) {
    if (swivel->mode == FREE_MODE) return 0.0;
    return friction_moment(mu, swivel->mean_diameter, swivel->seal_moment, tension);
}

double swivel_moment(const Scene *scene, const State *state, int side, const double *reaction) {
    const Swivel *swivel = &scene->swivels[side];
    const SwivelState *now = &state->swivels[side];
    if (now->phase == SLIP) return -now->sign * swivel_friction(swivel, swivel->mu_kinetic, reaction[1]);
    return reaction[ANGLE];
}

void swivel_relative(const State *state, int side, double t, double theta, double theta_t, double relative[2]) {
    double yaw[3];
    path_rates(&state->paths[side], t, YAW, yaw);
    relative[0] = theta - state->offsets[side] - YAW_SENSE[side] * yaw[0];
    relative[1] = theta_t - YAW_SENSE[side] * yaw[1];
}
