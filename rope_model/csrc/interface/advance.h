/* Acceptance of a new state. */
#ifndef ADVANCE_H
#define ADVANCE_H

#include "rope.h"

/* Make `next` the state; its outputs are to be computed anew. */
RopeStatus accept_next(Simulator *sim);

#endif
