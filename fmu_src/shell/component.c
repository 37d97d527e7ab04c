/* State of an FMU's instance: modes, entered values, saved states and messages. */

#include "component.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define TIME_SLACK(t) (1e-9 + 4 * DBL_EPSILON * fabs(t)) /* s, difference allowed between times of host and model */
#define TOLERANCE_DIGITS 1e-5 /* relative, to which a model description writes its tolerance */
#define MIN_STEP 1e-9 /* s; shorter steps, which rounding of the host's times leaves, do not advance the model */
/* origins of an entry: its start value; the host has set it; the host has set it as the derivative of another input.
   Numbers, as a saved state has them among the others. */
#define FROM_START 0.0
#define GIVEN 1.0
#define DERIVED 2.0
/* entries that changed since the model was set up */
enum { NOTHING = 0, INPUTS = 1, PARAMETERS = 2 };
enum { DECIMAL_SIZE = 32, STATE_VERSION = 6 };

/* Numbers of all scalars by value reference, MODEL_SCALARS in each array */
typedef struct {
    double *entries; /* values that the host has entered */
    double *used;    /* entries last passed to the model */
    double *origins; /* of the entries: FROM_START, GIVEN or DERIVED */
} Scalars;

struct Component {
    Allocator allocator;
    ComponentLog log;
    void *context;
    ModelInstance *model;
    double start, stop; /* stop: infinite if not announced */
    double time;        /* host's time, s; the model differs by less than MIN_STEP */
    double last_step;   /* s, length of the last step; 0 before the first */
    bool coarse;        /* the log has said that times are coarse */
    int mode, changed;
    bool retune;
    bool started;    /* initialised, and not reset since */
    bool valid;      /* the last initialisation or step succeeded */
    bool at_event;   /* the last step ended at an event */
    unsigned warned; /* bit k: warning k was logged since initialisation began */
    char status[MESSAGE_BYTES], message[MESSAGE_BYTES];
    Scalars scalars; /* arrays in `numbers` */
    double numbers[];
};

/* Header of a state; the numbers of Scalars and the model's bytes follow. */
typedef struct {
    char magic[8];
    uint64_t bytes, checksum; /* checksum: of the bytes behind it */
    uint32_t version;
    int32_t mode, valid, started, at_event;
    double start, stop, time, last_step;
    char token[TOKEN_BYTES], status[MESSAGE_BYTES];
} StateHeader;

static const char MAGIC[8] = "FMUSTATE";

void copy_text(char *to, size_t room, const char *from) {
    size_t length = strlen(from);
    if (length >= room) {
        length = room - 1;
        while (length && ((unsigned char)from[length] & 0xC0) == 0x80) length--; /* a character's later bytes */
    }
    memcpy(to, from, length);
    to[length] = '\0';
}

/* Put a point for the decimal separator, of one or more bytes, of the host's locale. */
static char *with_point(char *number) {
    char *at = number + strspn(number, "+-0123456789eE.infa"), *rest; /* letters of inf and nan too */
    if (!*at) return number;
    rest = at + 1 + strcspn(at + 1, "0123456789eE");
    *at = '.';
    memmove(at + 1, rest, strlen(rest) + 1);
    return number;
}

static void write_arguments(char message[MESSAGE_BYTES], const char *format, va_list arguments) {
    enum { WHOLE = 2 * MESSAGE_BYTES, SPEC = 16 };
    char whole[WHOLE], spec[SPEC], number[64], *end = whole, *stop = whole + WHOLE - 1;
    while (*format && end < stop) {
        if (*format != '%') {
            *end++ = *format++;
            continue;
        }
        const size_t length = strcspn(format, "sdg") + 1;
        const char kind = format[length - 1], *text = number;
        memcpy(spec, format, length);
        spec[length] = '\0';
        format += length;
        if (kind == 's') text = va_arg(arguments, const char *);
        if (kind == 'd') snprintf(number, sizeof number, spec, va_arg(arguments, int));
        if (kind == 'g') {
            snprintf(number, sizeof number, spec, va_arg(arguments, double));
            with_point(number);
        }
        copy_text(end, (size_t)(stop - end) + 1, text);
        end += strlen(end);
    }
    *end = '\0';
    copy_text(message, MESSAGE_BYTES, whole);
}

void write_message(char message[MESSAGE_BYTES], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    write_arguments(message, format, arguments);
    va_end(arguments);
}

