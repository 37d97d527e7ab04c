/* The balance rope as a model.  Entries become scene and end motions, signals become outputs. */
#include <stdio.h>
#include <string.h>

#include "model.h"
#include "rope.h"
#include "rope_table.h"

enum { LOADS = 12 };

struct ModelInstance {
    Simulator *sim;
    Memory memory;
    Scene scene;
    bool at_step_end; /* true if inputs apply at the end of a step */
    char warning[(ROPE_EXTRAPOLATION + 1) * (MESSAGE_BYTES + 2)];
};

static void *field(void *structure, size_t offset) {
    return (char *)structure + offset;
}

static void read_parameters(ModelInstance *model, const double *values) {
    for (size_t i = 0; i < MODEL_SCALARS; i++) {
        const Place *place = &ROPE_PLACES[i];
        if (place->where == SCENE_REAL) *(double *)field(&model->scene, place->offset) = values[i];
        if (place->where == SCENE_INTEGER) *(int *)field(&model->scene, place->offset) = (int)values[i];
    }
    model->at_step_end = values[MODEL_AT_STEP_END] != 0.0;
}

static void read_motions(const double *values, EndMotion ends[2]) {
    static const size_t offsets[] = END_MOTION_OFFSETS;
    for (int side = LEFT; side <= RIGHT; side++)
        for (int k = 0; k < END_MOTIONS; k++) *(double *)field(&ends[side], offsets[k]) = values[ROPE_MOTIONS[side][k]];
}

/* Return true for an action of the rope that is done; else write its message, and return false. */
static bool succeeded(const ModelInstance *model, RopeStatus status, char *message) {
    if (status == ROPE_DONE) return true;
    write_message(message, "%s", rope_message(model->sim));
    return false;
}

bool model_has_events(void) {
    return true;
}

bool model_open(const char *resources, char *message) {
    (void)resources, (void)message; /* nothing to load */
    return true;
}

ModelInstance *model_create(const double *values, const Allocator *allocator, char *message) {
    ModelInstance *model = allocator->allocate(1, sizeof *model);
    if (!model) {
        write_message(message, "no memory for the rope; free other instances first");
        return NULL;
    }
    memset(model, 0, sizeof *model);
    model->memory = (Memory){.allocate = allocator->allocate, .deallocate = allocator->deallocate};
    read_parameters(model, values);
    model->sim = rope_create(&model->scene, &model->memory, message);
    if (model->sim) return model;
    allocator->deallocate(model);
    return NULL;
}

void model_destroy(ModelInstance *model) {
    if (!model) return;
    rope_destroy(model->sim);
    model->memory.deallocate(model);
}

bool model_initialize(ModelInstance *model, double t, const double *values, char *message) {
    EndMotion ends[2];
    read_motions(values, ends);
    return succeeded(model, rope_initialize(model->sim, t, ends), message);
}

bool model_step(ModelInstance *model, double t, double h, const double *values, int *event, char *message) {
    EndMotion ends[2];
    read_motions(values, ends);
    const double given_at = model->at_step_end ? t + h : t;
    if (event && !model->at_step_end) /* only extrapolated motions are known at an event */
        return succeeded(model, rope_advance_to_event(model->sim, t + h, ends, given_at, event), message);
    return succeeded(model, rope_advance_to(model->sim, t + h, ends, given_at), message);
}

bool model_retune(ModelInstance *model, const double *values, char *message) {
    Scene before = model->scene;
    read_parameters(model, values);
    if (succeeded(model, rope_retune(model->sim, &model->scene), message)) return true;
    model->scene = before;
    return false;
}

bool model_time(const ModelInstance *model, double *t, char *message) {
    (void)message;
    *t = rope_time(model->sim);
    return true;
}

bool model_output(ModelInstance *model, size_t scalar, double *value, char *message) {
    (void)message;
    const int signal = (int)ROPE_PLACES[scalar].offset;
    rope_signals(model->sim, 1, &signal, value);
    return true;
}

bool model_warning(ModelInstance *model, int index, char *message) {
    message[0] = '\0';
    if (index > ROPE_EXTRAPOLATION) return false;
    if (index < ROPE_EXTRAPOLATION || !model->at_step_end) rope_warning(model->sim, index, message);
    return true;
}

/* Return all warnings, a line each. */
static const char *all_warnings(ModelInstance *model) {
    char text[MESSAGE_BYTES];
    char *end = model->warning;
    char *const stop = end + sizeof(model->warning);
    *end = '\0';
    for (int k = 0; model_warning(model, k, text); k++) {
        const char *separator = end > model->warning ? "\n" : "";
        if (*text) end += snprintf(end, (size_t)(stop - end), "%s%s", separator, text);
    }
    return model->warning;
}

bool model_text(ModelInstance *model, size_t scalar, const char **text, char *message) {
    (void)message;
    const enum Where where = ROPE_PLACES[scalar].where;
    if (where == WARNING) *text = all_warnings(model);
    if (where == FIDELITY_NAME) *text = rope_fidelity(model->sim);
    if (where == FIDELITY_REASON) *text = rope_fidelity_reason(model->sim);
    return true;
}

bool model_note(const ModelInstance *model, char *note, char *message) {
    (void)message;
    write_message(note, "model: %s, %d elements, %s", rope_fidelity(model->sim), rope_elements(model->sim),
                  rope_fidelity_reason(model->sim));
    return true;
}

bool model_derivative(ModelInstance *model, size_t known, double seed, const unsigned *unknown, size_t count,
                      double *sum, char *message) {
    const int side = ROPE_PLACES[known].where == RIGHT_MOTION;
    const int input = side * END_MOTIONS + (int)ROPE_PLACES[known].offset;
    double loads[LOADS]; /* their derivatives */
    for (size_t i = 0; i < count; i++)
        if (ROPE_PLACES[unknown[i]].derivative < 0) {
            write_message(message,
                          "there is no derivative of %s; ask for those of left.fx ... left.mz, right.fx ... right.mz",
                          MODEL_VARIABLES[unknown[i]].name);
            return false;
        }
    if (!succeeded(model, rope_load_derivative(model->sim, input, model->at_step_end, loads), message)) return false;
    for (size_t i = 0; i < count; i++) sum[i] += seed * loads[ROPE_PLACES[unknown[i]].derivative];
    return true;
}

bool model_state_bytes(const ModelInstance *model, size_t *bytes, char *message) {
    (void)message;
    *bytes = rope_state_bytes(model->sim);
    return true;
}

bool model_save(const ModelInstance *model, void *to, size_t bytes, char *message) {
    (void)bytes, (void)message; /* the rope writes the bytes that it has counted */
    rope_save(model->sim, to);
    return true;
}

bool model_restore(ModelInstance *model, const void *from, size_t bytes, char *message) {
    return succeeded(model, rope_restore(model->sim, from, bytes), message);
}
