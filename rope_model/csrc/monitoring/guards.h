/* Guarded quantities of the present rope. */
#ifndef GUARDS_H
#define GUARDS_H

#include "loop.h"
#include "state_structures.h"

/* Return the height of the loop's bottom above its quasi-static position, m. */
double guards_rise(const Scene *scene, const State *state, const NodalArrays *arrays, const LoopBottom *bottom);
void set_rise_reference(const Scene *scene, State *state); /* Reset the guards of a rope at rest. */
void update_guards(const Scene *scene, State *state);      /* Update the guards at the state's time. */

#endif
