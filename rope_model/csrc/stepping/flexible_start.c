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

/* Find the equilibria at the state's time, and just before and after it.  They are left in q, v and a, and the
   reactions are those at its time.  b and a_rate are scratch until the restart. */
static RopeStatus find_equilibria_around(Simulator *sim, State *state, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const size_t bytes = sizeof(double) * DOF * (size_t)nodal.nodes;
    const double t = state->t;
    if (!find_equilibrium(sim, state, INFINITY, message)) return ROPE_FAILED;
    const double turned = state->offsets[RIGHT];
    memcpy(nodal.b, nodal.q, bytes);
    memcpy(nodal.a_rate, nodal.reaction, bytes);

    state->t = t - STEPPING_DIFFERENCE;
    if (!find_equilibrium(sim, state, INFINITY, message)) return ROPE_FAILED;
    memcpy(nodal.v, nodal.q, bytes);
    memcpy(nodal.q, nodal.b, bytes);
    state->offsets[RIGHT] = turned;

    state->t = t + STEPPING_DIFFERENCE;
    if (!find_equilibrium(sim, state, INFINITY, message)) return ROPE_FAILED;
    memcpy(nodal.a, nodal.q, bytes);
    memcpy(nodal.q, nodal.b, bytes);
    memcpy(nodal.reaction, nodal.a_rate, bytes);
    state->t = t;
    return ROPE_DONE;
}

/* Replace the shapes before and after q, in v and a, by the velocity and the acceleration. */
static void differentiate(const NodalArrays *nodal) {
    const size_t size = (size_t)nodal->nodes * DOF;
    for (size_t i = 0; i < size; i++) {
        const double before = nodal->v[i];
        const double after = nodal->a[i];
        nodal->v[i] = (after - before) / (2 * STEPPING_DIFFERENCE);
        nodal->a[i] = (after - 2 * nodal->q[i] + before) / (STEPPING_DIFFERENCE * STEPPING_DIFFERENCE);
    }
}

RopeStatus flexible_start(Simulator *sim, State *state, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const double offset = state->offsets[RIGHT];
    const EndPath paths[2] = {state->paths[LEFT], state->paths[RIGHT]};
    double director[3];
    memcpy(director, state->director, sizeof director);
    memcpy(sim->spare, state, sim->state_bytes);
    for (int side = LEFT; side <= RIGHT; side++)
        state->paths[side] = end_path_at_constant_acceleration(&paths[side], state->t);
    sim->search.corrections = 0;
    sim->search.solutions = 0;
    if (!find_equilibria_around(sim, state, message)) return ROPE_FAILED;
    state->offsets[RIGHT] = offset;
    memcpy(state->paths, paths, sizeof paths);
    double *const shapes[3] = {nodal.q, nodal.v, nodal.a};
    const double *rigid = state_arrays(sim->spare).q;
    for (int k = 0; k < 3; k++) count_from_rigid(sim, state, rigid, shapes[k]);
    memcpy(state->director, director, sizeof director);
    rope_system_refer(sim, state, rigid);
    differentiate(&nodal);
    return ROPE_DONE;
}
