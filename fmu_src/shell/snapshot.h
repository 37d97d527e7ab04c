/* States of a component, as objects and as bytes of a host.  Functions return as those of component.h. */
#ifndef SNAPSHOT_H
#define SNAPSHOT_H

#include "component.h"

typedef struct Snapshot Snapshot;

/* Refuse NULL, and what is not a snapshot of this FMU or was freed. */
bool snapshot_check(Component *c, const Snapshot *snapshot);
/* Save the state; *snapshot is NULL for a new one, or one to overwrite.  It stays as it was on failure. */
bool snapshot_take(Component *c, const Allocator *allocator, Snapshot **snapshot);
bool snapshot_restore(Component *c, const Snapshot *snapshot);
void snapshot_free(const Allocator *allocator, Snapshot *snapshot);

size_t snapshot_bytes(const Snapshot *snapshot);
bool snapshot_write(Component *c, const Snapshot *snapshot, void *to, size_t bytes);
/* Create a snapshot from the bytes of snapshot_write. */
bool snapshot_read(Component *c, const Allocator *allocator, const void *from, size_t bytes, Snapshot **snapshot);

#endif
