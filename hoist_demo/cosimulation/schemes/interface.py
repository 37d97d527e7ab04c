"""Data that cross the interface, functions that a scheme calls of both partners, and its state.

load of a step      F(s) = start + linear s + quadratic s^2 - m_a a ,   a: acceleration of the
drive's ends, s = 0 .. 1
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from time import perf_counter
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rope_model import SIDES, EndMotion, Status

Vector = NDArray[np.float64]


def end_signals(*names: str) -> tuple[str, ...]:
    """Return these signals of the rope's left end, then those of its right end."""
    return tuple(f"{end}.{name}" for end, name in product(SIDES, names))


#: The rope's signals: forces now, and their means over the last step; without them no loop can run.
ROPE_FORCES = end_signals("fy") + end_signals("fy_mean")
ADDED_MASSES = end_signals("added_mass")
HISTORY = 3  #: Samples that are remembered: enough for a quadratic extrapolation.
SUCCESS = Status(True)


class ParticipantFailed(RuntimeError):
    """Failure of drive or rope that ends the run; its text is the cause."""


class InterfaceMotion(NamedTuple):
    """Places, speeds and accelerations of the n interface coordinates at one instant, each (n,)."""

    position: Vector  # m
    speed: Vector  # m/s
    acceleration: Vector  # m/s^2


class DriveLoad(NamedTuple):
    """Forces on the drive over one step, each (n,), in N; the added mass in kg."""

    start: Vector
    linear: Vector
    quadratic: Vector
    added_mass: Vector

    @staticmethod
    def constant(force: Vector) -> DriveLoad:
        """Return a load with this force (n,) throughout."""
        zero = np.zeros(force.shape)
        return DriveLoad(force, zero, zero, zero)

    @staticmethod
    def through(start: Vector, mean: Vector, end: Vector) -> DriveLoad:
        """Return the parabola with these forces at both ends and this mean."""
        quadratic = 3.0 * (start + end) - 6.0 * mean
        return DriveLoad(start, end - start - quadratic, quadratic, np.zeros(start.shape))


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
    residual: float = 0.0  # J, work that one partner gave and the other did not get, from the start

    @property
    def last(self) -> Sample:
        """Sample at the latest communication point."""
        return self.samples[-1]

    def with_taken_back(self, count: int = 1) -> SchemeState:
        """Return the state with ``count`` more exchanges that were done and undone."""
        return self._replace(exchanges=self.exchanges + count, taken_back=self.taken_back + count)


class Advance(NamedTuple):
    """State after a step, or that before it with the status of the step that failed."""

    scheme_state: SchemeState
    status: Status = SUCCESS


class DrivePartner(Protocol):
    """Partner that takes forces and gives motions."""

    def step(self, t: float, h: float, load: DriveLoad) -> Status:
        """Advance from t to t + h [s]."""

    def position(self) -> Vector:
        """Places of the ends now, (n,) [m]."""

    def motion(self, load: DriveLoad, s: float) -> InterfaceMotion:
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
        """Restore a snapshot of ``save``."""


Reader = Callable[[], Vector]


