/* Life cycle of an FMU's instance: modes, steps and messages. */

#include "component.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "component_data.h"
#include "text.h"

#define TOLERANCE_DIGITS 1e-5 /* relative, to which a model description writes its tolerance */
/* s; shorter steps, which rounding of the host's times leaves, do not advance the model.  A model must
   take all longer ones: the rope skips those below ROPE_MIN_INTERVAL. */
#define TIME_RESOLUTION 1e-9
/* s, difference allowed between times of host and model */
#define TIME_SLACK(t) (TIME_RESOLUTION + 4 * DBL_EPSILON * fabs(t))

/* Return the bytes of one array of Scalars. */
static size_t array_bytes(void) {
    return MODEL_SCALARS * sizeof(double);
}

size_t scalars_bytes(void) {
    return 3 * array_bytes();
}

/* Return the arrays that follow each other in a block of scalars_bytes(). */
static Scalars scalars_in(double *block) {
    return (Scalars){
        .entries = block,
        .used = block + MODEL_SCALARS,
        .origins = block + 2 * MODEL_SCALARS,
    };
}

/* Record that the model uses the present entries. */
static void mark_as_used(Component *c) {
    memcpy(c->scalars.used, c->scalars.entries, array_bytes());
    c->retune = false;
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

bool component_error(Component *c, const char *format, ...) {
    char message[MESSAGE_BYTES]; /* the arguments may point into c->message */
    va_list arguments;
    va_start(arguments, format);
    write_message_of(message, format, arguments);
    va_end(arguments);
    memcpy(c->message, message, sizeof message);
    c->log(c->context, LOG_ERROR, c->message);
    return false;
}

bool component_nonnull(Component *c, const void *pointer) {
    return pointer || component_error(c, "a pointer is NULL; give the address of the data");
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
            return component_error(c, "there is no such log category; use logAll, logStatusWarning or logStatusError");
        *all |= !strcmp(names[k], log_category(LOG_NOTE));
    }
    return true;
}

/* Keep the last error as the reason why there are no results; return false. */
static bool keep_reason(Component *c) {
    c->valid = false;
    memcpy(c->status, c->message, sizeof c->status);
    return false;
}

bool component_fail(Component *c) {
    c->mode = FAILED;
    return keep_reason(c);
}

bool component_check_mode(Component *c, const char *function, int modes) {
    if (c->mode & modes) return true;
    if (c->mode == INSTANTIATED)
        return component_error(c, "%s is not allowed before a successful initialisation", function);
    if (c->mode == INITIALIZATION)
        return component_error(c, "%s is not allowed during initialisation; exit it first", function);
    if (c->mode == STEPPING)
        return component_error(c, "%s is not allowed after initialisation; reset the FMU first", function);
    if (c->mode == TERMINATED)
        return component_error(c, "%s is not allowed after termination; reset the FMU first", function);
    return component_error(c, "%s is not allowed after a failure; reset the FMU or restore a state; the failure: %s",
                           function, c->status);
}

/* life cycle */

bool component_setup(Component *c, double start, bool stop_defined, double stop) {
    if (!isfinite(start)) return component_error(c, "the start time %s s is not finite; give a number", SHORT(start));
    if (stop_defined && !(stop >= start))
        return component_error(c, "the stop time %s s is not at or after the start time %s s; give a later one",
                               SHORT(stop), SHORT(start));
    c->start = start;
    c->time = start;
    c->stop = stop_defined ? stop : INFINITY;
    return true;
}

void component_tolerance(Component *c, double tolerance) {
    const bool controlled = MODEL_ACCURACY < MODEL_SCALARS;
    const double own = controlled ? c->scalars.entries[MODEL_ACCURACY] : 0.0;
    char message[MESSAGE_BYTES];
    if (controlled && fabs(tolerance - own) <= TOLERANCE_DIGITS * fabs(own)) return;
    if (controlled)
        write_message(message, "the tolerance %s is not used: %s = %s is the accuracy; set that parameter",
                      SHORT(tolerance), MODEL_VARIABLES[MODEL_ACCURACY].name, SHORT(own));
    else
        write_message(message, "the tolerance %s is not used: this model has no error control", SHORT(tolerance));
    c->log(c->context, LOG_WARNING, message);
}

