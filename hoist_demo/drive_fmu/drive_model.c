/* The hoist drive as a model: controller and plant over one communication step.

   Per step: the reference at its start, the controller's torque, then plant steps of equal length with torque and rope
   forces held, as hoist_demo.cosimulation does it.  The numbers of drive_table.h and the functions drive_... are
   generated. */
#include "drive_table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"

typedef struct {
    double t, start, hold, integral, left_start;
    double x[DRIVE_STATES], u[DRIVE_INPUTS], free_lengths[2];
    double outputs[DRIVE_OUTPUTS]; /* of the plant, then reference and command */
} State;

struct ModelInstance {
    State state, next;
    void (*deallocate)(void *);
    double parameters[DRIVE_PARAMETERS];
    const double *arg[DRIVE_ARG];
    double *res[DRIVE_RES], w[DRIVE_W];
    int iw[DRIVE_IW];
};

typedef struct {
    double s, v, a;
} Motion;

/* the trip at t, s after its start; it rests before */
static Motion reference(double t) {
    int k = DRIVE_SEGMENTS - 1;
    while (k >= 0 && t < DRIVE_TRIP[k][0]) k--;
    if (k < 0) return (Motion){0.0, 0.0, 0.0};
    const double *at = DRIVE_TRIP[k], dt = t - at[0], s = at[1], v = at[2], a = at[3], j = at[4];
    return (Motion){s + dt * (v + dt * (a / 2.0 + dt * j / 6.0)), v + dt * (a + dt * j / 2.0), a + dt * j};
}

static void plant_outputs(ModelInstance *model, State *s) {
    model->arg[0] = s->x;
    model->arg[1] = s->u;
    model->arg[2] = s->free_lengths;
    model->res[0] = s->outputs;
    drive_outputs(model->arg, model->res, model->iw, model->w, 0);
}

static void control_outputs(State *s, const double *parameters) {
    Motion r = reference(s->t - s->start - parameters[DRIVE_TRIP_START]);
    double *shown = s->outputs + DRIVE_PLANT_OUTPUTS;
    memcpy(shown, (const double[]){r.s, r.v, r.a, s->u[0]}, 4 * sizeof *shown);
}

static int read_parameters(double *parameters, const double *values, char *message) {
    for (int i = 0; i < DRIVE_PARAMETERS; i++) {
        if (!(values[i] >= DRIVE_BOUNDS[i][0] && values[i] <= DRIVE_BOUNDS[i][1])) {
            snprintf(message, MESSAGE_BYTES,
                     "%s = %.9g is out of range: it must be at least %.9g and at most %.9g; "
                     "give the value of the export, %.9g",
                     MODEL_VARIABLES[i].name, values[i], DRIVE_BOUNDS[i][0], DRIVE_BOUNDS[i][1], model_start(i));
            return 0;
        }
    }
    memcpy(parameters, values, DRIVE_PARAMETERS * sizeof(double));
    return 1;
}

int model_open(const char *resources, char *message) {
    (void)resources, (void)message; /* all is in this library */
    return 1;
}

ModelInstance *model_create(const double *values, const Allocator *allocator, char *message) {
    ModelInstance *model = allocator->allocate(1, sizeof *model);
    if (!model) {
        snprintf(message, MESSAGE_BYTES, "no memory for the drive; free other instances first");
        return NULL;
    }
    memset(model, 0, sizeof *model);
    model->deallocate = allocator->deallocate;
    if (read_parameters(model->parameters, values, message)) return model;
    model->deallocate(model);
    return NULL;
}

void model_destroy(ModelInstance *model) {
    if (model) model->deallocate(model);
}

/* Sum the forces of all balance ropes into the plant input behind its torque. */
static void add_up(ModelInstance *model, State *s, const double *values) {
    model->arg[0] = s->x;
    model->arg[1] = values + DRIVE_FORCE;
    model->res[0] = s->u + 1;
    drive_input(model->arg, model->res, model->iw, model->w, 0);
}

static const char *const OF_ALL = DRIVE_FORCES > 2 ? " (all ropes)" : "";

