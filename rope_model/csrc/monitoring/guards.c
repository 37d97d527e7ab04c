/* Guarded quantities of the present rope, for physics.guard. */

#include "guards.h"

#include <math.h>
#include <stddef.h>

#include "ends.h"
#include "formulas.h"
#include "loop.h"
#include "rope.h"
#include "shaft.h"
#include "state.h"
#include "state_structures.h"

double guards_rise(const Scene *scene, const State *state, const NodalArrays *nodal, const LoopBottom *bottom) {
    const double left = nodal->q[UP];
    const double right = end_row(nodal->q, nodal->nodes, RIGHT)[UP];
    return guard_loop_height(&scene->rope, &scene->layout, bottom->position[UP], left, right) - state->guard.rest;
}

/* Return the distance of the lowest point from the middle between the ends; with a window, that of a leg from plumb. */
static double guards_sideways(const NodalArrays *nodal, double height, const LoopBottom *bottom) {
    const double *last = end_row(nodal->q, nodal->nodes, RIGHT);
    const double *lowest = nodal->q + (size_t)lowest_node(nodal->nodes, nodal->q) * DOF;
    double farthest = 0;
    if (height <= -FAR) return guard_sideways(bottom->position, nodal->q, last);
    for (const double *a = nodal->q; a < last; a += DOF)
        if ((a[UP] < height) != (a[DOF + UP] < height))
            farthest = maximum(farthest, guard_off_plumb(height, a, a + DOF, a < lowest ? nodal->q : last));
    return farthest;
}

void set_rise_reference(const Scene *scene, State *state) {
    const NodalArrays nodal = state_arrays(state);
    const LoopBottom bottom = loop_bottom(nodal.nodes, nodal.q, nodal.s);
    state->guard = (GuardState){0};
    for (int guard = 0; guard < GUARDS; guard++) state->guard.since[guard] = GUARD_NEVER;
    state->guard.rest = guards_rise(scene, state, &nodal, &bottom);
}

void update_guards(const Scene *scene, State *state) {
    const Guard *guard = &scene->shaft.guard;
    if (guard_any_threshold(guard) == 0) return;
    const NodalArrays nodal = state_arrays(state);
    const LoopBottom bottom = loop_bottom(nodal.nodes, nodal.q, nodal.s);
    Nearest nearest[KINDS];
    double clearance = guard->clearance;
    double torque = 0;
    for (int kind = 0; kind < KINDS; kind++) nearest[kind] = (Nearest){.clearance = guard->clearance};
    shaft_nearer(scene, &nodal, state->t, nearest);
    for (int kind = 0; kind < KINDS; kind++) clearance = minimum(clearance, nearest[kind].clearance);
    for (int side = LEFT; side <= RIGHT; side++)
        torque = maximum(torque, fabs(ends_moment(scene, state, &nodal, side)));
    const double quantities[GUARDS] = {
        guard->rise_y <= -FAR ? guards_rise(scene, state, &nodal, &bottom) : bottom.position[UP] - guard->rise_y,
        guards_sideways(&nodal, guard->window_y, &bottom),
        clearance,
        fabs(centreline_turns(centreline_nearest_turn(bottom.yaw, state->loop_yaw), ends_yaw(&nodal),
                              state->crossing.net)),
        torque,
    };
    state->guard = guard_watch(guard, &state->guard, state->t, quantities);
}
