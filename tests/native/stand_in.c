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
    Simulator *rope;
    if (!fits(scene, message)) return NULL;
    rope = memory->allocate(1, sizeof *rope);
    if (!rope) {
        snprintf(message, MESSAGE, "no memory for the rope");
        return NULL;
    }
    rope->memory = *memory;
    rope->scene = *scene;
    rope->state.elements = scene->mesh.kind == EEM ? scene->mesh.elements : 100;
    return rope;
}

void rope_destroy(Simulator *rope) {
    rope->memory.deallocate(rope);
}

static int moves_well(Simulator *rope, double h, const EndMotion ends[2]) {
    int side;
    for (side = LEFT; side <= RIGHT; side++) {
        const char *name = side == LEFT ? "left" : "right";
        if (fabs(ends[side].vy) > 60.0) {
            snprintf(rope->message, MESSAGE,
                     "input %s.vy = %g is beyond +-60 (SI units); check its unit and connection", name, ends[side].vy);
            return 0;
        }
        if (rope->state.initialized && fabs(ends[side].y - rope->state.ends[side].y) > 60.0 * h + 0.1) {
            snprintf(rope->message, MESSAGE,
                     "inputs %s.y and its derivatives do not fit together; give one smooth motion", name);
            return 0;
        }
    }
    return 1;
}

int rope_initialize(Simulator *rope, double t, const EndMotion ends[2]) {
    rope->state.initialized = 0;
    if (!moves_well(rope, 0.0, ends)) return 0;
    rope->state.t = t;
    memcpy(rope->state.ends, ends, sizeof rope->state.ends);
    rope->state.initialized = 1;
    return 1;
}

int rope_advance_to(Simulator *rope, double t, const EndMotion given[2], double given_at) {
    const double ahead = t - given_at;
    EndMotion ends[2] = {given[LEFT], given[RIGHT]};
    for (int side = LEFT; side <= RIGHT; side++) {
        ends[side].y += ahead * (given[side].vy + 0.5 * ahead * given[side].ay);
        ends[side].vy += ahead * given[side].ay;
    }
    if (!moves_well(rope, t - rope->state.t, ends)) return 0;
    rope->state.h = t - rope->state.t;
    rope->state.t = t;
    rope->state.steps += ceil(rope->state.h / rope->scene.solver.step_max - 1e-9);
    memcpy(rope->state.ends, ends, sizeof rope->state.ends);
    return 1;
}

int rope_advance_to_event(Simulator *rope, double t, const EndMotion ends[2], double given_at, int *event) {
    *event = 0;
    return rope_advance_to(rope, t, ends, given_at);
}

int rope_retune(Simulator *rope, const Scene *scene) {
    if (!fits(scene, rope->message)) return 0;
    rope->scene = *scene;
    return 1;
}

const char *rope_message(const Simulator *rope) {
    return rope->message;
}
int rope_is_initialized(const Simulator *rope) {
    return rope->state.initialized;
}
double rope_time(const Simulator *rope) {
    return rope->state.t;
}
int rope_elements(const Simulator *rope) {
    return rope->state.elements;
}
const char *rope_fidelity(const Simulator *rope) {
    return rope->state.initialized ? "torsional" : "";
}
const char *rope_fidelity_reason(const Simulator *rope) {
    return rope->state.initialized ? "a stand-in has one fidelity" : "";
}

static double leg_mass(const Simulator *rope, int side) {
    const EndMotion *ends = rope->state.ends;
    double leg = 0.5 * (rope->scene.rope.length + ends[side].y - ends[1 - side].y);
    return leg * rope->scene.rope.mass_per_length;
}

void rope_warning(Simulator *rope, int number, char *message) {
    (void)rope, (void)number;
    message[0] = '\0';
}

static double value_of(Simulator *rope, int signal) {
    int side = signal == SIGNAL_LEFT_FY ? LEFT : RIGHT;
    if (signal == SIGNAL_LEFT_FY || signal == SIGNAL_RIGHT_FY)
        return -leg_mass(rope, side) * (rope->scene.layout.gravity + rope->state.ends[side].ay);
    return signal == SIGNAL_COUNT_STEPS ? rope->state.steps : 0.0;
}

void rope_signals(Simulator *rope, size_t number, const int *signals, double *values) {
    for (size_t k = 0; k < number; k++) values[k] = value_of(rope, signals[k]);
}

int rope_load_derivative(Simulator *rope, int input, int at_step_end, double derivative[12]) {
    (void)at_step_end;
    int moved = input / 11, k = input % 11, side;
    for (side = 0; side < 12; side++) derivative[side] = 0.0;
    for (side = LEFT; side <= RIGHT; side++) {
        double g = rope->scene.layout.gravity + rope->state.ends[side].ay;
        if (k == 1) derivative[6 * side + 1] = (side == moved ? -0.5 : 0.5) * rope->scene.rope.mass_per_length * g;
        if (k == 7 && side == moved) derivative[6 * side + 1] = -leg_mass(rope, side);
    }
    return 1;
}

size_t rope_state_bytes(const Simulator *rope) {
    (void)rope;
    return sizeof(State);
}

void rope_save(const Simulator *rope, void *to) {
    memcpy(to, &rope->state, sizeof rope->state);
}

int rope_restore(Simulator *rope, const void *from, size_t bytes) {
    const State *state = from;
    if (bytes != sizeof *state || state->elements != rope->state.elements) {
        snprintf(rope->message, MESSAGE,
                 "the saved state does not fit; restore it into a rope with the same parameters");
        return 0;
    }
    rope->state = *state;
    return 1;
}
