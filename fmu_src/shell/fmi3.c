/* FMI 3.0 for co-simulation of any model: all functions of the standard, over component.h.  Those of clocks and
   intermediate update return an error.  Event mode changes nothing: fmi3DoStep has handled the event on return. */
#include "component.h"
#include "fmi3Functions.h"
#include "snapshot.h"
#include "values.h"

typedef struct {
    Component *component;
    Allocator allocator;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    bool logging;      /* true if notes are logged */
    bool event_mode;   /* true if the host handles events */
    bool early_return; /* true if a step may end early */
} Instance;

static void log_message(void *context, Severity severity, const char *message) {
    static const fmi3Status statuses[] = {fmi3OK, fmi3Warning, fmi3Error};
    Instance *i = context;
    if (i->log && (severity != LOG_NOTE || i->logging))
        i->log(i->environment, statuses[severity], log_category(severity), message);
}

typedef fmi3Float64 Real;
typedef fmi3Int32 Integer;
typedef fmi3Int64 Enumeration;
typedef fmi3Boolean Boolean;
typedef fmi3String String;
#include "shell.inc"

static fmi3Status status(bool ok) {
    return ok ? fmi3OK : fmi3Error;
}

/* inquiry, creation and destruction */

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    const char *wrong = NULL;
    char reason[MESSAGE_BYTES];
    (void)visible, (void)requiredIntermediateVariables, (void)intermediateUpdate;
    if (!instanceName || !*instanceName)
        wrong = NO_NAME;
    else if (!component_has_token(instantiationToken))
        wrong = "the instantiation token is not that of this FMU; read it from the modelDescription.xml beside it";
    else if (nRequiredIntermediateVariables)
        wrong = "this FMU has no intermediate values (providesIntermediateUpdate is false); require none";
    else if (eventModeUsed && !model_has_events())
        wrong = "this FMU has no event mode (hasEventMode is false); instantiate it with eventModeUsed = false";
    else if (!model_open(resourcePath, reason))
        wrong = reason;
    if (!wrong) {
        Instance *i = create_instance((Instance){
            .allocator = {.allocate = calloc, .deallocate = free},
            .log = logMessage,
            .environment = instanceEnvironment,
            .logging = loggingOn,
            .event_mode = eventModeUsed,
            .early_return = earlyReturnAllowed,
        });
        if (i) return i;
        wrong = NO_MEMORY;
    }
    if (logMessage) logMessage(instanceEnvironment, fmi3Error, "logStatusError", wrong);
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
    free_instance(instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
    return status(set_logging(instance, loggingOn, nCategories, categories));
}

/* life cycle */

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    Instance *i = instance;
    if (!check_call(i, "fmi3EnterInitializationMode", INSTANTIATED) ||
        !component_setup(i->component, startTime, stopTimeDefined, stopTime))
        return fmi3Error;
    component_enter_initialization(i->component);
    if (toleranceDefined) component_tolerance(i->component, tolerance);
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return status(exit_initialization(instance, "fmi3ExitInitializationMode"));
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    Instance *i = instance;
    (void)noSetFMUStatePriorToCurrentPoint; /* the host owns the states */
    if (!check_call(i, "fmi3DoStep", STEPPING) || !component_nonnull(i->component, eventHandlingNeeded) ||
        !component_nonnull(i->component, terminateSimulation) || !component_nonnull(i->component, earlyReturn) ||
        !component_nonnull(i->component, lastSuccessfulTime))
        return fmi3Error;
    const bool to_event = i->event_mode && i->early_return;
    const bool ok = component_step(i->component, currentCommunicationPoint, communicationStepSize, to_event);
    *lastSuccessfulTime = component_time(i->component);
    *terminateSimulation = fmi3False;
    *eventHandlingNeeded = component_at_event(i->component);
    *earlyReturn = *eventHandlingNeeded && *lastSuccessfulTime < currentCommunicationPoint + communicationStepSize;
    return status(ok);
}

static fmi3Status in_event_mode(Instance *i, const char *function) {
    if (!check_call(i, function, STEPPING)) return fmi3Error;
    return status(i->event_mode || component_error(i->component, "instantiate the FMU with eventModeUsed = true"));
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    return in_event_mode(instance, "fmi3EnterEventMode");
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return in_event_mode(instance, "fmi3EnterStepMode");
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
    fmi3Boolean *const answers[] = {discreteStatesNeedUpdate, terminateSimulation, nominalsOfContinuousStatesChanged,
                                    valuesOfContinuousStatesChanged, nextEventTimeDefined};
    Instance *i = instance;
    if (in_event_mode(i, "fmi3UpdateDiscreteStates") != fmi3OK || !component_nonnull(i->component, nextEventTime))
        return fmi3Error;
    for (int k = 0; k < 5; k++) {
        if (!component_nonnull(i->component, answers[k])) return fmi3Error;
        *answers[k] = fmi3False;
    }
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    return status(terminate(instance, "fmi3Terminate"));
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    return status(reset(instance));
}

