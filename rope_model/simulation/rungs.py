"""No more model than the scene needs: which rung of the model serves, and why.

    torsional   the complete rope
    spatial     no torsion: the same for a rope without torque, but for spin inertia and theta's interpolation
    planar      the same for a rope that carries no torque and stays in the plane
    rigid       no waves, no bending: closed-form end forces of an inextensible rope, see simulation.rigid

A torque-free rope has no coupling and no installed twist.  Out of plane its swivels must turn freely as well, or its
writhe twists it; they hold while the rope is hung up, so the run must start in the plane.  What a rung leaves out is
then zero in the complete model too.  Beyond that 'auto' takes a rung only when the error of the
vertical end forces (root mean square over a winding, relative to the largest) is estimated within the scene's force
tolerance.  With W the width of the loop, l the length of a leg, kappa = Qs^2 / (Qa Qd), F = rho g l_long

    longitudinal  a leg answers a step of jerk J by swinging at omega = pi c / (2 l): (8/pi^2) rho l J / (omega F)
    lean          the loop bulges sideways by X, a leg is longer by X^2 / (2 l_short): rho g X^2 / (4 l_short F)
    whip          the flow u carries the loop sideways once rho u^2 exceeds its weight: WHIP (u^2 / g W)^2
    yaw           the uniform torque M turns the loop by psi = 4 M ln(L / 2W) / (rho g W^2); the lean shrinks by psi^2

    release       the torque M let go sends off a torsional wave, which carries the tension Qs M rho / (Qa rhoJ)

    planar or spatial on a rope with torque:   kappa longitudinal + psi^2 lean + whip + release
    rigid against planar:                      longitudinal + lean

Constants that no theory gives are measured; `python -m benchmarks.choice --estimates` compares estimate and error.
"""

from __future__ import annotations

import logging
import math
from typing import Literal, NamedTuple

from ..parameters import Rope, Scene
from ..physics.element import Rung
from .ends import SIDES, EndMotion, EndPath
from .rigid import lowest_tension

log = logging.getLogger(__name__)

RungName = Literal["torsional", "spatial", "planar", "rigid"]

#: from the least model to the complete one
LADDER: tuple[RungName, ...] = ("rigid", "planar", "spatial", "torsional")
#: inputs that act out of the plane, and that turn a rope whose swivels hold
OUT_OF_PLANE, TURNED = ("z", "vz", "az"), ("yaw", "yaw_rate")
#: sideways displacement of the loop's bottom over its natural width: 0.25 to 0.33 measured at 4 m/s, EI 50 to 1000
LEAN = 1 / 3
#: how the lean grows with acceleration / g: 6 to 11 measured at 4 m/s^2 and 16 m/s, none at 0.75 m/s^2
LEAN_GROWTH = 10.0
#: 1.7e-5 to 2.5e-5 measured on the 120 m rope at u^2 / (g W) = 4 to 12
WHIP = 3e-5
#: natural width of a free loop over (EI / rho g)^(1/3)
NATURAL_WIDTH = 2.54307
#: rad: beyond it the loop may turn over; the estimate is 1.2 to 5 times the yaw measured
LARGEST_YAW = 1.0


class Choice(NamedTuple):
    """A rung and why it was taken."""

    rung: RungName
    reason: str


class Travel(NamedTuple):
    """What an estimate needs of a winding: its largest values."""

    height_difference: float  # m
    speed: float  # m/s
    acceleration: float  # m/s^2
    jerk: float  # m/s^3


#: what 'auto' expects of the ends; inputs do not tell the jerk, so it is taken to grow with the acceleration
ASSUMED = Travel(0.0, 10.0, 1.0, 1.0)


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


