/* A model behind value references, for the FMI shells.  Actions that return bool return true on success, and false
   after they have logged the reason.  Between the end of initialisation and destruction only states are allocated. */
#ifndef COMPONENT_H
#define COMPONENT_H

#include <stdbool.h>
#include <stddef.h>

#include "model.h"

/* modes of co-simulation; a sum is a set of modes */
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16, ANY_MODE = 31 };

/* messages of both shells */
#define NO_NAME "the instance has no name; give one"
#define NO_MEMORY "no memory for an instance; free others first"
#define CO_SIMULATION_ONLY "this FMU is for co-simulation only; functions of other kinds are not supported"

typedef struct Component Component;
typedef enum { LOG_NOTE, LOG_WARNING, LOG_ERROR } Severity;
const char *log_category(Severity severity); /* "logAll", "logStatusWarning", "logStatusError" */
typedef void (*ComponentLog)(void *context, Severity severity, const char *message);

/* Return NULL without memory.  `log` receives `context`. */
Component *component_create(const Allocator *allocator, ComponentLog log, void *context);
void component_destroy(Component *c);
/* Log an error, keep it for component_fail, and return 0. */
bool component_error(Component *c, const char *message);
/* Enter FAILED after a refusal, with its reason in status.message. */
void component_fail(Component *c);

/* Copy a text of UTF-8 as far as there is room, and no part of a character. */
void copy_text(char *to, size_t room, const char *from);

bool component_nonnull(Component *c, const void *pointer); /* Refuse NULL. */
/* Check names of log categories; *all is true if they select all, also for an empty list. */
bool component_categories(Component *c, size_t count, const char *const names[], bool *all);

/* Refuse a call of `function` outside of `modes`. */
bool component_check_mode(Component *c, const char *function, int modes);

/* life cycle: each enters the next mode, or FAILED */
bool component_setup(Component *c, double start, bool stop_defined, double stop);
/* Say in the log that a tolerance of the host is not used, unless the model has it already. */
void component_tolerance(Component *c, double tolerance);
void component_enter_initialization(Component *c);
bool component_exit_initialization(Component *c);
/* Step to t + h; with to_event only to the first event before it. */
bool component_step(Component *c, double t, double h, bool to_event);
double component_time(const Component *c);
bool component_at_event(const Component *c); /* True if the last step ended at an event. */
/* Terminate.  Does nothing after a failure, and after a refusal before the first step. */
bool component_terminate(Component *c, const char *function);
void component_reset(Component *c);

bool component_has_token(const char *token); /* NULL is no token */

/* Find the scalars of a variable: *length from *first on. */
bool component_find(Component *c, unsigned reference, Kind kind, size_t *first, size_t *length);
bool component_get(Component *c, size_t scalar, double *value);
bool component_get_text(Component *c, size_t scalar, const char **text);
/* Set a time derivative of an input: the value of the input that is this derivative, unless the host has set that.
   Where it gives speeds so, and neither accelerations nor their derivatives, those of the end follow by differences. */
bool component_set_rate(Component *c, size_t scalar, int order, double value);
/* Set an entry; refuse values that are not finite or no choice, and fixed entries after initialisation. */
bool component_set(Component *c, size_t scalar, double value);

/* sensitivity (unknowns): derivatives of the unknowns with respect to the knowns, times seed (knowns) */
bool component_derivative(Component *c, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                          const double *seed, double *sensitivity);

/* The complete state, with entries, mode, status and times.  `from` is aligned as by calloc, from any process. */
size_t component_state_bytes(const Component *c);
void component_save(const Component *c, void *to);
bool component_restore(Component *c, const void *from, size_t bytes);
bool component_is_state(Component *c, const void *from, size_t bytes); /* Refuse what component_restore cannot read. */

#endif
