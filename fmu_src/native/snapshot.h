/* States of a component as objects that a host holds, and as bytes that it keeps. */
#ifndef SNAPSHOT_H
#define SNAPSHOT_H

#include "component.h"

typedef struct Snapshot Snapshot;

/* return as the functions of component.h */

/* whether it is a snapshot of this FMU that was not freed, and not NULL */
int snapshot_given(Component *c, const Snapshot *snapshot);
/* *snapshot: NULL for a new one, or one of this FMU to write over */
int snapshot_take(Component *c, const Allocator *allocator, Snapshot **snapshot);
int snapshot_restore(Component *c, const Snapshot *snapshot);
void snapshot_free(const Allocator *allocator, Snapshot *snapshot);

size_t snapshot_bytes(const Snapshot *snapshot);
int snapshot_write(Component *c, const Snapshot *snapshot, void *to, size_t bytes);
/* a new snapshot from bytes that snapshot_write wrote, in any process */
int snapshot_read(Component *c, const Allocator *allocator, const void *from, size_t bytes, Snapshot **snapshot);

#endif