/* values */

#define GETTER(name, Type, kind)                                                                                       \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,        \
                    Type values[], size_t nValues) {                                                                   \
        return status(get(instance, #name, kind, valueReferences, nValueReferences, values, nValues));                 \
    }
#define SETTER(name, Type, kind)                                                                                       \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,        \
                    const Type values[], size_t nValues) {                                                             \
        return status(set(instance, #name, kind, valueReferences, nValueReferences, values, nValues));                 \
    }

GETTER(fmi3GetFloat64, fmi3Float64, KIND_REAL)
SETTER(fmi3SetFloat64, fmi3Float64, KIND_REAL)
GETTER(fmi3GetInt32, fmi3Int32, KIND_INTEGER)
SETTER(fmi3SetInt32, fmi3Int32, KIND_INTEGER)
GETTER(fmi3GetInt64, fmi3Int64, KIND_ENUMERATION)
SETTER(fmi3SetInt64, fmi3Int64, KIND_ENUMERATION)
GETTER(fmi3GetBoolean, fmi3Boolean, KIND_BOOLEAN)
SETTER(fmi3SetBoolean, fmi3Boolean, KIND_BOOLEAN)
GETTER(fmi3GetString, fmi3String, KIND_STRING)
SETTER(fmi3SetString, fmi3String, KIND_STRING)

/* states */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return status(get_state(instance, "fmi3GetFMUState", FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
    return status(set_state(instance, "fmi3SetFMUState", FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return status(free_state(instance, "fmi3FreeFMUState", FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size) {
    return status(serialized_size(instance, "fmi3SerializedFMUStateSize", FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
    return status(serialize(instance, "fmi3SerializeFMUState", FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return status(deserialize(instance, "fmi3DeserializeFMUState", serializedState, size, FMUState));
}

/* types without variables */

static fmi3Status none_of(Instance *i, const char *function, size_t count) {
    if (!check_call(i, function, ANY_MODE)) return fmi3Error;
    return status(!count || component_error(i->component, "there is no variable of this type"));
}

/* functions below ignore arguments */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#define NONE_OF(name, ...)                                                                                             \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,        \
                    __VA_ARGS__) {                                                                                     \
        return none_of(instance, #name, nValueReferences);                                                             \
    }

NONE_OF(fmi3GetFloat32, fmi3Float32 values[], size_t nValues)
NONE_OF(fmi3SetFloat32, const fmi3Float32 values[], size_t nValues)
NONE_OF(fmi3GetInt8, fmi3Int8 values[], size_t nValues)
NONE_OF(fmi3SetInt8, const fmi3Int8 values[], size_t nValues)
NONE_OF(fmi3GetUInt8, fmi3UInt8 values[], size_t nValues)
NONE_OF(fmi3SetUInt8, const fmi3UInt8 values[], size_t nValues)
NONE_OF(fmi3GetInt16, fmi3Int16 values[], size_t nValues)
NONE_OF(fmi3SetInt16, const fmi3Int16 values[], size_t nValues)
NONE_OF(fmi3GetUInt16, fmi3UInt16 values[], size_t nValues)
NONE_OF(fmi3SetUInt16, const fmi3UInt16 values[], size_t nValues)
NONE_OF(fmi3GetUInt32, fmi3UInt32 values[], size_t nValues)
NONE_OF(fmi3SetUInt32, const fmi3UInt32 values[], size_t nValues)
NONE_OF(fmi3GetUInt64, fmi3UInt64 values[], size_t nValues)
NONE_OF(fmi3SetUInt64, const fmi3UInt64 values[], size_t nValues)
NONE_OF(fmi3GetBinary, size_t valueSizes[], fmi3Binary values[], size_t nValues)
NONE_OF(fmi3SetBinary, const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
NONE_OF(fmi3GetClock, fmi3Clock values[])
NONE_OF(fmi3SetClock, const fmi3Clock values[])

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    Instance *i = instance;
    if (!check_access(i, "fmi3GetDirectionalDerivative", COMPUTED, unknowns, nUnknowns, sensitivity)) return fmi3Error;
    if (nKnowns && !(component_nonnull(i->component, knowns) && component_nonnull(i->component, seed)))
        return fmi3Error;
    if (nSeed != nKnowns || nSensitivity != nUnknowns)
        return status(component_error(i->component,
                                      "derivatives are of scalars: give one seed per known, one place per unknown"));
    return status(component_derivative(i->component, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity));
}

/* functions ruled out by capability flags */

#define NOT_SUPPORTED(name, reason, ...)                                                                               \
    fmi3Status name(__VA_ARGS__) {                                                                                     \
        return status(refuse(instance, reason));                                                                       \
    }
#define NOT_PROVIDED "this FMU does not provide that; see its capability flags"
#define NO_EVENTS "this FMU has no structural parameters, no discrete states to evaluate and no clocks"

NOT_SUPPORTED(fmi3GetAdjointDerivative, NOT_PROVIDED, fmi3Instance instance, const fmi3ValueReference unknowns[],
              size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
              size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
NOT_SUPPORTED(fmi3GetOutputDerivatives, NOT_PROVIDED, fmi3Instance instance, const fmi3ValueReference valueReferences[],
              size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
NOT_SUPPORTED(fmi3GetNumberOfVariableDependencies, NOT_PROVIDED, fmi3Instance instance,
              fmi3ValueReference valueReference, size_t *nDependencies)
NOT_SUPPORTED(fmi3GetVariableDependencies, NOT_PROVIDED, fmi3Instance instance, fmi3ValueReference dependent,
              size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
              size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies)

/* structural parameters and clocks */

NOT_SUPPORTED(fmi3EnterConfigurationMode, NO_EVENTS, fmi3Instance instance)
NOT_SUPPORTED(fmi3ExitConfigurationMode, NO_EVENTS, fmi3Instance instance)
NOT_SUPPORTED(fmi3EvaluateDiscreteStates, NO_EVENTS, fmi3Instance instance)
#define OF_CLOCKS(name, ...)                                                                                           \
    NOT_SUPPORTED(name, NO_EVENTS, fmi3Instance instance, const fmi3ValueReference valueReferences[],                  \
                  size_t nValueReferences, __VA_ARGS__)

OF_CLOCKS(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(fmi3GetShiftDecimal, fmi3Float64 shifts[])
OF_CLOCKS(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
OF_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
OF_CLOCKS(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
OF_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
OF_CLOCKS(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_SUPPORTED(fmi3ActivateModelPartition, NO_EVENTS, fmi3Instance instance, fmi3ValueReference clockReference,
              fmi3Float64 activationTime)

/* other kinds of simulation; the first argument behind the environment is logMessage */

#define OTHER_KIND(name, ...)                                                                                          \
    fmi3Instance name(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,                 \
                      fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,         \
                      __VA_ARGS__) {                                                                                   \
        if (logMessage) logMessage(instanceEnvironment, fmi3Error, "logStatusError", CO_SIMULATION_ONLY);              \
        return NULL;                                                                                                   \
    }

OTHER_KIND(fmi3InstantiateModelExchange, fmi3LogMessageCallback logMessage)
OTHER_KIND(fmi3InstantiateScheduledExecution, fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
           fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)

NOT_SUPPORTED(fmi3GetContinuousStateDerivatives, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 derivatives[],
              size_t nContinuousStates)
NOT_SUPPORTED(fmi3GetNumberOfEventIndicators, CO_SIMULATION_ONLY, fmi3Instance instance, size_t *nEventIndicators)
NOT_SUPPORTED(fmi3GetNumberOfContinuousStates, CO_SIMULATION_ONLY, fmi3Instance instance, size_t *nContinuousStates)
NOT_SUPPORTED(fmi3EnterContinuousTimeMode, CO_SIMULATION_ONLY, fmi3Instance instance)
NOT_SUPPORTED(fmi3CompletedIntegratorStep, CO_SIMULATION_ONLY, fmi3Instance instance,
              fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *enterEventMode,
              fmi3Boolean *terminateSimulation)
NOT_SUPPORTED(fmi3SetTime, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 time)
NOT_SUPPORTED(fmi3SetContinuousStates, CO_SIMULATION_ONLY, fmi3Instance instance, const fmi3Float64 continuousStates[],
              size_t nContinuousStates)
NOT_SUPPORTED(fmi3GetEventIndicators, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 eventIndicators[],
              size_t nEventIndicators)
NOT_SUPPORTED(fmi3GetContinuousStates, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 continuousStates[],
              size_t nContinuousStates)
NOT_SUPPORTED(fmi3GetNominalsOfContinuousStates, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 nominals[],
              size_t nContinuousStates)
