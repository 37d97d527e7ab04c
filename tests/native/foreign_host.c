/* A host of one FMI 2.0 library, for platforms that are emulated: commands from stdin, values to stdout.

   r REFERENCE VALUE   set a Real         b REFERENCE VALUE   set a Boolean      i   initialise at t = 0
   s T H               step               g REFERENCE         print a Real as a hexadecimal number
   The first call that fails ends the program with code 1 and the library's message. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define SYMBOL(library, name) ((void *)GetProcAddress((HMODULE)library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define SYMBOL(library, name) dlsym(library, name)
#endif

static void say(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                fmi2String message, ...) {
    va_list arguments;
    (void)environment, (void)name, (void)category;
    if (status == fmi2OK) return;
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void *symbol(void *library, const char *name) {
    void *found = SYMBOL(library, name);
    if (found) return found;
    fprintf(stderr, "the library does not export %s\n", name);
    exit(1);
}

#define GET(type, name) type *name = (type *)symbol(library, "fmi2" #name)
#define MUST(call)                                                                                                     \
    if ((call) > fmi2Warning) {                                                                                        \
        fprintf(stderr, "%s failed\n", #call);                                                                         \
        return 1;                                                                                                      \
    }

int main(int argc, char **argv) {
    fmi2CallbackFunctions callbacks = {say, calloc, free, NULL, NULL};
    void *library = argc == 3 ? OPEN(argv[1]) : NULL;
    fmi2Component c;
    char command;
    if (!library) {
        fprintf(stderr, "usage: foreign_host LIBRARY GUID; the library must load\n");
        return 1;
    }
    {
        GET(fmi2InstantiateTYPE, Instantiate);
        GET(fmi2SetupExperimentTYPE, SetupExperiment);
        GET(fmi2EnterInitializationModeTYPE, EnterInitializationMode);
        GET(fmi2ExitInitializationModeTYPE, ExitInitializationMode);
        GET(fmi2SetRealTYPE, SetReal);
        GET(fmi2SetBooleanTYPE, SetBoolean);
        GET(fmi2GetRealTYPE, GetReal);
        GET(fmi2DoStepTYPE, DoStep);
        GET(fmi2TerminateTYPE, Terminate);
        GET(fmi2FreeInstanceTYPE, FreeInstance);
        c = Instantiate("foreign", fmi2CoSimulation, argv[2], "file:///", &callbacks, fmi2False, fmi2False);
        if (!c) return 1;
        while (scanf(" %c", &command) == 1) {
            double a = 0.0, b = 0.0;
            fmi2ValueReference reference;
            int number = command == 'i' ? 0 : command == 'g' ? 1 : 2;
            if ((number > 0 && scanf("%lf", &a) != 1) || (number > 1 && scanf("%lf", &b) != 1)) return 1;
            reference = (fmi2ValueReference)a;
            if (command == 'r') MUST(SetReal(c, &reference, 1, &b))
            if (command == 'b') {
                fmi2Boolean value = b != 0.0;
                MUST(SetBoolean(c, &reference, 1, &value))
            }
            if (command == 'i') {
                MUST(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0))
                MUST(EnterInitializationMode(c))
                MUST(ExitInitializationMode(c))
            }
            if (command == 's') MUST(DoStep(c, a, b, fmi2True))
            if (command == 'g') {
                MUST(GetReal(c, &reference, 1, &b))
                printf("%a\n", b);
            }
        }
        MUST(Terminate(c))
        FreeInstance(c);
    }
    return 0;
}
