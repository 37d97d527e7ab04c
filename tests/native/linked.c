/* A host that has a drive and two ropes linked in: it steps them and prints left.y, and left.fy of both ropes. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#define FUNCTIONS_OF(identifier)                                                                                       \
    extern fmi2InstantiateTYPE identifier##_fmi2Instantiate;                                                           \
    extern fmi2SetupExperimentTYPE identifier##_fmi2SetupExperiment;                                                   \
    extern fmi2EnterInitializationModeTYPE identifier##_fmi2EnterInitializationMode;                                   \
    extern fmi2ExitInitializationModeTYPE identifier##_fmi2ExitInitializationMode;                                     \
    extern fmi2DoStepTYPE identifier##_fmi2DoStep;                                                                     \
    extern fmi2GetRealTYPE identifier##_fmi2GetReal;                                                                   \
    extern fmi2FreeInstanceTYPE identifier##_fmi2FreeInstance;

FUNCTIONS_OF(HoistDrive)
FUNCTIONS_OF(RopeA)
FUNCTIONS_OF(RopeB)

static void told(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String message, ...) {
    (void)environment;
    fprintf(stderr, "%s %s %d: %s\n", instance, category, (int)status, message);
}

#define BEGIN(identifier, token)                                                                                       \
    fmi2Component identifier =                                                                                         \
        identifier##_fmi2Instantiate(#identifier, fmi2CoSimulation, token, "", &callbacks, 0, 0);                      \
    if (!identifier || identifier##_fmi2SetupExperiment(identifier, 0, 0.0, 0.0, 0, 0.0) ||                            \
        identifier##_fmi2EnterInitializationMode(identifier) || identifier##_fmi2ExitInitializationMode(identifier))   \
        return 1;

#define END(identifier, reference)                                                                                     \
    if (identifier##_fmi2GetReal(identifier, &reference, 1, &value)) return 3;                                         \
    printf("%.17g\n", value);                                                                                          \
    identifier##_fmi2FreeInstance(identifier);

/* arguments: the tokens of drive, rope A and rope B, and the value references of left.y and left.fy */
int main(int count, char **arguments) {
    const fmi2CallbackFunctions callbacks = {told, calloc, free, NULL, NULL};
    if (count != 6) return 4;
    const fmi2ValueReference y = (fmi2ValueReference)atoi(arguments[4]), fy = (fmi2ValueReference)atoi(arguments[5]);
    fmi2Real value;
    BEGIN(HoistDrive, arguments[1])
    BEGIN(RopeA, arguments[2])
    BEGIN(RopeB, arguments[3])
    for (int k = 0; k < 200; k++)
        if (HoistDrive_fmi2DoStep(HoistDrive, 0.01 * k, 0.01, 1) || RopeA_fmi2DoStep(RopeA, 0.01 * k, 0.01, 1) ||
            RopeB_fmi2DoStep(RopeB, 0.01 * k, 0.01, 1))
            return 2;
    END(HoistDrive, y)
    END(RopeA, fy)
    END(RopeB, fy)
    return 0;
}
