"""Data that cross the interface, questions of a scheme to both partners, and its state between steps.

load of a step      F(s) = start + linear s + quadratic s^2 - m_a a ,   a: acceleration of the drive's ends, s = 0 .. 1
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rope_model import EndMotion, Status

Vector = NDArray[np.float64]
ENDS = ("left", "right")
#: The rope's signals: forces now, and their means over the last step; without them no loop can run.
ROPE_FORCES = tuple(f"{end}.{name}" for name in ("fy", "fy_mean") for end in ENDS)
ADDED_MASSES = tuple(f"{end}.added_mass" for end in ENDS)
HISTORY = 3  #: Samples that are remembered: enough for a quadratic extrapolation.


class InterfaceMotion(NamedTuple):
    """Places, speeds and accelerations of the n interface coordinates at one instant, each (n,)."""

    position: Vector  # m
    speed: Vector  # m/s
    acceleration: Vector  # m/s^2


class Load(NamedTuple):
    """Forces on the drive over one step, each (n,), in N; the added mass in kg."""

    start: Vector
    linear: Vector
    quadratic: Vector
    added_mass: Vector

    @staticmethod
    def constant(force: Vector) -> Load:
        """Return a load with this force (n,) throughout."""
        zero = np.zeros(force.shape)
        return Load(force, zero, zero, zero)

    @staticmethod
    def through(start: Vector, mean: Vector, end: Vector) -> Load:
        """Return the parabola with these forces at both ends and this mean."""
        quadratic = 3.0 * (start + end) - 6.0 * mean
        return Load(start, end - start - quadratic, quadratic, np.zeros(start.shape))


class Sample(NamedTuple):
    """Data of both partners at one communication point; vectors (n,)."""

    t: float  # s
    force: Vector  # N, of the rope at t
    mean: Vector  # N, of the rope over the step that ended at t
    acceleration: Vector  # m/s^2, of the drive under the load that it had at t


class SchemeState(NamedTuple):
    """State of a scheme; saving it with the partners' states is enough to go on."""

    samples: tuple[Sample, ...]  # the last HISTORY, oldest first
    step_next: float = 0.0  # s, that the energy control would like; 0: not chosen yet
    exchanges: int = 0  # steps of the rope, those taken back included
    taken_back: int = 0  # exchanges that were taken back
    residual: float = (
        0.0  # J, work that one partner gave and the other did not get, since the start
    )

    @property
    def last(self) -> Sample:
        """Sample at the latest communication point."""
        return self.samples[-1]

    def with_taken_back(self, count: int = 1) -> SchemeState:
        """Return the state with ``count`` more exchanges that were done and undone."""
        return self._replace(exchanges=self.exchanges + count, taken_back=self.taken_back + count)


class Advance(NamedTuple):
    """State after a step, or that before it with the cause for which the step failed."""

    scheme_state: SchemeState
    cause: str = ""


