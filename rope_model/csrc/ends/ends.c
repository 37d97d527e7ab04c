/* Checks of the host's motions, and moments of the swivels.

   Boundary conditions at the rope's two ends: motion with the conveyances, and swivels.

   An end is vertical (tangent -Y on the left, +Y on the right); its position and tangent direction are
   prescribed, only the stretch |r'| is free. A clamp prescribes r' = n along its axis, without stretch; at a
   hinge r' is free. In both cases the end's section follows the tangent without spin about it. theta is
   prescribed while the swivel holds and free while it slips:

       theta = offset + s yaw + b,   s = -1 on the left, +1 on the right

   with the conveyance's yaw about Y, the swivel's relative angle b, and an offset that belongs to the frame:
   theta counts along the rope from the left end (physics.frame), so the right end's offset changes as the rope
   turns in space. */

#include "ends.h"

#include <math.h>
#include <stdbool.h>

#include "formulas.h"
#include "messages.h"
#include "partition.h"
#include "rope.h"
#include "rules.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"

enum { YAW = 3, AXES = 4, PEAKS = 6, LEAN = 11 };
static const char *const AXIS_NAMES[PEAKS] = {"x", "y", "z", "yaw", "lean", "lean_z"};
const char *side_name(int side) {
    return side == LEFT ? "left" : "right";
}

static const double SENSE_OF_YAW[2] = END_CONDITIONS_YAW_SENSE;

static int largest(int axes, const double *sizes) {
    int worst = 0;
    for (int axis = 0; axis < axes; axis++)
        if (isnan(sizes[axis]) || (!isnan(sizes[worst]) && sizes[axis] > sizes[worst])) worst = axis;
    return worst;
}

/* Return r' of the end in x; of the next node where a clamp prescribes that of the end. */
static const double *stretching_slope(int attachment, int nodes, const double *x, int side) {
    const double *slope = end_row(x, nodes, side) + SLOPE;
    if (attachment != CLAMPED) return slope;
    return side == LEFT ? slope + DOF : slope - DOF;
}

double end_strain(const Scene *scene, int nodes, const double *q, const double *x, int side) {
    const int attachment = scene->swivels[side].attachment;
    const double *t = stretching_slope(attachment, nodes, q, side);
    const double *y = stretching_slope(attachment, nodes, x, side);
    return attachment == PLUMB ? y[UP] : elementary_dot(y, t) / sqrt(elementary_dot(t, t));
}

RopeStatus check_motion(const Scene *scene, const EndMotion *target, const double measures[PATH_MEASURES], int side,
                        char *message) {
    const Inputs *inputs = &scene->inputs;
    static const char *const names[] = END_MOTION_NAMES;
    static const double bounds[] = END_MOTION_BOUNDS;
    static const char *const units[2][2] = {{"m", "rad"}, {"m/s", "rad/s"}};
    message[0] = '\0';
    for (int i = 0; i < (int)(sizeof bounds / sizeof *bounds); i++) {
        const double value = end_value(target, i);
        if (!isfinite(value)) return say_input_not_finite(message, side_name(side), names[i], value);
        if (fabs(value) > bounds[i])
            return say_input_out_of_range(message, side_name(side), names[i], value, bounds[i]);
        if (value != 0 && i >= LEAN && scene->swivels[side].attachment != CLAMPED)
            return say_no_clamp(message, side_name(side), names[i], value);
    }
    for (int k = 0; k < 2; k++) {
        const double *misfits = measures + PEAKS + k * AXES;
        const int worst = largest(AXES, misfits);
        if (misfits[worst] <= inputs->misfit_max) continue;
        const char *unit = units[k][worst == YAW];
        if (inputs->given == ALL_GIVEN)
            return say_input_misfit(message, side_name(side), AXIS_NAMES[worst], misfits[worst], unit,
                                    inputs->misfit_max);
        const double bandwidth = filter_settings(scene, inputs->given).estimate;
        return say_input_jump(message, side_name(side), AXIS_NAMES[worst], misfits[worst], unit, inputs->misfit_max,
                              INPUT_FILTER_MAX_LAG / bandwidth, bandwidth);
    }
    const int worst = largest(PEAKS, measures);
    if (!(measures[worst] <= inputs->acceleration_max))
        return say_inputs_do_not_fit(message, side_name(side), AXIS_NAMES[worst], measures[worst],
                                     worst < YAW ? "m/s^2" : "rad/s^2", inputs->acceleration_max);
    return ROPE_DONE;
}

