/* Values of a component by value reference.  Functions return as those of component.h. */
#ifndef VALUES_H
#define VALUES_H

#include "component.h"

/* Find the scalars of a variable: *length from *first on. */
bool component_find(Component *c, unsigned reference, Kind kind, size_t *first, size_t *length);
bool component_get(Component *c, size_t scalar, double *value);
bool component_get_text(Component *c, size_t scalar, const char **text);
/* Set a time derivative of an input: the value of the input that is this derivative, unless the host has set that.
   Where it gives speeds so, and neither accelerations nor their derivatives, those of the end follow by differences. */
bool component_set_rate(Component *c, size_t scalar, int order, double value);
/* Set an entry; refuse values that are not finite or no choice, and fixed entries after initialisation. */
bool component_set(Component *c, size_t scalar, double value);

/* sensitivity (unknowns): derivatives of the unknowns with respect to the knowns, times seed (knowns) */
bool component_derivative(Component *c, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns,
                          const double *seed, double *sensitivity);

/* True if an entry can have the value; else the reason is written. */
bool entry_fits(const Variable *variable, double value, char reason[MESSAGE_BYTES]);

#endif