int model_initialize(ModelInstance *model, double t, const double *values, char *message) {
    State *s = &model->next;
    double pull[2];
    memset(s, 0, sizeof *s);
    add_up(model, s, values);
    memcpy(pull, s->u + 1, sizeof pull);
    for (int i = 0; i < 2; i++) {
        if (pull[i] == 0.0)
            pull[i] = model->parameters[DRIVE_FY_START + i]; /* containers initialise what they connect */
        if (!(pull[i] >= DRIVE_LOWEST_FORCE && pull[i] <= 0.0)) {
            snprintf(message, MESSAGE_BYTES,
                     "%s%s = %.9g N at the start must be between %.9g N and 0: it is the balance rope's pull at rest, "
                     "check the rope's mass and the sign",
                     MODEL_VARIABLES[DRIVE_FORCE + i].name, OF_ALL, pull[i], DRIVE_LOWEST_FORCE);
            return 0;
        }
    }
    s->t = s->start = t;
    model->arg[0] = pull;
    model->res[0] = s->x;
    model->res[1] = s->free_lengths;
    drive_rest(model->arg, model->res, model->iw, model->w, 0);
    if (!(fabs(s->x[0]) <= DRIVE_TORQUE_LIMIT)) {
        snprintf(message, MESSAGE_BYTES,
                 "holding torque = %.6g N m must be within +-%.6g N m, that of the motor: check "
                 "the forces %s = %.9g N and %s = %.9g N%s at the start",
                 s->x[0], DRIVE_TORQUE_LIMIT, MODEL_VARIABLES[DRIVE_FORCE].name, pull[0],
                 MODEL_VARIABLES[DRIVE_FORCE + 1].name, pull[1], OF_ALL);
        return 0;
    }
    memset(s->u, 0, sizeof s->u);
    s->u[0] = s->hold = s->x[0];
    memcpy(s->u + 1, pull, sizeof pull); /* the sides come with the first step: the conveyances hang in the middle */
    plant_outputs(model, s);
    s->left_start = s->outputs[DRIVE_LEFT_Y];
    control_outputs(s, model->parameters);
    model->state = *s;
    return 1;
}

static void control(ModelInstance *model, State *s, double h) {
    Motion r = reference(s->t - s->start - model->parameters[DRIVE_TRIP_START]);
    const double sample[] = {
        r.s,     r.v,         r.a, s->outputs[DRIVE_LEFT_Y] - s->left_start, DRIVE_RADIUS * s->outputs[DRIVE_RATE],
        s->hold, s->integral, h};
    double torque, integral;
    model->arg[0] = sample;
    model->arg[1] = model->parameters + DRIVE_GAINS;
    model->res[0] = &torque;
    model->res[1] = &integral;
    drive_control(model->arg, model->res, model->iw, model->w, 0);
    s->u[0] = torque;
    s->integral = integral;
}

/* Check that the state is finite and that rope is left at the sheave. */
static int sound(const State *s, char *message) {
    double left = s->free_lengths[0] - DRIVE_RADIUS * s->x[1], right = s->free_lengths[1] + DRIVE_RADIUS * s->x[1];
    for (int i = 0; i < DRIVE_STATES; i++)
        if (!isfinite(s->x[i])) {
            snprintf(message, MESSAGE_BYTES,
                     "the drive's state is not finite after t = %.9g s; check the forces "
                     "%s = %.9g N and %s = %.9g N%s",
                     s->t, MODEL_VARIABLES[DRIVE_FORCE].name, s->u[1], MODEL_VARIABLES[DRIVE_FORCE + 1].name, s->u[2],
                     OF_ALL);
            return 0;
        }
    if (fmin(left, right) > DRIVE_MIN_ROPE) return 1;
    snprintf(message, MESSAGE_BYTES,
             "head rope of %.3g m left at the sheave, not above %.3g m: overwind; check trip, "
             "gains and rope forces",
             fmin(left, right), DRIVE_MIN_ROPE);
    return 0;
}

