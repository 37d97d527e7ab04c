/* Stick and slip of the swivels. */
#ifndef SWITCHING_H
#define SWITCHING_H

#include <stdbool.h>

#include "communication_step.h"
#include "generalized_alpha.h"
#include "state_structures.h"

void release_swivels(Simulator *sim, State *state);
double next_release(const Scene *scene, const State *state);
/* STAYS: no swivel must switch in a trial.  SWITCHES: one must at its end, to which it was shortened.  NOT_FOUND: the
   step to that instant does not converge. */
typedef enum { STAYS, SWITCHES, NOT_FOUND } Switching;
/* Shorten the trial to end where a swivel must switch. */
Switching switching_step(Simulator *sim, State *state, StepResult *trial);
void switch_swivels(Simulator *sim, State *state);
Phases phases_of(const State *state);
/* Set the phases of swivels, which hold where they are, and restart unless nothing changes. */
void set_phases(Simulator *sim, State *state, const Phases *phases);
bool chatters(const State *state);

#endif
