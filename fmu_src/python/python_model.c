/* A model written in Python: the functions of model.h call an object of a class in the FMU's resources.

   The interpreter is that of the process.  A tool without Python loads a libpython, which stays until the process ends
   because numpy cannot be loaded twice.  Functions of Python's stable ABI are loaded by name, so that one library
   serves every Python from 3.11 on, without its headers.

   Object and library share arrays by scalar: entries of the last call, outputs, and flags of the outputs known since
   the last change.  Python computes an unknown output together with its group. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#include <pthread.h>
#endif

#include "model.h"

typedef struct PyObject PyObject;

#define PYTHON_FUNCTIONS(F)                                                                                            \
    F(int, Py_IsInitialized, (void))                                                                                   \
    F(void, Py_InitializeEx, (int signals))                                                                            \
    F(void *, PyEval_SaveThread, (void))                                                                               \
    F(int, PyGILState_Ensure, (void))                                                                                  \
    F(void, PyGILState_Release, (int))                                                                                 \
    F(void, Py_DecRef, (PyObject *))                                                                                   \
    F(void, PyErr_WriteUnraisable, (PyObject *))                                                                       \
    F(int, PyObject_IsTrue, (PyObject *))                                                                              \
    F(PyObject *, PyObject_GetAttrString, (PyObject *, const char *))                                                  \
    F(PyObject *, PyObject_CallFunction, (PyObject *, const char *format, ...))                                        \
    F(PyObject *, PyObject_CallMethod, (PyObject *, const char *name, const char *format, ...))                        \
    F(PyObject *, PyImport_ImportModule, (const char *))                                                               \
    F(PyObject *, Py_BuildValue, (const char *format, ...))                                                            \
    F(PyObject *, PyDict_GetItemString, (PyObject *, const char *))                                                    \
    F(PyObject *, PyMemoryView_FromMemory, (char *, ptrdiff_t, int access))                                            \
    F(const char *, PyUnicode_AsUTF8AndSize, (PyObject *, ptrdiff_t *))                                                \
    F(double, PyFloat_AsDouble, (PyObject *))                                                                          \
    F(int, PyBytes_AsStringAndSize, (PyObject *, char **, ptrdiff_t *))

#define POINTER(type, name, arguments) type(*name) arguments;
#define ENTRY(type, name, arguments) {#name, (void **)&python.name},

static struct {
    PYTHON_FUNCTIONS(POINTER)
} python;
static PyObject *make; /* creates a model object; NULL until the package is loaded; needs the GIL */

enum { READ = 0x100, WRITE = 0x200 }; /* access to a memoryview */
enum { OLDEST = 11, NEWEST = 29 };    /* versions 3.x to try */

struct ModelInstance {
    PyObject *object;
    void (*deallocate)(void *);
    /* MODEL_SCALARS each */
    double *values, *outputs;
    unsigned char *known;
};

/* Loads the module that pythonfmu's builder names from the host's folder, and finds its class. */
static const char LOAD[] =
    "import functools, importlib, pathlib, sys, urllib.request\n"
    "wrong = ''\n"
    "try:\n"
    "    folder = location\n"
    "    if folder.startswith('file:'):\n"
    "        folder = folder.removeprefix('file:')\n"
    "        if folder.startswith('//'):\n"
    "            folder = folder[folder.index('/', 2):]\n"
    "        folder = urllib.request.url2pathname(folder)\n"
    "    name = pathlib.Path(folder, 'slavemodule.txt').read_text(encoding='utf-8').strip()\n"
    "    importlib.invalidate_caches()\n"
    "    sys.path.insert(0, folder)\n"
    "    try:\n"
    "        module = importlib.import_module(name)\n"
    "    finally:\n"
    "        sys.path.remove(folder)\n"
    "    kind = next(v for v in vars(module).values() if isinstance(v, type) and v.__module__ == name)\n"
    "    make = functools.partial(kind, instance_name=kind.__name__, resources=folder)\n"
    "except Exception as error:\n"
    "    wrong = (\n"
    "        'this FMU runs Python code, which cannot be loaded: it needs Python 3.11 or newer with numpy, '\n"
    "        f'scipy and casadi; or take its native flavour ({type(error).__name__}: {error}; resources: {location})'\n"
    "    )\n";

