/* A host in C with many threads: each instantiates an FMU of FMI 2.0 as soon as all are there, initialises, steps and
   frees it.  Arguments: library, GUID, folder of the resources, number of threads, steps, references of left.y, vy and
   ay, then entries as kind:reference:value with the kind r, i or b, "--", and references of outputs.
   Exits with 0 where all have the bits of one more life, on its own, when the others are over. */
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

enum { MOST_THREADS = 64, MOST_NUMBERS = 4096, FIRST_ENTRY = 9 };
#define H 0.01

static void *library;
static char **arguments;
static int number_of_arguments;
static pthread_barrier_t together;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (!found) exit(fprintf(stderr, "%s is missing\n", name));
    return found;
}

#define F(name) ((name##TYPE *)function(#name))
#define DO(call)                                                                                                       \
    if ((call) != fmi2OK) {                                                                                            \
        fprintf(stderr, "failed: %s\n", #call);                                                                        \
        return 1;                                                                                                      \
    }

static void tell(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String message, ...) {
    (void)environment, (void)name, (void)category;
    if (status >= fmi2Error) fprintf(stderr, "%s\n", message);
}

static const fmi2CallbackFunctions CALLBACKS = {tell, calloc, free, NULL, NULL};

typedef struct {
    double numbers[MOST_NUMBERS];
    int length, failed;
} Record;

static int enter(fmi2Component c, const char *text) {
    fmi2ValueReference vr;
    double value;
    char kind;
    if (sscanf(text, "%c:%u:%lf", &kind, &vr, &value) != 3) return fmi2Error;
    const int whole = (int)value;
    if (kind == 'r') return F(fmi2SetReal)(c, &vr, 1, &value);
    return kind == 'i' ? F(fmi2SetInteger)(c, &vr, 1, &whole) : F(fmi2SetBoolean)(c, &vr, 1, &whole);
}

static int live(Record *record) {
    const int steps = atoi(arguments[5]);
    fmi2ValueReference motion[3];
    fmi2Component c = F(fmi2Instantiate)("rope", fmi2CoSimulation, arguments[2], arguments[3], &CALLBACKS, 0, 0);
    int first;
    if (!c) return 1;
    for (int k = 0; k < 3; k++) motion[k] = (fmi2ValueReference)atoi(arguments[6 + k]);
    for (first = FIRST_ENTRY; strcmp(arguments[first], "--"); first++) DO(enter(c, arguments[first]));
    DO(F(fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0));
    DO(F(fmi2EnterInitializationMode)(c));
    DO(F(fmi2ExitInitializationMode)(c));
    for (int k = 0; k < steps; k++) {
        const double t = (k + 1) * H, y[3] = {1 - cos(t), sin(t), cos(t)};
        DO(F(fmi2SetReal)(c, motion, 3, y));
        DO(F(fmi2DoStep)(c, k * H, H, 1));
        for (int at = first + 1; at < number_of_arguments; at++) {
            const fmi2ValueReference vr = (fmi2ValueReference)atoi(arguments[at]);
            DO(F(fmi2GetReal)(c, &vr, 1, &record->numbers[record->length++]));
        }
    }
    DO(F(fmi2Terminate)(c));
    F(fmi2FreeInstance)(c);
    return 0;
}

static void *run(void *with) {
    Record *record = with;
    pthread_barrier_wait(&together);
    record->failed = live(record);
    return NULL;
}

int main(int number, char **given) {
    static Record records[MOST_THREADS], alone;
    pthread_t threads[MOST_THREADS];
    int wrong = 0;
    number_of_arguments = number;
    arguments = given;
    if (number < FIRST_ENTRY + 2 || !(library = dlopen(given[1], RTLD_NOW))) return 2;
    const int many = atoi(given[4]);
    if (many < 1 || many > MOST_THREADS) return 3;
    pthread_barrier_init(&together, NULL, (unsigned)many);
    for (int k = 0; k < many; k++)
        if (pthread_create(&threads[k], NULL, run, &records[k])) return 4;
    for (int k = 0; k < many; k++) pthread_join(threads[k], NULL);
    alone.failed = live(&alone);
    for (int k = 0; k < many; k++)
        wrong += records[k].failed || records[k].length != alone.length ||
                 memcmp(records[k].numbers, alone.numbers, sizeof(double) * (size_t)alone.length) != 0;
    printf("%d threads, %d numbers each, %d differ from those of one alone\n", many, alone.length, wrong);
    return alone.failed || alone.length == 0 || wrong ? 5 : 0;
}
