"""Random ropes in random shafts, wound among what they may strike.

What came through a body is found from the recorded shapes alone, without the rope's own distances: points of the centre
line more than half a diameter deep in lining, floor or divider, and dividers about which the rope, seen along them,
winds otherwise than at the start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scenes import ends_at

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import BalanceRope, Layout, Model, Rope, Scene, Status, at_level, balance_rope
from rope_model.shaft_parameters import Conveyance, Divider, HeadRopes, Lining, Shaft, Sump
from rope_model.simulation.outputs.diagnostics import shape

Array = NDArray[np.float64]
SEED = 15
POINTS = 161
SETTLE, H, SAMPLE = 2.0, 0.01, 5  # s, s, steps


@dataclass(frozen=True)
class Case:
    """A scene, and the trip of its left end (m)."""

    scene: Scene
    trip: Trip


def draw(seed: int) -> Case:
    rng = np.random.default_rng([SEED, seed])
    travel, spare, spacing = rng.uniform(6.0, 15.0), rng.uniform(8.0, 16.0), rng.uniform(1.4, 2.4)
    coupling = rng.choice([-1.0, 0.2, 1.0]) * 2.336e5
    length = travel + spare
    rope = Rope(length=length, EI=math.exp(rng.uniform(math.log(80.0), math.log(600.0))), Qb=coupling, Qc=coupling)
    lowest = -0.5 * spare  # about where the loop hangs with either end below
    dividers = [
        Divider(
            size=float(rng.choice([0.0, 1.0], p=[0.4, 0.6])) * rng.uniform(0.1, 0.3),
            y=lowest + rng.uniform(-1.0, 2.0),
            offset=rng.uniform(-0.7, 0.7) * spacing,
            rounding=float(rng.choice([0.3, 1.0])),
        )
        for _ in range(2)
    ]
    width = spacing + rng.uniform(0.2, 1.5)
    shaft = Shaft(
        lining=Lining(width=width, depth=rng.uniform(0.8, 3.0)) if rng.random() < 0.7 else Lining(),
        conveyance=Conveyance(width=0.5 * spacing, depth=0.8, height=3.0, above=0.5),
        head_ropes=HeadRopes(diameter=0.03, row=0.6),
        sump=Sump(level=lowest + rng.uniform(-1.5, 0.3)) if rng.random() < 0.6 else Sump(),
        divider_1=dividers[0],
        divider_2=dividers[1],
    )
    scene = Scene(rope=rope, layout=Layout(spacing=spacing), model=Model("torsional"), shaft=shaft)
    trip = Trip(travel=travel, speed=rng.uniform(2.0, 8.0), acceleration=rng.uniform(0.5, 2.0), jerk=1.0)
    return Case(replace(at_level(scene, "draft"), model=Model("torsional")), trip)


def centre_line(rope: BalanceRope) -> Array:
    state, scene = rope.state, rope.scene
    q, lengths = state.motion.q, state.partition.lengths
    return shape(q, lengths, 0.5 * float(lengths.sum()), scene.layout.spacing, POINTS)


def depths(scene: Scene, points: Array) -> dict[str, float]:
    """How deep the centre line is in what it may not enter (m); negative: outside."""
    shaft, found = scene.shaft, dict[str, float]()
    if shaft.lining.width > 0.0:
        across = np.abs(points[:, [0, 2]] - (shaft.lining.x, shaft.lining.z))
        found["lining"] = float((across - (0.5 * shaft.lining.width, 0.5 * shaft.lining.depth)).max())
    if shaft.sump.level > -1e6:
        found["floor"] = float(shaft.sump.level - points[:, 1].min())
    for k, divider in dividers(scene).items():
        found[k] = 0.5 * divider.size - float(_distance_from(points[:, :2], divider).min())
    return found


def dividers(scene: Scene) -> dict[str, Divider]:
    found = {f"divider {k}": getattr(scene.shaft, f"divider_{k}") for k in range(1, 5)}
    return {name: divider for name, divider in found.items() if divider.size > 0.0}


def _distance_from(points: Array, divider: Divider) -> Array:
    """Of the rope's straight pieces from the divider's axis, seen along it (m)."""
    start, way = points[:-1] - (divider.offset, divider.y), np.diff(points, axis=0)
    along = np.clip(-(start * way).sum(-1) / (way * way).sum(-1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(start + along[:, None] * way, axis=-1))


def windings(points: Array, divider: Divider) -> int:
    """Turns about the divider's axis of the rope, closed far above its ends: 1 where it hangs below, 0 beside."""
    top = np.array([[points[0, 0], 1e3], [points[-1, 0], 1e3]])
    closed = np.vstack([top[:1], points[:, :2], top[1:], top[:1]]) - (divider.offset, divider.y)
    angle = np.arctan2(closed[:, 1], closed[:, 0])
    turned = (np.diff(angle) + math.pi) % (2.0 * math.pi) - math.pi
    return round(float(turned.sum()) / (2.0 * math.pi))


def wind(scene: Scene, trip: Trip) -> tuple[BalanceRope, Status, list[Array], list[Array]]:
    """The rope, its last status, and every ``SAMPLE`` steps its centre line and the pulls of its ends (N)."""
    rope, reference = balance_rope(scene), s_curve(trip)
    lines: list[Array] = []
    forces: list[Array] = []
    status = rope.initialize(0.0, *ends_at(reference, trip.travel, 0.0))
    for k in range(1, round((reference.duration + SETTLE) / H) + 1):
        if status.valid:
            status = rope.advance_to(k * H, *ends_at(reference, trip.travel, k * H))
        if not status.valid:
            break
        if k % SAMPLE == 0:
            lines.append(centre_line(rope))
            forces.append(-rope.state.motion.reaction[[0, -1], 1])
    return rope, status, lines, forces


def run(case: Case) -> tuple[str, list[str], float]:
    """How a scene ends, what came through what by the recorded shapes, and the deepest point beyond touch (m)."""
    scene = case.scene
    rope, status, lines, forces = wind(scene, case.trip)
    if not lines:
        return f"not hung: {status.message}", [], -math.inf
    through = []
    if not all(np.isfinite(line).all() for line in lines) or not np.isfinite(forces).all():
        through.append("a number is not finite")
    deepest = -math.inf
    for name in depths(scene, lines[0]):
        depth = max(depths(scene, line)[name] for line in lines)
        deepest = max(deepest, depth)
        if depth > 0.5 * scene.rope.diameter:
            through.append(f"{depth:.3f} m deep in {name}")
    for name, divider in dividers(scene).items():
        if len({windings(line, divider) for line in lines}) > 1:
            through.append(f"through {name}")
    told = rope.warnings()
    ending = "completed, having struck something" if "passed_bodies" in told else "completed"
    ending += ", its legs having passed through each other" if "passed_sides" in told else ""
    return ending if status.valid else f"stopped: {status.message}", through, deepest
