/* rope_model.simulation.ends: quintic paths between the host's instants, their checks, and the swivels' friction. */
#include <math.h>

#include "cases.h"

enum { YAW = 3, AXES = 4 };

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
    path_peaks(path, peaks);
    for (int axis = 0; axis < AXES; axis++)
        if (peaks[axis] > peaks[worst]) worst = axis;
    if (!(peaks[worst] <= HARDEST))
        say_inputs_do_not_fit(message, SIDE_NAMES[side], worst == YAW ? "yaw" : names[worst], peaks[worst],
                              worst == YAW ? "rad/s^2" : "m/s^2", HARDEST);
}

double swivel_moment(const Scene *scene, const State *state, int side, const double *reaction) {
    return moment_of_swivel(&scene->swivels[side], &state->swivels[side], reaction[1], reaction[ANGLE]);
}

void swivel_relative(const State *state, int side, double t, double theta, double theta_t, double relative[2]) {
    const EndMotion now = path_at(&state->paths[side], t);
    relative[0] = theta - state->offsets[side] - YAW_SENSE[side] * now.yaw;
    relative[1] = theta_t - YAW_SENSE[side] * now.yaw_rate;
}