static bool log_error(Component *c, const char *format, ...) {
    char message[MESSAGE_BYTES]; /* the arguments may point into c->message */
    va_list arguments;
    va_start(arguments, format);
    write_arguments(message, format, arguments);
    va_end(arguments);
    memcpy(c->message, message, sizeof message);
    c->log(c->context, LOG_ERROR, c->message);
    return false;
}

/* Return the bytes of one array of Scalars. */
static size_t array_bytes(void) {
    return MODEL_SCALARS * sizeof(double);
}

/* Return the bytes of all arrays of Scalars. */
static size_t scalars_bytes(void) {
    return 3 * array_bytes();
}

/* Return the arrays that follow each other in a block of scalars_bytes(). */
static Scalars scalars_in(double *block) {
    return (Scalars){block, block + MODEL_SCALARS, block + 2 * MODEL_SCALARS};
}

/* Record that the model uses the present entries. */
static void mark_as_used(Component *c) {
    memcpy(c->scalars.used, c->scalars.entries, array_bytes());
    c->retune = false;
}

/* Print the shortest decimal that reads back as x. */
static const char *shortest(double x, char text[DECIMAL_SIZE]) {
    if (isnan(x)) return "nan";
    if (isinf(x)) return x > 0 ? "inf" : "-inf";
    for (int digits = 6; digits <= 17; digits++) {
        double back;
        snprintf(text, DECIMAL_SIZE, "%.*g", digits, x);
        if (sscanf(text, "%lf", &back) == 1 && back == x) break;
    }
    return with_point(text);
}

static const char *value_text(const Variable *variable, double value, char text[DECIMAL_SIZE]) {
    if (variable->kind == KIND_BOOLEAN) return value != 0.0 ? "true" : "false";
    return shortest(value, text);
}

const char *log_category(Severity severity) {
    static const char *const names[] = {"logAll", "logStatusWarning", "logStatusError"};
    return names[severity];
}

Component *component_create(const Allocator *allocator, ComponentLog log, void *context) {
    Component *c = allocator->allocate(1, sizeof *c + scalars_bytes());
    if (!c) return NULL;
    memset(c, 0, sizeof *c + scalars_bytes());
    c->scalars = scalars_in(c->numbers);
    c->allocator = *allocator;
    c->log = log;
    c->context = context;
    component_reset(c);
    return c;
}

void component_destroy(Component *c) {
    Allocator allocator = c->allocator;
    model_destroy(c->model);
    allocator.deallocate(c);
}

bool component_error(Component *c, const char *message) {
    return log_error(c, "%s", message);
}

bool component_nonnull(Component *c, const void *pointer) {
    return pointer || log_error(c, "a pointer is NULL; give the address of the data");
}

static bool is_log_category(const char *name) {
    for (int k = LOG_NOTE; k <= LOG_ERROR; k++)
        if (!strcmp(name, log_category((Severity)k))) return true;
    return false;
}

bool component_categories(Component *c, size_t count, const char *const names[], bool *all) {
    *all = count == 0;
    if (count && !component_nonnull(c, names)) return false;
    for (size_t k = 0; k < count; k++) {
        if (!component_nonnull(c, names[k])) return false;
        if (!is_log_category(names[k]))
            return log_error(c, "there is no such log category; use logAll, logStatusWarning or logStatusError");
        *all |= !strcmp(names[k], log_category(LOG_NOTE));
    }
    return true;
}

void component_fail(Component *c) {
    c->mode = FAILED;
    c->valid = false;
    memcpy(c->status, c->message, sizeof c->status);
}

bool component_check_mode(Component *c, const char *function, int modes) {
    if (c->mode & modes) return true;
    if (c->mode == INSTANTIATED) return log_error(c, "%s is not allowed before a successful initialisation", function);
    if (c->mode == INITIALIZATION)
        return log_error(c, "%s is not allowed during initialisation; exit it first", function);
    if (c->mode == STEPPING)
        return log_error(c, "%s is not allowed after initialisation; reset the FMU first", function);
    if (c->mode == TERMINATED)
        return log_error(c, "%s is not allowed after termination; reset the FMU first", function);
    return log_error(c, "%s is not allowed after a failure; reset the FMU or restore a state; the failure: %s",
                     function, c->status);
}

/* life cycle */

