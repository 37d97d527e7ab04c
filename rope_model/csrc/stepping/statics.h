/* Static equilibrium. */
#ifndef STATICS_H
#define STATICS_H

#include "state_structures.h"

/* Set q to an equilibrium, reaction to its residual.  Fail if theta turns by over max_turn (rad) at the right end. */
RopeStatus find_equilibrium(Simulator *sim, State *state, double max_turn, char *message);

#endif
