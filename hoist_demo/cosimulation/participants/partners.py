"""Hoist and rope as the two partners of a coupling scheme, and the table of what they exchange.

One row of COORDINATES per motion that the hoist gives and the rope follows; the rope's answer to it is the force of
the same row. A hoist with lateral play adds rows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.participants.rope_plant import EndMotion, RopePlant, RopeStatus
from hoist_demo.cosimulation.schemes.interface import Load, Motion, Vector
from hoist_demo.drive.plant import HoistPlant, PlantInput, PlantInputPath, PlantOutput, PlantState


class Coordinate(NamedTuple):
    """One interface coordinate by its names on either side."""

    end: str
    motion: tuple[str, str, str]  # place, speed and acceleration, of EndMotion
    output: tuple[str, str, str]  # the same, of PlantOutput
    force: str  # the rope's signal
    mean: str  # its mean over the last step
    added_mass: str
    input: str  # of PlantInput


COORDINATES = tuple(
    Coordinate(
        end,
        ("y", "vy", "ay"),
        (f"y_{end}", f"v_{end}", f"a_{end}"),
        f"{end}.fy",
        f"{end}.fy_mean",
        f"{end}.added_mass",
        f"force_{end}",
    )
    for end in ("left", "right")
)
FORCES = tuple(c.force for c in COORDINATES) + tuple(c.mean for c in COORDINATES)
ADDED_MASSES = tuple(c.added_mass for c in COORDINATES)


@dataclass
class Stopwatch:
    """Wall and processor time of one of the two partners, added up."""

    wall: float = 0.0  # s
    cpu: float = 0.0  # s

    @contextmanager
    def count_time(self) -> Iterator[None]:
        """Counts the time within."""
        wall, cpu = perf_counter(), process_time()
        try:
            yield
        finally:
            self.wall += perf_counter() - wall
            self.cpu += process_time() - cpu


def end_motions(motion: Motion, beside: tuple[EndMotion, EndMotion]) -> tuple[EndMotion, EndMotion]:
    """The coupling's motion as that of the rope's two ends; what it does not hold is that of ``beside``."""
    ends = dict(zip(("left", "right"), beside, strict=True))
    for k, c in enumerate(COORDINATES):
        values = (motion.place[k], motion.speed[k], motion.acceleration[k])
        ends[c.end] = replace(ends[c.end], **dict(zip(c.motion, map(float, values), strict=True)))
    return ends["left"], ends["right"]


def mid_guide_motions() -> tuple[EndMotion, EndMotion]:
    """Ends that hang in the middle of their guides."""
    return EndMotion(), EndMotion()


def motion_of(output: PlantOutput) -> Motion:
    """The motion of the drive's ends as the coupling has it."""
    return Motion(*(np.array([getattr(output, c.output[k]) for c in COORDINATES]) for k in range(3)))


def input_of(held: PlantInput, forces: Vector) -> PlantInput:
    """A plant's input with the rope's forces."""
    return PlantInput(**vars(held) | dict(zip(_INPUTS, forces.tolist(), strict=True)))


_INPUTS = tuple(c.input for c in COORDINATES)
_NOTHING = PlantInput(0.0, 0.0, 0.0)


