/* Values of the output signals: the port of rope_model.simulation.outputs.signals. */
#include <math.h>
#include <string.h>

#include "simulator.h"
#include "state_signals.h" /* state_signals: generated */

static void end_signals(Simulator *rope, double *values) {
    const State *state = rope->state;
    const Arrays m = state_arrays(rope->state);
    for (int side = LEFT; side <= RIGHT; side++, values += SIGNAL_RIGHT_FX - SIGNAL_LEFT_FX) {
        const double *q = end_row(m.q, m.nodes, side), *v = end_row(m.v, m.nodes, side);
        const double *reaction = end_row(m.reaction, m.nodes, side);
        const double torque = swivel_moment(&rope->scene, state, side, reaction);
        conveyance_load(q, reaction, torque, values + SIGNAL_LEFT_FX);
        swivel_relative(state, side, state->t, q[ANGLE], v[ANGLE], values + SIGNAL_LEFT_SWIVEL_ANGLE);
        values[SIGNAL_LEFT_SWIVEL_TORQUE] = torque;
        values[SIGNAL_LEFT_SWIVEL_SLIPPING] = state->swivels[side].phase == SLIP;
    }
}

static void loop_signals(Simulator *rope, double *values) {
    const Scene *scene = &rope->scene;
    const State *state = rope->state;
    const Arrays m = state_arrays(rope->state);
    const LoopBottom *bottom = bottom_now(rope);
    memcpy(values + SIGNAL_LOOP_X, bottom->position, sizeof bottom->position);
    values[SIGNAL_LOOP_YAW] = shape_nearest_turn(bottom->yaw, state->loop_yaw);
    values[SIGNAL_LOOP_CLEARANCE] =
        shape_leg_clearance(m.nodes, m.q, m.s, bottom, loop_width(scene), scene->rope.diameter, scene->layout.spacing);
    values[SIGNAL_LOOP_TURNS] = turns_of(values[SIGNAL_LOOP_YAW], shape_direction(&m), state->crossing.net);
    values[SIGNAL_LOOP_RISE] = guards_rise(scene, state, &m, bottom);
    values[SIGNAL_LOOP_SIDEWAYS] = guards_sideways(&m, bottom);
}

static void clearance_signals(Simulator *rope, double *values) {
    const Arrays m = state_arrays(rope->state);
    Nearest nearest[KINDS];
    shaft_clearances(&rope->scene, &m, rope->state->t, nearest);
    for (int kind = 0; kind < KINDS; kind++) values[SIGNAL_CLEARANCE_LINING + kind] = nearest[kind].clearance;
}

/* the order of physics.stress.material_values */
enum { BENDING_STRESS, TORSIONAL_STRESS, CURVATURE, TORQUE, MATERIAL_VALUES };

/* of an element */
static double material_value(const Simulator *rope, int element, int which) {
    double found[MATERIAL_VALUES];
    material_values(&rope->scene.rope, rope->state->fidelity == TORSIONAL, rope->strains[element], found);
    return found[which];
}

static void stress_signals(Simulator *rope, double *values) {
    const Arrays m = state_arrays(rope->state);
    const int last = m.elements - 1;
    int lowest = 0;
    compute_strains(rope);
    values[SIGNAL_STRESS_BENDING_MAX] = values[SIGNAL_STRESS_TORSION_MAX] = -HUGE_VAL;
    for (int k = 0; k <= last; k++)
        for (int which = BENDING_STRESS; which <= TORSIONAL_STRESS; which++) {
            double *most = values + SIGNAL_STRESS_BENDING_MAX + which;
            *most = fmax(*most, material_value(rope, k, which));
        }
    while (lowest < last && m.s[lowest + 1] < bottom_now(rope)->s) lowest++;
    values[SIGNAL_LEFT_TWIST] = rope->strains[0][1];
    values[SIGNAL_RIGHT_TWIST] = rope->strains[last][1];
    values[SIGNAL_LOOP_TWIST] = rope->strains[lowest][1];
}

static void audit_signals(Simulator *rope, double *values) {
    audit_values(&rope->state->audit, values + SIGNAL_AUDIT_MOMENTUM); /* in their order */
}

