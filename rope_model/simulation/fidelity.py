"""No more model than the scene needs: which fidelity of the model serves, and why.

    torsional   the complete rope
    spatial     no torsion: the same for a rope without torque, but for spin inertia and theta's interpolation
    planar      the same for a rope that carries no torque and stays in the plane
    rigid       no waves, no bending: closed-form end forces of an inextensible rope, see simulation.rigid

A torque-free rope has no coupling and no installed twist.  Out of plane its swivels must turn freely as well, or its
writhe twists it; they hold while the rope is initialised, so the run must start in the plane.  What a simplified model
leaves out is then zero in the complete model too.  Beyond that 'auto' takes one only when the error of the vertical
end forces (root mean square over a winding, relative to the largest) is estimated within the scene's force tolerance.
  physics.estimates has the estimates.
"""

from __future__ import annotations

import logging
import math
from typing import Literal, NamedTuple

from ..parameters import Scene
from ..physics.element import ElementFidelity
from ..physics.estimates import (
    LARGEST_YAW,
    Travel,
    held_error,
    lean_error,
    longitudinal_error,
    loop_yaw,
    release_error,
    travel_estimate,
)
from ..physics.guard import guarded
from . import messages
from .bodies import may_touch
from .paths import SIDES, EndMotion
from .rigid import lowest_tension

log = logging.getLogger(__name__)

Fidelity = Literal["torsional", "spatial", "planar", "rigid"]

#: from the least model to the complete one
FIDELITIES: tuple[Fidelity, ...] = ("rigid", "planar", "spatial", "torsional")
#: inputs that act out of the plane, and that turn a rope whose swivels hold
OUT_OF_PLANE, TURNED = ("z", "vz", "az"), ("yaw", "yaw_rate")


class Choice(NamedTuple):
    """A fidelity and why it was taken."""

    fidelity: Fidelity
    reason: str


def flexible(fidelity: Fidelity) -> ElementFidelity:
    """The element's fidelity that shows a rope of ``fidelity``."""
    return "planar" if fidelity == "rigid" else fidelity


def choose_fidelity(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Choice:
    """The fidelity that the scene asks for, or the lowest that serves."""
    if scene.model.fidelity != "auto":
        return Choice(scene.model.fidelity, messages.as_asked())
    choice = _lowest(scene, ends)
    log.info("model: %s, because %s", *choice)
    return choice


def lowest_sufficient(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Fidelity:
    """The lowest fidelity that can follow the ends."""
    return next(fidelity for fidelity in FIDELITIES if not unsupported_motion(scene, fidelity, ends))


def unsupported_motion(scene: Scene, fidelity: Fidelity, ends: tuple[EndMotion, EndMotion]) -> str:
    """'' while ``fidelity`` can follow the ends, for 'auto' within the tolerance; otherwise what it cannot."""
    if fidelity == "torsional":
        return ""
    why = "" if _turns_freely(scene) else _nonzero_input(ends, TURNED)
    if fidelity != "spatial":
        why = why or _nonzero_input(ends, OUT_OF_PLANE)
    if fidelity == "rigid":
        why = why or _nonzero_input(ends, ("vx", "ax"))
    if why or scene.model.fidelity != "auto":
        return why
    if fidelity == "spatial" and not _turns_freely(scene) and (why := _nonzero_input(ends, OUT_OF_PLANE)):
        return messages.while_swivels_hold(why)
    error, tolerance = force_error(scene, fidelity, expected_travel(ends)), scene.model.force_tolerance
    if error > tolerance:
        return messages.errs_too_much(100 * tolerance, 100 * error)
    if fidelity == "rigid" and (tension := lowest_tension(scene, ends)) < 0:
        return messages.would_go_slack(tension)
    return ""


def expected_travel(ends: tuple[EndMotion, EndMotion]) -> Travel:
    """What to expect of ends that move like this now."""
    speed, acceleration = (max(abs(x) for x in pair) for pair in zip(*((end.vy, end.ay) for end in ends), strict=True))
    return travel_estimate(abs(ends[0].y - ends[1].y), speed, acceleration)


def force_error(scene: Scene, fidelity: Fidelity, travel: Travel) -> float:
    """Estimated error of the vertical end forces against the complete model; inf where the loop may turn far."""
    error = 0.0
    if fidelity != "torsional" and _torque(scene):
        if loop_yaw(scene) > LARGEST_YAW:
            return math.inf
        error += held_error(scene, travel)
        if not scene.left.mode == scene.right.mode == "locked":
            error += release_error(scene, travel)
    if fidelity == "rigid":
        error += longitudinal_error(scene, travel) + lean_error(scene, travel)
    return error


def _lowest(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Choice:
    if may_touch(scene.shaft):
        return Choice("torsional", messages.may_touch())
    if guarded(scene.shaft.guard):
        return Choice("torsional", messages.guards_watch())
    if scene.shaft.air.density > 0:
        return Choice("torsional", messages.in_air())
    if why := _nonzero_input(ends, OUT_OF_PLANE + TURNED):
        return Choice("torsional", messages.held_where_initialised(why))
    fidelity = lowest_sufficient(scene, ends) if scene.model.force_tolerance > 0 else "torsional"
    if not (torque := _torque(scene)) and fidelity != "rigid":
        return Choice("planar", messages.no_torque())
    if fidelity == "torsional":
        below = unsupported_motion(scene, "spatial", ends) if scene.model.force_tolerance > 0 else ""
        return Choice(fidelity, messages.torque_and_more(torque, below) if below else torque)
    travel, tolerance = expected_travel(ends), scene.model.force_tolerance
    error = force_error(scene, fidelity, travel)
    return Choice(fidelity, messages.errs_little(fidelity, 100 * error, 100 * tolerance, *travel[1:]))


def _torque(scene: Scene) -> str:
    """'' for a rope that carries no torque in the plane while its ends do not turn; otherwise why it does."""
    rope = scene.rope
    if rope.Qs or rope.Qk:
        return messages.coupled(rope.Qb, rope.Qc)
    if rope.installed_twist:
        return messages.twisted(rope.installed_twist)
    return ""


def carries_torque(scene: Scene) -> bool:
    """Whether the rope carries torque even in the plane."""
    return bool(_torque(scene))


def _turns_freely(scene: Scene) -> bool:
    return all(swivel.mode == "free" and swivel.release_time <= 0 for swivel in (scene.left, scene.right))


def _nonzero_input(ends: tuple[EndMotion, EndMotion], names: tuple[str, ...]) -> str:
    for side, end in zip(SIDES, ends, strict=True):
        for name in names:
            if value := getattr(end, name):
                return messages.nonzero_input(side, name, value)
    return ""