bool component_setup(Component *c, double start, bool stop_defined, double stop) {
    char text[DECIMAL_SIZE], other[DECIMAL_SIZE];
    if (!isfinite(start))
        return log_error(c, "the start time %s s is not finite; give a number", shortest(start, text));
    if (stop_defined && !(stop >= start))
        return log_error(c, "the stop time %s s is not at or after the start time %s s; give a later one",
                         shortest(stop, text), shortest(start, other));
    c->start = c->time = start;
    c->stop = stop_defined ? stop : INFINITY;
    return true;
}

static size_t index_of(const char *name) {
    size_t i = 0;
    while (i < MODEL_SCALARS && strcmp(MODEL_VARIABLES[i].name, name)) i++;
    return i;
}

void component_tolerance(Component *c, double tolerance) {
    const char *name = model_accuracy();
    const size_t scalar = name ? index_of(name) : MODEL_SCALARS;
    const double own = scalar < MODEL_SCALARS ? c->scalars.entries[scalar] : 0.0;
    char message[MESSAGE_BYTES], text[DECIMAL_SIZE], other[DECIMAL_SIZE];
    if (scalar < MODEL_SCALARS && fabs(tolerance - own) <= TOLERANCE_DIGITS * fabs(own)) return;
    shortest(tolerance, text);
    if (scalar < MODEL_SCALARS)
        write_message(message, "the tolerance %s is not used: %s = %s is the accuracy; set that parameter", text, name,
                      shortest(own, other));
    else
        write_message(message, "the tolerance %s is not used: this model has no error control", text);
    c->log(c->context, LOG_WARNING, message);
}

/* Say once that the host's times are too large to tell apart what lies MIN_STEP apart. */
static void warn_of_coarse_times(Component *c) {
    char message[MESSAGE_BYTES], text[DECIMAL_SIZE];
    if (c->coarse || DBL_EPSILON * fabs(c->time) <= MIN_STEP) return;
    c->coarse = true;
    write_message(message,
                  "at t = %s s numbers are %.1g s apart, more than %g s: steps and motions lose digits; count the time "
                  "from the run's beginning, up to %.2g s",
                  shortest(c->time, text), DBL_EPSILON * fabs(c->time), MIN_STEP, MIN_STEP / DBL_EPSILON);
    c->log(c->context, LOG_WARNING, message);
}

void component_enter_initialization(Component *c) {
    c->mode = INITIALIZATION;
    c->changed = INPUTS | PARAMETERS;
    c->warned = 0;
    c->coarse = false;
    warn_of_coarse_times(c);
}

static void warn(Component *c) {
    char text[MESSAGE_BYTES];
    for (int k = 0;; k++) {
        if (c->warned & 1u << k) continue;
        if (!model_warning(c->model, k, text)) return;
        if (!*text) continue;
        c->warned |= 1u << k;
        c->log(c->context, LOG_WARNING, text);
    }
}

static bool set_up(Component *c) {
    char reason[MESSAGE_BYTES] = "";
    if (c->model && c->changed & PARAMETERS) {
        model_destroy(c->model);
        c->model = NULL;
    }
    c->changed = NOTHING;
    c->valid = true;
    c->status[0] = '\0';
    if (!c->model) c->model = model_create(c->scalars.entries, &c->allocator, reason);
    if (!c->model)
        log_error(c, "initialisation: %s", reason);
    else if (!model_initialize(c->model, c->start, c->scalars.entries, reason)) {
        log_error(c, "%s", reason);
        model_destroy(c->model);
        c->model = NULL;
    } else {
        mark_as_used(c);
        model_note(c->model, reason);
        if (*reason) c->log(c->context, LOG_NOTE, reason);
        warn(c);
        return true;
    }
    c->valid = false;
    memcpy(c->status, c->message, sizeof c->status);
    return false;
}

/* Provide the model.  During initialisation it is set up anew after each change of an entry. */
static bool have_model(Component *c) {
    if (c->mode == INITIALIZATION && c->changed) return set_up(c);
    if (c->model) return true;
    return c->valid ? log_error(c, "there are no results before initialisation") : log_error(c, "%s", c->status);
}

bool component_exit_initialization(Component *c) {
    if (!have_model(c)) {
        c->mode = FAILED;
        return false;
    }
    c->mode = STEPPING;
    c->started = true;
    return true;
}

