/* The rope at rest.

   Equilibrium at the start: the rope is hung up straight, takes its permanent curvature, then its twist.

   Where the sump's floor is higher than the loop of a rope that hangs freely, the straight rope is laid down on
   it first.

   Its swivels hold. If one that starts relaxed cannot, the rope is hung up again while that one turns against the
   friction of its slip: neither coupling nor installed twist winds up its loop. That friction is below the one
   that holds it at rest. A straight rope at rest carries the same torque all along, so only the swivel with the
   least friction turns. On a curved rope the other may have to turn as well.

   A rope whose ends are not plumb hangs with ends close together; they move apart and lean step by step; it
   relaxes again. */

#include "hang.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "adaptation.h"
#include "curvature.h"
#include "ends.h"
#include "formulas.h"
#include "messages.h"
#include "obstacles.h"
#include "rigid.h"
#include "rope.h"
#include "rope_system.h"
#include "rules.h"
#include "simulator.h"
#include "state.h"
#include "state_structures.h"
#include "statics.h"
#include "trial_step.h"
#include "wires.h"

/* Bring the state to an equilibrium at rest, with the yaw of its loop. */
static RopeStatus equilibrium_in_frame(Simulator *sim, State *state, double max_turn, char *message) {
    const NodalArrays nodal = state_arrays(state);
    const size_t bytes = sizeof(double) * (size_t)nodal.nodes * DOF;
    const double offset = state->offsets[RIGHT];
    if (!find_equilibrium(sim, state, max_turn, message)) return ROPE_FAILED;
    double *const moving[] = {nodal.v, nodal.a, nodal.b, nodal.a_rate};
    for (size_t k = 0; k < sizeof moving / sizeof *moving; k++) memset(moving[k], 0, bytes);
    state->h = 0;
    rope_energies(sim, state);
    /* A yaw psi of the loop turns the frame of the right end by -2 psi.  This counts full turns. */
    state->loop_yaw -= 0.5 * (state->offsets[RIGHT] - offset);
    update_loop_yaw(state);
    return ROPE_DONE;
}

/* Turn the right end by `step`, and the rope before it in proportion. */
static void add_twist(State *state, double step) {
    const NodalArrays nodal = state_arrays(state);
    state->offsets[RIGHT] += step;
    for (int k = 0; k < nodal.nodes; k++)
        nodal.q[(size_t)k * DOF + ANGLE] += step * (nodal.s[k] / nodal.s[nodal.elements]);
}

/* Add twist in steps, each to an equilibrium.  `spare` has the state before the latest step. */
static RopeStatus turn_in(Simulator *sim, State *state, double twist, char *message) {
    const int64_t *corrections = &sim->search.corrections;
    double left = twist;              /* still to be added */
    double beyond = INFINITY;         /* twist left behind a step that turned the loop too far */
    double size = STATICS_TWIST_STEP; /* of the next step */
    while (left != 0) {
        size = fmin(size, 0.5 * fabs(left - beyond));
        const double step = size < fabs(left) ? copysign(size, twist) : left;
        const bool last = fabs(step) <= STATICS_MIN_TWIST_STEP;
        char why[MESSAGE];
        if (*corrections >= STATICS_MAX_TWISTING) {
            say_takes_too_long(why);
            return say_fails_at_twist(message, twist - left, twist, fabs(step), (int)*corrections, why);
        }
        memcpy(sim->spare, state, sim->state_bytes);
        add_twist(state, step);
        if (!equilibrium_in_frame(sim, state, last ? INFINITY : STATICS_MAX_TURN, message)) {
            if (!sim->search.turned) {
                memcpy(why, message, MESSAGE);
                return say_fails_at_twist(message, twist - left, twist, fabs(step), (int)*corrections, why);
            }
            memcpy(state, sim->spare, sim->state_bytes);
            message[0] = '\0';
            beyond = left - step;
            continue;
        }
        const double turn = state->offsets[RIGHT] - sim->spare->offsets[RIGHT] - step;
        left -= step;
        if (fabs(turn) > STATICS_MAX_TURN) state->snap_twist = twist - left;
        size = fmin(2 * fabs(step), STATICS_TWIST_STEP);
        if (last) beyond = INFINITY;
    }
    return ROPE_DONE;
}

static void put_floor(Scene *scene, Obstacles *obstacles, double level) {
    scene->shaft.sump.level = level;
    obstacles->cache.free = 0; /* distances to the floor are others now */
}

