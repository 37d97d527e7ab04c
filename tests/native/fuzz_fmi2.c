/* The calls of FMI 2.0 for fuzz.h. */
#include "fuzz.h"

#include "fmi2Functions.h"

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
    (void)environment, (void)name, (void)category;
    heard(status, message);
}

static Instance api_new(void) {
    static const fmi2CallbackFunctions callbacks = {log_message, fuzz_take, fuzz_give_back, NULL, NULL};
    char token[TOKEN_BYTES];
    model_token(token);
    return fmi2Instantiate("rope", fmi2CoSimulation, token, "", &callbacks, fmi2False, fmi2False);
}

static void api_free(Instance c) {
    fmi2FreeInstance(c);
}

static int api_enter(Instance c, double start, int stop_defined, double stop) {
    int status = fmi2SetupExperiment(c, fmi2False, 0.0, start, stop_defined, stop);
    return status == OK ? (int)fmi2EnterInitializationMode(c) : status;
}

static int api_exit(Instance c) {
    return fmi2ExitInitializationMode(c);
}
static int api_step(Instance c, double t, double h) {
    return fmi2DoStep(c, t, h, fmi2True);
}
static int api_terminate(Instance c) {
    return fmi2Terminate(c);
}
static int api_reset(Instance c) {
    return fmi2Reset(c);
}

static int api_set(Instance c, int kind, unsigned vr, const double *reals, const int64_t *integers, size_t number) {
    int integer = (int)integers[0];
    fmi2String text = "text";
    (void)number;
    switch (kind) {
    case KIND_REAL:
        return fmi2SetReal(c, &vr, 1, reals);
    case KIND_BOOLEAN:
        return fmi2SetBoolean(c, &vr, 1, &integer);
    case KIND_STRING:
        return fmi2SetString(c, &vr, 1, &text);
    default:
        return fmi2SetInteger(c, &vr, 1, &integer);
    }
}

static int api_get(Instance c, int kind, unsigned vr, double *real, const char **text, size_t number) {
    int integer;
    (void)number;
    switch (kind) {
    case KIND_REAL:
        return fmi2GetReal(c, &vr, 1, real);
    case KIND_BOOLEAN:
        return fmi2GetBoolean(c, &vr, 1, &integer);
    case KIND_STRING:
        return fmi2GetString(c, &vr, 1, text);
    default:
        return fmi2GetInteger(c, &vr, 1, &integer);
    }
}

static int api_save(Instance c, Saved *state) {
    return fmi2GetFMUstate(c, state);
}
static int api_restore(Instance c, Saved state) {
    return fmi2SetFMUstate(c, state);
}
static int api_forget(Instance c, Saved *state) {
    return fmi2FreeFMUstate(c, state);
}
static int api_size(Instance c, Saved state, size_t *size) {
    return fmi2SerializedFMUstateSize(c, state, size);
}

static int api_write(Instance c, Saved state, unsigned char *bytes, size_t size) {
    return fmi2SerializeFMUstate(c, state, (fmi2Byte *)bytes, size);
}

static int api_read(Instance c, const unsigned char *bytes, size_t size, Saved *state) {
    return fmi2DeSerializeFMUstate(c, (const fmi2Byte *)bytes, size, state);
}

static int api_derivative(Instance c, unsigned unknown, unsigned known, double seed, double *value) {
    return fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &seed, value);
}

static int api_other(Bytes *b, Instance c) {
    fmi2Status status;
    fmi2Real real;
    fmi2Integer integer;
    fmi2String text = byte(b) % 2 ? "logAll" : "none";
    unsigned vr = some_reference(b);
    switch (byte(b) % 18) {
    case 0:
        return fmi2GetStatus(c, (fmi2StatusKind)(byte(b) % 4), &status);
    case 1:
        return fmi2GetRealStatus(c, (fmi2StatusKind)(byte(b) % 4), &real);
    case 2:
        return fmi2GetIntegerStatus(c, fmi2PendingStatus, &integer);
    case 3:
        return fmi2GetBooleanStatus(c, fmi2Terminated, &integer);
    case 4:
        return fmi2GetStringStatus(c, fmi2PendingStatus, &text);
    case 5:
        return fmi2SetDebugLogging(c, (fmi2Boolean)(byte(b) % 2), 1, &text);
    case 6:
        return fmi2CancelStep(c);
    case 7:
        return fmi2SetRealInputDerivatives(c, &vr, 1, &integer, &real);
    case 8:
        return fmi2GetRealOutputDerivatives(c, &vr, 1, &integer, &real);
    case 9:
        return fmi2GetReal(c, NULL, 1, &real);
    case 10:
        return fmi2SetReal(c, &vr, 1, NULL);
    case 11:
        return fmi2GetFMUstate(c, NULL);
    case 12:
        return fmi2SetFMUstate(c, NULL);
    case 13:
        return fmi2DeSerializeFMUstate(c, NULL, (size_t)word(b), NULL);
    case 14:
        return fmi2SetTime(c, 0.0);
    case 15:
        return fmi2SetupExperiment(c, fmi2True, number(b), number(b), fmi2True, number(b));
    case 16:
        return fmi2EnterInitializationMode(c);
    default:
        return fmi2GetDirectionalDerivative(c, &vr, 1, NULL, 1, NULL, &real);
    }
}
