#include "snapshot.h"

#include <stdint.h>
#include <string.h>

#include "saved_state.h"

struct Snapshot {
    const void *mark; /* &OURS until it is freed */
    size_t bytes;
    size_t capacity;
    uint64_t state[]; /* words of 64 bits, for alignment */
};

static const char OURS = 1; /* its address marks a snapshot */

static Snapshot *allocate_snapshot(Component *c, const Allocator *allocator, size_t bytes) {
    Snapshot *snapshot = bytes < SIZE_MAX / 2 ? allocator->allocate(1, sizeof *snapshot + bytes) : NULL;
    if (!snapshot) {
        component_error(c, "no memory for a state; free states that are not needed");
        return NULL;
    }
    snapshot->mark = &OURS;
    snapshot->capacity = bytes;
    return snapshot;
}

bool snapshot_check(Component *c, const Snapshot *snapshot) {
    if (!component_nonnull(c, snapshot)) return false;
    if (snapshot->mark == &OURS) return true;
    return component_error(
        c, "this is no state of this FMU, or it was freed; give a pointer from the call that gets a state");
}

bool snapshot_take(Component *c, const Allocator *allocator, Snapshot **snapshot) {
    size_t bytes;
    if (!component_state_bytes(c, &bytes)) return false;
    const bool fits = *snapshot && (*snapshot)->capacity >= bytes;
    Snapshot *taken = fits ? *snapshot : allocate_snapshot(c, allocator, bytes);
    if (!taken) return false;
    if (!component_save(c, taken->state, bytes)) {
        if (!fits) snapshot_free(allocator, taken);
        return false;
    }
    taken->bytes = bytes;
    if (!fits) snapshot_free(allocator, *snapshot);
    *snapshot = taken;
    return true;
}

bool snapshot_restore(Component *c, const Snapshot *snapshot) {
    return component_restore(c, snapshot->state, snapshot->bytes);
}

void snapshot_free(const Allocator *allocator, Snapshot *snapshot) {
    if (!snapshot) return;
    snapshot->mark = NULL;
    allocator->deallocate(snapshot);
}

size_t snapshot_bytes(const Snapshot *snapshot) {
    return snapshot->bytes;
}

bool snapshot_write(Component *c, const Snapshot *snapshot, void *to, size_t bytes) {
    if (bytes < snapshot->bytes)
        return component_error(c, "the buffer is too small for the state; ask for the state's size first");
    memcpy(to, snapshot->state, snapshot->bytes);
    return true;
}

bool snapshot_read(Component *c, const Allocator *allocator, const void *from, size_t bytes, Snapshot **snapshot) {
    Snapshot *read = allocate_snapshot(c, allocator, bytes);
    if (!read) return false;
    memcpy(read->state, from, bytes);
    read->bytes = bytes;
    if (!component_is_state(c, read->state, bytes)) {
        snapshot_free(allocator, read);
        return false;
    }
    *snapshot = read;
    return true;
}
