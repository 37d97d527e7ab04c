/* FMI 3.0 for co-simulation of any model: all functions of the standard, over component.h.  Those of clocks and
   intermediate update return an error.  Event mode changes nothing: fmi3DoStep has handled the event on return. */
#include "component.h"
#include "fmi3Functions.h"
#include "snapshot.h"

typedef struct {
    Component *component;
    Allocator allocator;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    bool logging; /* true if notes are logged */
    bool event_mode, early_return;
} Instance;

static void log_message(void *context, Severity severity, const char *message) {
    static const fmi3Status statuses[] = {fmi3OK, fmi3Warning, fmi3Error};
    Instance *i = context;
    if (i->log && (severity != LOG_NOTE || i->logging))
        i->log(i->environment, statuses[severity], log_category(severity), message);
}

#define FMI(name) fmi3##name
#define STATE(verb, rest) fmi3##verb##FMUState##rest
#define DESERIALIZE fmi3DeserializeFMUState
typedef fmi3Instance Handle;
typedef fmi3FMUState State;
typedef fmi3Status Status;
typedef fmi3Float64 Real;
typedef fmi3Int32 Integer;
typedef fmi3Int64 Enumeration;
#include "shell.inc"

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
            NULL, {calloc, free}, logMessage, instanceEnvironment, loggingOn, eventModeUsed, earlyReturnAllowed});
        if (i) return i;
        wrong = NO_MEMORY;
    }
    if (logMessage) logMessage(instanceEnvironment, fmi3Error, "logStatusError", wrong);
    return NULL;
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

/* values */

#define VARIABLES_OF(Type, kind)                                                                                       \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues) {                           \
        return get(instance, "fmi3Get" #Type, kind, valueReferences, nValueReferences, values, nValues);               \
    }                                                                                                                  \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues) {                     \
        return set(instance, "fmi3Set" #Type, kind, valueReferences, nValueReferences, values, nValues);               \
    }

VARIABLES_OF(Float64, KIND_REAL)
VARIABLES_OF(Int32, KIND_INTEGER)
VARIABLES_OF(Int64, KIND_ENUMERATION)
VARIABLES_OF(Boolean, KIND_BOOLEAN)
VARIABLES_OF(String, KIND_STRING)

/* types without variables */

static fmi3Status none_of(Instance *i, const char *function, size_t count) {
    if (!check_call(i, function, ANY_MODE)) return fmi3Error;
    return status(!count || component_error(i->component, "there is no variable of this type"));
}

/* functions below ignore arguments */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#define NONE_OF(name, ...)                                                                                             \
    fmi3Status fmi3##name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,  \
                          __VA_ARGS__) {                                                                               \
        return none_of(instance, "fmi3" #name, nValueReferences);                                                      \
    }
#define NO_VARIABLES_OF(Type)                                                                                          \
    NONE_OF(Get##Type, fmi3##Type values[], size_t nValues)                                                            \
    NONE_OF(Set##Type, const fmi3##Type values[], size_t nValues)

NO_VARIABLES_OF(Float32)
NO_VARIABLES_OF(Int8)
NO_VARIABLES_OF(UInt8)
NO_VARIABLES_OF(Int16)
NO_VARIABLES_OF(UInt16)
NO_VARIABLES_OF(UInt32)
NO_VARIABLES_OF(UInt64)
NONE_OF(GetBinary, size_t valueSizes[], fmi3Binary values[], size_t nValues)
NONE_OF(SetBinary, const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
NONE_OF(GetClock, fmi3Clock values[])
NONE_OF(SetClock, const fmi3Clock values[])

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

#define NOT_PROVIDED "this FMU does not provide that; see its capability flags"
#define NO_EVENTS "this FMU has no structural parameters, no discrete states to evaluate and no clocks"

NOT_SUPPORTED(GetAdjointDerivative, NOT_PROVIDED, fmi3Instance instance, const fmi3ValueReference unknowns[],
              size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
              size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
NOT_SUPPORTED(GetOutputDerivatives, NOT_PROVIDED, fmi3Instance instance, const fmi3ValueReference valueReferences[],
              size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
NOT_SUPPORTED(GetNumberOfVariableDependencies, NOT_PROVIDED, fmi3Instance instance, fmi3ValueReference valueReference,
              size_t *nDependencies)
NOT_SUPPORTED(GetVariableDependencies, NOT_PROVIDED, fmi3Instance instance, fmi3ValueReference dependent,
              size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
              size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies)

/* structural parameters and clocks */

NOT_SUPPORTED(EnterConfigurationMode, NO_EVENTS, fmi3Instance instance)
NOT_SUPPORTED(ExitConfigurationMode, NO_EVENTS, fmi3Instance instance)
NOT_SUPPORTED(EvaluateDiscreteStates, NO_EVENTS, fmi3Instance instance)
#define OF_CLOCKS(name, ...)                                                                                           \
    NOT_SUPPORTED(name, NO_EVENTS, fmi3Instance instance, const fmi3ValueReference valueReferences[],                  \
                  size_t nValueReferences, __VA_ARGS__)

OF_CLOCKS(GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(GetShiftDecimal, fmi3Float64 shifts[])
OF_CLOCKS(GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
OF_CLOCKS(SetIntervalDecimal, const fmi3Float64 intervals[])
OF_CLOCKS(SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
OF_CLOCKS(SetShiftDecimal, const fmi3Float64 shifts[])
OF_CLOCKS(SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_SUPPORTED(ActivateModelPartition, NO_EVENTS, fmi3Instance instance, fmi3ValueReference clockReference,
              fmi3Float64 activationTime)

/* other kinds of simulation; the first argument behind the environment is logMessage */

#define OTHER_KIND(name, ...)                                                                                          \
    fmi3Instance fmi3Instantiate##name(fmi3String instanceName, fmi3String instantiationToken,                         \
                                       fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,            \
                                       fmi3InstanceEnvironment instanceEnvironment, __VA_ARGS__) {                     \
        if (logMessage) logMessage(instanceEnvironment, fmi3Error, "logStatusError", CO_SIMULATION_ONLY);              \
        return NULL;                                                                                                   \
    }

OTHER_KIND(ModelExchange, fmi3LogMessageCallback logMessage)
OTHER_KIND(ScheduledExecution, fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
           fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)

NOT_SUPPORTED(GetContinuousStateDerivatives, CO_SIMULATION_ONLY, fmi3Instance instance, fmi3Float64 derivatives[],
              size_t nContinuousStates)
NOT_SUPPORTED(GetNumberOfEventIndicators, CO_SIMULATION_ONLY, fmi3Instance instance, size_t *nEventIndicators)
NOT_SUPPORTED(GetNumberOfContinuousStates, CO_SIMULATION_ONLY, fmi3Instance instance, size_t *nContinuousStates)
