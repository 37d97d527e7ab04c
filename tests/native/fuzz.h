/* libFuzzer target: the fuzzer's bytes become calls of FMI, in any order, with any values, memory that runs out, and
   states that are damaged with a checksum that fits.  The rope is small enough for thousands of runs.  fuzz_fmi2.c and
   fuzz_fmi3.c bring the calls of their standard, benchmarks.fuzz builds and runs them.

   What must hold: no sanitizer complains, every error has said why, an accepted step leaves finite forces, no memory
   is lost, and after a reset the rope does what it did when it was new, to the bit. */
#ifndef FUZZ_H
#define FUZZ_H

#undef calloc /* the build renames them, so that the sources under test ask for memory here */
#undef free
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

#define REQUIRE(condition)                                                                                             \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                    \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

typedef struct {
    const uint8_t *at, *end;
} Bytes;

static unsigned byte(Bytes *b) {
    return b->at < b->end ? *b->at++ : 0;
}

static uint64_t word(Bytes *b) {
    uint64_t x = 0;
    int k;
    for (k = 0; k < 8; k++) x = x << 8 | byte(b);
    return x;
}

static double number(Bytes *b) {
    static const double hostile[] = {NAN,      INFINITY, -INFINITY,    0.0,           -0.0,  -1.0, 1.0,  4.9e-324,
                                     2.2e-308, 1e-300,   1e300,        -1e300,        1e-9,  1e-5, 0.02, 1e3,
                                     1e6,      1e10,     2147483647.0, -2147483648.0, 1e18,  0.5,  1.5,  20000.0,
                                     1e-12,    59.9,     99.9,         1e4,           1e-17, 3.0,  7.0,  64.0};
    double x;
    uint64_t bits;
    switch (byte(b) % 4) {
    case 0:
        return hostile[byte(b) % (sizeof hostile / sizeof *hostile)];
    case 1:
        bits = word(b);
        memcpy(&x, &bits, sizeof x);
        return x;
    case 2:
        return ((int)byte(b) - 128) / 16.0;
    default:
        x = pow(10.0, byte(b) / 4.0 - 40.0);
        return byte(b) % 2 ? -x : x;
    }
}

/* memory with a limit: the largest rope has some 100 elements; the allocation after `left` others fails */
enum { LIMIT = 400000 };
static size_t taken, left;

void *fuzz_take(size_t number, size_t size);
void *fuzz_take(size_t number, size_t size) {
    size_t *block;
    if (left-- == 0 || (size && number > LIMIT / size)) return NULL;
    if (!(block = malloc(16 + number * size))) return NULL;
    memset(block + 2, 0xa5, number * size); /* whoever reads before writing shall notice */
    taken++;
    return block + 2;
}

void fuzz_give_back(void *block);
void fuzz_give_back(void *block) {
    if (!block) return;
    taken--;
    free((size_t *)block - 2);
}

static unsigned reference(const char *name) {
    size_t i;
    for (i = 0; i < MODEL_SCALARS; i++)
        if (!strcmp(MODEL_VARIABLES[i].name, name)) return (unsigned)i;
    fprintf(stderr, "there is no %s\n", name);
    abort();
}

/* one that there is, mostly an entry, or any number */
static unsigned some_reference(Bytes *b) {
    unsigned at = byte(b);
    if (at == 255) return (unsigned)word(b);
    return (at < 80 ? at : at * 8 + byte(b)) % (unsigned)MODEL_SCALARS;
}

/* smooth motions of amplitude 0.05 to 3 m that begin at rest; name of the input -> its value at t */
typedef struct {
    double amplitude, frequency, turn;
} Motion;

static Motion some_motion(Bytes *b) {
    Motion m;
    m.amplitude = (1 + byte(b)) / 80.0;
    m.frequency = (1 + byte(b) % 32) / 8.0;
    m.turn = byte(b) % 4 ? 0.0 : 1.0;
    return m;
}

enum { MOVED = 8 };
static const char *const MOVED_NAMES[MOVED] = {"left.y",   "left.vy",  "left.ay",  "right.y",
                                               "right.vy", "right.ay", "left.yaw", "left.yaw_rate"};

static void motion_values(const Motion *m, double t, double values[MOVED]) {
    double w = m->frequency, y = m->amplitude * (1 - cos(w * t)), v = m->amplitude * w * sin(w * t);
    double a = m->amplitude * w * w * cos(w * t);
    values[0] = y, values[1] = v, values[2] = a;
    values[3] = -y, values[4] = -v, values[5] = -a;
    values[6] = m->turn * y, values[7] = m->turn * v;
}

/* a rope of few elements, of all kinds of mesh */
enum { REALS = 7, INTEGERS = 10 };
static const char *const REAL_NAMES[REALS] = {
    "rope.length",     "mesh.coarse_length",  "right.y", "left.swivel.release_time", "right.swivel.release_time",
    "solver.step_max", "rope.installed_twist"};
