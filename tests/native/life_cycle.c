/* A host in C for valgrind: two instances of FMI 2.0 through a whole life with failed calls, states, reset.
   Arguments: library, GUID, value references of y, vy and ay of both ends, and of a text.  Prints how often memory was
   asked for, of the host and as tests/native/counted.c counts where it is preloaded, while the ends moved. */
#ifdef _WIN32
#include <windows.h>
#define dlopen(path, how) ((void *)LoadLibraryA(path))
#define dlsym(from, name) ((void *)GetProcAddress(from, name))
#else
#include <dlfcn.h>
#endif
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

enum { ENDS = 6, GIVEN = 3, STEPS = 20, REFERENCES = 2000 };
static const double H = 0.04;
static size_t taken;

static void *allocate(size_t number, size_t size) {
    taken++;
    return calloc(number, size);
}

static void ignore(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

static void *library;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (!found) exit(fprintf(stderr, "%s is missing\n", name));
    return found;
}

#define F(name) ((name##TYPE *)function(#name))

int main(int number, char **arguments) {
    fmi2CallbackFunctions callbacks = {ignore, allocate, free, NULL, NULL};
    fmi2Component c[2];
    fmi2FMUstate state = NULL, read = NULL;
    fmi2ValueReference references[REFERENCES], given[ENDS + 1];
    fmi2Real values[REFERENCES], nan_value = NAN, point = 0.0, t, right;
    fmi2String text;
    fmi2Byte *bytes;
    size_t size, before, i, k, outputs = 0, none = 0, *asked;
    unsigned life;
    if (number != GIVEN + ENDS + 1 || !(library = dlopen(arguments[1], RTLD_NOW))) return 1;
    for (k = 0; k <= ENDS; k++) given[k] = (fmi2ValueReference)atoi(arguments[GIVEN + k]);
    if (!(asked = (size_t *)dlsym(NULL, "asked_of_libc"))) asked = &none;
    if (F(fmi2Instantiate)("bad", fmi2CoSimulation, "none", "", &callbacks, 0, 0)) return 2;
    for (i = 0; i < 2; i++)
        if (!(c[i] = F(fmi2Instantiate)("rope", fmi2CoSimulation, arguments[2], "", &callbacks, 0, 1))) return 3;
    for (life = 0; life < 2; life++) {
        for (i = 0; i < 2; i++) {
            if (F(fmi2DoStep)(c[i], 0.0, 0.01, 1) != fmi2Error) return 4;
            F(fmi2SetupExperiment)(c[i], 0, 0.0, 0.0, 0, 0.0);
            if (F(fmi2EnterInitializationMode)(c[i]) || F(fmi2ExitInitializationMode)(c[i])) return 5;
        }
        for (k = outputs = 0; k < REFERENCES; k++) {
            references[outputs] = (fmi2ValueReference)k;
            if (F(fmi2GetReal)(c[0], references + outputs, 1, values) == fmi2OK) outputs++;
        }
        if (F(fmi2GetReal)(c[0], given + ENDS / 2, 1, &right)) return 6;
        before = taken + *asked;
        for (k = 0; k < STEPS; k++)
            for (i = 0; i < 2; i++) {
                t = H * (double)(k + 1);
                const fmi2Real up[ENDS] = {5 * t * t, 10 * t, 10, right - 5 * t * t, -10 * t, -10};
                if (F(fmi2SetReal)(c[i], given, ENDS, up)) return 6;
                if (F(fmi2DoStep)(c[i], H * (double)k, H, 1)) return 6;
                if (F(fmi2GetReal)(c[i], references, outputs, values)) return 7;
                if (F(fmi2GetString)(c[i], given + ENDS, 1, &text)) return 7;
            }
        printf("%lu\n", (unsigned long)(taken + *asked - before));
        if (F(fmi2GetFMUstate)(c[0], &state) || F(fmi2SerializedFMUstateSize)(c[0], state, &size)) return 8;
        bytes = malloc(size);
        if (F(fmi2SerializeFMUstate)(c[0], state, bytes, size)) return 9;
        if (F(fmi2DeSerializeFMUstate)(c[1], bytes, size, &read) || F(fmi2SetFMUstate)(c[1], read)) return 10;
        bytes[size / 2] ^= 1;
        if (F(fmi2DeSerializeFMUstate)(c[1], bytes, size, &read) != fmi2Error) return 11;
        free(bytes);
        if (F(fmi2SetReal)(c[0], given, 1, &nan_value) != fmi2Error) return 12;
        if (F(fmi2DoStep)(c[0], STEPS * H, H, 1) != fmi2Error || F(fmi2SetFMUstate)(c[0], state)) return 13;
        if (F(fmi2GetRealStatus)(c[0], fmi2LastSuccessfulTime, &point) || fabs(point - STEPS * H) > 1e-9) return 14;
        F(fmi2GetString)(c[0], given + ENDS, 1, &text);
        F(fmi2FreeFMUstate)(c[0], &state);
        F(fmi2FreeFMUstate)(c[1], &read);
        if (life) continue;
        for (i = 0; i < 2; i++) F(fmi2Reset)(c[i]);
        references[0] = 6; /* rope.EI, one that makes initialisation fail */
        values[0] = -1.0;
        F(fmi2SetReal)(c[0], references, 1, values);
        F(fmi2EnterInitializationMode)(c[0]);
        if (F(fmi2ExitInitializationMode)(c[0]) != fmi2Error) return 15;
        F(fmi2Reset)(c[0]);
    }
    if (F(fmi2Terminate)(c[1])) return 16;
    for (i = 0; i < 2; i++) F(fmi2FreeInstance)(c[i]);
    return 0;
}
