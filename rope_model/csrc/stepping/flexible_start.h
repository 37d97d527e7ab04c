/* Transition from the rigid rope to a flexible one. */
#ifndef FLEXIBLE_START_H
#define FLEXIBLE_START_H

#include "state_structures.h"

/* Set q, v, a and reaction from equilibria between the moving ends, referred to the rigid rope. */
RopeStatus flexible_start(Simulator *sim, State *state, char *message);

#endif