/* finding Python */

#ifdef _WIN32

static SRWLOCK starting = SRWLOCK_INIT;

static void begin_alone(void) {
    AcquireSRWLockExclusive(&starting);
}

static void end_alone(void) {
    ReleaseSRWLockExclusive(&starting);
}

static void *symbol(HMODULE from, const char *name) {
    return (void *)GetProcAddress(from, name);
}

/* python3.dll forwards to the python3x.dll beside it. */
static HMODULE library(void) {
    HMODULE found = GetModuleHandleA("python3.dll");
    return found ? found : LoadLibraryA("python3.dll");
}

#else

static pthread_mutex_t starting = PTHREAD_MUTEX_INITIALIZER;

static void begin_alone(void) {
    pthread_mutex_lock(&starting);
}

static void end_alone(void) {
    pthread_mutex_unlock(&starting);
}

static void *symbol(void *from, const char *name) {
    return dlsym(from, name);
}

#ifdef __APPLE__
static const char NAME[] = "libpython3.%d.dylib";
#else
static const char NAME[] = "libpython3.%d.so.1.0";
#endif

/* Return the process itself, or a libpython whose symbols are visible to the libraries of numpy, scipy and casadi. */
static void *library(void) {
    void *found = dlopen(NULL, RTLD_LAZY);
    char name[sizeof NAME];
    if (found && dlsym(found, "Py_IsInitialized")) return found;
    for (int minor = OLDEST; minor <= NEWEST; minor++) {
        snprintf(name, sizeof name, NAME, minor);
        found = dlopen(name, RTLD_LAZY | RTLD_GLOBAL);
        if (found) return found;
    }
    return NULL;
}

#endif

/* Load Python's functions and an interpreter, in one thread while others wait.  This must not wait for the GIL: a
   thread that holds it may wait for the lock. */
static bool find_python(char *message) {
    static const struct {
        const char *name;
        void **place;
    } entries[] = {PYTHON_FUNCTIONS(ENTRY)};
    static int found_all;
    if (found_all) return true;
    void *from = (void *)library();
    if (!from) {
        snprintf(message, MESSAGE_BYTES,
                 "this FMU runs Python code, and there is neither a Python in this process nor a libpython to load; "
                 "preload one or put it on the library path, or take the native flavour of this FMU");
        return false;
    }
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
        void *found = symbol(from, entries[i].name);
        if (!found) {
            snprintf(message, MESSAGE_BYTES,
                     "the Python of this process has no %s; this FMU needs Python 3.%d or newer", entries[i].name,
                     OLDEST);
            return false;
        }
        memcpy(entries[i].place, &found, sizeof found);
    }
    if (!python.Py_IsInitialized()) {
        python.Py_InitializeEx(0);  /* signals stay the host's */
        python.PyEval_SaveThread(); /* each call takes the interpreter's lock */
    }
    found_all = 1;
    return true;
}

static bool have_python(char *message) {
    begin_alone();
    const int found = find_python(message);
    end_alone();
    return found;
}

/* answers of Python */

/* Copy a message as far as it fits, cut between two characters. */
static void copy(const char *text, char *message) {
    size_t length = strlen(text);
    if (length >= MESSAGE_BYTES)
        for (length = MESSAGE_BYTES - 1; (text[length] & 0xC0) == 0x80;) length--;
    memcpy(message, text, length);
    message[length] = '\0';
}

/* Report an exception that no Python code caught. */
static void report(char *message) {
    python.PyErr_WriteUnraisable(NULL);
    copy("internal error in Python, please report it; its standard error has the traceback", message);
}

/* Copy a string and release it. */
static void take_text(PyObject *text, char *message) {
    const char *found = text ? python.PyUnicode_AsUTF8AndSize(text, NULL) : NULL;
    if (found)
        copy(found, message);
    else
        report(message);
    python.Py_DecRef(text);
}

