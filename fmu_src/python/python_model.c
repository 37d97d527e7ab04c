/* A model written in Python: the functions of model.h call an object of a class in the FMU's resources.

   The interpreter is that of the process.  A tool without Python loads a libpython, which stays until the process ends
   because numpy cannot be loaded twice.  Functions of Python's stable ABI are loaded by name, so that one library
   serves every Python from 3.11 on, without its headers.

   Object and library share arrays by scalar: entries of the last call, outputs, and flags of the outputs known since
   the last change.  Python computes an unknown output together with its group. */
#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#include <pthread.h>
#endif

#include "model.h"
#include "text.h"

typedef struct PyObject PyObject;

#define PYTHON_FUNCTIONS(F)                                                                                            \
    F(int, Py_IsInitialized, (void))                                                                                   \
    F(void, Py_InitializeEx, (int signals))                                                                            \
    F(void *, PyEval_SaveThread, (void))                                                                               \
    F(int, PyGILState_Ensure, (void))                                                                                  \
    F(void, PyGILState_Release, (int))                                                                                 \
    F(void, Py_DecRef, (PyObject *))                                                                                   \
    F(void, PyErr_WriteUnraisable, (PyObject *))                                                                       \
    F(PyObject *, PyErr_Occurred, (void))                                                                              \
    F(void, PyErr_Fetch, (PyObject * *kind, PyObject * *value, PyObject * *traceback))                                 \
    F(void, PyErr_Restore, (PyObject * kind, PyObject * value, PyObject * traceback))                                  \
    F(void, PyErr_Clear, (void))                                                                                       \
    F(PyObject *, PyObject_Repr, (PyObject *))                                                                         \
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
    int warnings; /* number of warnings that the object has */
    /* MODEL_SCALARS each */
    double *values;
    double *outputs;
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
        write_message(
            message,
            "this FMU runs Python code, and there is neither a Python in this process nor a libpython to load; "
            "preload one or put it on the library path, or take the native flavour of this FMU");
        return false;
    }
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
        void *found = symbol(from, entries[i].name);
        if (!found) {
            write_message(message, "the Python of this process has no %s; this FMU needs Python 3.%d or newer",
                          entries[i].name, OLDEST);
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

/* Report an exception that no Python code caught: its text as the message, its traceback on standard error. */
static void report(char *message) {
    PyObject *kind = NULL;
    PyObject *value = NULL;
    PyObject *traceback = NULL;
    python.PyErr_Fetch(&kind, &value, &traceback);
    PyObject *text = value ? python.PyObject_Repr(value) : NULL;
    const char *cause = text ? python.PyUnicode_AsUTF8AndSize(text, NULL) : NULL;
    write_message(message, "internal error in Python, please report it: %s; its standard error has the traceback",
                  cause ? cause : "an exception without a text");
    python.Py_DecRef(text);
    python.PyErr_Clear(); /* one of its text */
    python.PyErr_Restore(kind, value, traceback);
    python.PyErr_WriteUnraisable(NULL);
}

/* Copy a string and release it; report an exception in its place. */
static bool take_text(PyObject *text, char *message) {
    const char *found = text ? python.PyUnicode_AsUTF8AndSize(text, NULL) : NULL;
    if (found)
        copy_text(message, MESSAGE_BYTES, found);
    else
        report(message);
    python.Py_DecRef(text);
    return found != NULL;
}

/* True if a method succeeded; else copies the object's message. */
static bool check_answer(PyObject *object, PyObject *answer, char *message) {
    int ok = answer ? python.PyObject_IsTrue(answer) : -1;
    python.Py_DecRef(answer);
    if (ok < 0)
        report(message);
    else if (!ok)
        (void)take_text(python.PyObject_GetAttrString(object, "message"), message); /* false either way */
    return ok > 0;
}

/* Take a number and release it; report an exception in its place. */
static bool take_number(PyObject *answer, double *number, char *message) {
    *number = answer ? python.PyFloat_AsDouble(answer) : -1.0;
    const bool ok = answer && !(*number == -1.0 && python.PyErr_Occurred());
    if (!ok) report(message);
    python.Py_DecRef(answer);
    return ok;
}

/* Call a method without arguments for a number. */
static bool call_for_number(const ModelInstance *model, const char *method, double *number, char *message) {
    const int gil = python.PyGILState_Ensure();
    const bool ok = take_number(python.PyObject_CallMethod(model->object, method, NULL), number, message);
    python.PyGILState_Release(gil);
    return ok;
}

/* the functions of model.h */

bool model_has_events(void) {
    return false;
}

bool model_open(const char *resources, char *message) {
    if (!have_python(message)) return false;
    const int gil = python.PyGILState_Ensure();
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
            (void)take_text(python.Py_BuildValue("O", python.PyDict_GetItemString(scope, "wrong")), message);
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
        write_message(message, "no memory for the model; free other instances first");
        return NULL;
    }
    model->deallocate = allocator->deallocate;
    model->values = (double *)(model + 1);
    model->outputs = model->values + MODEL_SCALARS;
    model->known = (unsigned char *)(model->outputs + MODEL_SCALARS);
    memcpy(model->values, values, bytes);
    memset(model->outputs, 0, bytes + MODEL_SCALARS);
    const int gil = python.PyGILState_Ensure();
    PyObject *answer = NULL;
    model->object = python.PyObject_CallFunction(make, NULL);
    if (model->object)
        answer = python.PyObject_CallMethod(
            model->object, "create", "NNN",
            python.PyMemoryView_FromMemory((char *)model->values, (ptrdiff_t)bytes, READ),
            python.PyMemoryView_FromMemory((char *)model->outputs, (ptrdiff_t)bytes, WRITE),
            python.PyMemoryView_FromMemory((char *)model->known, (ptrdiff_t)MODEL_SCALARS, WRITE));
    double warnings = 0.0;
    const bool ok = check_answer(model->object, answer, message) &&
                    take_number(python.PyObject_GetAttrString(model->object, "warnings"), &warnings, message);
    model->warnings = (int)warnings;
    python.PyGILState_Release(gil);
    if (ok) return model;
    model_destroy(model);
    return NULL;
}

