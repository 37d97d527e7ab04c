/* Values of the output signals: the port of rope_model.simulation.signals. */
#include "signals.h"

#include <math.h>
#include <string.h>

#include "guards.h"
#include "shaft.h"
#include "energy_values.h" /* energy_signals: generated */

int signal_group(int signal) {
    static const signed char groups[] = {SIGNAL_GROUPS};
    return signal >= 0 && signal < SIGNALS ? groups[signal] : -1;
}

static void end_signals(int side, const Scene *scene, const State *state, const Arrays *arrays, double *values) {
    ptrdiff_t row = side == LEFT ? 0 : (ptrdiff_t)DOF * (arrays->nodes - 1);
    const double *q = arrays->q + row, *v = arrays->v + row, *reaction = arrays->reaction + row;
    double torque = swivel_moment(scene, state, side, reaction), moment[3], relative[2];
    end_moment(q + SLOPE, reaction + SLOPE, torque, moment);
    swivel_relative(state, side, state->t, q[ANGLE], v[ANGLE], relative);

    /* both ends have the same signals in the same order */
    if (side == RIGHT) values += SIGNAL_RIGHT_FX - SIGNAL_LEFT_FX;
    for (int axis = 0; axis < 3; axis++) {
        values[SIGNAL_LEFT_FX + axis] = -reaction[axis];
        values[SIGNAL_LEFT_MX + axis] = -moment[axis];
    }
    values[SIGNAL_LEFT_FY_MEAN] = state->force_mean[side];
    values[SIGNAL_LEFT_SWIVEL_ANGLE] = relative[0];
    values[SIGNAL_LEFT_SWIVEL_RATE] = relative[1];
    values[SIGNAL_LEFT_SWIVEL_TORQUE] = torque;
    values[SIGNAL_LEFT_SWIVEL_SLIPPING] = state->swivels[side].phase == SLIP;
}

static void loop_signals(const Scene *scene, const State *state, const Arrays *arrays, const LoopBottom *bottom,
                         double *values) {
    memcpy(values + SIGNAL_LOOP_X, bottom->position, sizeof bottom->position);
    values[SIGNAL_LOOP_YAW] = shape_nearest_turn(bottom->yaw, state->loop_yaw);
    values[SIGNAL_LOOP_CLEARANCE] = shape_leg_clearance(arrays->nodes, arrays->q, arrays->s, bottom, loop_width(scene),
                                                        scene->rope.diameter, scene->layout.spacing);
    values[SIGNAL_LOOP_TURNS] = shape_loop_turns(arrays->nodes, arrays->q, arrays->s, bottom).number;
    values[SIGNAL_LOOP_CROSSINGS] = state->crossing.number;
    values[SIGNAL_LOOP_CROSSED_AT] = state->crossing.since;
    values[SIGNAL_LOOP_CROSSED_Y] = state->crossing.y;
    values[SIGNAL_LOOP_RISE] = guards_rise(scene, state, arrays, bottom);
    values[SIGNAL_LOOP_SIDEWAYS] = guards_sideways(arrays, bottom);
}

static void guard_signals(const GuardState *guard, double *values) {
    values[SIGNAL_GUARD_TRIPPED] = guard->cause > 0;
    values[SIGNAL_GUARD_CAUSE] = guard->cause;
    values[SIGNAL_GUARD_TIME] = guard->time;
}

static void clearance_signals(const Scene *scene, const State *state, const Arrays *arrays, double *values) {
    Nearest nearest[KINDS];
    shaft_clearances(scene, arrays, state->t, nearest);
    for (int kind = 0; kind < KINDS; kind++) values[SIGNAL_CLEARANCE_LINING + kind] = nearest[kind].clearance;
}

/* of an element; a fidelity without torsion has no torque */
static double shear_stress(const Rope *rope, int fidelity, const double strains[3]) {
    return fidelity == TORSIONAL ? torsional_stress(rope, strains[0], strains[1]) : 0.0;
}

