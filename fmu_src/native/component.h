/* A model behind value references: what the FMI shells have in common.

   Functions that return int return 1 when all is well; 0 when not, then the reason was logged.  Nothing is allocated
   between the end of initialisation and destruction, but for states. */
#ifndef COMPONENT_H
#define COMPONENT_H

#include <stddef.h>

#include "model.h"

/* modes of the co-simulation state machine; a set of them is a sum */
enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8, FAILED = 16, ANY_MODE = 31 };

/* what both shells say */
#define NO_NAME "the instance has no name; give one"
#define NO_MEMORY "no memory for an instance; free others first"
#define CO_SIMULATION_ONLY "this FMU is for co-simulation only; functions of other kinds are not supported"

typedef struct Component Component;
/* how serious a line of the log is */
typedef enum { LOG_NOTE, LOG_WARNING, LOG_ERROR } Severity;
/* "logAll", "logStatusWarning", "logStatusError" */
const char *log_category(Severity severity);
typedef void (*ComponentLog)(void *context, Severity severity, const char *message);

/* NULL when there is no memory; `log` gets `context` back */
Component *component_create(const Allocator *allocator, ComponentLog log, void *context);
void component_destroy(Component *c);
/* says `message` in the log, and leaves it for component_fail; returns 0 */
int component_refuse(Component *c, const char *message);
/* after a refusal that leaves host and FMU at odds, as of a value to be set: FAILED, status.message tells why */
void component_fail(Component *c);

/* whether the pointer is not NULL */
int component_given(Component *c, const void *pointer);
/* whether these are log categories; `all`: whether they are all, by name or because there are none */
int component_categories(Component *c, size_t number, const char *const names[], int *all);

/* whether `function` may be called now, in one of `modes` */
int component_allows(Component *c, const char *function, int modes);

/* life cycle; each moves to the mode that follows, to FAILED when it fails */
int component_setup(Component *c, double start, int stop_defined, double stop);
void component_enter_initialization(Component *c);
int component_exit_initialization(Component *c);
/* to t + h, or `to_event` to an event before it */
int component_step(Component *c, double t, double h, int to_event);
double component_time(const Component *c);
int component_at_event(const Component *c); /* whether the last step ended at one */
/* of no effect and without a word after something has failed, or been refused before the first step */
int component_terminate(Component *c, const char *function);
void component_reset(Component *c);

/* whether `token` is this FMU's; NULL is not */
int component_has_token(const char *token);

/* the scalars of the variable `reference` of `kind`: *length from *first on */
int component_find(Component *c, unsigned reference, Kind kind, size_t *first, size_t *length);
int component_get(Component *c, size_t scalar, double *value);
int component_get_text(Component *c, size_t scalar, const char **text);
/* The derivative of so high an order of an input: it stands for the input that is this derivative, where there is one
   and the host has not set it. */
int component_set_rate(Component *c, size_t scalar, int order, double value);
/* finite, one of the choices, and not fixed by now */
int component_set(Component *c, size_t scalar, double value);

/* sensitivity (unknowns) = derivatives of the unknowns to the knowns, times seed (knowns) */
int component_derivative(Component *c, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                         const double *seed, double *sensitivity);

/* the complete state, entries, mode, status, start and stop time included; `from`, aligned as by calloc, may be another
 * process's */
size_t component_state_bytes(const Component *c);
void component_save(const Component *c, void *to);
int component_restore(Component *c, const void *from, size_t bytes);
/* whether component_restore could read it */
int component_is_state(Component *c, const void *from, size_t bytes);

#endif