class RopePlant(Protocol):
    """A balance rope between two moving ends, in an FMU or in this process.

    Names of signals are those of the FMI interface, e.g. ``left.fy`` [N], the rope's force on the
    left conveyance.
    """

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        """Find the hanging shape at time t0 [s]; readers then give the forces at rest."""

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Advance from t to t + h [s]; ``left`` and ``right`` hold at t + h."""

    def units(self) -> dict[str, str]:
        """FMI unit of each signal of which a run makes a record, "1" or "" where it has none."""

    def reader(self, names: Sequence[str]) -> Reader:
        """Return a function that reads these outputs now, also those without a record.

        Booleans are 0 and 1, outputs that the rope lacks are NaN. The function may be made before
        the rope hangs; its array is the caller's.
        """

    def save(self) -> Any:
        """Return the complete state as a snapshot in memory, None if the rope cannot."""

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot: whatever comes next is the same to the bit."""

    def to_bytes(self, snapshot: Any) -> bytes:
        """Serialize a snapshot for a file."""

    def from_bytes(self, data: bytes) -> Any:
        """Deserialize the bytes of ``to_bytes``, of any instance; ValueError if they do not fit."""

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
    """Drive and rope of a co-simulation: a scheme steps both, and reads the rope's forces."""

    def __init__(
        self, drive: DrivePartner, rope: RopePlant, clock: Stopwatch | None = None
    ) -> None:
        """``rope`` hangs; ``clock`` counts the time that it takes."""
        self.drive = drive
        self.rope = rope
        self._clock = clock or Stopwatch()
        self._read_forces = rope.reader(ROPE_FORCES)
        self._read_added_masses = rope.reader(ADDED_MASSES)
        self._forces: Vector | None = None  # ROPE_FORCES, None where they have to be read
        self._work_before = 0.0  # J, on the drive, where the step began
        self._position_before = np.zeros(len(SIDES))  # m, of the drive, where the step began

    def step_rope(self, t: float, h: float, motion: InterfaceMotion) -> Status:
        """Advance the rope from t to t + h [s], where the motion holds."""
        with self._clock:
            return self.read_rope(t, self.rope.step(t, h, *self.drive.ends(motion)))

    def read_rope(self, t: float, status: Status) -> Status:
        """Read the rope's forces behind its step from t [s]; ``status`` is that of the step."""
        response = read_response(status, self._read_forces)
        self._forces = response.forces
        if response.status.valid:
            return response.status
        return Status(False, f"rope, step from t = {t:.6g} s: {response.status.message}")

    def step(self, t: float, h: float, load: DriveLoad) -> Status:
        """Advance the drive under the load by one step, and the rope along the drive's motion."""
        status = self.step_drive(t, h, load)
        if not status.valid:
            return status
        return self.step_rope(t, h, self.drive.motion(load, 1.0))

    def step_drive(self, t: float, h: float, load: DriveLoad) -> Status:
        """Advance the drive alone from t to t + h [s]."""
        self._work_before = self.drive.work()
        self._position_before = self.drive.position()
        return self.drive.step(t, h, load)

    def forces(self) -> tuple[Vector, Vector]:
        """Return the rope's force now, and its mean over the last step, each (n,) [N]."""
        if self._forces is None:
            self._forces = self._read_forces()
        return self._forces[: len(SIDES)], self._forces[len(SIDES) :]

    def added_mass(self) -> Vector:
        """Return the fall of the forces per acceleration that grows over a step, (n,) [kg].

        Raises ParticipantFailed if the rope does not compute it.
        """
        with self._clock:
            added = self._read_added_masses()
        if not np.isfinite(added).all():
            raise ParticipantFailed(
                f"the rope's added mass, outputs {' and '.join(ADDED_MASSES)}, must be known, "
                f"it is {added}: take gauss-seidel-1 or iterative-secant"
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
        """Return the state of a scheme that begins at t [s].

        Before it everything counts as at rest.
        """
        force, mean = self.forces()
        acceleration = self.drive.motion(DriveLoad.constant(force), 1.0).acceleration
        return SchemeState((Sample(t, force, mean, acceleration),))

    def exchanged(self, scheme_state: SchemeState, t: float, load: DriveLoad) -> SchemeState:
        """Return the state behind a step that ended at t [s], where ``load`` acts.

        Its residual grows by the drive's work less the rope's, which is the mean force times the
        distance to the third order in h.
        """
        force, mean = self.forces()
        sample = Sample(t, force, mean, self.drive.motion(load, 1.0).acceleration)
        distance = self.drive.position() - self._position_before
        residual = self.drive.work() - self._work_before - float((mean * distance).sum())
        return scheme_state._replace(
            samples=(*scheme_state.samples, sample)[-HISTORY:],
            exchanges=scheme_state.exchanges + 1,
            residual=scheme_state.residual + residual,
        )

    def exchange(self, scheme_state: SchemeState, t: float, h: float, load: DriveLoad) -> Advance:
        """Do the step under a load, drive first, and return the new state."""
        status = self.step(t, h, load)
        if not status.valid:
            return Advance(scheme_state, status)
        return Advance(self.exchanged(scheme_state, t + h, load))


class RopeResponse(NamedTuple):
    """Status of a start or step of the rope, and its ROPE_FORCES; None where it failed."""

    status: Status
    forces: Vector | None = None


def read_response(status: Status, read: Reader) -> RopeResponse:
    """Read ROPE_FORCES behind a start or step that had ``status``.

    It fails unless they are finite.
    """
    if not status.valid:
        message = status.message or "status.valid is false, without a message"
        return RopeResponse(Status(False, message))
    forces = read()
    if math.isfinite(sum(forces.tolist())):
        return RopeResponse(status, forces)
    bad = [name for name, force in zip(ROPE_FORCES, forces, strict=True) if not np.isfinite(force)]
    message = f"{', '.join(bad)} missing or not finite: check the rope plant"
    return RopeResponse(Status(False, message))


class Scheme(Protocol):
    """Method of exchanging forces and motions over a communication step."""

    @property
    def weights(self) -> tuple[float, ...]:
        """Weights of past forces in a step's mean load, latest first; none if it is iterated."""

    @property
    def needs_rollback(self) -> bool:
        """True if steps are taken back, for which the rope must save and restore its state."""

    @property
    def needs_added_mass(self) -> bool:
        """True if the rope must give its added mass."""

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        """Advance both partners from t to t + h [s].

        If that fails, each may be anywhere between.
        """