static void stress_signals(const Rope *rope, int fidelity, const Arrays *arrays, const double (*strains)[3],
                           const LoopBottom *bottom, double *values) {
    double bending = -HUGE_VAL, torsion = -HUGE_VAL;
    for (int k = 0; k < arrays->elements; k++) {
        bending = fmax(bending, bending_stress(rope, strains[k][2]));
        torsion = fmax(torsion, shear_stress(rope, fidelity, strains[k]));
    }
    int last = arrays->elements - 1, lowest = 0;
    while (lowest < last && arrays->s[lowest + 1] < bottom->s) lowest++;
    values[SIGNAL_LEFT_TWIST] = strains[0][1];
    values[SIGNAL_RIGHT_TWIST] = strains[last][1];
    values[SIGNAL_LOOP_TWIST] = strains[lowest][1];
    values[SIGNAL_STRESS_BENDING_MAX] = bending;
    values[SIGNAL_STRESS_TORSION_MAX] = torsion;
}

static void error_signals(const Scene *scene, const State *state, const Arrays *arrays, double *values) {
    const double fine = mesh_fine_length(&state->pattern, arrays->lengths);
    values[SIGNAL_STATUS_END_FORCE_ERROR] = end_force_error(&scene->rope, &state->errors);
    values[SIGNAL_STATUS_LOOP_ERROR] = loop_error(scene, &state->errors, fine, state->pattern.grading_length);
    values[SIGNAL_STATUS_GIVEN_UP] = (double)state->counts.given_up;
    values[SIGNAL_STATUS_GIVEN_UP_SINCE] = state->given_up_since;
}

static void shape_signals(const Scene *scene, const Arrays *arrays, const LoopBottom *bottom, double *values) {
    double at[SHAPE_POINTS], xyz[SHAPE_POINTS][3];
    shape_places(arrays->s[arrays->nodes - 1], bottom->s, loop_width(scene), SHAPE_POINTS, at);
    shape_points(arrays->nodes, arrays->q, arrays->s, SHAPE_POINTS, at, xyz[0]);
    for (int i = 0; i < SHAPE_POINTS; i++) {
        values[SIGNAL_SHAPE_X_1 + i] = xyz[i][0];
        values[SIGNAL_SHAPE_Y_1 + i] = xyz[i][1];
        values[SIGNAL_SHAPE_Z_1 + i] = xyz[i][2];
    }
}

/* of an element, at one fidelity */
typedef double Quantity(const Rope *rope, int fidelity, const double strains[3]);

static double bend_stress(const Rope *rope, int fidelity, const double strains[3]) {
    (void)fidelity;
    return bending_stress(rope, strains[2]);
}

static double curvature(const Rope *rope, int fidelity, const double strains[3]) {
    (void)rope, (void)fidelity;
    return strains[2];
}

static double torque(const Rope *rope, int fidelity, const double strains[3]) {
    return fidelity == TORSIONAL ? torque_of(rope, strains[0], strains[1]) : 0.0;
}

/* a quantity at arc lengths `at`, linear between the middles of the elements */
static void along(const Scene *scene, int fidelity, const Arrays *arrays, const double (*strains)[3], const double *at,
                  Quantity *of, double *values) {
    for (int i = 0; i < SHAPE_POINTS; i++) {
        int k = shape_middle_before(arrays->nodes, arrays->s, at[i]), next = k < arrays->nodes - 2 ? k + 1 : k;
        values[i] =
            shape_interpolate_midpoints(arrays->nodes, arrays->s, k, at[i], of(&scene->rope, fidelity, strains[k]),
                                        of(&scene->rope, fidelity, strains[next]));
    }
}

