/* FMI 2.0 for co-simulation of any model: all functions of the standard, over component.h. */
#include <string.h>

#include "component.h"
#include "fmi2Functions.h"
#include "snapshot.h"
#include "text.h"
#include "values.h"

enum { NAME = 128 };

typedef struct {
    Component *component;
    Allocator allocator;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    bool logging;     /* true if notes are logged */
    double tolerance; /* of the experiment; 0 if the host gives none */
    char name[NAME];
} Instance;

static void say(fmi2CallbackLogger logger, fmi2ComponentEnvironment environment, const char *name, Severity severity,
                const char *message) {
    static const fmi2Status statuses[] = {fmi2OK, fmi2Warning, fmi2Error};
    /* The logger takes a format, which some hosts print as it is. */
    char format[2 * MESSAGE_BYTES];
    char *end = format;
    if (!logger) return;
    for (; *message && end < format + sizeof format - 2; message++) {
        *end++ = *message;
        if (*message == '%') *end++ = '%';
    }
    *end = '\0';
    logger(environment, name, statuses[severity], log_category(severity), format);
}

static void log_message(void *context, Severity severity, const char *message) {
    Instance *i = context;
    if (severity != LOG_NOTE || i->logging) say(i->logger, i->environment, i->name, severity, message);
}

typedef fmi2Real Real;
typedef fmi2Integer Integer;
typedef fmi2Integer Enumeration;
typedef fmi2Boolean Boolean;
typedef fmi2String String;
#include "shell.inc"

static fmi2Status status(bool ok) {
    return ok ? fmi2OK : fmi2Error;
}

/* inquiry, creation and destruction */

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    const char *wrong = NULL;
    char reason[MESSAGE_BYTES];
    (void)visible;
    if (!functions) return NULL;
    if (!instanceName || !*instanceName)
        wrong = NO_NAME;
    else if (fmuType != fmi2CoSimulation)
        wrong = "this FMU is for co-simulation only; instantiate it with fmi2CoSimulation";
    else if (!component_has_token(fmuGUID))
        wrong = "the GUID is not that of this FMU; read it from the modelDescription.xml beside this binary";
    else if (!functions->allocateMemory || !functions->freeMemory)
        wrong = "the callbacks allocateMemory and freeMemory are missing; this FMU needs them";
    else if (!model_open(fmuResourceLocation, reason))
        wrong = reason;
    if (!wrong) {
        Instance fields = {.allocator = {functions->allocateMemory, functions->freeMemory},
                           .logger = functions->logger,
                           .environment = functions->componentEnvironment,
                           .logging = loggingOn != fmi2False};
        copy_text(fields.name, NAME, instanceName);
        Instance *i = create_instance(fields);
        if (i) return i;
        wrong = NO_MEMORY;
    }
    say(functions->logger, functions->componentEnvironment, instanceName ? instanceName : "", LOG_ERROR, wrong);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
    free_instance(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    return status(set_logging(c, loggingOn != fmi2False, nCategories, categories));
}

/* life cycle */

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    Instance *i = c;
    if (!check_call(i, "fmi2SetupExperiment", INSTANTIATED) ||
        !component_setup(i->component, startTime, stopTimeDefined, stopTime))
        return fmi2Error;
    i->tolerance = toleranceDefined ? tolerance : 0.0;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *i = c;
    if (!check_call(i, "fmi2EnterInitializationMode", INSTANTIATED)) return fmi2Error;
    component_enter_initialization(i->component);
    if (i->tolerance != 0.0) component_tolerance(i->component, i->tolerance);
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return status(exit_initialization(c, "fmi2ExitInitializationMode"));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    Instance *i = c;
    (void)noSetFMUStatePriorToCurrentPoint; /* the host owns the states */
    return status(check_call(i, "fmi2DoStep", STEPPING) &&
                  component_step(i->component, currentCommunicationPoint, communicationStepSize, false));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return status(terminate(c, "fmi2Terminate"));
}

fmi2Status fmi2Reset(fmi2Component c) {
    return status(reset(c));
}

/* values */

