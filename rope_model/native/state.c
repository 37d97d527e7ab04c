/* The state as one block of bytes. */

#include <string.h>

#include "simulator.h"

Arrays state_arrays(State *state)
{
    const size_t nodes = (size_t)state->elements + 1, size = nodes * DOF;
    double *at = (double *)(state + 1);
    Arrays x;
    x.elements = state->elements;
    x.nodes = (int)nodes;
    x.q = at;
    x.v = at + size;
    x.a = at + 2 * size;
    x.b = at + 3 * size;
    x.a_rate = at + 4 * size;
    x.reaction = at + 5 * size;
    x.lengths = at + 6 * size;
    x.s = x.lengths + state->elements;
    return x;
}

void state_copy(const Simulator *rope, State *to, const State *from)
{
    memcpy(to, from, rope->state_bytes);
}

double ledger_total(const Ledger *ledger)
{
    return ledger->kinetic + ledger->strain + ledger->gravity;
}

void happened(State *state, int what, int which, double kinetic, double potential)
{
    if (state->happened < LOGGED_EVENTS) {
        Event *event = &state->events[state->happened++];
        event->t = state->t;
        event->kinetic = kinetic;
        event->potential = potential;
        event->what = what;
        event->which = which;
    }
}