static const char *const INTEGER_NAMES[INTEGERS] = {
    "mesh.elements",  "mesh.counts[1]",  "mesh.counts[2]", "mesh.counts[3]",   "mesh.counts[4]",
    "mesh.counts[5]", "mesh.end_levels", "mesh.kind",      "left.swivel.mode", "model.fidelity"};

static void small(unsigned which, double reals[REALS], int integers[INTEGERS]) {
    reals[0] = 30.0, reals[1] = 1.5, reals[2] = 0.0;
    reals[3] = which & 4 ? 0.05 : 0.0, reals[4] = 0.1, reals[5] = which & 8 ? 0.05 : 0.01;
    reals[6] = which & 64 ? 3.0 : 0.0;
    integers[0] = 9, integers[1] = integers[5] = 2, integers[2] = integers[4] = 4, integers[3] = 8;
    integers[6] = which & 16 ? 1 : 0;
    integers[7] = which & 1;
    integers[8] = which & 2 ? 2 : 0;
    integers[9] = (which & 80) == 80 ? 4 : 0; /* rigid */
}

/* a shaft in which the rope touches bodies of all kinds, and itself; set_shaft leaves some out, and may take any number
 * for one */
typedef struct {
    const char *name;
    double value;
} Entry;
static const Entry SHAFT[] = {
    {"lining.width", 2.2},        {"lining.depth", 0.8},         {"lining.rounding", 0.2},
    {"conveyance.width", 1.0},    {"conveyance.depth", 0.8},     {"conveyance.height", 2.0},
    {"conveyance.above", 0.4},    {"head_ropes.diameter", 0.03}, {"head_ropes.row", 0.6},
    {"divider_1.size", 0.2},      {"divider_1.y", -13.5},        {"divider_1.rounding", 0.3},
    {"divider_2.size", 0.15},     {"divider_2.y", -6.0},         {"divider_2.offset", 0.4},
    {"divider_2.direction", 0.3}, {"sump.level", -14.6},         {"contact.friction", 0.3},
    {"contact.damping", 0.5},     {"contact.stiffness", 1e6},    {"contact.rope_stiffness", 1e5}};
enum { BODIES = sizeof SHAFT / sizeof *SHAFT };

/* Damage to a serialized state: the fuzzer's bytes, numbers and small integers anywhere, or one of its halves cut
   off; the checksum of component.c fits again, unless the fuzzer likes another.  Returns the bytes left. */
static size_t damage(Bytes *b, unsigned char *state, size_t bytes) {
    enum { CHECKED_FROM = 24 };
    unsigned changes = byte(b) % 8, cut = byte(b);
    uint64_t sum = 14695981039346656037u, part;
    size_t i;
    while (changes--) {
        unsigned how = byte(b);
        size_t at = (how & 16 ? word(b) : (size_t)(byte(b) << 8 | byte(b))) % (bytes - 8);
        double value = how % 4 == 1 ? number(b) : 0.0;
        int32_t integer = (int32_t)byte(b) - 3;
        if (how & 32) at = bytes - 8 - at;
        if (how & 64) at -= at % 8;
        if (how % 4 == 0)
            state[at] ^= (unsigned char)(1u << integer % 8 * (integer > 0));
        else if (how % 4 == 1)
            memcpy(state + at, &value, sizeof value);
        else
            memcpy(state + at, &integer, sizeof integer);
    }
    if (cut >= 250) bytes = cut == 255 ? 0 : bytes / (cut - 248);
    if (bytes > CHECKED_FROM && cut != 249) {
        uint64_t length = bytes;
        memcpy(state + 8, &length, sizeof length);
        for (i = CHECKED_FROM; i + sizeof part <= bytes; i += sizeof part) {
            memcpy(&part, state + i, sizeof part);
            sum = (sum ^ part) * 1099511628211u;
        }
        for (; i < bytes; i++) sum = (sum ^ state[i]) * 1099511628211u;
        memcpy(state + 16, &sum, sizeof sum);
    }
    return bytes;
}

/* the calls of one standard; they return its status, which is the same number in both */
enum { OK, WARNING, DISCARD, ERROR };
typedef void *Instance;
typedef void *Saved;
static Instance api_new(void);
static void api_free(Instance c);
static int api_enter(Instance c, double start, int stop_defined, double stop);
static int api_exit(Instance c);
static int api_step(Instance c, double t, double h);
static int api_terminate(Instance c);
static int api_reset(Instance c);
static int api_set(Instance c, int kind, unsigned vr, const double *reals, const int64_t *integers, size_t number);
static int api_get(Instance c, int kind, unsigned vr, double *real, const char **text, size_t number);
static int api_save(Instance c, Saved *state);
static int api_restore(Instance c, Saved state);
static int api_forget(Instance c, Saved *state);
static int api_size(Instance c, Saved state, size_t *size);
static int api_write(Instance c, Saved state, unsigned char *bytes, size_t size);
static int api_read(Instance c, const unsigned char *bytes, size_t size, Saved *state);
static int api_derivative(Instance c, unsigned unknown, unsigned known, double seed, double *value);
static int api_other(Bytes *b, Instance c);