/* Say once that the host's times are too large to tell apart what lies TIME_RESOLUTION apart. */
static void warn_of_coarse_times(Component *c) {
    char message[MESSAGE_BYTES];
    if (c->coarse || DBL_EPSILON * fabs(c->time) <= TIME_RESOLUTION) return;
    c->coarse = true;
    write_message(message,
                  "at t = %s s numbers are %.1g s apart, more than %g s: steps and motions lose digits; count the time "
                  "from the run's beginning, up to %.2g s",
                  SHORT(c->time), DBL_EPSILON * fabs(c->time), TIME_RESOLUTION, TIME_RESOLUTION / DBL_EPSILON);
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
    char note[MESSAGE_BYTES] = "";
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
        component_error(c, "initialisation: %s", reason);
    else if (!model_initialize(c->model, c->start, c->scalars.entries, reason) || !model_note(c->model, note, reason)) {
        component_error(c, "%s", reason);
        model_destroy(c->model);
        c->model = NULL;
    } else {
        mark_as_used(c);
        if (*note) c->log(c->context, LOG_NOTE, note);
        warn(c);
        return true;
    }
    return keep_reason(c);
}

bool component_provide_model(Component *c) {
    if (c->mode == INITIALIZATION && c->changed) return set_up(c);
    if (c->model) return true;
    return c->valid ? component_error(c, "there are no results before initialisation")
                    : component_error(c, "%s", c->status);
}

bool component_exit_initialization(Component *c) {
    if (!component_provide_model(c)) {
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
    const double *now = c->scalars.entries;
    const double *before = c->scalars.used;
    const double *origins = c->scalars.origins;
    const bool at_end = MODEL_AT_STEP_END < MODEL_SCALARS && now[MODEL_AT_STEP_END] != 0.0;
    const double H = at_end ? h : c->last_step;
    for (size_t y = 0; y < MODEL_SCALARS; y++) {
        const size_t v = MODEL_VARIABLES[y].rate;
        const size_t a = v ? MODEL_VARIABLES[v].rate : 0;
        if (!a || origins[v] != DERIVED || origins[a] != FROM_START) continue;
        c->scalars.entries[a] = H > 0.0 ? (6.0 * (before[y] - now[y]) / H + 2.0 * before[v] + 4.0 * now[v]) / H : 0.0;
    }
}

/* Step to t + h, or to an event unless `event` is NULL; *reached is the time then. */
static bool step(Component *c, double t, double h, int *event, double *reached) {
    char reason[MESSAGE_BYTES];
    const double now = c->time;
    double of_model;
    if (!(h > 0.0 && isfinite(h)))
        return component_error(c, "communication step %s s is not positive and finite", SHORT(h));
    if (!(fabs(t - now) <= fmin(TIME_SLACK(now), 0.5 * h)))
        return component_error(c, "the host steps from t = %s s, the FMU is at %s s; restore a state to go back",
                               SHORT(t), SHORT(now));
    if (t + h > c->stop + TIME_SLACK(c->stop))
        return component_error(c, "a step to t = %s s goes beyond the stop time %s s; announce a later one, or none",
                               SHORT(t + h), SHORT(c->stop));
    *reached = t + h;
    if (!model_time(c->model, &of_model, reason)) return component_error(c, "%s", reason);
    if (t + h - of_model < TIME_RESOLUTION) { /* the next step starts at the model's time */
        if (event) *event = 0;
        return true;
    }
    if (c->retune && !model_retune(c->model, c->scalars.entries, reason)) return component_error(c, "%s", reason);
    infer_accelerations(c, h);
    mark_as_used(c);
    if (!model_step(c->model, t, h, c->scalars.entries, event, reason)) return component_error(c, "%s", reason);
    if (event && *event && !model_time(c->model, reached, reason)) return component_error(c, "%s", reason);
    return true;
}

bool component_step(Component *c, double t, double h, bool to_event) {
    int event = c->at_event;
    double reached;
    c->at_event = false;
    if (!step(c, t, h, to_event ? &event : NULL, &reached)) return component_fail(c);
    c->at_event = to_event && event;
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
    c->retune = false;
    c->started = false;
    c->at_event = false;
    c->start = 0.0;
    c->time = 0.0;
    c->last_step = 0.0;
    c->stop = INFINITY;
    c->valid = true;
    c->status[0] = '\0';
    c->message[0] = '\0';
    for (size_t i = 0; i < MODEL_SCALARS; i++) {
        c->scalars.entries[i] = model_start(i);
        c->scalars.origins[i] = FROM_START;
    }
}

bool component_has_token(const char *token) {
    char expected[TOKEN_BYTES];
    model_token(expected);
    return token && !strcmp(token, expected);
}
