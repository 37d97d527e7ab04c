"""The 240 m winding whose swivels are released at t = 20 s, and the same whose swivels stay locked."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import H, Winding, progress_bar, wind
from evidence.tables import Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import BalanceRope, RopeSimulator, Scene, Swivel, rope_240
from rope_model.simulation.ends.paths import SIDES
from rope_model.simulation.rope_system import ANGLE, POSITION, arc_lengths

Array = NDArray[np.float64]

RELEASE, END = 20.0, 45.0  # s
FROM = 17.0  # s, start of the swivel's record
INSTANTS = (10.0, 19.9, 20.2, 20.8, 22.0, 25.0, 30.0, 38.0)
EVERY = 5  # samples per row of the table of the loop
RIGHT = ("right.swivel.angle", "right.swivel.rate", "right.swivel.torque")
SWIVEL = ("acceleration [rad/s^2]", "rate [rad/s]", "angle [rad]", "torque [N m]", "static limit [N m]")


@dataclass
class Watch:
    """What is kept of every communication step; ``python`` looks at the states that the rope comes to."""

    python: RopeSimulator
    swivel: list[tuple[float, ...]] = field(default_factory=list)  # right one: SWIVEL
    yaw: list[float] = field(default_factory=list)  # rad
    shapes: list[tuple[float, ...]] = field(default_factory=list)  # t, s, x, y, z, theta

    def __call__(self, rope: BalanceRope) -> None:
        """Look at the rope."""
        state, python = rope.state, self.python
        python.restore(state)
        m, limit = state.motion, python.ends.friction(1, state.motion.reaction, kinetic=False)
        angle, rate, on_rope = rope.signals(RIGHT).values()
        self.swivel.append((float(m.a[-1, ANGLE]), rate, angle, on_rope, limit))
        self.yaw.append(python.loop.yaw)
        if np.min(np.abs(m.t - np.array(INSTANTS))) < 0.5 * H:
            s = arc_lengths(state.partition.lengths)
            self.shapes += [(round(m.t, 3), *row) for row in np.column_stack((s, m.q[:, POSITION], m.q[:, ANGLE]))]


def follow(scene: Scene, name: str, until: float = END) -> tuple[Winding, Watch]:
    """The case's winding up to ``until`` (s); RuntimeError when it fails."""
    case, watch = rope_240(), Watch(RopeSimulator(scene))
    reference = s_curve(Trip(travel=case.travel, speed=case.speed))
    with progress_bar(name, until) as advance:
        run = wind(scene, reference, case.travel, until - reference.duration, 1, advance, watch)
    if not run.status.valid:
        raise RuntimeError(f"{name}: {run.status.message}")
    return run, watch


def measure() -> Tables:
    """Both runs as tables."""
    scene = rope_240().scene
    run, watch = follow(scene, "240 m, swivels released")
    locked, still = follow(scene.with_(left=Swivel(), right=Swivel()), "240 m, swivels locked")
    t = np.array(run.t)
    late = t >= FROM
    columns = {
        name: np.array(column)[late] for name, column in zip(SWIVEL, zip(*watch.swivel, strict=True), strict=True)
    }
    loop = {"t [s]": t[EVERY - 1 :: EVERY]}
    half = 0.5 * scene.layout.spacing
    for kind, each, seen in (("released", run, watch), ("locked", locked, still)):
        observed, bottom = np.array(each.observed)[EVERY - 1 :: EVERY], np.array(each.bottom)[EVERY - 1 :: EVERY]
        for i, side in enumerate(SIDES):
            loop[f"{kind} {side} in plane [m]"] = observed[:, i, 0] + (half, -half)[i]
            loop[f"{kind} {side} out of plane [m]"] = observed[:, i, 2]
            loop[f"{kind} {side} theta [rad]"] = observed[:, i, 6]
        loop[f"{kind} bottom x [m]"], loop[f"{kind} bottom z [m]"] = bottom[:, 0], bottom[:, 2]
        loop[f"{kind} yaw [rad]"] = np.unwrap(seen.yaw)[EVERY - 1 :: EVERY]
    events = [(e.t, *e.what.split(" swivel ")) for e in run.events if " swivel " in e.what]
    return {
        "release-swivel": {"t [s]": t[late], **columns},
        "release-loop": loop,
        "release-events": table(("t [s]", "side", "what"), events),
        "release-shapes": table(("t [s]", "s [m]", "x [m]", "y [m]", "z [m]", "theta [rad]"), watch.shapes),
    }