def lowest_able(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> RungName:
    """The lowest rung that can follow the ends."""
    return next(rung for rung in LADDER if not outgrown(scene, rung, ends))


def ends_after(paths: tuple[EndPath, EndPath]) -> tuple[EndMotion, EndMotion]:
    """The motions in which the ends' paths end."""

    def after(path: EndPath) -> EndMotion:
        x, v, a = path(path.stop).tolist()
        yaw, yaw_rate = x.pop(), v.pop()
        names = ("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az")
        return EndMotion(**dict(zip(names, x + v + a[:3], strict=True)), yaw=yaw, yaw_rate=yaw_rate)

    return after(paths[0]), after(paths[1])


def outgrown(scene: Scene, rung: RungName, ends: tuple[EndMotion, EndMotion]) -> str:
    """'' while ``rung`` can follow the ends, for 'auto' within the tolerance; otherwise what it cannot."""
    if rung == "torsional":
        return ""
    why = "" if _turns_freely(scene) else _moved(ends, TURNED)
    if rung != "spatial":
        why = why or _moved(ends, OUT_OF_PLANE)
    if rung == "rigid":
        why = why or _moved(ends, ("vx", "ax"))
    if why or scene.model.rung != "auto":
        return why
    if rung == "spatial" and not _turns_freely(scene) and (why := _moved(ends, OUT_OF_PLANE)):
        return f"{why} while its swivels hold"
    error, tolerance = force_error(scene, rung, expected(ends)), scene.model.force_tolerance
    if error > tolerance:
        return f"the ends within the tolerance of {100 * tolerance:.3g} %: it errs by an estimated {100 * error:.2g} %"
    if rung == "rigid" and (tension := lowest_tension(scene, ends)) < 0:
        return f"a rope that goes slack (tension {tension:.4g} N)"
    return ""


def expected(ends: tuple[EndMotion, EndMotion]) -> Travel:
    """What 'auto' expects of ends that move like this now: at least what is ASSUMED."""
    speed, acceleration = (max(abs(x) for x in pair) for pair in zip(*((end.vy, end.ay) for end in ends), strict=True))
    growth = max(acceleration / ASSUMED.acceleration, 1.0)
    speed = max(speed, ASSUMED.speed)
    return Travel(abs(ends[0].y - ends[1].y), speed, growth * ASSUMED.acceleration, growth * ASSUMED.jerk)


def force_error(scene: Scene, rung: RungName, travel: Travel) -> float:
    """Estimated error of the vertical end forces against the complete model, see the module; inf: no estimate."""
    error = 0.0
    if rung != "torsional" and _torque(scene):
        error += torsion_error(scene, travel)
    if rung == "rigid":
        error += longitudinal_error(scene, travel) + lean_error(scene, travel)
    return error


def torsion_error(scene: Scene, travel: Travel) -> float:
    """What leaving out the torsion of a rope with torque costs; inf where the torque may turn the loop far."""
    rope = scene.rope
    if (psi := loop_yaw(scene)) > LARGEST_YAW:
        return math.inf
    flow = travel.speed**2 / (scene.layout.gravity * natural_width(scene))
    kappa = rope.Qs**2 / (rope.Qa * rope.Qd)
    held = kappa * longitudinal_error(scene, travel) + psi**2 * lean_error(scene, travel) + WHIP * flow**2
    return held + release_error(scene, travel)


def release_error(scene: Scene, travel: Travel) -> float:
    """The tension of the torsional wave that a released swivel sends off, over the longer leg's weight."""
    if scene.left.mode == scene.right.mode == "locked":
        return 0.0
    rope, g = scene.rope, scene.layout.gravity
    return abs(rope.Qs) * held_torque(rope, g) / (rope.Qa * rope.rhoJ * g * _legs(scene, travel)[0])


def loop_yaw(scene: Scene) -> float:
    """Yaw of the loop (rad) under the torque of a held rope: legs like strings under their own weight."""
    rope, g = scene.rope, scene.layout.gravity
    width = 0.5 * (scene.layout.spacing + natural_width(scene))  # the legs close in from one to the other
    height = max(0.5 * rope.length / width, 1.0)
    return 4 * abs(held_torque(rope, g)) * math.log(height) / (rope.mass_per_length * g * width**2)


def held_torque(rope: Rope, gravity: float) -> float:
    """Torque (N m) of a hanging rope whose ends were fastened unloaded."""
    return coupling_torque(rope, gravity) + twist_torque(rope, rope.installed_twist)


def coupling_torque(rope: Rope, gravity: float) -> float:
    """Size of the torque (N m) that the weight of half the rope makes by the coupling."""
    return abs(rope.Qc / rope.Qa * rope.mass_per_length * gravity * 0.5 * rope.length)


def twist_torque(rope: Rope, angle: float) -> float:
    """Size of the torque (N m) of a rope that is twisted by ``angle`` (rad) from end to end, at constant tension."""
    return abs((rope.Qd - rope.Qb * rope.Qc / rope.Qa) * angle / rope.length)


def longitudinal_error(scene: Scene, travel: Travel) -> float:
    """The first longitudinal mode of the longer leg after a step of the jerk, over the leg's weight."""
    rope = scene.rope
    leg, _ = _legs(scene, travel)
    omega = 0.5 * math.pi * math.sqrt(rope.Qa / rope.mass_per_length) / leg
    return 8 / math.pi**2 * travel.jerk / (omega * scene.layout.gravity)


def lean_error(scene: Scene, travel: Travel) -> float:
    """The length that a leaning leg takes from the other, over the longer leg."""
    long, short = _legs(scene, travel)
    width = max(natural_width(scene), scene.layout.spacing)
    lean = LEAN * width * (1 + LEAN_GROWTH * travel.acceleration / scene.layout.gravity)
    return lean**2 / (4 * short * long)


def natural_width(scene: Scene) -> float:
    """Width (m) of the loop of a rope that hangs from legs wherever they like to be."""
    return NATURAL_WIDTH * math.cbrt(scene.rope.EI / (scene.rope.mass_per_length * scene.layout.gravity))


def _legs(scene: Scene, travel: Travel) -> tuple[float, float]:
    """Lengths (m) of the longer and the shorter leg, the latter at least the loop's spacing."""
    L, H = scene.rope.length, travel.height_difference
    return 0.5 * (L + H), max(0.5 * (L - H), scene.layout.spacing)


def _lowest(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> Choice:
    if why := _moved(ends, OUT_OF_PLANE + TURNED):
        return Choice("torsional", f"{why} where the rope is hung up with its swivels held")
    rung = lowest_able(scene, ends) if scene.model.force_tolerance > 0 else "torsional"
    if not (torque := _torque(scene)) and rung != "rigid":
        return Choice("planar", "no torque acts and nothing acts out of plane")
    if rung == "torsional":
        below = outgrown(scene, "spatial", ends) if scene.model.force_tolerance > 0 else ""
        return Choice(rung, torque + (f"; the spatial rung cannot follow {below}" if below else ""))
    travel, tolerance = expected(ends), scene.model.force_tolerance
    return Choice(
        rung,
        f"the {rung} rung errs by an estimated {100 * force_error(scene, rung, travel):.2g} %, within the tolerance of "
        f"{100 * tolerance:.3g} %, for ends at up to {travel.speed:g} m/s, {travel.acceleration:g} m/s^2 and "
        f"{travel.jerk:g} m/s^3",
    )


def _torque(scene: Scene) -> str:
    """'' for a rope that carries no torque in the plane while its ends do not turn; otherwise why it does."""
    rope = scene.rope
    if rope.Qs or rope.Qk:
        return f"tension and torsion are coupled (Qb = {rope.Qb:g}, Qc = {rope.Qc:g} N m)"
    if rope.installed_twist:
        return f"the rope is twisted by {rope.installed_twist:g} rad"
    return ""


def carries_torque(scene: Scene) -> bool:
    """Whether the rope carries torque even in the plane."""
    return bool(_torque(scene))


def _turns_freely(scene: Scene) -> bool:
    return all(swivel.mode == "free" and swivel.release_time <= 0 for swivel in (scene.left, scene.right))


def _moved(ends: tuple[EndMotion, EndMotion], names: tuple[str, ...]) -> str:
    for side, end in zip(SIDES, ends, strict=True):
        for name in names:
            if value := getattr(end, name):
                return f"{side}.{name} = {value:g}"
    return ""
