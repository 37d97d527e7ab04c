/* The calls of FMI 3.0 for fuzz.h. */
#include "fuzz.h"

#include "fmi3Functions.h"

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message) {
    (void)environment, (void)category;
    heard(status, message);
}

static Instance api_new(void) {
    char token[TOKEN_BYTES];
    model_token(token);
    return fmi3InstantiateCoSimulation("rope", token, "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL,
                                       log_message, NULL);
}

static void api_free(Instance c) {
    fmi3FreeInstance(c);
}

static int api_enter(Instance c, double start, int stop_defined, double stop) {
    return fmi3EnterInitializationMode(c, fmi3False, 0.0, start, stop_defined, stop);
}

static int api_exit(Instance c) {
    return fmi3ExitInitializationMode(c);
}

static int api_step(Instance c, double t, double h) {
    fmi3Boolean event, terminate, early;
    fmi3Float64 last;
    return fmi3DoStep(c, t, h, fmi3True, &event, &terminate, &early, &last);
}

static int api_terminate(Instance c) {
    return fmi3Terminate(c);
}
static int api_reset(Instance c) {
    return fmi3Reset(c);
}

static int api_set(Instance c, int kind, unsigned vr, const double *reals, const int64_t *integers, size_t number) {
    fmi3Int32 small_integers[MOST_VALUES];
    fmi3Boolean truths[MOST_VALUES];
    fmi3String texts[MOST_VALUES];
    size_t k;
    for (k = 0; k < number; k++) {
        small_integers[k] = (fmi3Int32)integers[k];
        truths[k] = integers[k] != 0;
        texts[k] = "text";
    }
    switch (kind) {
    case KIND_REAL:
        return fmi3SetFloat64(c, &vr, 1, reals, number);
    case KIND_INTEGER:
        return fmi3SetInt32(c, &vr, 1, small_integers, number);
    case KIND_BOOLEAN:
        return fmi3SetBoolean(c, &vr, 1, truths, number);
    case KIND_STRING:
        return fmi3SetString(c, &vr, 1, texts, number);
    default:
        return fmi3SetInt64(c, &vr, 1, integers, number);
    }
}

static int api_get(Instance c, int kind, unsigned vr, double *real, const char **text, size_t number) {
    fmi3Int32 small_integers[MOST_VALUES];
    fmi3Int64 integers[MOST_VALUES];
    fmi3Boolean truths[MOST_VALUES];
    switch (kind) {
    case KIND_REAL:
        return fmi3GetFloat64(c, &vr, 1, real, number);
    case KIND_INTEGER:
        return fmi3GetInt32(c, &vr, 1, small_integers, number);
    case KIND_BOOLEAN:
        return fmi3GetBoolean(c, &vr, 1, truths, number);
    case KIND_STRING:
        return number == 1 ? fmi3GetString(c, &vr, 1, text, 1) : OK;
    default:
        return fmi3GetInt64(c, &vr, 1, integers, number);
    }
}

static int api_save(Instance c, Saved *state) {
    return fmi3GetFMUState(c, state);
}
static int api_restore(Instance c, Saved state) {
    return fmi3SetFMUState(c, state);
}
static int api_forget(Instance c, Saved *state) {
    return fmi3FreeFMUState(c, state);
}
static int api_size(Instance c, Saved state, size_t *size) {
    return fmi3SerializedFMUStateSize(c, state, size);
}

static int api_write(Instance c, Saved state, unsigned char *bytes, size_t size) {
    return fmi3SerializeFMUState(c, state, bytes, size);
}

static int api_read(Instance c, const unsigned char *bytes, size_t size, Saved *state) {
    return fmi3DeserializeFMUState(c, bytes, size, state);
}

static int api_derivative(Instance c, unsigned unknown, unsigned known, double seed, double *value) {
    return fmi3GetDirectionalDerivative(c, &unknown, 1, &known, 1, &seed, 1, value, 1);
}

static int api_other(Bytes *b, Instance c) {
    fmi3Float64 real = 0.0;
    fmi3String text = byte(b) % 2 ? "logAll" : "none";
    unsigned vr = some_reference(b);
    size_t number_of = byte(b);
    switch (byte(b) % 16) {
    case 0:
        return fmi3SetDebugLogging(c, byte(b) % 2, 1, &text);
    case 1:
        return fmi3GetFloat64(c, NULL, 1, &real, 1);
    case 2:
        return fmi3SetFloat64(c, &vr, 1, NULL, number_of);
    case 3:
        return fmi3GetFMUState(c, NULL);
    case 4:
        return fmi3SetFMUState(c, NULL);
    case 5:
        return fmi3DeserializeFMUState(c, NULL, (size_t)word(b), NULL);
    case 6:
        return fmi3DoStep(c, 0.0, 0.01, fmi3True, NULL, NULL, NULL, NULL);
    case 7:
        return fmi3GetFloat64(c, &vr, 0, &real, number_of);
    case 8:
        return fmi3GetUInt64(c, &vr, 1, NULL, number_of);
    case 9:
        return fmi3SetClock(c, &vr, 1, NULL);
    case 10:
        return fmi3EnterEventMode(c);
    case 11:
        return fmi3EnterStepMode(c);
    case 12:
        return fmi3SetTime(c, number(b));
    case 13:
        return fmi3GetDirectionalDerivative(c, &vr, 1, &vr, 1, &real, number_of, &real, 1);
    case 14:
        return fmi3GetAdjointDerivative(c, &vr, 1, &vr, 1, &real, 1, &real, 1);
    default:
        return fmi3GetOutputDerivatives(c, &vr, 1, NULL, &real, 1);
    }
}