/* True if a method succeeded; else copies the object's message. */
static bool check_answer(PyObject *object, PyObject *answer, char *message) {
    int ok = answer ? python.PyObject_IsTrue(answer) : -1;
    python.Py_DecRef(answer);
    if (ok < 0)
        report(message);
    else if (!ok)
        take_text(python.PyObject_GetAttrString(object, "message"), message);
    return ok > 0;
}

static double as_number(PyObject *answer) {
    double value = answer ? python.PyFloat_AsDouble(answer) : NAN;
    char message[MESSAGE_BYTES];
    if (!answer) report(message);
    python.Py_DecRef(answer);
    return value;
}

/* the functions of model.h */

bool model_has_events(void) {
    return false;
}

const char *model_accuracy(void) {
    return "accuracy.end_force";
}

bool model_open(const char *resources, char *message) {
    if (!have_python(message)) return false;
    int gil = python.PyGILState_Ensure();
    PyObject *loaded = make;
    if (!loaded) {
        PyObject *builtins = python.PyImport_ImportModule("builtins");
        PyObject *scope = python.Py_BuildValue("{s:s}", "location", resources ? resources : "");
        PyObject *done = builtins && scope ? python.PyObject_CallMethod(builtins, "exec", "sO", LOAD, scope) : NULL;
        /* Other threads may import the same module meanwhile; Python loads it once. */
        if (done) loaded = python.PyDict_GetItemString(scope, "make"); /* scope is never released */
        if (!done)
            report(message);
        else if (!loaded)
            take_text(python.Py_BuildValue("O", python.PyDict_GetItemString(scope, "wrong")), message);
        if (loaded) make = loaded;
        python.Py_DecRef(done);
        python.Py_DecRef(builtins);
    }
    python.PyGILState_Release(gil);
    return loaded != NULL;
}

ModelInstance *model_create(const double *values, const Allocator *allocator, char *message) {
    size_t bytes = MODEL_SCALARS * sizeof(double);
    ModelInstance *model = allocator->allocate(1, sizeof *model + 2 * bytes + MODEL_SCALARS);
    if (!model) {
        snprintf(message, MESSAGE_BYTES, "no memory for the model; free other instances first");
        return NULL;
    }
    model->deallocate = allocator->deallocate;
    model->values = (double *)(model + 1);
    model->outputs = model->values + MODEL_SCALARS;
    model->known = (unsigned char *)(model->outputs + MODEL_SCALARS);
    memcpy(model->values, values, bytes);
    memset(model->outputs, 0, bytes + MODEL_SCALARS);
    int gil = python.PyGILState_Ensure();
    PyObject *answer = NULL;
    model->object = python.PyObject_CallFunction(make, NULL);
    if (model->object)
        answer = python.PyObject_CallMethod(
            model->object, "create", "NNN",
            python.PyMemoryView_FromMemory((char *)model->values, (ptrdiff_t)bytes, READ),
            python.PyMemoryView_FromMemory((char *)model->outputs, (ptrdiff_t)bytes, WRITE),
            python.PyMemoryView_FromMemory((char *)model->known, (ptrdiff_t)MODEL_SCALARS, WRITE));
    const int ok = check_answer(model->object, answer, message);
    python.PyGILState_Release(gil);
    if (ok) return model;
    model_destroy(model);
    return NULL;
}

void model_destroy(ModelInstance *model) {
    if (!model) return;
    if (python.Py_IsInitialized()) { /* a Python host may end before its FMUs */
        int gil = python.PyGILState_Ensure();
        python.Py_DecRef(model->object);
        python.PyGILState_Release(gil);
    }
    model->deallocate(model);
}

/* Call a method with these entries and as many of t and h as `format` has; return true on success. */
static bool succeeds(ModelInstance *model, const double *values, const char *method, const char *format, double t,
                     double h, char *message) {
    int gil = python.PyGILState_Ensure(), ok;
    memcpy(model->values, values, MODEL_SCALARS * sizeof(double));
    memset(model->known, 0, MODEL_SCALARS); /* computed from other entries */
    ok = check_answer(model->object, python.PyObject_CallMethod(model->object, method, format, t, h), message);
    python.PyGILState_Release(gil);
    return ok;
}

