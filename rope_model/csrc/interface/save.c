/* Saved states.

   Their bytes are the state, the state before the step that led to it, and what the host asked for in that step. */

#include <stddef.h>
#include <string.h>

#include "advance.h"
#include "communication_step.h"
#include "messages.h"
#include "plausibility.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"

size_t rope_state_bytes(const Simulator *sim) {
    return 2 * sim->state_bytes + sizeof sim->last;
}

void rope_save(const Simulator *sim, void *to) {
    char *bytes = to;
    memcpy(bytes, sim->state, sim->state_bytes);
    memcpy(bytes + sim->state_bytes, sim->last.taken ? sim->start : sim->state, sim->state_bytes);
    memcpy(bytes + 2 * sim->state_bytes, &sim->last, sizeof sim->last);
}

RopeStatus rope_restore(Simulator *sim, const void *from, size_t bytes) {
    const char *saved = from;
    State *state = sim->next;
    State *start = sim->spare;
    HostStep last;
    if (bytes != rope_state_bytes(sim))
        return say_wrong_number_of_bytes(sim->message, (int)bytes, (int)rope_state_bytes(sim));
    memcpy(state, saved, sim->state_bytes);
    memcpy(start, saved + sim->state_bytes, sim->state_bytes);
    memcpy(&last, saved + 2 * sim->state_bytes, sizeof last);
    if (!state_plausible(sim, state) ||
        (last.taken && !(state_plausible(sim, start) && host_step_plausible(&last, start, state))))
        return say_no_state_in_bytes(sim->message);
    sim->spare = sim->start;
    sim->start = start;
    sim->last = last;
    rope_system_refer(sim, state, state_arrays(state).q);
    return accept_next(sim);
}