void model_destroy(ModelInstance *model) {
    if (!model) return;
    if (python.Py_IsInitialized()) { /* a Python host may end before its FMUs */
        const int gil = python.PyGILState_Ensure();
        python.Py_DecRef(model->object);
        python.PyGILState_Release(gil);
    }
    model->deallocate(model);
}

/* Call a method with these entries and as many of t and h as `format` has; return true on success. */
static bool succeeds(ModelInstance *model, const double *values, const char *method, const char *format, double t,
                     double h, char *message) {
    const int gil = python.PyGILState_Ensure();
    memcpy(model->values, values, MODEL_SCALARS * sizeof(double));
    memset(model->known, 0, MODEL_SCALARS); /* computed from other entries */
    const bool ok =
        check_answer(model->object, python.PyObject_CallMethod(model->object, method, format, t, h), message);
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

bool model_time(const ModelInstance *model, double *t, char *message) {
    return call_for_number(model, "time", t, message);
}

bool model_output(ModelInstance *model, size_t scalar, double *value, char *message) {
    bool ok = true;
    if (!model->known[scalar]) {
        const int gil = python.PyGILState_Ensure();
        ok = check_answer(model->object, python.PyObject_CallMethod(model->object, "compute", "n", (ptrdiff_t)scalar),
                          message);
        python.PyGILState_Release(gil);
    }
    if (ok) *value = model->outputs[scalar];
    return ok;
}

/* The object keeps the text until the next call for this scalar. */
bool model_text(ModelInstance *model, size_t scalar, const char **text, char *message) {
    const int gil = python.PyGILState_Ensure();
    PyObject *answer = python.PyObject_CallMethod(model->object, "text", "n", (ptrdiff_t)scalar);
    const char *found = answer ? python.PyUnicode_AsUTF8AndSize(answer, NULL) : NULL;
    if (!found) report(message);
    python.Py_DecRef(answer);
    python.PyGILState_Release(gil);
    if (found) *text = found;
    return found != NULL;
}

bool model_note(const ModelInstance *model, char *note, char *message) {
    const int gil = python.PyGILState_Ensure();
    const bool ok = take_text(python.PyObject_CallMethod(model->object, "note", NULL), note);
    python.PyGILState_Release(gil);
    if (!ok) copy_text(message, MESSAGE_BYTES, note);
    return ok;
}

/* An exception becomes the text of the warning. */
bool model_warning(ModelInstance *model, int index, char *message) {
    message[0] = '\0';
    if (index >= model->warnings) return false;
    const int gil = python.PyGILState_Ensure();
    (void)take_text(python.PyObject_CallMethod(model->object, "warning", "i", index), message);
    python.PyGILState_Release(gil);
    return true;
}

bool model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                      double *sum, char *message) {
    (void)model, (void)known, (void)seed, (void)unknown, (void)count, (void)sum;
    write_message(message, "this FMU has no directional derivatives; export the native flavour");
    return false;
}

bool model_state_bytes(const ModelInstance *model, size_t *bytes, char *message) {
    double number;
    if (!call_for_number(model, "state_bytes", &number, message)) return false;
    *bytes = (size_t)number;
    return true;
}

bool model_save(const ModelInstance *model, void *to, size_t bytes, char *message) {
    const int gil = python.PyGILState_Ensure();
    PyObject *state = python.PyObject_CallMethod(model->object, "state", NULL);
    char *from = NULL;
    ptrdiff_t length = 0;
    bool ok = state && python.PyBytes_AsStringAndSize(state, &from, &length) == 0;
    if (!ok) report(message);
    if (ok && (size_t)length != bytes) {
        write_message(message, "the state of the model has %s bytes, not the %s that it announced; please report it",
                      SHORT((double)length), SHORT((double)bytes));
        ok = false;
    }
    if (ok) memcpy(to, from, bytes);
    python.Py_DecRef(state);
    python.PyGILState_Release(gil);
    return ok;
}

bool model_restore(ModelInstance *model, const void *from, size_t bytes, char *message) {
    const int gil = python.PyGILState_Ensure();
    const bool ok =
        check_answer(model->object,
                     python.PyObject_CallMethod(model->object, "restore", "N",
                                                python.PyMemoryView_FromMemory((char *)from, (ptrdiff_t)bytes, READ)),
                     message);
    memset(model->known, 0, MODEL_SCALARS);
    python.PyGILState_Release(gil);
    return ok;
}
