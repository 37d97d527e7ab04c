/* Calls of a rope's functions, in a library of FMI 2.0 or 3.0 or in this process, by pointers of their own types. */
#ifndef ROPE_CALLS_H
#define ROPE_CALLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "numbers.h"
#include "rope.h"

typedef const char *Text;

/* Functions of the rope, by their types in rope.h and in the headers of FMI 2.0 and 3.0.  A call through another type
   is undefined, also where it differs only by an int for an enumeration.  The declarations behind the types of the
   rope's functions compile only if these are those of rope.h. */
typedef void RopeSignals(Simulator *, size_t, const int *, double *);
typedef const char *RopeFidelity(const Simulator *);
typedef RopeStatus RopeAdvanceTo(Simulator *, double, const EndMotion *, double);
typedef void RopeWarning(Simulator *, int, char *);
RopeSignals rope_signals;
RopeFidelity rope_fidelity;
RopeAdvanceTo rope_advance_to;
RopeWarning rope_warning;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef fmi2Status DoStep2(void *, double, double, int);
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef fmi3Status DoStep3(void *, double, double, bool, bool *, bool *, bool *, double *);

/* Getters and setters of FMI for numbers, each with the type of its values in C */
#define ACCESSES_2(X)                                                                                                  \
    X(fmi2GetReal, double)                                                                                             \
    X(fmi2GetInteger, int)                                                                                             \
    X(fmi2GetBoolean, int)                                                                                             \
    X(fmi2SetReal, const double)
#define ACCESSES_3(X)                                                                                                  \
    X(fmi3GetFloat32, float)                                                                                           \
    X(fmi3GetFloat64, double)                                                                                          \
    X(fmi3GetInt8, int8_t)                                                                                             \
    X(fmi3GetUInt8, uint8_t)                                                                                           \
    X(fmi3GetInt16, int16_t)                                                                                           \
    X(fmi3GetUInt16, uint16_t)                                                                                         \
    X(fmi3GetInt32, int32_t)                                                                                           \
    X(fmi3GetUInt32, uint32_t)                                                                                         \
    X(fmi3GetInt64, int64_t)                                                                                           \
    X(fmi3GetUInt64, uint64_t)                                                                                         \
    X(fmi3GetBoolean, bool)                                                                                            \
    X(fmi3SetFloat32, const float)                                                                                     \
    X(fmi3SetFloat64, const double)
#define POINTER_2(NAME, VALUE) fmi2Status (*NAME)(void *, const unsigned int *, size_t, VALUE *);
#define POINTER_3(NAME, VALUE) fmi3Status (*NAME)(void *, const uint32_t *, size_t, VALUE *, size_t);

/* Pointer to one of the rope's functions */
typedef union {
    void *address; /* NULL where the rope lacks the function */
    RopeSignals *rope_signals;
    RopeFidelity *rope_fidelity;
    RopeAdvanceTo *rope_advance_to;
    DoStep2 *fmi2DoStep;
    DoStep3 *fmi3DoStep;
    ACCESSES_2(POINTER_2)
    ACCESSES_3(POINTER_3)
    POINTER_2(fmi2GetString, Text)
    POINTER_3(fmi3GetString, Text)
} Function;

#include "access.h" /* Access: generated from participants/library_calls.py */

#define CALL_2(NAME, VALUE)                                                                                            \
    case AS_##NAME:                                                                                                    \
        return a->function.NAME(a->rope, a->numbers, a->count, values);
#define CALL_3(NAME, VALUE)                                                                                            \
    case AS_##NAME:                                                                                                    \
        return a->function.NAME(a->rope, a->numbers, a->count, values, a->length);

/* Call a getter or setter with these values, or with *text for a text; return its status in FMI. */
static int access_status(const Access *a, void *values, Text *text) {
    switch (a->called_as) {
        ACCESSES_2(CALL_2)
        ACCESSES_3(CALL_3)
    case AS_fmi2GetString:
        return a->function.fmi2GetString(a->rope, a->numbers, a->count, text);
    case AS_fmi3GetString:
        return a->function.fmi3GetString(a->rope, a->numbers, a->count, text, a->length);
    case AS_rope_fidelity:
        *text = a->function.rope_fidelity(a->rope);
        return fmi3OK;
    case AS_rope_signals:
        a->function.rope_signals(a->rope, a->count, a->numbers, values);
        return fmi3OK;
    }
    return fmi3Fatal; /* no getter or setter */
}

/* Return whether the value of an access, of any type, is not 0. */
static bool holds(const Access *a) {
    for (size_t i = 0; i < a->bytes; i++)
        if (a->values[i]) return true;
    return false;
}

/* Call DoStep of either version of FMI; a step that ends early counts as discarded. */
static int do_step_status(const Access *step, double t, double h) {
    bool event, ended = false, early;
    double last;
    int status;
    if (step->called_as == AS_fmi2DoStep) return step->function.fmi2DoStep(step->rope, t, h, 0);
    status = step->function.fmi3DoStep(step->rope, t, h, false, &event, &ended, &early, &last);
    return ended && status <= WARNING ? DISCARD : status;
}

#endif
