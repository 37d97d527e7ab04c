/* The hoist drive as a model: controller and plant over one communication step.

   The controller samples at its own period; from a sample to the next its torque is held, and over a communication step
   the rope forces.  Between samples and communication points the plant does steps of equal length, none longer than
   solver.step_max, by the method of hoist_demo.drive.integrator.  The host controls the length of its steps by their
   error instead, and its forces change within a communication step.  drive_table.h and the functions drive_... are
   generated.  The numbers of hoist and trip lie behind the start values. */
#include "drive_table.h"

#include <math.h>
#include <string.h>

#include "model.h"

#define DUE 1e-9 /* s, before which a sample is taken: the rounding of the host's times */

typedef struct {
    double t, start, hold, integral, left_start;
    double samples; /* taken so far: a whole number */
    double x[DRIVE_STATES], u[DRIVE_INPUTS], free_lengths[2];
    double outputs[DRIVE_OUTPUTS]; /* of the plant, then reference and command */
    double held;                   /* s, last step, if its forces differed from those of the step before; else 0 */
} State;

struct ModelInstance {
    State state, next;
    void (*deallocate)(void *);
    double parameters[DRIVE_PARAMETERS], data[DRIVE_DATA];
    const double *arg[DRIVE_ARG];
    double *res[DRIVE_RES], w[DRIVE_W];
    int iw[DRIVE_IW];
    char warning[MESSAGE_BYTES];
};

typedef struct {
    double s, v, a;
} Motion;

/* the trip at t, s after its start; it rests before, as hoist_demo.control.trajectory has it.  A segment: its start, s;
   position, speed, acceleration there, and its jerk */
static Motion reference(const ModelInstance *model, double t) {
    const double *trip = model->data + DRIVE_DATA_TRIP;
    int k = (int)model->data[DRIVE_DATA_SEGMENTS] - 1;
    while (k >= 0 && t < trip[5 * k]) k--;
    if (k < 0) return (Motion){0.0, 0.0, 0.0};
    const double *at = trip + 5 * k;
    const double dt = t - at[0];
    const double s = at[1];
    const double v = at[2];
    const double a = at[3];
    const double j = at[4];
    return (Motion){s + dt * (v + dt * (a / 2.0 + dt * j / 6.0)), v + dt * (a + dt * j / 2.0), a + dt * j};
}

/* Return x and z of the place where a rope hangs on a conveyance. */
static const double *place(const ModelInstance *model, int rope, int side) {
    return model->data + DRIVE_DATA_PLACES + 2 * (2 * rope + side);
}

static int ropes(const ModelInstance *model) {
    return (int)model->data[DRIVE_DATA_ROPES];
}

static void plant_outputs(ModelInstance *model, State *s) {
    double plant[DRIVE_PLANT_OUTPUTS], centre[DRIVE_MOVED], turn[3];
    model->arg[0] = s->x;
    model->arg[1] = s->u;
    model->arg[2] = s->free_lengths;
    model->arg[3] = model->data + DRIVE_DATA_NUMBERS;
    model->res[0] = plant;
    drive_outputs(model->arg, model->res, model->iw, model->w, 0);
    memcpy(s->outputs, plant, DRIVE_MOTIONS * sizeof *plant);
    memcpy(s->outputs + DRIVE_DRIVE_OUTPUTS, plant + DRIVE_DRIVE_IN_PLANT, DRIVE_DRIVE_SIGNALS * sizeof *plant);
    for (int rope = 0; rope < ropes(model); rope++)
        for (int side = 0; side < 2; side++) {
            for (int i = 0; i < DRIVE_MOVED; i++) centre[i] = plant[DRIVE_CENTRE[side][i]];
            for (int i = 0; i < 3; i++) turn[i] = plant[DRIVE_TURN[side][i]];
            model->arg[0] = place(model, rope, side);
            model->arg[1] = centre;
            model->arg[2] = turn;
            model->res[0] = s->outputs + DRIVE_MOTIONS + DRIVE_MOVED * (2 * rope + side);
            drive_point(model->arg, model->res, model->iw, model->w, 0);
        }
}

static void control_outputs(const ModelInstance *model, State *s) {
    Motion r = reference(model, s->t - s->start - model->parameters[DRIVE_TRIP_START]);
    double *shown = s->outputs + DRIVE_CONTROL;
    memcpy(shown, (const double[]){r.s, r.v, r.a, s->u[0]}, 4 * sizeof *shown);
}