/* Let the rope hang freely, and raise the floor to its level in steps, so that the rope is laid down on it.  In the way
   of a rope that hangs freely, the floor would push it up by its legs, to an equilibrium of two compressed bars. */
static RopeStatus lay_down(Simulator *sim, State *state, char *message) {
    const Shaft shaft = sim->scene.shaft;
    const NodalArrays nodal = state_arrays(state);
    const double lowest = nodal.q[(size_t)lowest_node(nodal.nodes, nodal.q) * DOF + UP];
    const double below = shaft.contact.stiffness > 0 ? shaft.sump.level - lowest : 0;
    const int parts = below > 0 ? (int)fmin(ceil(below / STATICS_FLOOR_STEP), STATICS_MAX_FLOOR_STEPS) : 0;
    RopeStatus found = ROPE_DONE;
    for (int k = 0; k < parts && found; k++) {
        put_floor(&sim->scene, sim->obstacles, lowest + below * k / parts);
        found = equilibrium_in_frame(sim, state, INFINITY, message);
        if (found && sim->search.corrections > STATICS_MAX_LAYING) {
            say_not_laid_down(message, (int)sim->search.corrections, below * k / parts, below, shaft.sump.level);
            found = ROPE_FAILED;
        }
    }
    if (parts > 0) put_floor(&sim->scene, sim->obstacles, shaft.sump.level);
    return found && equilibrium_in_frame(sim, state, INFINITY, message);
}

/* Find the equilibrium of the straight rope first, then add its permanent curvature in steps. */
static RopeStatus let_curve(Simulator *sim, State *state, char *message) {
    const Rope whole = sim->scene.rope;
    const int parts = is_curved(sim->reference.curved, &sim->scene.rope, state->fidelity) ? STATICS_CURVATURE_STEPS : 0;
    RopeStatus found = ROPE_DONE;
    for (int k = 0; k <= parts && found; k++) {
        if (parts > 0) sim->scene.rope = partly_curved(&whole, (double)k / parts);
        found = k == 0 ? lay_down(sim, state, message) : equilibrium_in_frame(sim, state, INFINITY, message);
    }
    const double reached = max_curvature(&sim->scene.rope);
    sim->scene.rope = whole;
    if (!found && parts > 0 && reached > 0) {
        char why[MESSAGE];
        memcpy(why, message, MESSAGE);
        say_fails_at_curvature(message, reached, max_curvature(&whole), why);
    }
    return found;
}

/* The rope before it was hung: prescribed motion of the ends, offset and yaw. */
typedef struct {
    double ends[2][3][DOF];
    double offset;
    double yaw;
} Before;

static void untwist(const NodalArrays *nodal, double angle) {
    for (int node = 0; node < nodal->nodes; node++) nodal->q[(size_t)node * DOF + ANGLE] = angle;
}

/* Hang the rope again, without twist, while its end at `side` may turn. */
static RopeStatus hang_while_it_turns(Simulator *sim, State *state, const Before *before, int side, char *message) {
    const NodalArrays nodal = state_arrays(state);
    if (!hanging_guess(nodal.nodes, nodal.s, before->ends[LEFT][0], before->ends[RIGHT][0], nodal.q, message))
        return ROPE_FAILED;
    start_director(state, nodal.q);
    untwist(&nodal, before->ends[side == LEFT ? RIGHT : LEFT][0][ANGLE]);
    state->offsets[RIGHT] = before->offset;
    state->loop_yaw = before->yaw;
    state->snap_twist = 0;
    return let_curve(sim, state, message);
}

/* Return the side of the loosest swivel that starts relaxed, cannot hold and has not slipped (sign 0); -1 for none. */
static int loosest_swivel(const Simulator *sim, State *state, const double sign[2]) {
    const NodalArrays nodal = state_arrays(state);
    int loosest = -1;
    double least = INFINITY;
    for (int side = LEFT; side <= RIGHT; side++) {
        const Swivel *swivel = &sim->scene.swivels[side];
        if (sign[side] != 0 || !swivel_phases_relaxes(swivel, &state->swivels[side], state->t)) continue;
        const double tension = ends_tension(&sim->scene, &nodal, side);
        const double friction = swivel_phases_kinetic_friction(swivel, tension);
        const double moment = end_row(nodal.reaction, nodal.nodes, side)[ANGLE];
        if (!(swivel_phases_beyond_rest(swivel, tension, moment) >= 0 && friction < least)) continue;
        loosest = side;
        least = friction;
    }
    return loosest;
}