/* Give each acceleration whose speed the host gives as a derivative, and which it does not give itself, the second
   derivative of the cubic through places and speeds of this step and the last one, at this step's:

       a = [6 (y_0 - y) / H + 2 v_0 + 4 v] / H .

   H is the time between them: the step's, where inputs are those at its end, else the last one's; a = 0 before. */
static void infer_accelerations(Component *c, double h) {
    const size_t at_end = index_of("inputs_at_step_end");
    const double H = at_end < MODEL_SCALARS && c->scalars.entries[at_end] != 0.0 ? h : c->last_step;
    const double *now = c->scalars.entries, *before = c->scalars.used, *origins = c->scalars.origins;
    for (size_t y = 0; y < MODEL_SCALARS; y++) {
        const size_t v = MODEL_VARIABLES[y].rate, a = v ? MODEL_VARIABLES[v].rate : 0;
        if (!a || origins[v] != DERIVED || origins[a] != FROM_START) continue;
        c->scalars.entries[a] = H > 0.0 ? (6.0 * (before[y] - now[y]) / H + 2.0 * before[v] + 4.0 * now[v]) / H : 0.0;
    }
}

static bool step(Component *c, double t, double h, int *event) {
    char text[DECIMAL_SIZE], other[DECIMAL_SIZE], reason[MESSAGE_BYTES];
    double now = c->time;
    if (!(h > 0.0 && isfinite(h)))
        return log_error(c, "communication step %s s is not positive and finite", shortest(h, text));
    if (!(fabs(t - now) <= fmin(TIME_SLACK(now), 0.5 * h)))
        return log_error(c, "the host steps from t = %s s, the FMU is at %s s; restore a state to go back",
                         shortest(t, text), shortest(now, other));
    if (t + h > c->stop + TIME_SLACK(c->stop))
        return log_error(c, "a step to t = %s s goes beyond the stop time %s s; announce a later one, or none",
                         shortest(t + h, text), shortest(c->stop, other));
    if (t + h - model_time(c->model) < MIN_STEP) { /* the next step starts at the model's time */
        if (event) *event = 0;
        return true;
    }
    if (c->retune && !model_retune(c->model, c->scalars.entries, reason)) return log_error(c, "%s", reason);
    infer_accelerations(c, h);
    mark_as_used(c);
    if (!model_step(c->model, t, h, c->scalars.entries, event, reason)) return log_error(c, "%s", reason);
    return true;
}

bool component_step(Component *c, double t, double h, bool to_event) {
    int event = c->at_event;
    c->at_event = false;
    if (!step(c, t, h, to_event ? &event : NULL)) {
        component_fail(c);
        return false;
    }
    c->at_event = to_event && event;
    const double reached = c->at_event ? model_time(c->model) : t + h;
    c->last_step = reached - c->time;
    c->time = reached;
    c->valid = true;
    c->status[0] = '\0';
    warn(c);
    warn_of_coarse_times(c);
    return true;
}

double component_time(const Component *c) {
    return c->time;
}

bool component_at_event(const Component *c) {
    return c->at_event;
}

bool component_terminate(Component *c, const char *function) {
    /* After a failure, a second error would hide the first. */
    if (c->mode == FAILED || (c->mode & (INSTANTIATED | INITIALIZATION) && c->message[0])) return true;
    if (!component_check_mode(c, function, STEPPING)) return false;
    c->mode = TERMINATED;
    return true;
}

void component_reset(Component *c) {
    model_destroy(c->model);
    c->model = NULL;
    c->mode = INSTANTIATED;
    c->changed = NOTHING;
    c->retune = c->started = c->at_event = false;
    c->start = c->time = c->last_step = 0.0;
    c->stop = INFINITY;
    c->valid = true;
    c->status[0] = c->message[0] = '\0';
    for (size_t i = 0; i < MODEL_SCALARS; i++) {
        c->scalars.entries[i] = model_start(i);
        c->scalars.origins[i] = FROM_START;
    }
}

/* values */

/* Return the number of scalars of a variable; 0 for an element of another variable. */
static size_t length_of(unsigned reference) {
    return model_has_arrays() ? MODEL_VARIABLES[reference].length : 1;
}

bool component_find(Component *c, unsigned reference, Kind kind, size_t *first, size_t *length) {
    static const char *const names[] = {"Real", "Integer", "Boolean", "String", "Enumeration"};
    char text[DECIMAL_SIZE];
    if (reference >= MODEL_SCALARS || MODEL_VARIABLES[reference].kind != kind || !length_of(reference))
        return log_error(c, "there is no %s variable with value reference %s", names[kind], shortest(reference, text));
    *first = reference;
    *length = length_of(reference);
    return true;
}

