/* Interface of a model: a table of scalars and a few functions.

   The files of an FMU, each of which calls none above it:

       fmi2.c or fmi3.c    functions of the standard; both with shell.inc
       snapshot.c          states as objects of the host
       saved_state.c       states of a component as blocks of bytes
       values.c            values by value reference, rules of causality and variability
       component.c         life cycle, modes, steps, log
       the model           rope_model.c, python_model.c, drive_model.c or another one
       variables.c         generated: table of the scalars
       start.c             generated: data of one export
       message.c, text.c   messages; texts and numbers

   A model is linked into its FMU.  Its data are in ModelInstance, except those loaded once. */
#ifndef MODEL_H
#define MODEL_H

#include <stdbool.h>
#include <stddef.h>

#include "message.h"

/* infinity and NaN must be told from numbers: a NaN would look like a force */
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "compile without -Ofast, -ffast-math and -ffinite-math-only: this code checks for NaN and infinity"
#endif

typedef enum { KIND_REAL, KIND_INTEGER, KIND_BOOLEAN, KIND_STRING, KIND_ENUMERATION } Kind;
typedef enum { CAUSALITY_PARAMETER, CAUSALITY_INPUT, CAUSALITY_OUTPUT, CAUSALITY_INDEPENDENT } Causality;
typedef enum { VARIABILITY_FIXED, VARIABILITY_TUNABLE, VARIABILITY_CONTINUOUS, VARIABILITY_DISCRETE } Variability;
/* source of a value: entered by the host, computed by the model, or kept by the component */
typedef enum { FROM_ENTRY, FROM_MODEL, FROM_STATUS_VALID, FROM_STATUS_MESSAGE, FROM_TIME } Source;

/* One scalar; its index in the table is its value reference.  An array is a run of scalars: the first has their number
   in `length`, the others have length 0 and no value reference. */
typedef struct {
    const char *name;
    const char *choices; /* as "0 locked, 1 free, 2 coulomb", or NULL */
    unsigned count;      /* number of choices */
    unsigned length;
    unsigned rate; /* value reference of the input that is the time derivative of this input; 0 for none */
    unsigned char kind, causality, variability, source;
} Variable;

extern const Variable MODEL_VARIABLES[];
extern const size_t MODEL_SCALARS;
/* scalars with a meaning for the shell; MODEL_SCALARS where the model has none */
extern const size_t MODEL_ACCURACY;    /* parameter that has the model's accuracy, in place of the tolerance of FMI */
extern const size_t MODEL_AT_STEP_END; /* parameter that is true if the inputs of a step are those at its end */

/* Data of one export, in start.c; they are also patched into a finished library.  The token is checked at
   instantiation: the GUID of FMI 2, the instantiation token of FMI 3. */
enum { TOKEN_BYTES = 64 };
void model_token(char token[TOKEN_BYTES]);
double model_start(size_t scalar); /* start value of an entry; from MODEL_SCALARS on further numbers of the model */
bool model_has_arrays(void);       /* true if an array is one variable, false if each of its scalars is one */

/* The host's allocator, with the behaviour of calloc and free. */
typedef struct {
    void *(*allocate)(size_t count, size_t size);
    void (*deallocate)(void *);
} Allocator;

bool model_has_events(void); /* true if a step may end at an event */

typedef struct ModelInstance ModelInstance;

/* `values` has the entries by value reference (MODEL_SCALARS doubles; others are 0), finite, with choices in range and
   integers whole.  Functions that return bool return true on success.  They return false on failure: `message`
   (MESSAGE_BYTES bytes) names value, bound and cure, and the model is unchanged. */

/* Prepare this process for models; call it before model_create.  `resources` is the FMU's folder of that name, a URI in
   FMI 2.0, a path in 3.0. */
bool model_open(const char *resources, char *message);
/* Create a model with all memory that it needs; return NULL on failure. */
ModelInstance *model_create(const double *values, const Allocator *allocator, char *message);
void model_destroy(ModelInstance *model); /* NULL is allowed */
/* Initialise at time t with these inputs, again if they change before the first step. */
bool model_initialize(ModelInstance *model, double t, const double *values, char *message);
/* Step from the model's time, about t, to t + h, or to an event unless `event` is NULL.  *event, in: nonzero if the
   last step ended at an event; out: nonzero if this one does. */
bool model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message);
/* Change tunable parameters. */
bool model_retune(ModelInstance *model, const double *values, char *message);

/* Write the model's time, s. */
bool model_time(const ModelInstance *model, double *t, char *message);
/* Return a scalar whose source is FROM_MODEL. */
bool model_output(ModelInstance *model, size_t scalar, double *value, char *message);
bool model_text(ModelInstance *model, size_t scalar, const char **text, char *message);
/* Write a line for the log about the model into `note` (MESSAGE_BYTES); "" for none. */
bool model_note(const ModelInstance *model, char *note, char *message);
/* Write warning `index`, from 0 on; "" if it does not apply.  Return false after the last warning. */
bool model_warning(ModelInstance *model, int index, char *message);

/* Add seed times the derivatives of the scalars `unknown` with respect to the scalar `known` to sum (count). */
bool model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                      double *sum, char *message);

/* The complete state without the entries is a block of bytes without addresses, valid in every process. */
bool model_state_bytes(const ModelInstance *model, size_t *bytes, char *message);
/* Write the state into `to`, of as many bytes as model_state_bytes gave; leave them unchanged on failure. */
bool model_save(const ModelInstance *model, void *to, size_t bytes, char *message);
bool model_restore(ModelInstance *model, const void *from, size_t bytes, char *message);

#endif
