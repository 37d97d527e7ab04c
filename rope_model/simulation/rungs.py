"""No more model than the scene needs: which rung of the model serves, and why.

    torsional   the complete rope
    spatial     no torsion: the same for a rope that carries no torque
    planar      the same for a rope that carries no torque and stays in the plane
    rigid       no waves, no bending: closed-form end forces of an inextensible rope, see simulation.rigid

A torque-free rope has no coupling and no installed twist, and its ends turn freely or do not turn at all.  What a
rung leaves out is then zero in the complete model too.  ``rigid`` is never the same; 'auto' takes it only when its
estimated error is within the scene's force tolerance.
"""

from __future__ import annotations

import logging
from typing import Literal, NamedTuple

from ..parameters import Scene
from ..physics.element import Rung
from .ends import SIDES, EndMotion

log = logging.getLogger(__name__)

RungName = Literal["torsional", "spatial", "planar", "rigid"]


class Choice(NamedTuple):
    """A rung and why it was taken."""

    rung: RungName
    reason: str


def flexible(rung: RungName) -> Rung:
    """The element's rung that shows a rope of ``rung``."""
    return "planar" if rung == "rigid" else rung


def chosen(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Choice:
    """The rung that the scene asks for, or the lowest that serves."""
    if scene.model.rung != "auto":
        return Choice(scene.model.rung, "as asked for")
    choice = _lowest(scene, ends)
    log.info("model: %s, because %s", *choice)
    return choice


def outgrown(scene: Scene, rung: RungName, ends: tuple[EndMotion, EndMotion]) -> str:
    """'' while ``rung`` can follow the ends; otherwise what it cannot."""
    if rung == "torsional":
        return ""
    turned = "" if _turns_freely(scene) else _moved(ends, ("yaw", "yaw_rate"))
    if rung == "spatial":
        return turned
    return turned or _moved(ends, ("z", "vz", "az"))


def _lowest(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Choice:
    if why := _torque(scene) or outgrown(scene, "spatial", ends):
        return Choice("torsional", why)
    if why := outgrown(scene, "planar", ends):
        return Choice("spatial", f"no torque acts, but {why}")
    return Choice("planar", "no torque acts and nothing acts out of plane")


def _torque(scene: Scene) -> str:
    """'' for a rope that carries no torque while its ends do not turn; otherwise why it does."""
    rope = scene.rope
    if rope.Qs or rope.Qk:
        return f"tension and torsion are coupled (Qb = {rope.Qb:g}, Qc = {rope.Qc:g} N m)"
    if rope.installed_twist and not _turns_freely(scene):
        return f"the rope is twisted by {rope.installed_twist:g} rad"
    return ""


def _turns_freely(scene: Scene) -> bool:
    return all(swivel.mode == "free" and swivel.release_time <= 0 for swivel in (scene.left, scene.right))


def _moved(ends: tuple[EndMotion, EndMotion], names: tuple[str, ...]) -> str:
    for side, end in zip(SIDES, ends, strict=True):
        for name in names:
            if value := getattr(end, name):
                return f"{side}.{name} = {value:g}"
    return ""