bool component_has_token(const char *token) {
    char expected[TOKEN_BYTES];
    model_token(expected);
    return token && !strcmp(token, expected);
}

bool component_get(Component *c, size_t scalar, double *value) {
    char reason[MESSAGE_BYTES];
    *value = 0.0;
    const Variable *variable = &MODEL_VARIABLES[scalar];
    if (variable->source == FROM_ENTRY) *value = c->scalars.entries[scalar];
    if (variable->source == FROM_STATUS_VALID) *value = c->valid;
    if (variable->source == FROM_TIME) *value = component_time(c);
    if (variable->source != FROM_MODEL) return true;
    if (have_model(c) && (model_output(c->model, scalar, value, reason) || log_error(c, "%s", reason))) {
        if (variable->kind == KIND_INTEGER) *value = fmin(*value, INT32_MAX); /* counters grow without bound */
        return true;
    }
    if (variable->kind == KIND_REAL) *value = NAN; /* must not look like a force */
    return false;
}

bool component_get_text(Component *c, size_t scalar, const char **text) {
    char reason[MESSAGE_BYTES] = "";
    *text = MODEL_VARIABLES[scalar].source == FROM_STATUS_MESSAGE ? c->status : "";
    if (MODEL_VARIABLES[scalar].source == FROM_STATUS_MESSAGE) return true;
    return have_model(c) && (model_text(c->model, scalar, text, reason) || log_error(c, "%s", reason));
}

/* Write the reason why an entry cannot have the value; "" if it can. */
static void check_entry(const Variable *variable, double value, char reason[MESSAGE_BYTES]) {
    char text[DECIMAL_SIZE];
    reason[0] = '\0';
    if (!isfinite(value) && variable->causality == CAUSALITY_INPUT)
        write_message(reason, "input %s = %s is not finite; check the signal connected to it", variable->name,
                      shortest(value, text));
    else if (!isfinite(value))
        write_message(reason, "%s = %s is out of range: it must be finite; give a number", variable->name,
                      shortest(value, text));
    else if (variable->choices && !(value >= 0.0 && value < variable->count))
        write_message(reason, "%s = %s is none of the choices: %s", variable->name, shortest(value, text),
                      variable->choices);
    else if (variable->kind != KIND_REAL && !(fabs(value) <= 2147483648.0 && value == floor(value)))
        write_message(reason, "%s = %s is out of range: it must be a whole number of 32 bits; give a smaller one",
                      variable->name, shortest(value, text));
}

static bool enter(Component *c, size_t scalar, double value) {
    const Variable *variable = &MODEL_VARIABLES[scalar];
    char reason[MESSAGE_BYTES], text[DECIMAL_SIZE];
    if (variable->causality == CAUSALITY_OUTPUT)
        return log_error(c, "%s is an output and cannot be set", variable->name);
    if (variable->causality == CAUSALITY_INDEPENDENT)
        return log_error(c, "%s is the independent variable; it advances with the steps and cannot be set",
                         variable->name);
    if (c->started && variable->variability == VARIABILITY_FIXED) {
        if (value == c->scalars.entries[scalar]) return true;
        return log_error(c, "%s is fixed after initialisation; it stays %s; reset the FMU to change it", variable->name,
                         value_text(variable, c->scalars.entries[scalar], text));
    }
    check_entry(variable, value, reason);
    if (*reason) return log_error(c, "%s", reason);
    if (c->started && variable->variability == VARIABILITY_TUNABLE) c->retune = true;
    c->changed |= variable->causality == CAUSALITY_PARAMETER ? PARAMETERS : INPUTS;
    c->scalars.entries[scalar] = value;
    return true;
}

bool component_set(Component *c, size_t scalar, double value) {
    if (!enter(c, scalar, value)) return false;
    if (c->started) c->scalars.origins[scalar] = GIVEN; /* earlier ones are start values */
    return true;
}