static bool read_parameters(double *parameters, const double *values, char *message) {
    for (int i = 0; i < DRIVE_PARAMETERS; i++) {
        const double lowest = DRIVE_BOUNDS[i][0], highest = i == DRIVE_STEP_MAX ? model_start(i) : DRIVE_BOUNDS[i][1];
        if (!(values[i] >= lowest && values[i] <= highest)) {
            write_message(message,
                          "%s = %.9g is out of range: it must be at least %.9g and at most %.9g; "
                          "give the value of the export, %.9g",
                          MODEL_VARIABLES[i].name, values[i], lowest, highest, model_start(i));
            return false;
        }
    }
    memcpy(parameters, values, DRIVE_PARAMETERS * sizeof(double));
    return true;
}

bool model_has_events(void) {
    return false;
}

bool model_open(const char *resources, char *message) {
    (void)resources, (void)message; /* all is in this library */
    return true;
}

ModelInstance *model_create(const double *values, const Allocator *allocator, char *message) {
    ModelInstance *model = allocator->allocate(1, sizeof *model);
    if (!model) {
        write_message(message, "no memory for the drive; free other instances first");
        return NULL;
    }
    memset(model, 0, sizeof *model);
    model->deallocate = allocator->deallocate;
    for (int i = 0; i < DRIVE_DATA; i++) model->data[i] = model_start(MODEL_SCALARS + i);
    if (read_parameters(model->parameters, values, message)) return model;
    model->deallocate(model);
    return NULL;
}

void model_destroy(ModelInstance *model) {
    if (model) model->deallocate(model);
}

/* Sum the forces of all balance ropes into the plant input: of each rope left.fy_mean, right.fy_mean, then fx, fz and
   my of either side. */
static void add_up(ModelInstance *model, State *s, const double *values) {
    double *sum = s->u + 1;
    double moment;
    memset(sum, 0, (DRIVE_INPUTS - 1) * sizeof *sum);
    for (int rope = 0; rope < ropes(model); rope++) {
        const double *force = values + DRIVE_FORCE + DRIVE_FORCES_OF_ROPE * rope;
        for (int side = 0; side < 2; side++) {
            const double fy = force[side];
            const double *lateral = force + 2 + 3 * side;
            double *sides = sum + 3 + 3 * side;
            model->arg[0] = place(model, rope, side);
            model->arg[1] = s->x + DRIVE_YAW[side];
            model->arg[2] = (const double[]){lateral[0], fy, lateral[1]};
            model->res[0] = &moment;
            drive_moment(model->arg, model->res, model->iw, model->w, 0);
            sum[side] += fy;
            sides[0] += lateral[0];
            sides[1] += lateral[1];
            sides[2] += lateral[2] + moment;
        }
    }
}

static const char *of_all(const ModelInstance *model) {
    return ropes(model) > 1 ? " (all ropes)" : "";
}

bool model_initialize(ModelInstance *model, double t, const double *values, char *message) {
    State *s = &model->next;
    const double lowest = model->data[DRIVE_DATA_LOWEST_FORCE], limit = model->data[DRIVE_DATA_TORQUE_LIMIT];
    double pull[2];
    memset(s, 0, sizeof *s);
    add_up(model, s, values);
    memcpy(pull, s->u + 1, sizeof pull);
    for (int i = 0; i < 2; i++) {
        if (pull[i] == 0.0)
            pull[i] = model->parameters[DRIVE_FY_START + i]; /* containers initialise what they connect */
        if (!(pull[i] >= lowest && pull[i] <= 0.0)) {
            write_message(
                message,
                "%s%s = %.9g N at the start must be between %.9g N and 0: it is the balance rope's pull at rest, "
                "check the rope's mass and the sign",
                MODEL_VARIABLES[DRIVE_FORCE + i].name, of_all(model), pull[i], lowest);
            return false;
        }
    }
    s->t = s->start = t;
    model->arg[0] = model->data + DRIVE_DATA_HEIGHTS;
    model->arg[1] = pull;
    model->arg[2] = model->data + DRIVE_DATA_NUMBERS;
    model->res[0] = s->x;
    model->res[1] = s->free_lengths;
    drive_rest(model->arg, model->res, model->iw, model->w, 0);
    if (!(fabs(s->x[0]) <= limit)) {
        write_message(message,
                      "holding torque = %.6g N m must be within +-%.6g N m, that of the motor: check "
                      "the forces %s = %.9g N and %s = %.9g N%s at the start",
                      s->x[0], limit, MODEL_VARIABLES[DRIVE_FORCE].name, pull[0], MODEL_VARIABLES[DRIVE_FORCE + 1].name,
                      pull[1], of_all(model));
        return false;
    }
    memset(s->u, 0, sizeof s->u);
    s->u[0] = s->hold = s->x[0];
    memcpy(s->u + 1, pull, sizeof pull); /* the sides come with the first step: the conveyances hang in the middle */
    plant_outputs(model, s);
    s->left_start = s->outputs[DRIVE_LEFT_Y];
    control_outputs(model, s);
    model->state = *s;
    return true;
}