static void error_signals(Simulator *rope, double *values) {
    const State *state = rope->state;
    const double fine = mesh_fine_length(&state->pattern, state_arrays(rope->state).lengths);
    const Following *left = &state->following[LEFT], *right = &state->following[RIGHT];
    double at_ends = end_force_error(&rope->scene.rope, &state->errors);
    double of_place = loop_error(&rope->scene, &state->errors, fine, state->pattern.grading_length);
    at_ends = with_contact_at_ends(at_ends, &state->contact, state->errors.time, state->errors.force);
    of_place = with_contact_of_place(&rope->scene, of_place, &state->contact);
    values[SIGNAL_STATUS_END_FORCE_ERROR] = with_misfit(at_ends, &state->errors, left, right);
    values[SIGNAL_STATUS_LOOP_ERROR] = with_drift(of_place, left, right);
    values[SIGNAL_STATUS_CONTACT_ERROR] = contact_error(&state->contact);
}

static void shape_signals(Simulator *rope, double *values) {
    const Arrays m = state_arrays(rope->state);
    double at[SHAPE_POINTS], xyz[SHAPE_POINTS][3];
    shape_places(m.s[m.elements], bottom_now(rope)->s, loop_width(&rope->scene), SHAPE_POINTS, at);
    shape_points(m.nodes, m.q, m.s, SHAPE_POINTS, at, xyz[0]);
    for (int i = 0; i < SHAPE_POINTS; i++)
        for (int axis = 0; axis < 3; axis++) values[SIGNAL_SHAPE_X_1 + SHAPE_POINTS * axis + i] = xyz[i][axis];
}

/* a value of the material at arc lengths `at`, which ascend, linear between the middles of the elements */
static void along(const Simulator *rope, const double *at, int which, double *values) {
    const Arrays m = state_arrays(rope->state);
    for (int i = 0, k = 0; i < SHAPE_POINTS; i++) {
        k = shape_middle_before(m.nodes, m.s, k, at[i]);
        const int next = k < m.nodes - 2 ? k + 1 : k;
        values[i] = shape_interpolate_midpoints(m.nodes, m.s, k, at[i], material_value(rope, k, which),
                                                material_value(rope, next, which));
    }
}

static void pull_at(const Simulator *rope, const double *at, double *tension) {
    const double rho = rope->scene.rope.mass_per_length, gravity = rope->scene.layout.gravity;
    const Arrays m = state_arrays(rope->state);
    double xyz[SHAPE_POINTS][3], y[SHAPE_POINTS];
    if (rope->state->fidelity != RIGID) {
        shape_tension(&m, rho, gravity, SHAPE_POINTS, at, tension);
        return;
    }
    shape_points(m.nodes, m.q, m.s, SHAPE_POINTS, at, xyz[0]);
    for (int i = 0; i < SHAPE_POINTS; i++) y[i] = xyz[i][1];
    rigid_tension(&m, rho, gravity, SHAPE_POINTS, at, y, tension);
}

static void along_signals(Simulator *rope, double *values) {
    const Arrays m = state_arrays(rope->state);
    double *at = values + SIGNAL_SHAPE_S_1;
    compute_strains(rope);
    shape_places(m.s[m.elements], bottom_now(rope)->s, loop_width(&rope->scene), SHAPE_POINTS, at);
    pull_at(rope, at, values + SIGNAL_SHAPE_TENSION_1);
    along(rope, at, BENDING_STRESS, values + SIGNAL_SHAPE_BENDING_1);
    along(rope, at, TORSIONAL_STRESS, values + SIGNAL_SHAPE_TORSION_1);
}

static void station_signals(Simulator *rope, double *values) {
    const Stations *station = &rope->scene.station;
    const Arrays m = state_arrays(rope->state);
    const double step = (station->last - station->first) / (SHAPE_POINTS - 1);
    double at[SHAPE_POINTS];
    compute_strains(rope);
    for (int i = 0; i < SHAPE_POINTS; i++)
        at[i] = m.s[m.elements] * (i < SHAPE_POINTS - 1 ? i * step + station->first : station->last);
    pull_at(rope, at, values + SIGNAL_STATION_TENSION_1);
    along(rope, at, CURVATURE, values + SIGNAL_STATION_CURVATURE_1);
    along(rope, at, TORQUE, values + SIGNAL_STATION_TORQUE_1);
}

double rope_signal(Simulator *rope, int signal) {
    static const signed char groups[] = SIGNAL_GROUPS;
    static void (*const compute[])(Simulator *, double *) = GROUP_FUNCTIONS;
    if (!rope->initialized || signal < 0 || signal >= SIGNALS) return NAN;
    const int group = groups[signal];
    if (!(rope->known & 1u << group)) compute[group](rope, rope->values);
    rope->known |= 1u << group;
    return rope->values[signal];
}

void rope_signals(Simulator *rope, size_t number, const int *signals, double *values) {
    for (size_t k = 0; k < number; k++) values[k] = rope_signal(rope, signals[k]);
}
