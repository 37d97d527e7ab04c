/* Stick and slip of the swivels. */
#ifndef SWITCHING_H
#define SWITCHING_H

#include <stdbool.h>

#include "generalized_alpha.h"
#include "state_structures.h"

/* Phases of both swivels, and the senses of their slips. */
typedef struct {
    signed char phase[2], sign[2];
} Phases;

void release_swivels(Simulator *sim, State *state);
double next_release(const Scene *scene, const State *state);
/* Shorten the trial to end where a swivel must switch.  Return 1 if it was shortened, 0 if not, -1 on failure. */
int switching_step(Simulator *sim, State *state, StepResult *trial);
void switch_swivels(Simulator *sim, State *state);
Phases phases_of(const State *state);
/* Set the phases of swivels, which hold where they are, and restart unless nothing changes. */
void set_phases(Simulator *sim, State *state, const Phases *phases);
bool chatters(const State *state);

#endif
