/* Values of the rope's outputs, by the names of signals.signal_table. */

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "contact_balance.h"
#include "diagnostics.h"
#include "ends.h"
#include "formulas.h"
#include "guards.h"
#include "loop.h"
#include "partition.h"
#include "rigid.h"
#include "rope.h"
#include "rope_system.h"
#include "sensitivity.h"
#include "shaft.h"
#include "signal_numbers.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "system.h"
#include "transfer.h"

#include "state_signals.h" /* state_signals: generated */

/* Return the loop's lowest point, which is kept until the state changes. */
static const LoopBottom *loop(Simulator *sim) {
    if (!sim->bottom_known) {
        const NodalArrays nodal = state_arrays(sim->state);
        sim->bottom = loop_bottom(nodal.nodes, nodal.q, nodal.s);
        sim->bottom_known = true;
    }
    return &sim->bottom;
}

static void end_signals(Simulator *sim, double *values) {
    const State *state = sim->state;
    const NodalArrays nodal = state_arrays(sim->state);
    for (int side = LEFT; side <= RIGHT; side++, values += SIGNAL_RIGHT_FX - SIGNAL_LEFT_FX) {
        const double *q = end_row(nodal.q, nodal.nodes, side);
        const double *v = end_row(nodal.v, nodal.nodes, side);
        const double *reaction = end_row(nodal.reaction, nodal.nodes, side);
        const double torque = ends_moment(&sim->scene, state, &nodal, side);
        frame_conveyance_load(q, reaction, torque, values + SIGNAL_LEFT_FX);
        const RelativeTurn turn = ends_relative(state, side, state->t, q[ANGLE], v[ANGLE]);
        values[SIGNAL_LEFT_SWIVEL_ANGLE] = turn.angle;
        values[SIGNAL_LEFT_SWIVEL_RATE] = turn.rate;
        values[SIGNAL_LEFT_FY_MEAN] = state->force_mean[side];
        values[SIGNAL_LEFT_SWIVEL_TORQUE] = torque;
        values[SIGNAL_LEFT_SWIVEL_SLIPPING] = state->swivels[side].phase == SLIP;
    }
}

static void loop_signals(Simulator *sim, double *values) {
    const Scene *scene = &sim->scene;
    const State *state = sim->state;
    const NodalArrays nodal = state_arrays(sim->state);
    const LoopBottom *bottom = loop(sim);
    memcpy(values + SIGNAL_LOOP_X, bottom->position, sizeof bottom->position);
    values[SIGNAL_LOOP_YAW] = centreline_nearest_turn(bottom->yaw, state->loop_yaw);
    values[SIGNAL_LOOP_CLEARANCE] = leg_clearance(nodal.nodes, nodal.q, nodal.s, bottom, estimates_loop_width(scene),
                                                  scene->rope.diameter, scene->layout.spacing, sim->nearest_blocks);
    values[SIGNAL_LOOP_TURNS] = centreline_turns(values[SIGNAL_LOOP_YAW], ends_yaw(&nodal), state->crossing.net);
    values[SIGNAL_LOOP_RISE] = guards_rise(scene, state, &nodal, bottom);
    values[SIGNAL_LOOP_SIDEWAYS] = guard_sideways(bottom->position, nodal.q, end_row(nodal.q, nodal.nodes, RIGHT));
}

static void clearance_signals(Simulator *sim, double *values) {
    const NodalArrays nodal = state_arrays(sim->state);
    Nearest nearest[KINDS];
    shaft_clearances(&sim->scene, &nodal, sim->state->t, nearest);
    for (int kind = 0; kind < KINDS; kind++) values[SIGNAL_CLEARANCE_LINING + kind] = nearest[kind].clearance;
}

/* values of physics.stress.material_values */
enum { BENDING_STRESS, TORSIONAL_STRESS, CURVATURE, TORQUE, MATERIAL_VALUES };

