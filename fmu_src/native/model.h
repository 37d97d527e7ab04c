/* What a model gives to the component: a table of scalars, and a handful of functions.

   fmi2.c or fmi3.c (the shell) -> component.c (values, rules, states) -> one model: rope_model.c, python_model.c, or
   another one.
   An FMU holds one model, linked in; all that it changes lives in its
   ModelInstance, but for what is loaded once. */
#ifndef MODEL_H
#define MODEL_H

#include <stddef.h>

/* room for a message, its end included */
enum { MODEL_MESSAGE = 640 };

typedef enum { KIND_REAL, KIND_INTEGER, KIND_BOOLEAN, KIND_STRING, KIND_ENUMERATION } Kind;
typedef enum { CAUSALITY_PARAMETER, CAUSALITY_INPUT, CAUSALITY_OUTPUT, CAUSALITY_INDEPENDENT } Causality;
typedef enum { VARIABILITY_FIXED, VARIABILITY_TUNABLE, VARIABILITY_CONTINUOUS, VARIABILITY_DISCRETE } Variability;
/* who knows the value: it was entered; the model computes it; the component knows it */
typedef enum { FROM_ENTRY, FROM_MODEL, FROM_STATUS_VALID, FROM_STATUS_MESSAGE, FROM_TIME } Source;

/* One scalar; its place in the table is its value reference.  An array is a run of scalars: the first carries the
   number of them in `length`, the others have length 0 and no value reference of their own. */
typedef struct {
    const char *name;
    const char *choices; /* of entries that choose one of a few: "0 locked, 1 free, 2 coulomb"; else NULL */
    unsigned number;     /* of choices */
    unsigned length;
    unsigned rate; /* of an input: value reference of the input that is its time derivative; 0: there is none */
    unsigned char kind, causality, variability, source;
} Variable;

extern const Variable MODEL_VARIABLES[];
extern const size_t MODEL_SCALARS;

/* What one export has and another has not (start.c).  It is written into the finished library, too: one library serves
   all exports.  The token is checked at instantiation: the GUID of FMI 2, the instantiation token of FMI 3. */
enum { MODEL_TOKEN = 64 };
void model_token(char token[MODEL_TOKEN]);
/* of entries; integers and booleans are exact */
double model_start(size_t scalar);
/* whether arrays are one variable; if not, each of their scalars is a variable of its own */
int model_has_arrays(void);

/* as calloc and free */
typedef struct {
    void *(*take)(size_t number, size_t size);
    void (*give_back)(void *);
} Allocator;

typedef struct ModelInstance ModelInstance;

/* `values` holds the entries by value reference (MODEL_SCALARS doubles; others are 0).  Entries are finite, choices in
   range, integers whole.  Functions that return int return 1 when all is well; 0 when not, then `message`
   (MODEL_MESSAGE bytes) names value, bound and cure, and the model is what it was before. */

/* Whether models can be made in this process: before the first, and as often as wanted. `resources` is the FMU's folder
   of that name, a URI in FMI 2.0, a path in 3.0; the model may need nothing of it. */
int model_open(const char *resources, char *message);
/* With these parameters; takes all memory it will ever need.  NULL when that cannot be. */
ModelInstance *model_create(const double *values, const Allocator *allocator, char *message);
void model_destroy(ModelInstance *model); /* NULL: nothing to do */
/* Consistent at the time t with these inputs; may be called again, with other inputs, before the first step. */
int model_initialize(ModelInstance *model, double t, const double *values, char *message);
/* From the model's own time, up to a rounding before t, to t + h, or to an event where `event` is not NULL.  *event
   tells before whether the last step ended at one, and then whether this one does. */
int model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message);
/* go on with other tunable parameters */
int model_retune(ModelInstance *model, const double *values, char *message);

/* the instant that the model is at */
double model_time(const ModelInstance *model);
/* scalars with FROM_MODEL */
int model_output(ModelInstance *model, size_t scalar, double *value, char *message);
int model_text(ModelInstance *model, size_t scalar, const char **text, char *message);
/* a line for the log about what was set up; "" for none */
void model_note(const ModelInstance *model, char *message);
/* Warnings about valid results, by number from 0 on: 1, and in message a sentence or "" where it does not apply;
   0 when the model has no more. */
int model_warning(ModelInstance *model, int number, char *message);

/* Adds seed times the derivatives of the scalars `unknown` to the scalar `known` to sum[0] ... sum[number - 1]. */
int model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t number,
                     double *sum, char *message);

/* The complete state without the entries: plain bytes without addresses, the same in every process. */
size_t model_state_bytes(const ModelInstance *model);
void model_save(const ModelInstance *model, void *to);
int model_restore(ModelInstance *model, const void *from, size_t bytes, char *message);

#endif