class DrivePartner(Protocol):
    """Partner that takes forces and gives motions."""

    def step(self, t: float, h: float, load: Load) -> str:
        """Advance from t to t + h [s]; "" or the cause why not."""

    def position(self) -> Vector:
        """Places of the ends now, (n,) [m]."""

    def motion(self, load: Load, s: float) -> InterfaceMotion:
        """Motion now, with the accelerations under the load as it is at s."""

    def ends(self, motion: InterfaceMotion) -> tuple[EndMotion, EndMotion]:
        """Motion of the rope's ends: that of the interface, and of everything else now."""

    def accelerance(self) -> Vector:
        """Return the change of the accelerations per force, (n, n) [1/kg]."""

    def work(self) -> float:
        """Work that the loads have done on the drive so far [J]."""

    def save(self) -> Any:
        """Return a snapshot of the present state."""

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of `save`."""


Reader = Callable[[], Vector]


class RopePlant(Protocol):
    """A balance rope between two moving ends, in an FMU or in this process.

    Names of signals are those of the FMI interface, e.g. `left.fy` [N], the rope's force on the left conveyance.
    """

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        """Find the hanging shape at time t0 [s]; readers then give the forces at rest."""

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Advance from t to t + h [s]; `left` and `right` hold at t + h."""

    def units(self) -> dict[str, str]:
        """FMI unit of each signal of which a run makes a record, "1" or "" where it has none."""

    def reader(self, names: Sequence[str]) -> Reader:
        """Return a function that reads these outputs now, also those without a record; NaN for those the rope lacks.

        Booleans are 0 and 1. It may be made before the rope hangs; its array is the caller's.
        """

    def save(self) -> Any:
        """Return the complete state as a snapshot in memory, None if the rope cannot."""

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot: whatever comes next is the same to the bit."""

    def to_bytes(self, snapshot: Any) -> bytes:
        """Serialize a snapshot for a file."""

    def from_bytes(self, data: bytes) -> Any:
        """Deserialize what `to_bytes` wrote, also of another instance; ValueError if it does not fit."""

    def close(self) -> None:
        """Free what the rope holds; may be called more than once."""


@dataclass
class Stopwatch:
    """Wall time of one of the two partners, added up."""

    wall: float = 0.0  # s
    _since: float = field(default=0.0, repr=False, compare=False)

    def __enter__(self) -> None:
        self._since = perf_counter()

    def __exit__(self, *_: object) -> None:
        self.wall += perf_counter() - self._since


class CoupledSystem:
    """Two partners of a co-simulation: a scheme steps and asks the rope here, and the drive itself."""

    def __init__(
        self, drive: DrivePartner, rope: RopePlant, clock: Stopwatch | None = None
    ) -> None:
        """`rope` hangs; `clock` counts the time that it takes."""
        self.drive, self.rope = drive, rope
        self._clock = Stopwatch() if clock is None else clock
        self._read, self._read_added_masses = rope.reader(ROPE_FORCES), rope.reader(ADDED_MASSES)
        self._forces: Vector | None = None
        self._before = (
            0.0,
            np.zeros(len(ENDS)),
        )  # work on the drive [J] and its place [m] where the step began

    def step_rope(self, t: float, h: float, motion: InterfaceMotion) -> str:
        """Advance the rope from t to t + h [s], where the motion holds; "" or the cause why not."""
        with self._clock:
            return self.rope_stepped(t, self.rope.step(t, h, *self.drive.ends(motion)))

    def rope_stepped(self, t: float, status: Status) -> str:
        """Take what the rope answers to a step from t [s]; "" or the cause why it is of no use."""
        forces = forces_or_error(status, self._read)
        self._forces = None if isinstance(forces, str) else forces
        return f"rope, step from t = {t:.6g} s: {forces}" if isinstance(forces, str) else ""

    def step(self, t: float, h: float, load: Load) -> str:
        """Advance both over one step: the rope follows the motion that the drive makes under the load."""
        return self.step_drive(t, h, load) or self.step_rope(t, h, self.drive.motion(load, 1.0))

    def step_drive(self, t: float, h: float, load: Load) -> str:
        """Advance the drive alone from t to t + h [s]; "" or the cause why not."""
        self._before = self.drive.work(), self.drive.position()
        return self.drive.step(t, h, load)

    def forces(self) -> tuple[Vector, Vector]:
        """Return the rope's force on the drive now, and its mean over the last step, each (n,) [N]."""
        if self._forces is None:
            self._forces = self._read()
        return self._forces[: len(ENDS)], self._forces[len(ENDS) :]

    def added_mass(self) -> Vector:
        """Return the fall of the forces per acceleration that grows over a step, (n,) [kg]; ValueError if unknown."""
        with self._clock:
            added = self._read_added_masses()
        if not np.isfinite(added).all():
            raise ValueError(
                f"the rope's added mass, outputs {' and '.join(ADDED_MASSES)}, must be known, it is {added}: take "
                "gauss-seidel-1 or iterative-secant"
            )
        return added

    def save(self) -> tuple[Any, Any]:
        """Return the states of drive and rope."""
        with self._clock:
            return self.drive.save(), self.rope.save()

    def restore(self, snapshot: tuple[Any, Any]) -> None:
        """Restore the states of drive and rope."""
        self.drive.restore(snapshot[0])
        self.restore_rope(snapshot[1])

    def restore_rope(self, snapshot: Any) -> None:
        """Restore a saved state of the rope alone."""
        with self._clock:
            self.rope.restore(snapshot)
            self._forces = None

    def start(self, t: float) -> SchemeState:
        """Return the state of a scheme that begins at t [s]; before it everything counts as at rest."""
        force, mean = self.forces()
        return SchemeState(
            (Sample(t, force, mean, self.drive.motion(Load.constant(force), 1.0).acceleration),)
        )

    def exchanged(self, scheme_state: SchemeState, t: float, load: Load) -> SchemeState:
        """State with the step that has ended at t, where the load acts, and with the energy that it made up.

        That is the drive's work less the rope's mean force times the distance: its work to the third order in h.
        """
        (force, mean), (work, position) = self.forces(), self._before
        sample = Sample(t, force, mean, self.drive.motion(load, 1.0).acceleration)
        made = self.drive.work() - work - float((mean * (self.drive.position() - position)).sum())
        samples, exchanges = (*scheme_state.samples, sample)[-HISTORY:], scheme_state.exchanges + 1
        return scheme_state._replace(
            samples=samples, exchanges=exchanges, residual=scheme_state.residual + made
        )

    def exchange(self, scheme_state: SchemeState, t: float, h: float, load: Load) -> Advance:
        """Do the step under a load, drive first, and return the new state."""
        if cause := self.step(t, h, load):
            return Advance(scheme_state, cause)
        return Advance(self.exchanged(scheme_state, t + h, load))


def forces_or_error(status: Status, read: Reader) -> Vector | str:
    """Return the rope's forces behind a start or a step, by a reader of ROPE_FORCES; or why they are unusable."""
    if not status.valid:
        return status.message or "status.valid is false, without a message"
    forces = read()
    if math.isfinite(sum(forces.tolist())):
        return forces
    bad = [
        name for name, force in zip(ROPE_FORCES, forces, strict=True) if not math.isfinite(force)
    ]
    return f"{', '.join(bad)} missing or not finite: check the rope plant"


class Scheme(Protocol):
    """Method of exchanging forces and motions over a communication step."""

    @property
    def weights(self) -> tuple[float, ...]:
        """Weights of past forces, latest first, in the mean load of a step; none when the load is iterated."""

    @property
    def needs_rollback(self) -> bool:
        """True if steps are taken back, for which the rope must save and restore its state."""

    @property
    def needs_added_mass(self) -> bool:
        """True if the rope must give its added mass."""

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        """Both partners from t to t + h [s]; when it fails their states may lie anywhere between."""