/* what an error says is in the log before it is returned */
static unsigned long told;

static void heard(int status, const char *message) {
    REQUIRE(*message && strlen(message) < 2 * MESSAGE_BYTES);
    told += status == ERROR;
}

#define CALL(call)                                                                                                     \
    do {                                                                                                               \
        unsigned long before_call = told;                                                                              \
        int returned = (call);                                                                                         \
        REQUIRE(returned == OK || returned == DISCARD || (returned == ERROR && told > before_call));                   \
    } while (0)

enum { STATES = 3, HOSTS = 2, MOST_VALUES = 512 };

typedef struct {
    Instance c;
    double t;
    Motion motion;
} Host;

static void set_small(Instance c, unsigned which) {
    double reals[REALS];
    int integers[INTEGERS], k;
    int64_t one[1] = {1};
    small(which, reals, integers);
    for (k = 0; k < REALS; k++) CALL(api_set(c, KIND_REAL, reference(REAL_NAMES[k]), reals + k, one, 1));
    for (k = 0; k < INTEGERS; k++) {
        unsigned vr = reference(INTEGER_NAMES[k]);
        one[0] = integers[k];
        CALL(api_set(c, MODEL_VARIABLES[vr].kind, vr, reals, one, 1));
    }
    one[0] = 1;
    CALL(api_set(c, KIND_BOOLEAN, reference("inputs_at_step_end"), reals, one, 1));
}

/* the bits of `which` leave something out; contact stays */
static void set_shaft(Bytes *b, Instance c) {
    unsigned which = byte(b), odd = byte(b);
    int64_t none = 0;
    if (which >= 192) return;
    for (unsigned k = 0; k < BODIES; k++) {
        double value = SHAFT[k].value;
        if (k < BODIES - 4 && which >> (k / 3 % 6) & 1) continue;
        if (odd % (4 * BODIES) == k) value = number(b);
        CALL(api_set(c, KIND_REAL, reference(SHAFT[k].name), &value, &none, 1));
    }
}

static void begin(Host *h, double start) {
    CALL(api_enter(h->c, start, 0, 0.0));
    CALL(api_exit(h->c));
    h->t = start;
}

static int forces_of(Instance c, double forces[2]) {
    const char *text;
    return api_get(c, KIND_REAL, reference("left.fy"), forces, &text, 1) == OK &&
           api_get(c, KIND_REAL, reference("right.my"), forces + 1, &text, 1) == OK;
}

static void step(Host *h, double size) {
    int status;
    double forces[2];
    CALL(status = api_step(h->c, h->t, size));
    if (status != OK) return;
    REQUIRE(forces_of(h->c, forces) && isfinite(forces[0]) && isfinite(forces[1]));
    h->t += size;
}

static void follow(Host *h, double size) {
    double values[MOVED];
    int64_t none = 0;
    int k;
    motion_values(&h->motion, h->t + size, values);
    for (k = 0; k < MOVED; k++) CALL(api_set(h->c, KIND_REAL, reference(MOVED_NAMES[k]), values + k, &none, 1));
    step(h, size);
}

static void set_some(Bytes *b, Instance c) {
    unsigned vr = some_reference(b), k, wrong = byte(b);
    double reals[MOST_VALUES];
    int64_t integers[MOST_VALUES];
    size_t number_of = vr < MODEL_SCALARS ? MODEL_VARIABLES[vr].length : 1;
    int kind = wrong >= 250 || vr >= MODEL_SCALARS ? (int)(byte(b) % 5) : (int)MODEL_VARIABLES[vr].kind;
    for (k = 0; k < MOST_VALUES; k++) reals[k] = 1.0, integers[k] = 4;
    for (k = 0; k < 2; k++) reals[k] = number(b), integers[k] = byte(b) % 4 ? (int64_t)byte(b) - 2 : (int64_t)word(b);
    if (wrong >= 240 && wrong < 250) number_of = byte(b);
    CALL(api_set(c, kind, vr, reals, integers, number_of > MOST_VALUES ? MOST_VALUES : number_of));
}

