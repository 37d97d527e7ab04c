/* Data of a component, for the files that keep it: component.c, values.c and saved_state.c. */
#ifndef COMPONENT_DATA_H
#define COMPONENT_DATA_H

#include "component.h"

/* origins of an entry: its start value; the host has set it; the host has set it as the derivative of another input.
   Numbers, as a saved state has them among the others. */
#define FROM_START 0.0
#define GIVEN 1.0
#define DERIVED 2.0
/* entries that changed since the model was set up */
enum { NOTHING = 0, INPUTS = 1, PARAMETERS = 2 };

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
    double start;
    double stop;      /* infinite if not announced */
    double time;      /* host's time, s; the model differs by less than TIME_RESOLUTION */
    double last_step; /* s, length of the last step; 0 before the first */
    bool coarse;      /* the log has said that times are coarse */
    int mode;
    int changed;                 /* entries since the model was set up: NOTHING, INPUTS, PARAMETERS or their sum */
    bool retune;                 /* tunable parameters have changed since the model used them */
    bool started;                /* initialised, and not reset since */
    bool valid;                  /* the last initialisation or step succeeded */
    bool at_event;               /* the last step ended at an event */
    unsigned warned;             /* bit k: warning k was logged since initialisation began */
    char status[MESSAGE_BYTES];  /* reason of the failure; "" while valid */
    char message[MESSAGE_BYTES]; /* last error */
    Scalars scalars;             /* arrays in `numbers` */
    double numbers[];
};

/* Return the bytes of all arrays of Scalars. */
size_t scalars_bytes(void);
/* Provide the model.  During initialisation it is set up anew after each change of an entry. */
bool component_provide_model(Component *c);

#endif