bool component_set_rate(Component *c, size_t scalar, int order, double value) {
    const Variable *variable = &MODEL_VARIABLES[scalar];
    char text[DECIMAL_SIZE];
    if (variable->causality != CAUSALITY_INPUT)
        return log_error(c, "there is no time derivative of %s to be set; give one of an input", variable->name);
    if (order < 1 || !isfinite(value))
        return log_error(c, "derivative %d of %s = %s must be of order 1 or higher, and finite", order, variable->name,
                         shortest(value, text));
    for (; order > 0 && scalar; order--) scalar = MODEL_VARIABLES[scalar].rate;
    if (!scalar || c->scalars.origins[scalar] == GIVEN) return true;
    if (!enter(c, scalar, value)) return false;
    if (c->started) c->scalars.origins[scalar] = DERIVED;
    return true;
}

bool component_derivative(Component *c, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                          const double *seed, double *sensitivity) {
    size_t i, first = 0, length = 0;
    char reason[MESSAGE_BYTES] = "", text[DECIMAL_SIZE];
    for (i = 0; i < unknowns; i++) {
        if (!component_find(c, unknown[i], KIND_REAL, &first, &length)) return false;
        if (MODEL_VARIABLES[first].source != FROM_MODEL || length != 1)
            return log_error(c, "there is no derivative of %s; ask for one of an output that depends on the inputs",
                             MODEL_VARIABLES[first].name);
        sensitivity[i] = 0.0;
    }
    for (i = 0; i < knowns; i++) {
        if (!component_find(c, known[i], KIND_REAL, &first, &length)) return false;
        if (MODEL_VARIABLES[first].causality != CAUSALITY_INPUT)
            return log_error(c, "there is no derivative to %s; ask for one to an input", MODEL_VARIABLES[first].name);
        if (!isfinite(seed[i]))
            return log_error(c, "the seed of %s = %s is not finite; give a number", MODEL_VARIABLES[first].name,
                             shortest(seed[i], text));
    }
    if (!have_model(c)) return false;
    for (i = 0; i < knowns; i++)
        if (!model_derivative(c->model, known[i], seed[i], unknown, unknowns, sensitivity, reason))
            return log_error(c, "%s", reason);
    return true;
}

/* states */

static size_t model_bytes(const Component *c) {
    return c->started && c->model ? model_state_bytes(c->model) : 0;
}

size_t component_state_bytes(const Component *c) {
    return sizeof(StateHeader) + scalars_bytes() + model_bytes(c);
}

/* Return the FNV-1a hash over words: fast, because hosts save at every step.  It detects damage, not malice. */
static uint64_t checksum(const unsigned char *bytes, size_t count) {
    uint64_t sum = 14695981039346656037u, word;
    for (; count >= sizeof word; bytes += sizeof word, count -= sizeof word) {
        memcpy(&word, bytes, sizeof word);
        sum = (sum ^ word) * 1099511628211u;
    }
    while (count--) sum = (sum ^ *bytes++) * 1099511628211u;
    return sum;
}

static uint64_t state_checksum(const void *state, size_t bytes) {
    size_t from = offsetof(StateHeader, checksum) + sizeof(uint64_t);
    return checksum((const unsigned char *)state + from, bytes - from);
}

void component_save(const Component *c, void *to) {
    StateHeader header;
    unsigned char *numbers = (unsigned char *)to + sizeof header, *rest = numbers + scalars_bytes();
    memset(&header, 0, sizeof header);
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    header.bytes = component_state_bytes(c);
    header.version = STATE_VERSION;
    header.mode = c->mode;
    header.valid = c->valid;
    header.started = model_bytes(c) != 0;
    header.at_event = c->at_event;
    header.start = c->start;
    header.stop = c->stop;
    header.time = c->time;
    header.last_step = c->last_step;
    model_token(header.token);
    strcpy(header.status, c->status);
    memcpy(numbers, c->numbers, scalars_bytes());
    if (model_bytes(c)) model_save(c->model, rest);
    memcpy(to, &header, sizeof header);
    header.checksum = state_checksum(to, (size_t)header.bytes);
    memcpy(to, &header, sizeof header);
}

/* True if the text is terminated and printable, as those of log_error() are. */
static bool is_message(const char text[MESSAGE_BYTES]) {
    for (size_t i = 0; i < MESSAGE_BYTES; i++) {
        if (text[i] == '\0') return true;
        if (((unsigned char)text[i] < ' ' && text[i] != '\n') || text[i] == 127) return false; /* UTF-8 passes */
    }
    return false;
}

/* Return the entries in a state. */
static const double *saved_entries(const StateHeader *header) {
    return (const double *)(header + 1);
}

