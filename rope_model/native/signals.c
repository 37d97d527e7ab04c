/* Values of the output signals: the twin of rope_model.simulation.signals. */
#include "signals.h"

#include <math.h>
#include <string.h>

/* of the conveyance's yaw in theta */
static const double YAW_SENSE[2] = {-1.0, 1.0};

int signal_group(int signal) {
    static const signed char groups[] = {SIGNAL_GROUPS};
    return signal >= 0 && signal < SIGNALS ? groups[signal] : -1;
}

/* Moment of the conveyance on the rope's end, from the reactions to r' and theta: the reaction to r' at fixed theta
   holds a part of the torque, which the last term gives back. */
void signals_end_moment(const double *q, const double *reaction, const double pole[3], double torque, double moment[3]) {
    const double *d = q + SLOPE, *f = reaction + SLOPE;
    double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    double t[3] = {d[0] / length, d[1] / length, d[2] / length};
    double along = pole[0] * t[0] + pole[1] * t[1] + pole[2] * t[2];
    double tilting[3] = {d[1] * f[2] - d[2] * f[1], d[2] * f[0] - d[0] * f[2], d[0] * f[1] - d[1] * f[0]};
    for (int axis = 0; axis < 3; axis++)
        moment[axis] = tilting[axis] + torque * (t[axis] + (pole[axis] - t[axis] * along) / (1 + along));
}

static void end_signals(int side, const Scene *scene, const State *state, const Arrays *arrays, double *values) {
    const Swivel *swivel = &scene->swivels[side];
    const SwivelState *held = &state->swivels[side];
    ptrdiff_t row = side == LEFT ? 0 : (ptrdiff_t)DOF * (arrays->nodes - 1);
    const double *q = arrays->q + row, *v = arrays->v + row, *reaction = arrays->reaction + row;
    double torque = reaction[ANGLE], moment[3], yaw[3];
    if (held->phase == SLIP)
        torque = -held->sign * swivel_friction(swivel, swivel->mu_kinetic, reaction[1]);
    signals_end_moment(q, reaction, state->pole, torque, moment);
    path_rates(&state->paths[side], state->t, 3, yaw);

    /* both ends have the same signals in the same order */
    if (side == RIGHT)
        values += SIGNAL_RIGHT_FX - SIGNAL_LEFT_FX;
    for (int axis = 0; axis < 3; axis++) {
        values[SIGNAL_LEFT_FX + axis] = -reaction[axis];
        values[SIGNAL_LEFT_MX + axis] = -moment[axis];
    }
    values[SIGNAL_LEFT_FY_MEAN] = state->force_mean[side];
    values[SIGNAL_LEFT_SWIVEL_ANGLE] = q[ANGLE] - state->offsets[side] - YAW_SENSE[side] * yaw[0];
    values[SIGNAL_LEFT_SWIVEL_RATE] = v[ANGLE] - YAW_SENSE[side] * yaw[1];
    values[SIGNAL_LEFT_SWIVEL_TORQUE] = torque;
    values[SIGNAL_LEFT_SWIVEL_SLIPPING] = held->phase == SLIP;
}

static void loop_signals(const Scene *scene, const State *state, const Arrays *arrays, const LoopBottom *bottom,
                         double *values) {
    memcpy(values + SIGNAL_LOOP_X, bottom->position, sizeof bottom->position);
    values[SIGNAL_LOOP_YAW] = frame_counted_on(bottom->yaw, state->loop_yaw);
    values[SIGNAL_LOOP_CLEARANCE] = shape_leg_clearance(arrays->nodes, arrays->q, arrays->s, bottom,
                                                        scene->rope.diameter, scene->layout.spacing);
}

