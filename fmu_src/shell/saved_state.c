#include "saved_state.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "component_data.h"
#include "text.h"
#include "values.h"

enum { STATE_VERSION = 6 };

/* Header of a state; the numbers of Scalars and the model's bytes follow. */
typedef struct {
    char magic[8];
    uint64_t bytes;
    uint64_t checksum; /* of the bytes behind it */
    uint32_t version;
    int32_t mode;
    int32_t valid;
    int32_t has_model; /* 1 if the model's bytes follow */
    int32_t at_event;
    double start;
    double stop;
    double time;
    double last_step;
    char token[TOKEN_BYTES];
    char status[MESSAGE_BYTES];
} StateHeader;

static const char MAGIC[8] = "FMUSTATE";

/* Return the bytes of a state in front of the model's. */
static size_t own_bytes(void) {
    return sizeof(StateHeader) + scalars_bytes();
}

/* True if a state of the component has one of the model, too. */
static bool saves_model(const Component *c) {
    return c->started && c->model;
}

bool component_state_bytes(Component *c, size_t *bytes) {
    char reason[MESSAGE_BYTES];
    size_t of_model = 0;
    if (saves_model(c) && !model_state_bytes(c->model, &of_model, reason)) return component_error(c, "%s", reason);
    *bytes = own_bytes() + of_model;
    return true;
}

/* Return the FNV-1a hash over words: fast, because hosts save at every step.  It detects damage, not malice. */
static uint64_t checksum(const unsigned char *bytes, size_t count) {
    uint64_t sum = 14695981039346656037u;
    uint64_t word;
    for (; count >= sizeof word; bytes += sizeof word, count -= sizeof word) {
        memcpy(&word, bytes, sizeof word);
        sum = (sum ^ word) * 1099511628211u;
    }
    while (count--) sum = (sum ^ *bytes++) * 1099511628211u;
    return sum;
}

static uint64_t state_checksum(const void *state, size_t bytes) {
    size_t from = offsetof(StateHeader, checksum) + sizeof(uint64_t);
    return checksum((const unsigned char *)state + from, bytes - from);
}

bool component_save(Component *c, void *to, size_t bytes) {
    StateHeader header;
    unsigned char *const numbers = (unsigned char *)to + sizeof header;
    unsigned char *const of_model = (unsigned char *)to + own_bytes();
    char reason[MESSAGE_BYTES];
    if (saves_model(c) && !model_save(c->model, of_model, bytes - own_bytes(), reason))
        return component_error(c, "the state is not saved: %s", reason);
    memset(&header, 0, sizeof header);
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    header.bytes = bytes;
    header.version = STATE_VERSION;
    header.mode = c->mode;
    header.valid = c->valid;
    header.has_model = saves_model(c);
    header.at_event = c->at_event;
    header.start = c->start;
    header.stop = c->stop;
    header.time = c->time;
    header.last_step = c->last_step;
    model_token(header.token);
    strcpy(header.status, c->status);
    memcpy(numbers, c->numbers, scalars_bytes());
    memcpy(to, &header, sizeof header);
    header.checksum = state_checksum(to, bytes);
    memcpy(to, &header, sizeof header);
    return true;
}

/* True if the text is terminated and printable, as those of component_error() are. */
static bool is_message(const char text[MESSAGE_BYTES]) {
    for (size_t i = 0; i < MESSAGE_BYTES; i++) {
        if (text[i] == '\0') return true;
        if (((unsigned char)text[i] < ' ' && text[i] != '\n') || text[i] == 127) return false; /* UTF-8 passes */
    }
    return false;
}

/* Return the entries in a state. */
static const double *saved_entries(const StateHeader *header) {
    return (const double *)(header + 1);
}

/* Return the entries in a state that the model used last. */
static const double *saved_used(const StateHeader *header) {
    return saved_entries(header) + MODEL_SCALARS;
}

/* Return the bytes of the model in a state. */
static const unsigned char *saved_model(const StateHeader *header) {
    return (const unsigned char *)(header + 1) + scalars_bytes();
}

