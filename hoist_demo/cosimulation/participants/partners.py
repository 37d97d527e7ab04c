"""Hoist and rope as the two partners of a coupling, and the names of what they exchange.

The coordinates of the exchange are the heights of the left and the right end; the rope's answer to them are its
vertical forces. Everything else of the ends' motion follows the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from hoist_demo.cosimulation.participants.rope_plant import EndMotion, RopePlant, RopeStatus
from hoist_demo.cosimulation.schemes.interface import Load, Motion, Vector
from hoist_demo.drive.equations import FORCES, INPUT_NAMES, WORK_NAMES
from hoist_demo.drive.outputs import SHOWN, PlantOutput, rope_ends
from hoist_demo.drive.plant import HoistPlant, PlantState, PlantStep

ENDS = ("left", "right")
ROPE_FORCES = tuple(f"{end}.{name}" for name in ("fy", "fy_mean") for end in ENDS)
"""The rope's signals: forces now, and their means over the last step."""
ADDED_MASSES = tuple(f"{end}.added_mass" for end in ENDS)

_PLACE, _SPEED, _ACCELERATION = (slice(SHOWN[f"{name}_left"], SHOWN[f"{name}_right"] + 1) for name in "yva")
_START, _RISE, _BEND = (slice(k * len(INPUT_NAMES) + FORCES[0], k * len(INPUT_NAMES) + FORCES[1] + 1) for k in range(3))
"""Places of the forces in a path of the drive's input."""


@dataclass
class Stopwatch:
    """Wall time of one of the two participants, added up."""

    wall: float = 0.0  # s
    _since: float = field(default=0.0, repr=False, compare=False)

    def __enter__(self) -> None:
        self._since = perf_counter()

    def __exit__(self, *_: object) -> None:
        self.wall += perf_counter() - self._since


def end_motions(motion: Motion, beside: tuple[EndMotion, EndMotion] | None) -> tuple[EndMotion, EndMotion]:
    """The coupling's motion as that of the rope's two ends; what it does not hold is that of ``beside``, or rests."""
    (y_left, y_right), (v_left, v_right) = motion.place.tolist(), motion.speed.tolist()
    a_left, a_right = motion.acceleration.tolist()
    if beside is None:
        left = EndMotion(0.0, y_left, 0.0, 0.0, v_left, 0.0, 0.0, a_left)
        return left, EndMotion(0.0, y_right, 0.0, 0.0, v_right, 0.0, 0.0, a_right)
    left, right = beside
    return _raise_end(left, y_left, v_left, a_left), _raise_end(right, y_right, v_right, a_right)


def _raise_end(end: EndMotion, y: float, vy: float, ay: float) -> EndMotion:
    x, _, z, vx, _, vz, ax, _, az, yaw, yaw_rate = end
    return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate)


NextCommand = Callable[[int, float, Vector], tuple[float, float]]
"""The controller's k-th command within a step, torque [N m] and brake: of k, time [s] and what the hoist shows then."""


class HoistParticipant:
    """The hoist as a coupling's drive; `command` is to be given between steps."""

    def __init__(self, plant: HoistPlant, state: PlantState, held: Vector, clock: Stopwatch) -> None:
        """`held` is the input that acts at the start, in the order of INPUT_NAMES."""
        self.plant, self.state = plant, state
        self.per_step = 1  # samples of the controller in a step
        self.next_command: NextCommand | None = None  # where there are several
        self._first = (0.0, 0.0)  # command of a step, torque and brake
        self.input = held  # that acts now, forces included
        self._path = np.concatenate([held, np.zeros(2 * held.size)])  # of the next step
        self._clock = clock
        self._shown: Vector | None = None  # under the input
        self._done: tuple[Load, Motion] | None = None  # load of the last step, and the motion at its end

    def command(self, torque: float, brake: float, sides: Vector) -> None:
        """Set what acts besides the vertical forces from now on: the command and the rope's side forces."""
        self._path[_TORQUE], self._path[_BRAKE], self._path[_SIDES] = torque, brake, sides
        self._first = torque, brake
        self._done = None

    def step(self, t: float, h: float, load: Load) -> str:
        """One step under the load; a constant one is held to the bit."""
        with self._clock:
            moved = self._moved(h, load) if self.next_command is None else self._sampled(t, h, load, self.next_command)
            if not moved.valid:
                return f"t = {t:.6g} s: {moved.message}"
            self.state, self.input, self._shown = moved.state, moved.acting, moved.shown
            self._done = load, _motion(moved.shown)
        return ""

    def _moved(self, h: float, load: Load) -> PlantStep:
        """The step under one command."""
        return self.plant.advance(self.state, h, self._under(load), load.added_mass)

    def _sampled(self, t: float, h: float, load: Load, next_command: NextCommand) -> PlantStep:
        """The step under several commands, the first again where it is repeated."""
        number, path, added = self.per_step, self._under(load), load.added_mass
        path[_TORQUE], path[_BRAKE] = self._first
        moved = self.plant.advance(self.state, h, path, added, 0.0, 1.0 / number)
        for k in range(1, number):
            if not moved.valid:
                break
            path[_TORQUE], path[_BRAKE] = next_command(k, t + k * h / number, moved.shown)
            moved = self.plant.advance(moved.state, h, path, added, k / number, (k + 1) / number)
        return moved

    @property
    def outputs(self) -> Vector:
        """Return the present values of PlantOutput."""
        if self._shown is None:
            path = np.concatenate([self.input, np.zeros(2 * self.input.size)])
            _, self._shown = self.plant.loads_and_outputs(self.state, path, np.zeros(2), 0.0)
        return self._shown

    def output(self) -> PlantOutput:
        """Return the present output of the hoist."""
        return PlantOutput(*self.outputs.tolist())

    def place(self) -> Vector:
        """Heights of the ends now."""
        return self.outputs[_PLACE]

    def motion(self, load: Load, s: float) -> Motion:
        """Motion of the ends now."""
        if self._done is not None and self._done[0] is load and s == 1.0:
            return self._done[1]
        with self._clock:
            _, shown = self.plant.loads_and_outputs(self.state, self._under(load), load.added_mass, s)
        return _motion(shown)

    def mobility(self) -> Vector:
        """Return the mobility of the two vertical accelerations."""
        return self.plant.mobility(self.state)

    def work(self) -> float:
        """Work of one balance rope's forces on the hoist [J]."""
        works = self.state.works
        return (works.item(_LEFT_WORK) + works.item(_RIGHT_WORK)) / self.plant.hoist.tail_rope_number

    def ends(self) -> tuple[EndMotion, EndMotion]:
        """Motion of the conveyances now, lateral and yaw too."""
        return rope_ends(self.outputs)

    def save(self) -> tuple[PlantState, Vector]:
        """Return the state and its input."""
        return self.state, self.input

    def restore(self, snapshot: tuple[PlantState, Vector]) -> None:
        """Go back to a saved state."""
        self.state, self.input = snapshot
        self._shown = self._done = None

    def _under(self, load: Load) -> Vector:
        """The path of a step."""
        self._path[_START], self._path[_RISE], self._path[_BEND] = load.start, load.rise, load.bend
        return self._path