class HoistParticipant:
    """The hoist as a coupling's drive; `held` is what the controller commands, to be set between steps."""

    def __init__(self, plant: HoistPlant, state: PlantState, held: PlantInput, clock: Stopwatch) -> None:
        self.plant, self.state, self.held = plant, state, held
        self.input = held  # that acts now, forces included
        self._clock = clock
        # a scheme asks for the same again and again
        self._known_output: tuple[PlantState, PlantInput, PlantOutput] | None = None
        self._known_path: tuple[Load, PlantInput, PlantInputPath] | None = None

    def step(self, t: float, h: float, load: Load) -> str:
        """One step under the load; a constant one is held to the bit."""
        with self._clock.count_time():
            given: PlantInput | PlantInputPath
            given = path = self._path(load)
            if not (load.rise.any() or load.bend.any() or load.added_mass.any()):
                given = path.start
            moved = self.plant.step(self.state, h, given)
            if not moved.valid:
                return f"t = {t:.6g} s: {moved.message}"
            self.state = moved.state
            self.input = self.plant.loads_at(self.state, path, 1.0)
        return ""

    def output(self) -> PlantOutput:
        """What the hoist shows now."""
        return self._output(self.input)

    def motion(self, load: Load, s: float) -> Motion:
        """Motion of the ends now."""
        with self._clock.count_time():
            acting = self.plant.loads_at(self.state, self._path(load), s)
            return motion_of(self._output(acting))

    def mobility(self) -> Vector:
        """Of the two vertical accelerations."""
        return self.plant.mobility(self.state)

    def work(self) -> float:
        """Work of one balance rope's forces on the hoist [J]."""
        return float(self.state.work[3] + self.state.work[4]) / self.plant.hoist.tail_rope_number

    def ends(self) -> tuple[EndMotion, EndMotion]:
        """Motion of the conveyances now, lateral and yaw too."""
        return self.output().ends

    def save(self) -> tuple[PlantState, PlantInput]:
        return self.state, self.input

    def restore(self, snapshot: tuple[PlantState, PlantInput]) -> None:
        self.state, self.input = snapshot

    def _output(self, acting: PlantInput) -> PlantOutput:
        known = self._known_output
        if known is None or known[0] is not self.state or known[1] != acting:
            self._known_output = known = self.state, acting, self.plant.outputs(self.state, acting)
        return known[2]

    def _path(self, load: Load) -> PlantInputPath:
        known = self._known_path
        if known is None or known[0] is not load or known[1] is not self.held:
            self._known_path = known = load, self.held, self._make_path(load)
        return known[2]

    def _make_path(self, load: Load) -> PlantInputPath:
        added = (float(load.added_mass[0]), float(load.added_mass[1]))
        rise, bend = input_of(_NOTHING, load.rise), input_of(_NOTHING, load.bend)
        return PlantInputPath(input_of(self.held, load.start), rise, bend, added)


class RopeParticipant:
    """A balance rope as a coupling's rope."""

    def __init__(self, rope: RopePlant, clock: Stopwatch) -> None:
        self.rope = rope
        self.beside: Callable[[], tuple[EndMotion, EndMotion]] = mid_guide_motions  # lateral motion of the conveyances
        self._clock = clock
        self._read: dict[str, float] | None = None

    def start(self, t: float, left: EndMotion, right: EndMotion, clock: Stopwatch) -> str:
        """Hang the rope; "" or the cause why it does not."""
        with clock.count_time():
            status = self.rope.initialize(t, left, right)
            return self._problem(status, "rope, at the start")

    def step(self, t: float, h: float, motion: Motion) -> str:
        """One step of the rope, and its forces."""
        with self._clock.count_time():
            status = self.rope.step(t, h, *end_motions(motion, self.beside()))
            return self._problem(status, f"rope, step from t = {t:.6g} s")

    def forces(self) -> tuple[Vector, Vector]:
        """Forces now and their means."""
        if self._read is None:
            self._read = self.rope.read(FORCES)
        read, n = self._read, len(COORDINATES)
        values = np.array([read[name] for name in FORCES])
        return values[:n], values[n:]

    def added_mass(self) -> Vector | None:
        """Of the last step; None where the rope cannot tell."""
        with self._clock.count_time():
            read = self.rope.read(ADDED_MASSES)
        values = [read.get(name, math.nan) for name in ADDED_MASSES]
        return np.array(values) if all(map(math.isfinite, values)) else None

    def save(self) -> object:
        with self._clock.count_time():
            return self.rope.save()

    def restore(self, snapshot: object) -> None:
        with self._clock.count_time():
            self.rope.restore(snapshot)
            self._read = None

    def free(self, snapshot: object) -> None:
        self.rope.free(snapshot)

    def to_bytes(self, snapshot: object) -> bytes:
        """A snapshot for a file."""
        return self.rope.to_bytes(snapshot)

    def restore_bytes(self, data: bytes) -> None:
        """Go on from what `to_bytes` wrote."""
        snapshot = self.rope.from_bytes(data)
        self.restore(snapshot)
        self.free(snapshot)

    def _problem(self, status: RopeStatus, where: str) -> str:
        """Why the rope's answer cannot be used; "" when it can."""
        self._read = None
        if not status.valid:
            return f"{where}: {status.message or 'status.valid is false, without a message'}"
        read = self.rope.read(FORCES)
        bad = [name for name in FORCES if not math.isfinite(read.get(name, math.nan))]
        if bad:
            return f"{where}: {', '.join(bad)} missing or not finite: check the rope plant"
        self._read = read
        return ""