/* True if a component can have this mode, these times and this status. */
static bool header_plausible(const StateHeader *header) {
    const bool before_start = header->mode == INSTANTIATED || header->mode == INITIALIZATION;
    const bool after_start = header->mode == STEPPING || header->mode == TERMINATED;
    if (!before_start && !after_start && header->mode != FAILED) return false;
    if ((before_start && header->has_model) || (after_start && !header->has_model)) return false;
    if (!isfinite(header->start) || !isfinite(header->time) || !isfinite(header->last_step)) return false;
    if (!(header->stop >= header->start) || !is_message(header->status)) return false;
    return header->valid || header->status[0] != '\0';
}

/* True if a component can have these entries; else the reason is written. */
static bool entries_fit(const double *entries, char reason[MESSAGE_BYTES]) {
    for (size_t i = 0; i < MODEL_SCALARS; i++) {
        const Variable *variable = &MODEL_VARIABLES[i];
        if (variable->source == FROM_ENTRY && !entry_fits(variable, entries[i], reason)) return false;
    }
    return true;
}

bool component_is_state(Component *c, const void *from, size_t bytes) {
    const StateHeader *header = from;
    char reason[MESSAGE_BYTES];
    char expected[TOKEN_BYTES];
    model_token(expected);
    if (bytes < sizeof *header || memcmp(header->magic, MAGIC, sizeof MAGIC))
        return component_error(c, "these %s bytes are not a state of this FMU", SHORT((double)bytes));
    if (header->version != STATE_VERSION || memcmp(header->token, expected, TOKEN_BYTES))
        return component_error(c, "the state is none of this FMU's: it is another build's; restore it there");
    if (bytes < own_bytes() || header->bytes != bytes || header->checksum != state_checksum(from, bytes))
        return component_error(c, "these %s bytes are a damaged state: length or checksum do not fit; save it anew",
                               SHORT((double)bytes));
    if (!header_plausible(header)) return component_error(c, "the state contradicts itself; save it anew");
    if (entries_fit(saved_entries(header), reason) && entries_fit(saved_used(header), reason)) return true;
    return component_error(c, "the state contradicts itself: %s", reason);
}

static bool same_fixed(const double *a, const double *b) {
    for (size_t i = 0; i < MODEL_SCALARS; i++)
        if (MODEL_VARIABLES[i].variability == VARIABILITY_FIXED && a[i] != b[i]) return false;
    return true;
}

bool component_restore(Component *c, const void *from, size_t bytes) {
    const StateHeader *header = from;
    ModelInstance *model = NULL;
    char reason[MESSAGE_BYTES] = "";
    if (!component_is_state(c, from, bytes)) return false;
    if (header->has_model) {
        const double *used = saved_used(header);
        const size_t count = bytes - own_bytes();
        /* Other fixed parameters need a new model; the present one stays until that has the state. */
        const bool fits = c->started && c->model && same_fixed(saved_entries(header), c->scalars.entries);
        model = fits ? c->model : model_create(used, &c->allocator, reason);
        if (!model || !model_retune(model, used, reason) || !model_restore(model, saved_model(header), count, reason)) {
            char other[MESSAGE_BYTES];
            if (fits && !model_retune(model, c->scalars.used, other)) {
                component_error(c, "setFMUstate: %s; the present parameters cannot be restored: %s", reason, other);
                return component_fail(c);
            }
            if (!fits) model_destroy(model);
            return component_error(c, "setFMUstate: %s", reason);
        }
    }
    if (model != c->model) model_destroy(c->model);
    c->model = model;
    memcpy(c->numbers, saved_entries(header), scalars_bytes());
    memcpy(c->status, header->status, sizeof c->status);
    c->start = header->start;
    c->stop = header->stop;
    c->time = header->time;
    c->last_step = header->last_step;
    c->mode = header->mode;
    c->valid = header->valid;
    c->started = header->has_model;
    c->at_event = header->at_event;
    c->retune = header->has_model;
    c->changed = header->has_model ? NOTHING : INPUTS | PARAMETERS;
    return true;
}
