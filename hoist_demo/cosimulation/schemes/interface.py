"""Data that cross the interface, questions of a scheme to both partners, and its memory between steps.

load of a step      F(s) = start + rise s + bend s^2 - m_a a ,     a: acceleration of the drive's ends, s = 0 .. 1
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

KEPT = 3
"""Samples that are remembered: enough for a quadratic extrapolation."""


class Motion(NamedTuple):
    """Places, speeds and accelerations of the n interface coordinates at one instant, each (n,)."""

    place: Vector  # m
    speed: Vector  # m/s
    acceleration: Vector  # m/s^2


class Load(NamedTuple):
    """Forces on the drive over one step, each (n,), in N; the added mass in kg."""

    start: Vector
    rise: Vector
    bend: Vector
    added_mass: Vector

    @staticmethod
    def constant(force: Vector) -> Load:
        """Return a load with this force throughout."""
        zero = np.zeros(force.shape)
        return Load(force, zero, zero, zero)

    @staticmethod
    def through(start: Vector, mean: Vector, end: Vector) -> Load:
        """The parabola with these forces at both ends and this mean."""
        bend = 3.0 * (start + end) - 6.0 * mean
        return Load(start, end - start - bend, bend, np.zeros(start.shape))

    def at(self, s: float) -> Vector:
        """The part that does not depend on the acceleration."""
        force: Vector = self.start + s * (self.rise + s * self.bend)
        return force


class Sample(NamedTuple):
    """Data of both partners at one communication point; vectors (n,)."""

    t: float  # s
    force: Vector  # N, of the rope at t
    mean: Vector  # N, of the rope over the step that ended at t
    acceleration: Vector  # m/s^2, of the drive under the load that it had at t


class Memory(NamedTuple):
    """All that a scheme remembers; saving it with the partners' states is enough to go on."""

    samples: tuple[Sample, ...]  # the last KEPT, oldest first
    step_next: float = 0.0  # s, that the energy control would like; 0: not chosen yet
    exchanges: int = 0  # steps of the rope, those taken back included
    taken_back: int = 0  # of them
    residual: float = 0.0  # J, work that one partner gave and the other did not get, since the start

    @property
    def last(self) -> Sample:
        """The latest sample."""
        return self.samples[-1]

    def with_sample(self, sample: Sample, residual: float) -> Memory:
        """One more exchange that is kept, with the energy it made up [J]."""
        samples = (*self.samples, sample)[-KEPT:]
        return Memory(samples, self.step_next, self.exchanges + 1, self.taken_back, self.residual + residual)

    def with_taken_back(self, count: int = 1) -> Memory:
        """Exchanges that were done and undone."""
        return self._replace(exchanges=self.exchanges + count, taken_back=self.taken_back + count)


class Advance(NamedTuple):
    """Memory after a step, or that before it with the cause for which the step failed."""

    memory: Memory
    cause: str = ""


class DrivePartner(Protocol):
    """Takes forces, gives motions."""

    def step(self, t: float, h: float, load: Load) -> str:
        """Advance from t to t + h [s]; "" or the cause why not."""
        ...

    def place(self) -> Vector:
        """Places of the ends now, (n,) [m]."""
        ...

    def motion(self, load: Load, s: float) -> Motion:
        """Motion now, with the accelerations under the load as it is at s."""
        ...

    def mobility(self) -> Vector:
        """Change of the accelerations per force, (n, n) [1/kg]."""
        ...

    def work(self) -> float:
        """Work that the loads have done on the drive so far [J]."""
        ...

    def save(self) -> Any:
        """Return the present state."""
        ...

    def restore(self, snapshot: Any) -> None:
        """Go back to a saved state."""
        ...


class RopePartner(Protocol):
    """Takes motions, gives forces."""

    def step(self, t: float, h: float, motion: Motion) -> str:
        """Advance from t to t + h [s], where the motion holds; "" or the cause why not."""
        ...

    def forces(self) -> tuple[Vector, Vector]:
        """Force on the drive now, and its mean over the last step, each (n,) [N]."""
        ...

    def added_mass(self) -> Vector | None:
        """Return the fall of the forces per acceleration held over a step, (n,) [kg]; None if the rope has none."""
        ...

    def save(self) -> Any:
        """Return the present state."""
        ...

    def restore(self, snapshot: Any) -> None:
        """Go back to a saved state."""
        ...

    def free(self, snapshot: Any) -> None:
        """Give up a saved state."""
        ...


@dataclass(frozen=True)
class Pair:
    """The two partners of a co-simulation."""

    drive: DrivePartner
    rope: RopePartner

    def sample_at(self, t: float, load: Load) -> Sample:
        """Return the data of both partners at the end of a step under the load."""
        return Sample(t, *self.rope.forces(), self.drive.motion(load, 1.0).acceleration)

    def added_mass(self) -> Vector:
        """Return the added mass of a rope that must have one."""
        added = self.rope.added_mass()
        if added is None or not np.all(np.isfinite(added)):
            raise ValueError(f"the rope's added mass {added} must be finite: take a scheme that needs none")
        return added

    def start(self, t: float) -> Memory:
        """Memory of a scheme that begins now; before t everything is taken to have been at rest."""
        return Memory((self.sample_at(t, Load.constant(self.rope.forces()[0])),))

    def drive_then_rope(self, t: float, h: float, load: Load) -> str:
        """Both over one step: the rope follows the motion that the drive makes under the load."""
        return self.drive.step(t, h, load) or self.rope.step(t, h, self.drive.motion(load, 1.0))


class ExchangeBalance:
    """Energy that the exchange makes up in one step: what the drive got, less what the rope gave."""

    def __init__(self, pair: Pair, load: Load) -> None:
        self._drive, self._load = pair.drive, load
        self._work, self._place = pair.drive.work(), pair.drive.place()

    def residual(self, mean: Vector) -> float:
        """The step's residual [J]; the rope gave its mean force times the way, to the third order in h."""
        way = self._drive.motion(self._load, 1.0).place - self._place
        return self._drive.work() - self._work - float(mean.dot(way))


class Scheme(Protocol):
    """A way to exchange."""

    @property
    def weights(self) -> tuple[float, ...]:
        """Weights of past forces, latest first, in the mean load of a step; none when the load is iterated."""
        ...

    @property
    def needs_rollback(self) -> bool:
        """True if steps are taken back, for which the rope must save and restore its state."""
        ...

    @property
    def needs_added_mass(self) -> bool:
        """True if the rope must give its added mass."""
        ...

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        """Both partners from t to t + h [s]; when it fails their states may lie anywhere between."""
        ...