/* nominal stresses as in a solid round bar; bending is root mean square along the element */
static void stress_signals(const Rope *rope, int rung, const Arrays *arrays, const double (*strains)[4], const LoopBottom *bottom,
                           double *values) {
    double Qs = 0.5 * (rope->Qb + rope->Qc), Qk = 0.5 * (rope->Qb - rope->Qc);
    double section = PI * pow(rope->diameter, 3), bending = -HUGE_VAL, torsion = -HUGE_VAL;
    for (int k = 0; k < arrays->elements; k++) {
        double e = strains[k][0], tau = strains[k][1], k_rms = strains[k][2];
        bending = fmax(bending, 32 * rope->EI * k_rms / section);
        torsion = fmax(torsion, 16 * fabs((Qs - Qk) * e + rope->Qd * tau) / section);
    }
    /* what a rung does not compute is 0, as torques and moments are */
    bending *= rung != RIGID;
    torsion *= rung == TORSIONAL;
    int last = arrays->elements - 1, lowest = 0;
    while (lowest < last && arrays->s[lowest + 1] < bottom->s)
        lowest++;
    values[SIGNAL_LEFT_TWIST] = strains[0][1];
    values[SIGNAL_RIGHT_TWIST] = strains[last][1];
    values[SIGNAL_LOOP_TWIST] = strains[lowest][1];
    values[SIGNAL_STRESS_BENDING_MAX] = bending;
    values[SIGNAL_STRESS_TORSION_MAX] = torsion;
}

static void book_signals(const Ledger *energy, const Counts *count, double *values) {
    double total = energy->kinetic + energy->strain + energy->gravity;
    double explained =
        energy->work_ends + energy->transformations - energy->dissipated_material - energy->dissipated_swivel;
    values[SIGNAL_ENERGY_KINETIC] = energy->kinetic;
    values[SIGNAL_ENERGY_STRAIN] = energy->strain;
    values[SIGNAL_ENERGY_GRAVITY] = energy->gravity;
    values[SIGNAL_ENERGY_TOTAL] = total;
    values[SIGNAL_ENERGY_WORK_ENDS] = energy->work_ends;
    values[SIGNAL_ENERGY_DISSIPATED_MATERIAL] = energy->dissipated_material;
    values[SIGNAL_ENERGY_DISSIPATED_SWIVEL] = energy->dissipated_swivel;
    values[SIGNAL_ENERGY_NONCONSERVATIVE] = energy->nonconservative;
    values[SIGNAL_ENERGY_TRANSFORMATIONS] = energy->transformations;
    values[SIGNAL_ENERGY_RESIDUAL] = total - energy->start - explained + energy->nonconservative;
    values[SIGNAL_COUNT_STEPS] = (double)count->steps;
    values[SIGNAL_COUNT_REJECTIONS] = (double)count->rejections;
    values[SIGNAL_COUNT_NEWTON] = (double)count->newton;
    values[SIGNAL_COUNT_TRANSFORMATIONS] = (double)count->transformations;
    values[SIGNAL_COUNT_SWIVEL_EVENTS] = (double)count->swivel_events;
}

static void shape_signals(const Arrays *arrays, const LoopBottom *bottom, double *values) {
    double xyz[SHAPE_POINTS][3];
    shape_points(arrays->nodes, arrays->q, arrays->s, bottom->s, SHAPE_POINTS, xyz[0]);
    for (int i = 0; i < SHAPE_POINTS; i++) {
        values[SIGNAL_SHAPE_X_1 + i] = xyz[i][0];
        values[SIGNAL_SHAPE_Y_1 + i] = xyz[i][1];
        values[SIGNAL_SHAPE_Z_1 + i] = xyz[i][2];
    }
}

void signals_of(int group, const Scene *scene, const State *state, const Arrays *arrays, const double (*strains)[4],
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
        stress_signals(&scene->rope, state->rung, arrays, strains, bottom, values);
        break;
    case BOOK_SIGNALS:
        book_signals(&state->ledger, &state->counts, values);
        break;
    case SHAPE_SIGNALS:
        shape_signals(arrays, bottom, values);
        break;
    default: /* the simulator computes added masses itself */
        break;
    }
}
