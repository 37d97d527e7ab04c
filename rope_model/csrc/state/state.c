/* Fields and events of the state. Formulas and tables: rope_model/state.py. */

#include "state.h"

#include <stddef.h>
#include <string.h>

#include "rope.h"
#include "state_structures.h"

void record_event(State *state, int what, int which, double kinetic, double potential) {
    if (state->event_count == LOGGED_EVENTS) return;
    state->events[state->event_count++] =
        (Event){.t = state->t, .kinetic = kinetic, .potential = potential, .what = what, .which = which};
}

void copy_fields(const NodalArrays *to, const NodalArrays *from) {
    const size_t bytes = sizeof(double) * DOF * (size_t)from->nodes;
    memcpy(to->q, from->q, bytes);
    memcpy(to->v, from->v, bytes);
    memcpy(to->a, from->a, bytes);
    memcpy(to->b, from->b, bytes);
    memcpy(to->a_rate, from->a_rate, bytes);
    memcpy(to->reaction, from->reaction, bytes);
}
