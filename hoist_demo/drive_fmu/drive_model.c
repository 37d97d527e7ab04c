/* The hoist drive as a model: controller and plant over one communication step.

   Per step: the reference at its start, the controller's torque, then plant steps of equal length with torque and rope
   forces held, as hoist_demo.cosimulation does it.  The numbers of drive_table.h and the functions drive_... are
   generated. */
#include "drive_table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"

#define MIN_ROPE 0.1 /* m, of a head rope between sheave and conveyance */

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

static void plant_outputs(ModelInstance *m, State *s) {
    m->arg[0] = s->x;
    m->arg[1] = s->u;
    m->arg[2] = s->free_lengths;
    m->res[0] = s->outputs;
    drive_outputs(m->arg, m->res, m->iw, m->w, 0);
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
    ModelInstance *m = allocator->allocate(1, sizeof *m);
    if (!m) {
        snprintf(message, MESSAGE_BYTES, "no memory for the drive; free other instances first");
        return NULL;
    }
    memset(m, 0, sizeof *m);
    m->deallocate = allocator->deallocate;
    if (read_parameters(m->parameters, values, message)) return m;
    m->deallocate(m);
    return NULL;
}

void model_destroy(ModelInstance *m) {
    if (m) m->deallocate(m);
}

/* what all balance ropes do to the plant: of its input all but the torque */
static void add_up(ModelInstance *m, State *s, const double *values) {
    m->arg[0] = s->x;
    m->arg[1] = values + DRIVE_FORCE;
    m->res[0] = s->u + 1;
    drive_input(m->arg, m->res, m->iw, m->w, 0);
}

static const char *const OF_ALL = DRIVE_FORCES > 2 ? " (all ropes)" : "";

int model_initialize(ModelInstance *m, double t, const double *values, char *message) {
    State *s = &m->next;
    double pull[2];
    memset(s, 0, sizeof *s);
    add_up(m, s, values);
    memcpy(pull, s->u + 1, sizeof pull);
    for (int i = 0; i < 2; i++) {
        if (pull[i] == 0.0) pull[i] = m->parameters[DRIVE_FY_START + i]; /* containers initialise what they connect */
        if (!(pull[i] >= DRIVE_LOWEST_FORCE && pull[i] <= 0.0)) {
            snprintf(message, MESSAGE_BYTES,
                     "%s%s = %.9g N at the start must be between %.9g N and 0: it is the balance rope's pull at rest, "
                     "check the rope's mass and the sign",
                     MODEL_VARIABLES[DRIVE_FORCE + i].name, OF_ALL, pull[i], DRIVE_LOWEST_FORCE);
            return 0;
        }
    }
    s->t = s->start = t;
    m->arg[0] = pull;
    m->res[0] = s->x;
    m->res[1] = s->free_lengths;
    drive_rest(m->arg, m->res, m->iw, m->w, 0);
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
    plant_outputs(m, s);
    s->left_start = s->outputs[DRIVE_LEFT_Y];
    control_outputs(s, m->parameters);
    m->state = *s;
    return 1;
}

static void control(ModelInstance *m, State *s, double h) {
    Motion r = reference(s->t - s->start - m->parameters[DRIVE_TRIP_START]);
    const double sample[] = {
        r.s,     r.v,         r.a, s->outputs[DRIVE_LEFT_Y] - s->left_start, DRIVE_RADIUS * s->outputs[DRIVE_RATE],
        s->hold, s->integral, h};
    double torque, integral;
    m->arg[0] = sample;
    m->arg[1] = m->parameters + DRIVE_GAINS;
    m->res[0] = &torque;
    m->res[1] = &integral;
    drive_control(m->arg, m->res, m->iw, m->w, 0);
    s->u[0] = torque;
    s->integral = integral;
}

/* finite, and rope left at the sheave */
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
    if (fmin(left, right) > MIN_ROPE) return 1;
    snprintf(message, MESSAGE_BYTES,
             "head rope of %.3g m left at the sheave, not above %.3g m: overwind; check trip, "
             "gains and rope forces",
             fmin(left, right), MIN_ROPE);
    return 0;
}

/* whether the rope's forces move the conveyances as a rope's ends may move */
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

int model_step(ModelInstance *m, double t, double h, const double *values, int *event, char *message) {
    (void)event; /* none */
    double stop = t + h, steps, part, x[DRIVE_STATES];
    State *s = &m->next;
    h += t - m->state.t; /* rests of rounding size included */
    steps = ceil(h / m->parameters[DRIVE_STEP_MAX] - 1e-9);
    if (!(steps <= DRIVE_MOST_STEPS)) {
        snprintf(message, MESSAGE_BYTES,
                 "communication step %.9g s needs %.3g internal steps of %.3g s, more than %d; "
                 "take shorter ones",
                 h, steps, m->parameters[DRIVE_STEP_MAX], DRIVE_MOST_STEPS);
        return 0;
    }
    if (steps < 1.0) steps = 1.0;
    part = h / steps;
    *s = m->state;
    control(m, s, h);
    add_up(m, s, values);
    plant_outputs(m, s);
    if (!can_follow(s, message)) return 0;
    for (long k = 0; k < (long)steps; k++) {
        m->arg[0] = s->x;
        m->arg[1] = s->u;
        m->arg[2] = s->free_lengths;
        m->arg[3] = &part;
        m->res[0] = x;
        drive_step(m->arg, m->res, m->iw, m->w, 0);
        memcpy(s->x, x, sizeof x);
        if (!sound(s, message)) return 0;
    }
    s->t = stop;
    plant_outputs(m, s);
    control_outputs(s, m->parameters);
    m->state = *s;
    return 1;
}

int model_retune(ModelInstance *m, const double *values, char *message) {
    return read_parameters(m->parameters, values, message);
}

double model_time(const ModelInstance *m) {
    return m->state.t;
}

int model_output(ModelInstance *m, size_t scalar, double *value, char *message) {
    (void)message;
    *value = m->state.outputs[scalar - DRIVE_FIRST_OUTPUT];
    return 1;
}

int model_text(ModelInstance *m, size_t scalar, const char **text, char *message) {
    (void)m, (void)scalar, (void)message;
    *text = "";
    return 1;
}

void model_note(const ModelInstance *m, char *message) {
    snprintf(message, MESSAGE_BYTES, "drive: %d states, internal steps of at most %.3g s", DRIVE_STATES,
             m->parameters[DRIVE_STEP_MAX]);
}

int model_warning(ModelInstance *m, int number, char *message) {
    (void)m, (void)number, (void)message;
    return 0;
}

int model_derivative(ModelInstance *m, size_t known, double seed, const unsigned *unknown, size_t number, double *sum,
                     char *message) {
    (void)m, (void)known, (void)seed, (void)unknown, (void)number, (void)sum;
    snprintf(message, MESSAGE_BYTES, "the drive has no directional derivatives; take differences");
    return 0;
}

size_t model_state_bytes(const ModelInstance *m) {
    return sizeof m->state;
}

void model_save(const ModelInstance *m, void *to) {
    memcpy(to, &m->state, sizeof m->state);
}

int model_restore(ModelInstance *m, const void *from, size_t bytes, char *message) {
    if (bytes != sizeof m->state) {
        snprintf(message, MESSAGE_BYTES, "a state of the drive has %lu bytes, not %lu; save it anew",
                 (unsigned long)sizeof m->state, (unsigned long)bytes);
        return 0;
    }
    memcpy(&m->state, from, sizeof m->state);
    return 1;
}