/* Take a sample: the torque from now on, and the integral at the next sample. */
static void control(ModelInstance *model, State *s) {
    Motion r = reference(model, s->t - s->start - model->parameters[DRIVE_TRIP_START]);
    const double speed = model->data[DRIVE_DATA_RADIUS] * s->outputs[DRIVE_RATE];
    const double travel = s->outputs[DRIVE_LEFT_Y] - s->left_start;
    const double sample[] = {r.s, r.v, r.a, travel, speed, s->hold, s->integral, model->parameters[DRIVE_PERIOD]};
    double torque, integral;
    model->arg[0] = sample;
    model->arg[1] = model->parameters + DRIVE_GAINS;
    model->arg[2] = model->data + DRIVE_DATA_NUMBERS;
    model->res[0] = &torque;
    model->res[1] = &integral;
    drive_control(model->arg, model->res, model->iw, model->w, 0);
    s->u[0] = torque;
    s->integral = integral;
    s->samples += 1.0;
}

/* Advance the plant by h, under the input held: a step of the Runge-Kutta method with the weights a and b,
   k_i = rates(x + h sum_j a_ij k_j),  x + h sum_i b_i k_i. */
static void plant_step(ModelInstance *model, State *s, double h) {
    double k[DRIVE_STAGES][DRIVE_STATES], x[DRIVE_STATES];
    memcpy(x, s->x, sizeof x);
    for (int stage = 0; stage < DRIVE_STAGES; stage++) {
        const double *weights = DRIVE_WEIGHTS[stage];
        model->arg[0] = x;
        model->arg[1] = s->u;
        model->arg[2] = s->free_lengths;
        model->arg[3] = model->data + DRIVE_DATA_NUMBERS;
        model->res[0] = k[stage];
        drive_rates(model->arg, model->res, model->iw, model->w, 0);
        for (int i = 0; i < DRIVE_STATES; i++) {
            double sum = weights[0] * k[0][i];
            for (int j = 1; j <= stage; j++)
                if (weights[j] != 0.0) sum += weights[j] * k[j][i];
            x[i] = s->x[i] + h * sum;
        }
    }
    memcpy(s->x, x, sizeof x);
}

/* Check that the state is finite and that rope is left at the sheave. */
static bool sound(const ModelInstance *model, const State *s, char *message) {
    const double wound = model->data[DRIVE_DATA_RADIUS] * s->x[1];
    double left = s->free_lengths[0] - wound, right = s->free_lengths[1] + wound;
    for (int i = 0; i < DRIVE_STATES; i++)
        if (!isfinite(s->x[i])) {
            write_message(message,
                          "the drive's state is not finite after t = %.9g s; check the forces "
                          "%s = %.9g N and %s = %.9g N%s",
                          s->t, MODEL_VARIABLES[DRIVE_FORCE].name, s->u[1], MODEL_VARIABLES[DRIVE_FORCE + 1].name,
                          s->u[2], of_all(model));
            return false;
        }
    if (fmin(left, right) > DRIVE_MIN_ROPE) return true;
    write_message(message,
                  "head rope of %.3g m left at the sheave, not above %.3g m: overwind; check trip, "
                  "gains and rope forces",
                  fmin(left, right), DRIVE_MIN_ROPE);
    return false;
}

/* Check that the ropes' forces accelerate the conveyances as a rope's ends may be. */
static bool can_follow(const ModelInstance *model, const State *s, char *message) {
    for (int i = 0; i < DRIVE_ACCELERATIONS; i++) {
        const int shown = DRIVE_ACCELERATION[i];
        if (fabs(s->outputs[shown]) <= DRIVE_HARDEST) continue;
        write_message(
            message,
            "%s = %.9g N and %s = %.9g N%s would make %s %.3g m/s2, not within +-%g m/s2: check units, signs and "
            "connections of the balance rope's forces",
            MODEL_VARIABLES[DRIVE_FORCE].name, s->u[1], MODEL_VARIABLES[DRIVE_FORCE + 1].name, s->u[2], of_all(model),
            MODEL_VARIABLES[DRIVE_FIRST_OUTPUT + shown].name, s->outputs[shown], DRIVE_HARDEST);
        return false;
    }
    return true;
}