RopeStatus check_input_age(const Inputs *inputs, double t, const InputFilter *end_filter, int side, char *message) {
    message[0] = '\0';
    if (end_filter->repetitions.held > 1 && t - end_filter->given_at > inputs->hold_max)
        return say_inputs_frozen(message, side_name(side), t - end_filter->given_at, inputs->hold_max);
    return ROPE_DONE;
}

double ends_tension(const Scene *scene, const NodalArrays *nodal, int side) {
    const bool plumb = scene->swivels[side].attachment == PLUMB;
    const double *q = end_row(nodal->q, nodal->nodes, side);
    return tension_at_end(plumb, side, q, end_row(nodal->reaction, nodal->nodes, side));
}

double ends_moment(const Scene *scene, const State *state, const NodalArrays *nodal, int side) {
    const double tension = ends_tension(scene, nodal, side);
    const double constraint_moment = end_row(nodal->reaction, nodal->nodes, side)[ANGLE];
    return moment_of_swivel(&scene->swivels[side], &state->swivels[side], tension, constraint_moment);
}

RelativeTurn ends_relative(const State *state, int side, double t, double theta, double theta_t) {
    const EndMotion now = end_path_at(&state->paths[side], t);
    return (RelativeTurn){
        .angle = theta - state->offsets[side] - SENSE_OF_YAW[side] * now.yaw,
        .rate = theta_t - SENSE_OF_YAW[side] * now.yaw_rate,
    };
}

double swivel_angle(State *state, int side) {
    const NodalArrays nodal = state_arrays(state);
    return ends_relative(state, side, state->t, end_row(nodal.q, nodal.nodes, side)[ANGLE], 0).angle;
}

void ends_freedom(const Scene *scene, const State *state, int side, bool free[DOF]) {
    const int attachment = scene->swivels[side].attachment;
    for (int dof = 0; dof < DOF; dof++) free[dof] = false;
    free[SLOPE] = attachment == HINGED;
    free[SLOPE + 1] = attachment != CLAMPED;
    free[SLOPE + 2] = attachment == HINGED;
    free[ANGLE] = state->swivels[side].phase == SLIP;
}

void ends_prescribed_motion(const Scene *scene, const State *state, int side, double t, double rows[3][DOF]) {
    held_end(&state->paths[side], t, (side == LEFT ? -0.5 : 0.5) * scene->layout.spacing, SENSE_OF_YAW[side],
             state->offsets[side] + state->swivels[side].angle, rows);
    if (scene->swivels[side].attachment != CLAMPED) return;
    double leans[2][3], n[3][3];
    end_path_lean_motion(&state->paths[side], t, leans);
    end_conditions_clamp_axis(leans[0], leans[1], n);
    for (int k = 0; k < 9; k++) rows[k / 3][SLOPE + k % 3] = -SENSE_OF_YAW[side] * n[k / 3][k % 3];
}

double bottom_arc_length(const Scene *scene, const EndPath paths[2], double t) {
    const double left = end_path_height(&paths[LEFT], t);
    const double right = end_path_height(&paths[RIGHT], t);
    return 0.5 * (scene->rope.length + left - right);
}

void dividers_on_rope(const Scene *scene, const EndPath paths[2], double t, double *divider_s) {
    mesh_dividers(scene, end_path_height(&paths[LEFT], t), end_path_height(&paths[RIGHT], t), divider_s);
}
