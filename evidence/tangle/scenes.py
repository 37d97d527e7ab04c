"""A hoist of 690 m in a round shaft, with swivels, a divider, a guard and meshes of all kinds.

Rope, shaft and motion are assumed; the coupling is the published one of a smaller rope, which is more than round ropes
of such depths have.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import (
    Accuracy,
    Conveyance,
    Divider,
    Guard,
    HeadRopes,
    Layout,
    Lining,
    Mesh,
    Rope,
    Scene,
    Shaft,
    Swivel,
)

ROPE = Rope(length=690.0, mass_per_length=8.2, EI=450.0)
LAYOUT = Layout(1.8)
TRIP = Winding(travel=650.0, speed=12.0, acceleration=1.0, jerk=1.0, start_delay=0.0)
#: s
TRIP_TIME = s_curve(TRIP).duration
SHAFT = Shaft(
    lining=Lining(width=7.0, depth=7.0, rounding=1.0),
    conveyance=Conveyance(width=1.2, depth=1.0, height=4.0, above=0.5),
    head_ropes=HeadRopes(diameter=0.036, row=0.7),
)
#: a square beam along Z between the legs, 12 m below the lower landing
DIVIDER = Divider(size=0.2, y=-12.0, rounding=0.0)
LOCKED, FREE, HEALTHY = Swivel("locked"), Swivel("free"), Swivel("coulomb")
STIFF = replace(HEALTHY, mu_static=10 * HEALTHY.mu_static, mu_kinetic=10 * HEALTHY.mu_kinetic)
#: turns, little more than what the rope hangs with at rest
TURNED = 0.25
FINE = Accuracy(end_force=1e-3, loop=1e-3)


@dataclass(frozen=True)
class Variant:
    """What is changed, in words and as a scene."""

    name: str
    scene: Scene


def _scene(swivel: Swivel, shaft: Shaft = SHAFT) -> Scene:
    return Scene(rope=ROPE, layout=LAYOUT, left=swivel, right=swivel, shaft=shaft)


def _seized(**parts: object) -> Scene:
    return _scene(LOCKED).with_(**parts)


SEIZED = Variant("seized swivels", _seized())
VARIANTS = (
    Variant("swivels turn freely", _scene(FREE)),
    Variant("healthy swivels", _scene(HEALTHY)),
    Variant("ten times their friction", _scene(STIFF)),
    SEIZED,
    Variant("seized, divider in the loop", _scene(LOCKED, replace(SHAFT, divider_1=DIVIDER))),
    Variant("seized, guard of turns", _scene(LOCKED, replace(SHAFT, guard=Guard(turns=TURNED)))),
)
#: the same on finer meshes and steps
MESHES = (
    SEIZED,
    Variant("loop to 1 mm", _seized(accuracy=FINE)),
    Variant("equal elements of 1 m", _seized(mesh=Mesh("eem", elements=690))),
    Variant("equal elements of 0.5 m, loop to 1 mm", _seized(mesh=Mesh("eem", elements=1380), accuracy=FINE)),
    Variant("loop to 0.3 mm, end force to 1e-4", _seized(accuracy=Accuracy(end_force=1e-4, loop=3e-4))),
)
