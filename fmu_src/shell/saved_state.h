/* The complete state of a component as a block of bytes: entries, mode, status, times, and the model's state.
   Functions return as those of component.h. */
#ifndef SAVED_STATE_H
#define SAVED_STATE_H

#include "component.h"

bool component_state_bytes(Component *c, size_t *bytes);
/* Write the state into `to`, of as many bytes as component_state_bytes gave; leave them unchanged on failure. */
bool component_save(Component *c, void *to, size_t bytes);
/* Go back to a state.  `from` is aligned as by calloc, and may come from any process. */
bool component_restore(Component *c, const void *from, size_t bytes);
bool component_is_state(Component *c, const void *from, size_t bytes); /* Refuse what component_restore cannot read. */

#endif
