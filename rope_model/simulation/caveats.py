"""What to mind in results that are valid: they are those of the model, and a real rope would do something else.

    left out   the rung computes no torsion, and the rope carries torque; or it is the rigid one
    tangled    the legs touch, or have passed through each other: contact is not in the model

Two straight legs between ends a width apart and a loop of about that width, turned by psi, come as near to each other
as cos(psi / 2) of it: they meet at half a turn, and beyond it they have passed through each other.  Once through,
their clearance is large again; only the count of the yaw tells.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ..parameters import Scene
from .diagnostics import leg_clearance, loop_bottom
from .rungs import carries_torque
from .state import RopeState

#: rad: below, a turned loop brings no legs together
TURNED_FAR = 0.5 * math.pi
_LEFT_OUT = {
    "spatial": "my, swivels, twists, stress.torsion_max and the yaw by torque",
    "planar": "fz, mx, my, swivels, twists, loop.z, loop.yaw and stress.torsion_max",
    "rigid": "fx, fz, moments, swivels, twists, loop.z, loop.yaw, stress.torsion_max and strain energy",
}


def left_out(scene: Scene, state: RopeState) -> str:
    """'' where the rung computes all that the rope does; otherwise which outputs are 0 and no results."""
    rung = state.rung
    if rung == "torsional" or (rung != "rigid" and not carries_torque(scene)):
        return ""
    return (
        f"the {rung} rung computes no {'bending and no ' if rung == 'rigid' else ''}torsion: {_LEFT_OUT[rung]} are 0 "
        "and no results; set model.rung = torsional (1) where they matter"
    )


def tangled(scene: Scene, state: RopeState) -> str:
    """'' while the legs hang free of each other; otherwise how they do not."""
    q, lengths = state.motion.q, state.partition.lengths
    across = q[-1] - q[0]
    yaw = state.loop_yaw - math.atan2(-across[2], across[0])
    cure = "contact is not computed, and a real rope would lie against itself; lower Qb, Qc or installed_twist, free"
    cure += " the swivels, or widen the spacing"
    if abs(yaw) > math.pi:
        return (
            f"the rope's legs have passed through each other: the loop has yawed by {yaw:.3g} rad against its ends, "
            f"and legs cross at half a turn; {cure}"
        )
    if abs(yaw) > TURNED_FAR:
        clearance = leg_clearance(q, lengths, loop_bottom(q, lengths), scene.rope.diameter, scene.layout.spacing)
        if clearance <= 0:
            return (
                f"the rope's legs touch (loop.clearance = {clearance:.3g} m) with the loop yawed by {yaw:.3g} rad; "
                f"{cure}"
            )
    return ""


#: each tells of one thing, in the order of rope_caveat in rope.h
CAVEATS: tuple[Callable[[Scene, RopeState], str], ...] = (left_out, tangled)