/* Check that the ropes' forces accelerate the conveyances as a rope's ends may be. */
static int can_follow(const State *s, char *message) {
    for (int i = 0; i < DRIVE_ACCELERATIONS; i++) {
        const int shown = DRIVE_ACCELERATION[i];
        if (fabs(s->outputs[shown]) <= DRIVE_HARDEST) continue;
        snprintf(message, MESSAGE_BYTES,
                 "%s = %.9g N and %s = %.9g N%s would make %s %.3g m/s2, not within +-%g m/s2: check units, signs and "
                 "connections of the balance rope's forces",
                 MODEL_VARIABLES[DRIVE_FORCE].name, s->u[1], MODEL_VARIABLES[DRIVE_FORCE + 1].name, s->u[2], OF_ALL,
                 MODEL_VARIABLES[DRIVE_FIRST_OUTPUT + shown].name, s->outputs[shown], DRIVE_HARDEST);
        return 0;
    }
    return 1;
}

int model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message) {
    (void)event; /* none */
    double stop = t + h, steps, part, x[DRIVE_STATES];
    State *s = &model->next;
    h += t - model->state.t; /* rests of rounding size included */
    steps = ceil(h / model->parameters[DRIVE_STEP_MAX] - 1e-9);
    if (!(steps <= DRIVE_MOST_STEPS)) {
        snprintf(message, MESSAGE_BYTES,
                 "communication step %.9g s needs %.3g internal steps of %.3g s, more than %d; "
                 "take shorter ones",
                 h, steps, model->parameters[DRIVE_STEP_MAX], DRIVE_MOST_STEPS);
        return 0;
    }
    if (steps < 1.0) steps = 1.0;
    part = h / steps;
    *s = model->state;
    control(model, s, h);
    add_up(model, s, values);
    plant_outputs(model, s);
    if (!can_follow(s, message)) return 0;
    for (long k = 0; k < (long)steps; k++) {
        model->arg[0] = s->x;
        model->arg[1] = s->u;
        model->arg[2] = s->free_lengths;
        model->arg[3] = &part;
        model->res[0] = x;
        drive_step(model->arg, model->res, model->iw, model->w, 0);
        memcpy(s->x, x, sizeof x);
        if (!sound(s, message)) return 0;
    }
    s->t = stop;
    plant_outputs(model, s);
    control_outputs(s, model->parameters);
    model->state = *s;
    return 1;
}

int model_retune(ModelInstance *model, const double *values, char *message) {
    return read_parameters(model->parameters, values, message);
}

double model_time(const ModelInstance *model) {
    return model->state.t;
}

int model_output(ModelInstance *model, size_t scalar, double *value, char *message) {
    (void)message;
    *value = model->state.outputs[scalar - DRIVE_FIRST_OUTPUT];
    return 1;
}

int model_text(ModelInstance *model, size_t scalar, const char **text, char *message) {
    (void)model, (void)scalar, (void)message;
    *text = "";
    return 1;
}

void model_note(const ModelInstance *model, char *message) {
    snprintf(message, MESSAGE_BYTES, "drive: %d states, internal steps of at most %.3g s", DRIVE_STATES,
             model->parameters[DRIVE_STEP_MAX]);
}

int model_warning(ModelInstance *model, int index, char *message) {
    (void)model, (void)index, (void)message;
    return 0;
}

int model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                     double *sum, char *message) {
    (void)model, (void)known, (void)seed, (void)unknown, (void)count, (void)sum;
    snprintf(message, MESSAGE_BYTES, "the drive has no directional derivatives; take differences");
    return 0;
}

size_t model_state_bytes(const ModelInstance *model) {
    return sizeof model->state;
}

void model_save(const ModelInstance *model, void *to) {
    memcpy(to, &model->state, sizeof model->state);
}

int model_restore(ModelInstance *model, const void *from, size_t bytes, char *message) {
    if (bytes != sizeof model->state) {
        snprintf(message, MESSAGE_BYTES, "a state of the drive has %lu bytes, not %lu; save it anew",
                 (unsigned long)sizeof model->state, (unsigned long)bytes);
        return 0;
    }
    memcpy(&model->state, from, sizeof model->state);
    return 1;
}
