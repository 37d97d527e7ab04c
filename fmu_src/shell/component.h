/* A model in the life cycle of FMI.  Actions that return bool return true on success, and false
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
/* Log an error, written as by write_message, keep it for component_fail, and return false. */
bool component_error(Component *c, const char *format, ...);
/* Enter FAILED after a refusal, with its reason in status.message; return false. */
bool component_fail(Component *c);

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

#endif
