/* What to mind in results that are valid: the twin of rope_model.simulation.caveats, which see. */
#include <math.h>
#include <stdio.h>

#include "simulator.h"
#include "text.h"

#define TURNED_FAR (0.5 * PI)

static void left_out(Simulator *rope, char *message)
{
    static const char *const zeros[] = {
        "", "", "my, swivels, twists, stress.torsion_max and the yaw by torque",
        "fz, mx, my, swivels, twists, loop.z, loop.yaw and stress.torsion_max",
        "fx, fz, moments, swivels, twists, loop.z, loop.yaw, stress.torsion_max and strain energy"};
    const int rung = rope->state->rung;
    if (rung == TORSIONAL || (rung != RIGID && !rung_carries_torque(&rope->scene)))
        return;
    snprintf(message, MESSAGE,
             "the %s rung computes no %storsion: %s are 0 and no results; set model.rung = torsional (1) where they "
             "matter",
             rung_name(rung), rung == RIGID ? "bending and no " : "", zeros[rung]);
}

static void tangled(Simulator *rope, char *message)
{
    static const char cure[] =
        "contact is not computed, and a real rope would lie against itself; lower Qb, Qc or installed_twist, free the "
        "swivels, or widen the spacing";
    const Arrays m = state_arrays(rope->state);
    const double *left = end_row(m.q, m.nodes, LEFT), *right = end_row(m.q, m.nodes, RIGHT);
    const double yaw = rope->state->loop_yaw - atan2(left[2] - right[2], right[0] - left[0]);
    if (fabs(yaw) > PI)
        snprintf(message, MESSAGE,
                 "the rope's legs have passed through each other: the loop has yawed by %s rad against its ends, and "
                 "legs cross at half a turn; %s",
                 ROUNDED(yaw, 3), cure);
    else if (fabs(yaw) > TURNED_FAR) {
        const double clearance = rope_signal(rope, SIGNAL_LOOP_CLEARANCE);
        if (clearance <= 0)
            snprintf(message, MESSAGE,
                     "the rope's legs touch (loop.clearance = %s m) with the loop yawed by %s rad; %s",
                     ROUNDED(clearance, 3), ROUNDED(yaw, 3), cure);
    }
}

void rope_caveat(Simulator *rope, int number, char *message)
{
    message[0] = '\0';
    if (!rope->initialized)
        return;
    if (number == 0)
        left_out(rope, message);
    else
        tangled(rope, message);
}
