/* Transition from the rigid rope to a flexible one.

   The flexible rope starts from the equilibrium between the ends of that instant and moves with it. */

#include "flexible_start.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "rope.h"
#include "rope_system.h"
#include "simulator.h"
#include "state_structures.h"
#include "statics.h"

/* Refer theta of an equilibrium q, which is referred to q, to the rigid rope. */
static void count_from_rigid(Simulator *sim, State *state, const double *rigid, double *q) {
    const size_t size = (size_t)(state->elements + 1) * DOF;
    double *moved = sim->work.trial.q;
    double *zeros = sim->work.trial.v;
    memcpy(moved, q, sizeof(double) * size);
    memset(zeros, 0, sizeof(double) * size);
    rope_system_refer(sim, state, rigid);
    rope_system_transport(sim, state, moved, zeros, zeros, zeros);
    for (size_t i = ANGLE; i < size; i += DOF) q[i] -= moved[i] - q[i];
}

RopeStatus flexible_start(Simulator *sim, State *state, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const size_t size = (size_t)nodal.nodes * DOF;
    const size_t bytes = sizeof(double) * size;
    const double t = state->t;
    const double offset = state->offsets[RIGHT];
    /* b and a_rate are scratch until the restart. */
    double *q = nodal.b;
    double *reaction = nodal.a_rate;
    double *const all[3] = {nodal.q, nodal.v, nodal.a};
    const EndPath paths[2] = {state->paths[LEFT], state->paths[RIGHT]};
    double director[3];
    memcpy(director, state->director, sizeof director);
    memcpy(sim->spare, state, sim->state_bytes);
    const double *rigid = state_arrays(sim->spare).q;
    for (int side = LEFT; side <= RIGHT; side++)
        state->paths[side] = end_path_at_constant_acceleration(&paths[side], t);
    sim->search.corrections = sim->search.solutions = 0;
    RopeStatus found = find_equilibrium(sim, state, INFINITY, message);
    const double turned = state->offsets[RIGHT];
    memcpy(q, nodal.q, bytes);
    memcpy(reaction, nodal.reaction, bytes);
    for (int k = 1; k < 3 && found; k++) { /* equilibria just before and after t */
        state->t = k == 1 ? t - STEPPING_DIFFERENCE : t + STEPPING_DIFFERENCE;
        state->offsets[RIGHT] = turned;
        memcpy(nodal.q, q, bytes);
        found = find_equilibrium(sim, state, INFINITY, message);
        memcpy(all[k], nodal.q, bytes);
    }
    state->t = t;
    state->offsets[RIGHT] = offset;
    memcpy(state->paths, paths, sizeof paths);
    memcpy(nodal.q, q, bytes);
    memcpy(nodal.reaction, reaction, bytes);
    for (int k = 0; k < 3 && found; k++) count_from_rigid(sim, state, rigid, all[k]);
    memcpy(state->director, director, sizeof director);
    rope_system_refer(sim, state, rigid);
    for (size_t i = 0; i < size; i++) {
        const double before = nodal.v[i];
        const double after = nodal.a[i];
        nodal.v[i] = (after - before) / (2 * STEPPING_DIFFERENCE);
        nodal.a[i] = (after - 2 * nodal.q[i] + before) / (STEPPING_DIFFERENCE * STEPPING_DIFFERENCE);
    }
    return found;
}