static void get_all(Instance c, int right) {
    unsigned vr;
    double reals[MOST_VALUES];
    const char *text = "";
    for (vr = 0; vr < MODEL_SCALARS + 2; vr++) {
        int kind = vr < MODEL_SCALARS ? (int)MODEL_VARIABLES[vr].kind : 0;
        size_t number_of = vr < MODEL_SCALARS && right ? MODEL_VARIABLES[vr].length : 1;
        if (!right) kind = (kind + 1) % 5;
        REQUIRE(number_of <= MOST_VALUES);
        CALL(api_get(c, kind, vr, reals, &text, number_of));
        REQUIRE(strlen(text) < MESSAGE_BYTES);
    }
}

static void states(Bytes *b, Instance c, Saved *state) {
    unsigned char *bytes;
    size_t size = 0, kept;
    switch (byte(b) % 8) {
    case 0:
    case 1:
        CALL(api_save(c, state));
        break;
    case 2:
    case 3:
        CALL(api_restore(c, *state));
        break;
    case 4:
        CALL(api_forget(c, state));
        break;
    default:
        if (!*state) CALL(api_save(c, state));
        if (!*state) return;
        CALL(api_size(c, *state, &size));
        REQUIRE(bytes = malloc(size));
        CALL(api_write(c, *state, bytes, size - 1));
        CALL(api_write(c, *state, bytes, size));
        CALL(api_forget(c, state));
        kept = damage(b, bytes, size);
        CALL(api_read(c, bytes, kept, state));
        free(bytes);
        if (*state) CALL(api_restore(c, *state));
    }
}

static void derivative(Bytes *b, Instance c) {
    unsigned known = byte(b) % 8 ? reference(MOVED_NAMES[byte(b) % MOVED]) : some_reference(b);
    unsigned unknown = byte(b) % 8 ? reference(byte(b) % 2 ? "left.fy" : "right.mx") : some_reference(b);
    double seed = byte(b) % 4 ? 1.0 : number(b), value = 0.0;
    CALL(api_derivative(c, unknown, known, seed, &value));
}

/* the forces of a rope that was reset, or is new */
static void as_new(Host *h, double forces[2]) {
    int k;
    left = (size_t)-1;
    CALL(api_reset(h->c));
    set_small(h->c, 2);
    h->motion.amplitude = 0.5, h->motion.frequency = 2.0, h->motion.turn = 1.0;
    begin(h, 0.0);
    for (k = 0; k < 3; k++) follow(h, 0.02);
    REQUIRE(forces_of(h->c, forces));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static double expected[2];
    static int known;
    Bytes bytes = {data, data + size}, *b = &bytes;
    Host hosts[HOSTS];
    Saved saved[STATES] = {NULL};
    double forces[2], start, stop;
    int k;
    memset(hosts, 0, sizeof hosts);
    left = (size_t)-1;
    if (!known) {
        REQUIRE(hosts[0].c = api_new());
        as_new(&hosts[0], expected);
        api_free(hosts[0].c);
        known = 1;
    }
    for (k = 0; k < HOSTS; k++) {
        unsigned which = byte(b);
        REQUIRE(hosts[k].c = api_new());
        hosts[k].motion = some_motion(b);
        if (which < 240) set_small(hosts[k].c, which);
        set_shaft(b, hosts[k].c);
        if (which < 128) begin(&hosts[k], which & 32 ? number(b) : 0.0);
    }
    for (k = 0; k < 64 && b->at < b->end; k++) {
        unsigned op = byte(b);
        Host *h = &hosts[op & 1];
        Saved *state = saved + (op >> 1) % STATES;
        left = op < 250 ? (size_t)-1 : byte(b) % 4;
        switch (op / 2 % 16) {
        case 0:
            start = number(b), stop = number(b);
            CALL(api_enter(h->c, start, byte(b) % 2, stop));
            break;
        case 1:
        case 2:
            CALL(api_exit(h->c));
            break;
        case 3:
            step(h, number(b));
            break;
        case 4:
            start = number(b);
            CALL(api_step(h->c, start, number(b)));
            break;
        case 5:
        case 6:
            set_some(b, h->c);
            break;
        case 7:
            get_all(h->c, byte(b) != 1);
            break;
        case 8:
        case 9:
            states(b, h->c, state);
            break;
        case 10:
            derivative(b, h->c);
            break;
        case 11:
            CALL(api_other(b, h->c));
            break;
        case 12:
            CALL(api_terminate(h->c));
            break;
        case 13:
            CALL(api_reset(h->c));
            set_small(h->c, byte(b));
            set_shaft(b, h->c);
            begin(h, 0.0);
            break;
        default:
            follow(h, (1 + byte(b) % 8) * 0.01);
            break;
        }
    }
    as_new(&hosts[size % HOSTS], forces);
    REQUIRE(!memcmp(forces, expected, sizeof forces));
    for (k = 0; k < STATES; k++) CALL(api_forget(hosts[0].c, saved + k));
    for (k = 0; k < HOSTS; k++) api_free(hosts[k].c);
    REQUIRE(taken == 0);
    return 0;
}

#endif