static double material_value(const Rope *rope, bool torsional, const double strains[STRAINS], int which) {
    double found[MATERIAL_VALUES];
    stress_material_values(rope, torsional, strains, found);
    return found[which];
}

static void stress_signals(Simulator *sim, double *values) {
    const NodalArrays nodal = state_arrays(sim->state);
    const bool torsional = sim->state->fidelity == TORSIONAL;
    const int last = nodal.elements - 1;
    int lowest = 0;
    rope_system_strains(sim);
    values[SIGNAL_STRESS_BENDING_MAX] = values[SIGNAL_STRESS_TORSION_MAX] = -HUGE_VAL;
    for (int k = 0; k <= last; k++)
        for (int which = BENDING_STRESS; which <= TORSIONAL_STRESS; which++) {
            double *most = values + SIGNAL_STRESS_BENDING_MAX + which;
            *most = fmax(*most, material_value(&sim->scene.rope, torsional, sim->work.strains[k], which));
        }
    while (lowest < last && nodal.s[lowest + 1] < loop(sim)->s) lowest++;
    values[SIGNAL_LEFT_TWIST] = sim->work.strains[0][STRAIN_TAU];
    values[SIGNAL_RIGHT_TWIST] = sim->work.strains[last][STRAIN_TAU];
    values[SIGNAL_LOOP_TWIST] = sim->work.strains[lowest][STRAIN_TAU];
}

static void contact_signals(Simulator *sim, double *values) {
    const NodalArrays nodal = state_arrays(sim->state);
    const System sys = rope_system(sim, sim->state);
    double sums[CONTACT_BALANCE] = {0};
    if (sim->state->fidelity != RIGID) external_sums(&sys, nodal.q, nodal.v, sums);
    memcpy(values + SIGNAL_CONTACT_LINING, sums + CONTACT_FORCES, sizeof(double) * (KINDS + 1));
}

static void audit_signals(Simulator *sim, double *values) {
    audit_signal_values(&sim->state->audit, values + SIGNAL_AUDIT_MOMENTUM);
}

static void error_signals(Simulator *sim, double *values) {
    const State *state = sim->state;
    const double fine_length = partition_fine_length(&state->pattern, state_arrays(sim->state).lengths);
    const InputFilter *left = &state->filters[LEFT];
    const InputFilter *right = &state->filters[RIGHT];
    double at_ends = step_errors_end_force_error(&sim->scene.rope, &state->errors);
    double of_place = step_errors_loop_error(&sim->scene, &state->errors, fine_length, state->pattern.grading_length,
                                             state->counts.transformations);
    at_ends = add_leg_force_error(&sim->scene, at_ends, &state->waves, &state->errors);
    of_place = add_leg_loop_error(&sim->scene, of_place, &state->waves, state->errors.time);
    at_ends = add_contact_end_error(at_ends, &state->contact, state->errors.time, state->errors.force);
    of_place = add_contact_loop_error(&sim->scene, of_place, &state->contact);
    values[SIGNAL_STATUS_END_FORCE_ERROR] = add_misfit_error(at_ends, &state->errors, left, right);
    values[SIGNAL_STATUS_LOOP_ERROR] = input_misfit_add_drift_error(of_place, left, right);
    values[SIGNAL_STATUS_CONTACT_ERROR] = contact_error(&state->contact);
}

/* Coordinates of the points at arc lengths `places`: all x, then all y, then all z. */
static void points_at(State *state, const double *places, double *values) {
    const NodalArrays nodal = state_arrays(state);
    double xyz[SHAPE_POINTS][3];
    diagnostics_shape(nodal.nodes, nodal.q, nodal.s, SHAPE_POINTS, places, xyz);
    for (int i = 0; i < SHAPE_POINTS; i++)
        for (int axis = 0; axis < 3; axis++) values[SHAPE_POINTS * axis + i] = xyz[i][axis];
}

static void shape_signals(Simulator *sim, double *values) {
    const NodalArrays nodal = state_arrays(sim->state);
    double places[SHAPE_POINTS];
    shape_places(nodal.s[nodal.elements], loop(sim)->s, estimates_loop_width(&sim->scene), SHAPE_POINTS, places);
    points_at(sim->state, places, values + SIGNAL_SHAPE_X_1);
}