static void pull_at(const Scene *scene, int fidelity, const Arrays *arrays, const double *at, double *tension) {
    const double rho = scene->rope.mass_per_length, gravity = scene->layout.gravity;
    double xyz[SHAPE_POINTS][3], y[SHAPE_POINTS];
    if (fidelity != RIGID) {
        shape_tension(arrays, rho, gravity, SHAPE_POINTS, at, tension);
        return;
    }
    shape_points(arrays->nodes, arrays->q, arrays->s, SHAPE_POINTS, at, xyz[0]);
    for (int i = 0; i < SHAPE_POINTS; i++) y[i] = xyz[i][1];
    rigid_tension(arrays, rho, gravity, SHAPE_POINTS, at, y, tension);
}

static void along_signals(const Scene *scene, int fidelity, const Arrays *arrays, const double (*strains)[3],
                          const LoopBottom *bottom, double *values) {
    double *at = values + SIGNAL_SHAPE_S_1;
    shape_places(arrays->s[arrays->nodes - 1], bottom->s, loop_width(scene), SHAPE_POINTS, at);
    pull_at(scene, fidelity, arrays, at, values + SIGNAL_SHAPE_TENSION_1);
    along(scene, fidelity, arrays, strains, at, bend_stress, values + SIGNAL_SHAPE_BENDING_1);
    along(scene, fidelity, arrays, strains, at, shear_stress, values + SIGNAL_SHAPE_TORSION_1);
}

static void station_signals(const Scene *scene, int fidelity, const Arrays *arrays, const double (*strains)[3],
                            double *values) {
    const double first = scene->station.first, step = (scene->station.last - first) / (SHAPE_POINTS - 1);
    double at[SHAPE_POINTS];
    for (int i = 0; i < SHAPE_POINTS; i++)
        at[i] = arrays->s[arrays->nodes - 1] * (i < SHAPE_POINTS - 1 ? i * step + first : scene->station.last);
    pull_at(scene, fidelity, arrays, at, values + SIGNAL_STATION_TENSION_1);
    along(scene, fidelity, arrays, strains, at, curvature, values + SIGNAL_STATION_CURVATURE_1);
    along(scene, fidelity, arrays, strains, at, torque, values + SIGNAL_STATION_TORQUE_1);
}

void signals_of(int group, const Scene *scene, const State *state, const Arrays *arrays, const double (*strains)[3],
                const LoopBottom *bottom, double *values) {
    switch (group) {
    case END_SIGNALS:
        end_signals(LEFT, scene, state, arrays, values);
        end_signals(RIGHT, scene, state, arrays, values);
        break;
    case LOOP_SIGNALS:
        loop_signals(scene, state, arrays, bottom, values);
        break;
    case STRESS_SIGNALS:
        stress_signals(&scene->rope, state->fidelity, arrays, strains, bottom, values);
        break;
    case ENERGY_SIGNALS:
        energy_signals(&state->energy_balance, &state->counts, values);
        break;
    case AUDIT_SIGNALS:
        audit_values(&state->audit, values + SIGNAL_AUDIT_MOMENTUM); /* in their order */
        break;
    case ERROR_SIGNALS:
        error_signals(scene, state, arrays, values);
        break;
    case SHAPE_SIGNALS:
        shape_signals(scene, arrays, bottom, values);
        break;
    case ALONG_SIGNALS:
        along_signals(scene, state->fidelity, arrays, strains, bottom, values);
        break;
    case STATION_SIGNALS:
        station_signals(scene, state->fidelity, arrays, strains, values);
        break;
    case CLEARANCE_SIGNALS:
        clearance_signals(scene, state, arrays, values);
        break;
    case NEAREST_SIGNALS: /* the same numbers in the same order */
        memcpy(values + SIGNAL_NEAREST_LINING_CLEARANCE, state->nearest, sizeof state->nearest);
        break;
    case GUARD_SIGNALS:
        guard_signals(&state->guard, values);
        break;
    default: /* the simulator computes added masses and contact itself */
        break;
    }
}
