/* What linear models and natural modes take from the present state: the chain's matrix, the frames of its elements, and
   facts about it. */

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "chain.h"
#include "formulas.h"
#include "loop.h"
#include "obstacles.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"
#include "system.h"

/* Return the system of the present state without contact, whose ends are not held: no row of its matrix is cleared. */
static System free_system(const Simulator *sim) {
    System sys = rope_system(sim, sim->state);
    sys.obstacles = NULL;
    sys.self_contact = NULL;
    for (int side = LEFT; side <= RIGHT; side++)
        for (int dof = 0; dof < DOF; dof++) sys.free[side][dof] = true;
    return sys;
}

/* Return the number of values of an element in rope_frames. */
static int frame_size(const System *sys) {
    int size = ELEMENT_FRAME_SIZE;
    if (sys->curved != NULL) size += CURVED_SIZE;
    if (sys->wires != NULL) size += WIRE_ELEMENT_HISTORY_SIZE;
    return size;
}

void rope_linear_facts(Simulator *sim, LinearFacts *facts) {
    const System sys = rope_system(sim, sim->state);
    const NodalArrays nodal = state_arrays(sim->state);
    find_near_bodies(&sys, nodal.q, nodal.v, 0);
    for (int side = LEFT; side <= RIGHT; side++)
        for (int dof = 0; dof < DOF; dof++) facts->free[side][dof] = sys.free[side][dof];
    facts->near_bodies = longest_near(&sys) > 0;
    facts->curved = sys.curved != NULL;
    facts->rubs = sys.wires != NULL;
    facts->frame_size = frame_size(&sys);
    facts->lowest_s = loop_bottom(nodal.nodes, nodal.q, nodal.s).s;
}

/* Copy `count` numbers of each element behind the first `begin` numbers of its row. */
static void copy_columns(int elements, const double *from, size_t count, double *rows, size_t begin, size_t length) {
    for (size_t e = 0; e < (size_t)elements; e++)
        memcpy(rows + e * length + begin, from + e * count, sizeof(double) * count);
}

void rope_frames(Simulator *sim, double *frames) {
    const System sys = rope_system(sim, sim->state);
    const size_t length = (size_t)frame_size(&sys);
    size_t begin = ELEMENT_FRAME_SIZE;
    chain_of(sim, sim->state)->frame_rows(&sys, length, frames);
    if (sys.curved != NULL) {
        copy_columns(sys.elements, sys.curved, CURVED_SIZE, frames, begin, length);
        begin += CURVED_SIZE;
    }
    if (sys.wires != NULL) copy_columns(sys.elements, sys.wires, WIRE_ELEMENT_HISTORY_SIZE, frames, begin, length);
}

void rope_tangent(Simulator *sim, const TangentCoefficients *c, double (*nodes)[DOF][DOF], double (*next)[DOF][DOF]) {
    const System sys = free_system(sim);
    const Chain *torsional = sim->chains;
    const NodalArrays nodal = state_arrays(sim->state);
    if (sim->state->fidelity != TORSIONAL) torsional->refer(&sys, nodal.q); /* which has no frames of its own */
    torsional->blocks(&sys, sim->work.chain, nodal.q, nodal.v, nodal.a, c, nodes, next);
    nodes[0][ANGLE][ANGLE] += c->a * sys.inertia[LEFT];
    nodes[sys.elements][ANGLE][ANGLE] += c->a * sys.inertia[RIGHT];
}