def _motion(shown: Vector) -> Motion:
    return Motion(shown[_PLACE], shown[_SPEED], shown[_ACCELERATION])


_LEFT_WORK, _RIGHT_WORK = (WORK_NAMES.index(end) for end in ENDS)
_TORQUE, _BRAKE, _SIDES = INPUT_NAMES.index("torque_command"), INPUT_NAMES.index("brake"), slice(4, 10)


class RopeParticipant:
    """A balance rope as a coupling's rope."""

    def __init__(self, rope: RopePlant, clock: Stopwatch) -> None:
        self.rope = rope
        self.beside: Callable[[], tuple[EndMotion, EndMotion]] | None = None  # lateral motion of conveyances with play
        self._clock = clock
        self._read, self._read_added_masses = rope.reader(ROPE_FORCES), rope.reader(ADDED_MASSES)
        self._forces: Vector | None = None

    def start(self, t: float, left: EndMotion, right: EndMotion, clock: Stopwatch) -> str:
        """Hang the rope; "" or the cause why it does not."""
        with clock:
            status = self.rope.initialize(t, left, right)
            return self._problem(status, None)

    def step(self, t: float, h: float, motion: Motion) -> str:
        """One step of the rope, and its forces."""
        with self._clock:
            beside = None if self.beside is None else self.beside()
            status = self.rope.step(t, h, *end_motions(motion, beside))
            return self._problem(status, t)

    def forces(self) -> tuple[Vector, Vector]:
        """Forces now and their means."""
        if self._forces is None:
            self._forces = self._read()
        return self._forces[: len(ENDS)], self._forces[len(ENDS) :]

    def added_mass(self) -> Vector | None:
        """Return the added mass of the last step; None if the rope has none."""
        with self._clock:
            values = self._read_added_masses()
        return values if np.isfinite(values).all() else None

    def save(self) -> object:
        """Return the rope's state."""
        with self._clock:
            return self.rope.save()

    def restore(self, snapshot: object) -> None:
        """Go back to a saved state."""
        with self._clock:
            self.rope.restore(snapshot)
            self._forces = None

    def free(self, snapshot: object) -> None:
        """Give up a saved state."""
        self.rope.free(snapshot)

    def to_bytes(self, snapshot: object) -> bytes:
        """A snapshot for a file."""
        return self.rope.to_bytes(snapshot)

    def restore_bytes(self, data: bytes) -> None:
        """Go on from what `to_bytes` wrote."""
        snapshot = self.rope.from_bytes(data)
        self.restore(snapshot)
        self.free(snapshot)

    def _problem(self, status: RopeStatus, t: float | None) -> str:
        """Return why the rope's answer to a step from t [s], or to the start (None), is unusable; "" if it is not."""
        self._forces = None
        if status.valid:
            forces = self._read()
            if math.isfinite(sum(forces.tolist())):
                self._forces = forces
                return ""
            bad = [name for name, force in zip(ROPE_FORCES, forces, strict=True) if not math.isfinite(force)]
            problem = f"{', '.join(bad)} missing or not finite: check the rope plant"
        else:
            problem = status.message or "status.valid is false, without a message"
        return f"rope, {'at the start' if t is None else f'step from t = {t:.6g} s'}: {problem}"