bool model_initialize(ModelInstance *model, double t, const double *values, char *message) {
    return succeeds(model, values, "initialize", "d", t, 0.0, message);
}

bool model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message) {
    (void)event; /* FMI 2.0 has no event mode */
    return succeeds(model, values, "do_step", "dd", t, h, message);
}

bool model_retune(ModelInstance *model, const double *values, char *message) {
    return succeeds(model, values, "retune", NULL, 0.0, 0.0, message);
}

double model_time(const ModelInstance *model) {
    int gil = python.PyGILState_Ensure();
    double time = as_number(python.PyObject_CallMethod(model->object, "time", NULL));
    python.PyGILState_Release(gil);
    return time;
}

bool model_output(ModelInstance *model, size_t scalar, double *value, char *message) {
    int ok = 1;
    if (!model->known[scalar]) {
        int gil = python.PyGILState_Ensure();
        ok = check_answer(model->object, python.PyObject_CallMethod(model->object, "compute", "n", (ptrdiff_t)scalar),
                          message);
        python.PyGILState_Release(gil);
    }
    if (ok) *value = model->outputs[scalar];
    return ok;
}

/* The object keeps the text until the next call for this scalar. */
bool model_text(ModelInstance *model, size_t scalar, const char **text, char *message) {
    int gil = python.PyGILState_Ensure();
    PyObject *answer = python.PyObject_CallMethod(model->object, "text", "n", (ptrdiff_t)scalar);
    const char *found = answer ? python.PyUnicode_AsUTF8AndSize(answer, NULL) : NULL;
    if (!found) report(message);
    python.Py_DecRef(answer);
    python.PyGILState_Release(gil);
    if (found) *text = found;
    return found != NULL;
}

void model_note(const ModelInstance *model, char *message) {
    int gil = python.PyGILState_Ensure();
    take_text(python.PyObject_CallMethod(model->object, "note", NULL), message);
    python.PyGILState_Release(gil);
}

bool model_warning(ModelInstance *model, int index, char *message) {
    const int gil = python.PyGILState_Ensure();
    const int exists = index < as_number(python.PyObject_GetAttrString(model->object, "warnings"));
    message[0] = '\0';
    if (exists) take_text(python.PyObject_CallMethod(model->object, "warning", "i", index), message);
    python.PyGILState_Release(gil);
    return exists;
}

bool model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                      double *sum, char *message) {
    (void)model, (void)known, (void)seed, (void)unknown, (void)count, (void)sum;
    snprintf(message, MESSAGE_BYTES, "this FMU has no directional derivatives; export the native flavour");
    return false;
}

size_t model_state_bytes(const ModelInstance *model) {
    int gil = python.PyGILState_Ensure();
    double bytes = as_number(python.PyObject_CallMethod(model->object, "state_bytes", NULL));
    python.PyGILState_Release(gil);
    return bytes > 0.0 ? (size_t)bytes : 0;
}

void model_save(const ModelInstance *model, void *to) {
    int gil = python.PyGILState_Ensure();
    PyObject *state = python.PyObject_CallMethod(model->object, "state", NULL);
    char *bytes = NULL, message[MESSAGE_BYTES];
    ptrdiff_t length = 0;
    if (state && python.PyBytes_AsStringAndSize(state, &bytes, &length) == 0)
        memcpy(to, bytes, (size_t)length);
    else
        report(message);
    python.Py_DecRef(state);
    python.PyGILState_Release(gil);
}

bool model_restore(ModelInstance *model, const void *from, size_t bytes, char *message) {
    int gil = python.PyGILState_Ensure(), ok;
    ok = check_answer(model->object,
                      python.PyObject_CallMethod(model->object, "restore", "N",
                                                 python.PyMemoryView_FromMemory((char *)from, (ptrdiff_t)bytes, READ)),
                      message);
    memset(model->known, 0, MODEL_SCALARS);
    python.PyGILState_Release(gil);
    return ok;
}