/* Return 1 if a vertical force of the balance ropes differs from that of the step before. */
static bool forces_changed(const State *before, const State *now) {
    return before->u[1] != now->u[1] || before->u[2] != now->u[2];
}

/* Advance by h in equal steps under the torque held. */
static bool advance(ModelInstance *model, State *s, double h, char *message) {
    const double steps = fmax(1.0, ceil(h / model->parameters[DRIVE_STEP_MAX] - 1e-9)), part = h / steps;
    for (long k = 0; k < (long)steps; k++) {
        plant_step(model, s, part);
        if (!sound(model, s, message)) return false;
    }
    return true;
}

bool model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message) {
    (void)event; /* none */
    const double stop = t + h, period = model->parameters[DRIVE_PERIOD];
    State *s = &model->next;
    h += t - model->state.t; /* rests of rounding size included */
    const double steps = ceil(h / model->parameters[DRIVE_STEP_MAX] - 1e-9);
    if (!(steps <= DRIVE_MOST_STEPS)) {
        write_message(message,
                      "communication step %.9g s needs %.3g internal steps of %.3g s, more than %d; "
                      "take shorter ones",
                      h, steps, model->parameters[DRIVE_STEP_MAX], DRIVE_MOST_STEPS);
        return false;
    }
    *s = model->state;
    add_up(model, s, values);
    s->held = forces_changed(&model->state, s) ? h : 0.0;
    for (int first = 1; first || h > DUE; first = 0) {
        double next = s->start + s->samples * period - s->t; /* s, until the next sample */
        if (next <= DUE) {
            control(model, s);
            next = s->start + s->samples * period - s->t;
        }
        if (first) {
            plant_outputs(model, s);
            if (!can_follow(model, s, message)) return false;
        }
        const int last = next > h - DUE;
        if (!advance(model, s, last ? h : next, message)) return false;
        h = last ? 0.0 : h - next;
        s->t = last ? stop : s->t + next;
        plant_outputs(model, s);
    }
    control_outputs(model, s);
    model->state = *s;
    return true;
}

bool model_retune(ModelInstance *model, const double *values, char *message) {
    return read_parameters(model->parameters, values, message);
}

bool model_time(const ModelInstance *model, double *t, char *message) {
    (void)message;
    *t = model->state.t;
    return true;
}

bool model_output(ModelInstance *model, size_t scalar, double *value, char *message) {
    (void)message;
    *value = model->state.outputs[scalar - DRIVE_FIRST_OUTPUT];
    return true;
}

bool model_warning(ModelInstance *model, int index, char *message) {
    const double held = model->state.held;
    message[0] = '\0';
    if (index) return false;
    if (held > DRIVE_LONGEST_HOLD)
        write_message(
            message,
            "the rope forces, which change, are held over the communication step of %.4g s, longer than %g s: the "
            "motion depends on the step; take a shorter one",
            held, DRIVE_LONGEST_HOLD);
    return true;
}

bool model_text(ModelInstance *model, size_t scalar, const char **text, char *message) {
    (void)message;
    *text = "";
    if (scalar == DRIVE_WARNING && model_warning(model, 0, model->warning)) *text = model->warning;
    return true;
}

bool model_note(const ModelInstance *model, char *note, char *message) {
    (void)message;
    write_message(note, "drive: %d states, internal steps of at most %.3g s", DRIVE_STATES,
                  model->parameters[DRIVE_STEP_MAX]);
    return true;
}

bool model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                      double *sum, char *message) {
    (void)model, (void)known, (void)seed, (void)unknown, (void)count, (void)sum;
    write_message(message, "the drive has no directional derivatives; take differences");
    return false;
}

bool model_state_bytes(const ModelInstance *model, size_t *bytes, char *message) {
    (void)message;
    *bytes = sizeof model->state;
    return true;
}

bool model_save(const ModelInstance *model, void *to, size_t bytes, char *message) {
    (void)message;
    memcpy(to, &model->state, bytes);
    return true;
}

bool model_restore(ModelInstance *model, const void *from, size_t bytes, char *message) {
    if (bytes != sizeof model->state) {
        write_message(message, "a state of the drive has %d bytes, not %d; save it anew", (int)sizeof model->state,
                      (int)bytes);
        return false;
    }
    memcpy(&model->state, from, sizeof model->state);
    return true;
}