#define GETTER(name, Type, kind)                                                                                       \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, Type value[]) {                        \
        return status(get(c, #name, kind, vr, nvr, value, nvr));                                                       \
    }
#define SETTER(name, Type, kind)                                                                                       \
    fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const Type value[]) {                  \
        return status(set(c, #name, kind, vr, nvr, value, nvr));                                                       \
    }

GETTER(fmi2GetReal, fmi2Real, KIND_REAL)
SETTER(fmi2SetReal, fmi2Real, KIND_REAL)
GETTER(fmi2GetInteger, fmi2Integer, KIND_INTEGER)
SETTER(fmi2SetInteger, fmi2Integer, KIND_INTEGER)
GETTER(fmi2GetBoolean, fmi2Boolean, KIND_BOOLEAN)
SETTER(fmi2SetBoolean, fmi2Boolean, KIND_BOOLEAN)
GETTER(fmi2GetString, fmi2String, KIND_STRING)
SETTER(fmi2SetString, fmi2String, KIND_STRING)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    Instance *i = c;
    if (!check_access(i, "fmi2GetDirectionalDerivative", COMPUTED, vUnknown_ref, nUnknown, dvUnknown)) return fmi2Error;
    if (nKnown && !(component_nonnull(i->component, vKnown_ref) && component_nonnull(i->component, dvKnown)))
        return fmi2Error;
    return status(component_derivative(i->component, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    Instance *i = c;
    if (!check_access(i, "fmi2SetRealInputDerivatives", SETTABLE, vr, nvr, value) ||
        (nvr && !component_nonnull(i->component, order)))
        return fmi2Error;
    for (size_t k = 0; k < nvr; k++) {
        size_t first;
        size_t length;
        if (!component_find(i->component, vr[k], KIND_REAL, &first, &length) ||
            !component_set_rate(i->component, first, order[k], value[k]))
            return fmi2Error;
    }
    return fmi2OK;
}

/* states */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return status(get_state(c, "fmi2GetFMUstate", FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return status(set_state(c, "fmi2SetFMUstate", FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return status(free_state(c, "fmi2FreeFMUstate", FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    return status(serialized_size(c, "fmi2SerializedFMUstateSize", FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size) {
    return status(serialize(c, "fmi2SerializeFMUstate", FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    return status(deserialize(c, "fmi2DeSerializeFMUstate", serializedState, size, FMUstate));
}

/* functions below ignore arguments */
#pragma GCC diagnostic ignored "-Wunused-parameter"

/* status; only steps in the background have a pending one */

#define STATUS_OF(name, Type, found, answered)                                                                         \
    fmi2Status name(fmi2Component c, const fmi2StatusKind s, Type *value) {                                            \
        Instance *i = c;                                                                                               \
        if (!check_call(i, #name, COMPUTED) || !component_nonnull(i->component, value)) return fmi2Error;              \
        *value = found;                                                                                                \
        return answered ? fmi2OK : fmi2Discard;                                                                        \
    }

STATUS_OF(fmi2GetStatus, fmi2Status, fmi2OK, 0)
STATUS_OF(fmi2GetRealStatus, fmi2Real, component_time(i->component), s == fmi2LastSuccessfulTime)
STATUS_OF(fmi2GetIntegerStatus, fmi2Integer, 0, 0)
STATUS_OF(fmi2GetBooleanStatus, fmi2Boolean, fmi2False, s == fmi2Terminated)
STATUS_OF(fmi2GetStringStatus, fmi2String, "", 0)

/* functions ruled out by capability flags */

#define NOT_SUPPORTED(name, reason, ...)                                                                               \
    fmi2Status name(__VA_ARGS__) {                                                                                     \
        return status(refuse(c, reason));                                                                              \
    }

NOT_SUPPORTED(fmi2CancelStep, "fmi2CancelStep: steps are done when fmi2DoStep returns; there is none to cancel",
              fmi2Component c)
NOT_SUPPORTED(fmi2GetRealOutputDerivatives,
              "fmi2GetRealOutputDerivatives: maxOutputDerivativeOrder is 0; there are none", fmi2Component c,
              const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], fmi2Real value[])

/* functions of model exchange, refused */

NOT_SUPPORTED(fmi2EnterEventMode, CO_SIMULATION_ONLY, fmi2Component c)
NOT_SUPPORTED(fmi2NewDiscreteStates, CO_SIMULATION_ONLY, fmi2Component c, fmi2EventInfo *eventInfo)
NOT_SUPPORTED(fmi2EnterContinuousTimeMode, CO_SIMULATION_ONLY, fmi2Component c)
NOT_SUPPORTED(fmi2CompletedIntegratorStep, CO_SIMULATION_ONLY, fmi2Component c,
              fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean *enterEventMode,
              fmi2Boolean *terminateSimulation)
NOT_SUPPORTED(fmi2SetTime, CO_SIMULATION_ONLY, fmi2Component c, fmi2Real time)
NOT_SUPPORTED(fmi2SetContinuousStates, CO_SIMULATION_ONLY, fmi2Component c, const fmi2Real x[], size_t nx)
NOT_SUPPORTED(fmi2GetDerivatives, CO_SIMULATION_ONLY, fmi2Component c, fmi2Real derivatives[], size_t nx)
NOT_SUPPORTED(fmi2GetEventIndicators, CO_SIMULATION_ONLY, fmi2Component c, fmi2Real eventIndicators[], size_t ni)
NOT_SUPPORTED(fmi2GetContinuousStates, CO_SIMULATION_ONLY, fmi2Component c, fmi2Real x[], size_t nx)
NOT_SUPPORTED(fmi2GetNominalsOfContinuousStates, CO_SIMULATION_ONLY, fmi2Component c, fmi2Real x_nominal[], size_t nx)
