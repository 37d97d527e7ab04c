/* The rope at rest. */
#ifndef HANG_H
#define HANG_H

#include "state_structures.h"

/* Hang the rope at rest, untwisted; then twist it, relax it, and move the ends to `ends`. */
RopeStatus hang(Simulator *sim, State *state, const EndMotion ends[2], char *message);
/* Release the free swivels of a rope at rest, and bring it to rest again. */
RopeStatus release_free_swivels(Simulator *sim, State *state, char *message);
/* Set paths at rest, a fraction `placed` of the way to `ends`. */
void paths_at_rest(const Scene *scene, State *state, const EndMotion ends[2], double placed);

#endif