/* Return the entries in a state that the model used last. */
static const double *saved_used(const StateHeader *header) {
    return saved_entries(header) + MODEL_SCALARS;
}

/* Return the bytes of the model in a state. */
static const unsigned char *saved_model(const StateHeader *header) {
    return (const unsigned char *)(header + 1) + scalars_bytes();
}

/* True if a component can have this mode, these times and this status. */
static bool header_plausible(const StateHeader *header) {
    const bool before_start = header->mode == INSTANTIATED || header->mode == INITIALIZATION;
    const bool after_start = header->mode == STEPPING || header->mode == TERMINATED;
    if (!before_start && !after_start && header->mode != FAILED) return false;
    if ((before_start && header->started) || (after_start && !header->started)) return false;
    if (!isfinite(header->start) || !isfinite(header->time) || !isfinite(header->last_step)) return false;
    if (!(header->stop >= header->start) || !is_message(header->status)) return false;
    return header->valid || header->status[0] != '\0';
}

/* Write the reason why a component cannot have these entries; "" if it can. */
static void check_entries(const double *entries, char reason[MESSAGE_BYTES]) {
    reason[0] = '\0';
    for (size_t i = 0; i < MODEL_SCALARS && !reason[0]; i++)
        if (MODEL_VARIABLES[i].source == FROM_ENTRY) check_entry(&MODEL_VARIABLES[i], entries[i], reason);
}

bool component_is_state(Component *c, const void *from, size_t bytes) {
    const StateHeader *header = from;
    const size_t least = sizeof *header + scalars_bytes();
    char reason[MESSAGE_BYTES], expected[TOKEN_BYTES], text[DECIMAL_SIZE];
    model_token(expected);
    if (bytes < sizeof *header || memcmp(header->magic, MAGIC, sizeof MAGIC))
        return log_error(c, "these %s bytes are not a state of this FMU", shortest((double)bytes, text));
    if (header->version != STATE_VERSION || memcmp(header->token, expected, TOKEN_BYTES))
        return log_error(c, "the state is none of this FMU's: it is another build's; restore it there");
    if (bytes < least || header->bytes != bytes || header->checksum != state_checksum(from, bytes))
        return log_error(c, "these %s bytes are a damaged state: length or checksum do not fit; save it anew",
                         shortest((double)bytes, text));
    if (!header_plausible(header)) return log_error(c, "the state contradicts itself; save it anew");
    check_entries(saved_entries(header), reason);
    if (!reason[0]) check_entries(saved_used(header), reason);
    return !reason[0] || log_error(c, "the state contradicts itself: %s", reason);
}

static bool same_fixed(const double *a, const double *b) {
    for (size_t i = 0; i < MODEL_SCALARS; i++)
        if (MODEL_VARIABLES[i].variability == VARIABILITY_FIXED && a[i] != b[i]) return false;
    return true;
}

bool component_restore(Component *c, const void *from, size_t bytes) {
    const StateHeader *header = from;
    ModelInstance *model = NULL;
    char reason[MESSAGE_BYTES] = "";
    if (!component_is_state(c, from, bytes)) return false;
    if (header->started) {
        const double *used = saved_used(header);
        const size_t count = bytes - sizeof *header - scalars_bytes();
        /* Other fixed parameters need a new model; the present one stays until that has the state. */
        const bool fits = c->started && c->model && same_fixed(saved_entries(header), c->scalars.entries);
        model = fits ? c->model : model_create(used, &c->allocator, reason);
        if (!model || !model_retune(model, used, reason) || !model_restore(model, saved_model(header), count, reason)) {
            char other[MESSAGE_BYTES];
            if (fits)
                model_retune(model, c->scalars.used, other);
            else
                model_destroy(model);
            return log_error(c, "setFMUstate: %s", reason);
        }
    }
    if (model != c->model) model_destroy(c->model);
    c->model = model;
    memcpy(c->numbers, saved_entries(header), scalars_bytes());
    memcpy(c->status, header->status, sizeof c->status);
    c->start = header->start;
    c->stop = header->stop;
    c->time = header->time;
    c->last_step = header->last_step;
    c->mode = header->mode;
    c->valid = header->valid;
    c->started = header->started;
    c->at_event = header->at_event;
    c->retune = header->started;
    c->changed = header->started ? NOTHING : INPUTS | PARAMETERS;
    return true;
}