/* Interpolate a material value at arc lengths `places`, which ascend, between the middles of the elements. */
static void along(const Simulator *sim, const double *places, int which, double *values) {
    const Rope *rope = &sim->scene.rope;
    const bool torsional = sim->state->fidelity == TORSIONAL;
    const NodalArrays nodal = state_arrays(sim->state);
    for (int i = 0, k = 0; i < SHAPE_POINTS; i++) {
        k = middle_before(nodal.nodes, nodal.s, k, places[i]);
        const int next = k < nodal.nodes - 2 ? k + 1 : k;
        const double value = material_value(rope, torsional, sim->work.strains[k], which);
        const double following = material_value(rope, torsional, sim->work.strains[next], which);
        values[i] = interpolate_midpoints(nodal.nodes, nodal.s, k, places[i], value, following);
    }
}

static void pull_at(const Scene *scene, State *state, const double *places, double *tension) {
    const double rho = scene->rope.mass_per_length;
    const double gravity = scene->layout.gravity;
    const NodalArrays nodal = state_arrays(state);
    double xyz[3 * SHAPE_POINTS];
    if (state->fidelity != RIGID) {
        diagnostics_tension(&nodal, rho, gravity, SHAPE_POINTS, places, tension);
        return;
    }
    points_at(state, places, xyz);
    rigid_tension(&nodal, rho, gravity, SHAPE_POINTS, places, xyz + SHAPE_POINTS, tension);
}

static void along_signals(Simulator *sim, double *values) {
    const NodalArrays nodal = state_arrays(sim->state);
    double *places = values + SIGNAL_SHAPE_S_1;
    rope_system_strains(sim);
    shape_places(nodal.s[nodal.elements], loop(sim)->s, estimates_loop_width(&sim->scene), SHAPE_POINTS, places);
    pull_at(&sim->scene, sim->state, places, values + SIGNAL_SHAPE_TENSION_1);
    along(sim, places, BENDING_STRESS, values + SIGNAL_SHAPE_BENDING_1);
    along(sim, places, TORSIONAL_STRESS, values + SIGNAL_SHAPE_TORSION_1);
}

static void station_signals(Simulator *sim, double *values) {
    const Stations *station = &sim->scene.station;
    const NodalArrays nodal = state_arrays(sim->state);
    const double step = (station->last - station->first) / (SHAPE_POINTS - 1);
    double places[SHAPE_POINTS];
    rope_system_strains(sim);
    for (int i = 0; i < SHAPE_POINTS; i++)
        places[i] = nodal.s[nodal.elements] * (i < SHAPE_POINTS - 1 ? i * step + station->first : station->last);
    pull_at(&sim->scene, sim->state, places, values + SIGNAL_STATION_TENSION_1);
    along(sim, places, CURVATURE, values + SIGNAL_STATION_CURVATURE_1);
    along(sim, places, TORQUE, values + SIGNAL_STATION_TORQUE_1);
    points_at(sim->state, places, values + SIGNAL_STATION_X_1);
}

/* Return a signal; the first call after a change of state computes its group. */
static double value_of(Simulator *sim, int signal) {
    static const signed char groups[] = SIGNAL_GROUPS;
    /* each writes the values of its group into (SIGNALS) */
    static void (*const compute[])(Simulator *, double *) = GROUP_FUNCTIONS;
    if (!sim->initialized || signal < 0 || signal >= SIGNALS) return NAN;
    const int group = groups[signal];
    if (!(sim->computed_groups & 1u << group)) compute[group](sim, sim->values);
    sim->computed_groups |= 1u << group;
    return sim->values[signal];
}

void rope_signals(Simulator *sim, size_t count, const int *signals, double *values) {
    for (size_t k = 0; k < count; k++) values[k] = value_of(sim, signals[k]);
}