/* Let the swivels with a sign slip in its sense. */
static void let_slip(State *state, const double sign[2]) {
    for (int side = LEFT; side <= RIGHT; side++)
        if (sign[side] != 0) state->swivels[side] = (SwivelState){.sign = sign[side], .phase = SLIP};
}

/* Lock the swivels that slip where they are. */
static void lock_slipping(State *state) {
    for (int side = LEFT; side <= RIGHT; side++)
        if (state->swivels[side].phase == SLIP)
            state->swivels[side] = (SwivelState){.angle = swivel_angle(state, side), .phase = LOCKED};
}

/* Let the swivels that start relaxed, and cannot hold, slip to equilibrium, the loosest first; from `before` or NULL.
 */
static RopeStatus relax(Simulator *sim, State *state, const Before *before, char *message) {
    const NodalArrays nodal = state_arrays(state);
    double sign[2] = {0, 0};
    do {
        const int loosest = loosest_swivel(sim, state, sign);
        if (loosest < 0) return ROPE_DONE;
        const bool first = before != NULL && sign[LEFT] == 0 && sign[RIGHT] == 0;
        sign[loosest] = copysign(1, -end_row(nodal.reaction, nodal.nodes, loosest)[ANGLE]);
        let_slip(state, sign);
        const RopeStatus found = first ? hang_while_it_turns(sim, state, before, loosest, message)
                                       : equilibrium_in_frame(sim, state, INFINITY, message);
        if (!found) return ROPE_FAILED;
        lock_slipping(state);
        if (!equilibrium_in_frame(sim, state, INFINITY, message)) return ROPE_FAILED;
    } while (is_curved(sim->reference.curved, &sim->scene.rope, state->fidelity));
    return ROPE_DONE;
}

static RopeStatus hang_in_loop(Simulator *sim, State *state, char *message) {
    const NodalArrays nodal = state_arrays(state);
    Before before = {.offset = state->offsets[RIGHT], .yaw = state->loop_yaw};
    for (int side = LEFT; side <= RIGHT; side++)
        ends_prescribed_motion(&sim->scene, state, side, state->t, before.ends[side]);
    const double first = before.ends[LEFT][0][ANGLE];
    const double twist = before.ends[RIGHT][0][ANGLE] - first;
    untwist(&nodal, first);
    state->offsets[RIGHT] -= twist;
    sim->search.corrections = 0;
    sim->search.solutions = 0;
    return let_curve(sim, state, message) && turn_in(sim, state, twist, message) && relax(sim, state, &before, message);
}

void paths_at_rest(const Scene *scene, State *state, const EndMotion ends[2], double placed) {
    for (int side = LEFT; side <= RIGHT; side++) {
        const double share = fidelity_rules_not_plumb(scene) ? placed : 1;
        const double sense = side ? 1 : -1;
        const EndMotion end = end_conditions_partly_placed(scene, &ends[side], &ends[!side], sense, share);
        state->paths[side] = end_path_at_rest(state->t, &end);
    }
}

RopeStatus hang(Simulator *sim, State *state, const EndMotion ends[2], char *message) {
    const int steps = fidelity_rules_not_plumb(&sim->scene) ? STATICS_PLACING_STEPS : 0;
    RopeStatus found = hang_in_loop(sim, state, message);
    for (int k = 0; k < steps && found; k++) {
        paths_at_rest(&sim->scene, state, ends, (k + 1.0) / STATICS_PLACING_STEPS);
        found = equilibrium_in_frame(sim, state, INFINITY, message);
    }
    return found && (steps == 0 || relax(sim, state, NULL, message));
}

RopeStatus release_free_swivels(Simulator *sim, State *state, char *message) {
    for (int side = LEFT; side <= RIGHT; side++)
        if (sim->scene.swivels[side].mode == FREE_MODE) state->swivels[side].phase = SLIP;
    state->rubs = 0; /* as while the rope was hung up: wires begin at rest without a moment */
    if (!equilibrium_in_frame(sim, state, INFINITY, message)) return ROPE_FAILED;
    if (start_hysteresis(sim->reference.wires, state)) rope_system_refer(sim, state, state_arrays(state).q);
    return ROPE_DONE;
}
