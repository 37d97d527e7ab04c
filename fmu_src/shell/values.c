/* Values of a component: rules of causality and variability, entries and results. */

#include "values.h"

#include <math.h>
#include <stdint.h>

#include "component_data.h"
#include "text.h"

/* Return the number of scalars of a variable; 0 for an element of another variable. */
static size_t length_of(unsigned reference) {
    return model_has_arrays() ? MODEL_VARIABLES[reference].length : 1;
}

bool component_find(Component *c, unsigned reference, Kind kind, size_t *first, size_t *length) {
    static const char *const names[] = {"Real", "Integer", "Boolean", "String", "Enumeration"};
    if (reference >= MODEL_SCALARS || MODEL_VARIABLES[reference].kind != kind || !length_of(reference))
        return component_error(c, "there is no %s variable with value reference %s", names[kind], SHORT(reference));
    *first = reference;
    *length = length_of(reference);
    return true;
}

bool component_get(Component *c, size_t scalar, double *value) {
    char reason[MESSAGE_BYTES];
    *value = 0.0;
    const Variable *variable = &MODEL_VARIABLES[scalar];
    if (variable->source == FROM_ENTRY) *value = c->scalars.entries[scalar];
    if (variable->source == FROM_STATUS_VALID) *value = c->valid;
    if (variable->source == FROM_TIME) *value = component_time(c);
    if (variable->source != FROM_MODEL) return true;
    if (component_provide_model(c) &&
        (model_output(c->model, scalar, value, reason) || component_error(c, "%s", reason))) {
        if (variable->kind == KIND_INTEGER) *value = fmin(*value, INT32_MAX); /* counters grow without bound */
        return true;
    }
    if (variable->kind == KIND_REAL) *value = NAN; /* must not look like a force */
    return false;
}

bool component_get_text(Component *c, size_t scalar, const char **text) {
    char reason[MESSAGE_BYTES] = "";
    *text = MODEL_VARIABLES[scalar].source == FROM_STATUS_MESSAGE ? c->status : "";
    if (MODEL_VARIABLES[scalar].source == FROM_STATUS_MESSAGE) return true;
    return component_provide_model(c) &&
           (model_text(c->model, scalar, text, reason) || component_error(c, "%s", reason));
}

bool entry_fits(const Variable *variable, double value, char reason[MESSAGE_BYTES]) {
    const bool whole = value >= INT32_MIN && value <= INT32_MAX && value == floor(value);
    const bool chosen = value >= 0.0 && value < variable->count;
    if (!isfinite(value) && variable->causality == CAUSALITY_INPUT)
        write_message(reason, "input %s = %s is not finite; check the signal connected to it", variable->name,
                      SHORT(value));
    else if (!isfinite(value))
        write_message(reason, "%s = %s is out of range: it must be finite; give a number", variable->name,
                      SHORT(value));
    else if (variable->choices && !chosen)
        write_message(reason, "%s = %s is none of the choices: %s", variable->name, SHORT(value), variable->choices);
    else if (variable->kind != KIND_REAL && !whole)
        write_message(reason, "%s = %s is out of range: it must be a whole number of 32 bits; give a smaller one",
                      variable->name, SHORT(value));
    else
        return true;
    return false;
}

static const char *value_text(char buffer[NUMBER], const Variable *variable, double value) {
    if (variable->kind == KIND_BOOLEAN) return value != 0.0 ? "true" : "false";
    return text_short(buffer, value);
}

static bool enter(Component *c, size_t scalar, double value) {
    const Variable *variable = &MODEL_VARIABLES[scalar];
    char reason[MESSAGE_BYTES];
    if (variable->causality == CAUSALITY_OUTPUT)
        return component_error(c, "%s is an output and cannot be set", variable->name);
    if (variable->causality == CAUSALITY_INDEPENDENT)
        return component_error(c, "%s is the independent variable; it advances with the steps and cannot be set",
                               variable->name);
    if (c->started && variable->variability == VARIABILITY_FIXED) {
        if (value == c->scalars.entries[scalar]) return true;
        return component_error(c, "%s is fixed after initialisation; it stays %s; reset the FMU to change it",
                               variable->name, value_text((char[NUMBER]){0}, variable, c->scalars.entries[scalar]));
    }
    if (!entry_fits(variable, value, reason)) return component_error(c, "%s", reason);
    if (c->started && variable->variability == VARIABILITY_TUNABLE) c->retune = true;
    c->changed |= variable->causality == CAUSALITY_PARAMETER ? PARAMETERS : INPUTS;
    c->scalars.entries[scalar] = value;
    return true;
}

bool component_set(Component *c, size_t scalar, double value) {
    if (!enter(c, scalar, value)) return false;
    if (c->started) c->scalars.origins[scalar] = GIVEN; /* earlier ones are start values */
    return true;
}

bool component_set_rate(Component *c, size_t scalar, int order, double value) {
    const Variable *variable = &MODEL_VARIABLES[scalar];
    if (variable->causality != CAUSALITY_INPUT)
        return component_error(c, "there is no time derivative of %s to be set; give one of an input", variable->name);
    if (order < 1 || !isfinite(value))
        return component_error(c, "derivative %d of %s = %s must be of order 1 or higher, and finite", order,
                               variable->name, SHORT(value));
    for (; order > 0 && scalar; order--) scalar = MODEL_VARIABLES[scalar].rate;
    if (!scalar || c->scalars.origins[scalar] == GIVEN) return true;
    if (!enter(c, scalar, value)) return false;
    if (c->started) c->scalars.origins[scalar] = DERIVED;
    return true;
}

bool component_derivative(Component *c, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                          const double *seed, double *sensitivity) {
    size_t i;
    size_t first = 0;
    size_t length = 0;
    char reason[MESSAGE_BYTES] = "";
    for (i = 0; i < unknowns; i++) {
        if (!component_find(c, unknown[i], KIND_REAL, &first, &length)) return false;
        if (MODEL_VARIABLES[first].source != FROM_MODEL || length != 1)
            return component_error(c,
                                   "there is no derivative of %s; ask for one of an output that depends on the inputs",
                                   MODEL_VARIABLES[first].name);
        sensitivity[i] = 0.0;
    }
    for (i = 0; i < knowns; i++) {
        if (!component_find(c, known[i], KIND_REAL, &first, &length)) return false;
        if (MODEL_VARIABLES[first].causality != CAUSALITY_INPUT)
            return component_error(c, "there is no derivative to %s; ask for one to an input",
                                   MODEL_VARIABLES[first].name);
        if (!isfinite(seed[i]))
            return component_error(c, "the seed of %s = %s is not finite; give a number", MODEL_VARIABLES[first].name,
                                   SHORT(seed[i]));
    }
    if (!component_provide_model(c)) return false;
    for (i = 0; i < knowns; i++)
        if (!model_derivative(c->model, known[i], seed[i], unknown, unknowns, sensitivity, reason))
            return component_error(c, "%s", reason);
    return true;
}
