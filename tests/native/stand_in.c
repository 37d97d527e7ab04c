/* A double of the rope for the tests of the FMI shells: hanging weights instead of mechanics, but time, bounds,
   messages and states as rope.h has them.  Each end carries the weight of its leg and the mass of it times the
   end's upward acceleration. */
#include "rope.h"
#include "signal_numbers.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct {
    double t, h;
    EndMotion ends[2];
    double steps;
    int elements, initialized;
} State;

struct Simulator {
    Memory memory;
    Scene scene;
    State state;
    char message[MESSAGE];
};

static int wrong(char *message, const char *what, double value, const char *bound) {
    snprintf(message, MESSAGE, "%s = %g is out of range: it must be %s", what, value, bound);
    return 0;
}

static int fits(const Scene *scene, char *message) {
    if (!(scene->rope.EI > 0)) return wrong(message, "rope: EI", scene->rope.EI, "> 0; check the rope's data sheet");
    if (!(scene->rope.length > 1.57 * scene->layout.spacing))
        return wrong(message, "spacing", scene->layout.spacing, "below length / 1.57; take a longer rope");
    if (!(scene->solver.step_max > 0))
        return wrong(message, "solver: step_max", scene->solver.step_max, "in (0, 1] s; 10 ms suits most ropes");
    return 1;
}

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    Simulator *sim;
    if (!fits(scene, message)) return NULL;
    sim = memory->allocate(1, sizeof *sim);
    if (!sim) {
        snprintf(message, MESSAGE, "no memory for the rope");
        return NULL;
    }
    sim->memory = *memory;
    sim->scene = *scene;
    sim->state.elements = scene->mesh.kind == EEM ? scene->mesh.elements : 100;
    return sim;
}

void rope_destroy(Simulator *sim) {
    sim->memory.deallocate(sim);
}

static int moves_well(Simulator *sim, double h, const EndMotion ends[2]) {
    int side;
    for (side = LEFT; side <= RIGHT; side++) {
        const char *name = side == LEFT ? "left" : "right";
        if (fabs(ends[side].vy) > 60.0) {
            snprintf(sim->message, MESSAGE, "input %s.vy = %g is beyond +-60 (SI units); check its unit and connection",
                     name, ends[side].vy);
            return 0;
        }
        if (sim->state.initialized && fabs(ends[side].y - sim->state.ends[side].y) > 60.0 * h + 0.1) {
            snprintf(sim->message, MESSAGE,
                     "inputs %s.y and its derivatives do not fit together; give one smooth motion", name);
            return 0;
        }
    }
    return 1;
}

RopeStatus rope_initialize(Simulator *sim, double t, const EndMotion ends[2]) {
    sim->state.initialized = 0;
    if (!moves_well(sim, 0.0, ends)) return 0;
    sim->state.t = t;
    memcpy(sim->state.ends, ends, sizeof sim->state.ends);
    sim->state.initialized = 1;
    return 1;
}

RopeStatus rope_advance_to(Simulator *sim, double t, const EndMotion given[2], double given_at) {
    const double ahead = t - given_at;
    EndMotion ends[2] = {given[LEFT], given[RIGHT]};
    for (int side = LEFT; side <= RIGHT; side++) {
        ends[side].y += ahead * (given[side].vy + 0.5 * ahead * given[side].ay);
        ends[side].vy += ahead * given[side].ay;
    }
    if (!moves_well(sim, t - sim->state.t, ends)) return 0;
    sim->state.h = t - sim->state.t;
    sim->state.t = t;
    sim->state.steps += ceil(sim->state.h / sim->scene.solver.step_max - 1e-9);
    memcpy(sim->state.ends, ends, sizeof sim->state.ends);
    return 1;
}

RopeStatus rope_advance_to_event(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event) {
    *event = 0;
    return rope_advance_to(sim, t, ends, given_at);
}

RopeStatus rope_retune(Simulator *sim, const Scene *scene) {
    if (!fits(scene, sim->message)) return 0;
    sim->scene = *scene;
    return 1;
}

const char *rope_message(const Simulator *sim) {
    return sim->message;
}
int rope_is_initialized(const Simulator *sim) {
    return sim->state.initialized;
}
double rope_time(const Simulator *sim) {
    return sim->state.t;
}
int rope_elements(const Simulator *sim) {
    return sim->state.elements;
}
const char *rope_fidelity(const Simulator *sim) {
    return sim->state.initialized ? "torsional" : "";
}
const char *rope_fidelity_reason(const Simulator *sim) {
    return sim->state.initialized ? "a stand-in has one fidelity" : "";
}

static double leg_mass(const Simulator *sim, int side) {
    const EndMotion *ends = sim->state.ends;
    double leg = 0.5 * (sim->scene.rope.length + ends[side].y - ends[1 - side].y);
    return leg * sim->scene.rope.mass_per_length;
}

void rope_warning(Simulator *sim, int index, char *message) {
    (void)sim, (void)index;
    message[0] = '\0';
}

static double value_of(Simulator *sim, int signal) {
    int side = signal == SIGNAL_LEFT_FY ? LEFT : RIGHT;
    if (signal == SIGNAL_LEFT_FY || signal == SIGNAL_RIGHT_FY)
        return -leg_mass(sim, side) * (sim->scene.layout.gravity + sim->state.ends[side].ay);
    return signal == SIGNAL_COUNT_STEPS ? sim->state.steps : 0.0;
}

void rope_signals(Simulator *sim, size_t count, const int *signals, double *values) {
    for (size_t k = 0; k < count; k++) values[k] = value_of(sim, signals[k]);
}

RopeStatus rope_load_derivative(Simulator *sim, int input, int at_step_end, double derivative[12]) {
    (void)at_step_end;
    int moved = input / 11, k = input % 11, side;
    for (side = 0; side < 12; side++) derivative[side] = 0.0;
    for (side = LEFT; side <= RIGHT; side++) {
        double g = sim->scene.layout.gravity + sim->state.ends[side].ay;
        if (k == 1) derivative[6 * side + 1] = (side == moved ? -0.5 : 0.5) * sim->scene.rope.mass_per_length * g;
        if (k == 7 && side == moved) derivative[6 * side + 1] = -leg_mass(sim, side);
    }
    return 1;
}

size_t rope_state_bytes(const Simulator *sim) {
    (void)sim;
    return sizeof(State);
}

void rope_save(const Simulator *sim, void *to) {
    memcpy(to, &sim->state, sizeof sim->state);
}

RopeStatus rope_restore(Simulator *sim, const void *from, size_t bytes) {
    const State *state = from;
    if (bytes != sizeof *state || state->elements != sim->state.elements) {
        snprintf(sim->message, MESSAGE,
                 "the saved state does not fit; restore it into a rope with the same parameters");
        return 0;
    }
    sim->state = *state;
    return 1;
}
