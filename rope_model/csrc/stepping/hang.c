/* The rope at rest: rope_model.simulation.stepping.hang, which see. */

#include "messages.h"
#include "simulator.h"

/* the state at rest in equilibrium */
static int equilibrium_in_frame(Simulator *rope, State *state, double most_turn, char *message) {
    const Arrays m = state_arrays(state);
    const size_t bytes = sizeof(double) * (size_t)m.nodes * DOF;
    const double offset = state->offsets[RIGHT];
    if (!find_equilibrium(rope, state, most_turn, message)) return 0;
    memset(m.v, 0, (FIELDS - 2) * bytes); /* all but q and the reaction */
    state->h = 0;
    model_energies(rope, state);
    /* a loop that yaws by psi turns the frame of the right end by -2 psi: which tells full turns on a long way */
    state->loop_yaw -= 0.5 * (state->offsets[RIGHT] - offset);
    with_loop_yaw(state);
    return 1;
}

/* the state at rest with so much more twist, put in so slowly that the speed does not matter; spare is where it was
   last */
static int turn_in(Simulator *rope, State *state, double twist, char *message) {
    const Arrays m = state_arrays(state);
    double left = twist, beyond = INFINITY, size = TWIST_STEP;
    while (left != 0) {
        size = fmin(size, 0.5 * fabs(left - beyond));
        const double step = size < fabs(left) ? copysign(size, twist) : left;
        const int last = fabs(step) <= LEAST_TWIST_STEP;
        char why[MESSAGE];
        if (rope->corrections >= MOST_CORRECTIONS) {
            say_takes_too_long(why);
            return say_fails_at_twist(message, twist - left, twist, fabs(step), (int)rope->corrections, why);
        }
        state_copy(rope, rope->spare, state);
        state->offsets[RIGHT] += step;
        for (int k = 0; k < m.nodes; k++) m.q[(size_t)k * DOF + ANGLE] += step * (m.s[k] / m.s[m.elements]);
        if (!equilibrium_in_frame(rope, state, last ? INFINITY : MOST_TURN, message)) {
            if (!rope->turned) {
                memcpy(why, message, MESSAGE);
                return say_fails_at_twist(message, twist - left, twist, fabs(step), (int)rope->corrections, why);
            }
            state_copy(rope, state, rope->spare);
            message[0] = '\0';
            beyond = left - step;
            continue;
        }
        const double turn = state->offsets[RIGHT] - rope->spare->offsets[RIGHT] - step;
        left -= step;
        if (fabs(turn) > MOST_TURN) state->snapped_at = twist - left;
        size = fmin(2 * fabs(step), TWIST_STEP);
        if (last) beyond = INFINITY;
    }
    return 1;
}

/* the state at rest, its rope straight first and then curved by and by */
static int let_curve(Simulator *rope, State *state, char *message) {
    const double k0 = rope->scene.rope.initial_curvature;
    const int parts = is_curved(rope, state) ? CURVATURE_STEPS : 0;
    int found = 1;
    for (int k = 0; k <= parts && found; k++) {
        if (parts > 0) rope->scene.rope.initial_curvature = k0 * k / parts;
        found = equilibrium_in_frame(rope, state, INFINITY, message);
    }
    const double reached = rope->scene.rope.initial_curvature;
    rope->scene.rope.initial_curvature = k0;
    if (!found && parts > 0 && reached > 0) {
        char why[MESSAGE];
        memcpy(why, message, MESSAGE);
        say_fails_at_curvature(message, reached, k0, why);
    }
    return found;
}

int hang(Simulator *rope, State *state, char *message) {
    const Arrays m = state_arrays(state);
    double left[3][DOF], right[3][DOF];
    ends_prescribed_motion(&rope->scene, state, LEFT, state->t, left);
    ends_prescribed_motion(&rope->scene, state, RIGHT, state->t, right);
    for (int node = 0; node < m.nodes; node++) m.q[(size_t)node * DOF + ANGLE] = left[0][ANGLE];
    const double twist = right[0][ANGLE] - left[0][ANGLE];
    state->offsets[RIGHT] -= twist;
    rope->corrections = 0;
    return let_curve(rope, state, message) && turn_in(rope, state, twist, message);
}
