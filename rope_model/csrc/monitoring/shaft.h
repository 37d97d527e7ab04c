/* Clearances of the rope from the bodies of its scene, and its passages through itself. */
#ifndef SHAFT_H
#define SHAFT_H

#include "formulas.h"
#include "self_contact.h"
#include "state_structures.h"

static inline void far_bodies(Nearest nearest[KINDS]) {
    for (int kind = 0; kind < KINDS; kind++) nearest[kind] = (Nearest){.clearance = FAR};
}
/* Find the place of the rope nearest to the bodies of each kind. */
void shaft_clearances(const Scene *scene, const NodalArrays *arrays, double t, Nearest nearest[KINDS]);
/* Update `nearest` where the rope is nearer. */
void shaft_nearer(const Scene *scene, const NodalArrays *arrays, double t, Nearest nearest[KINDS]);
/* Record clearances and passages of the rope at the state's time. */
void update_passages(const Scene *scene, SelfContactState *self_contact, State *state);

#endif
