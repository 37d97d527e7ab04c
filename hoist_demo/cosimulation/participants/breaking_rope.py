"""A rope that breaks: until then any other, from then on what hangs from either end, in closed form.

The legs are taken for straight and the loop for a point, so a leg is h = (L +- (y_L - y_R)) / 2 long. Of a piece of the
length p longer than its leg, what is beyond the loop falls freely behind the break, and what passes the fold is stopped
there, without rebound. With r the end's height over the break,

    h = (p + r) / 2 ,    F = -m h (g + a) - m r'^2 / 2 ,    until r = p and the piece hangs: F = -m p (g + a) ,

which is the momentum of the whole piece, its falling part weightless. A piece shorter than its leg hangs at once.
Waves along the rope, the whip of its end and what it strikes are not computed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.participants.rope_group import WholeRope
from hoist_demo.cosimulation.plain_data import from_bytes, to_bytes
from hoist_demo.cosimulation.schemes.interface import ENDS, Reader
from hoist_demo.parameters import GRAVITY
from rope_model import BalanceRope, EndMotion, Status

_TAG = "rope that breaks"
_NOTHING = tuple(f"{end}.{name}" for end in ENDS for name in ("fx", "fz", "mx", "my", "mz"))


@dataclass(frozen=True)
class Break:
    """Place and time of a rope's break: the first communication point from `t` on."""

    t: float  # s
    s: float  # m, along the rope from its left end
    gravity: float = GRAVITY  # m/s^2, of what then falls


@dataclass(frozen=True)
class Piece:
    """Piece that hangs from one end after the break at `t`."""

    t: float  # s
    mass: float  # kg/m
    length: float  # m
    break_height: float  # m, at t
    break_speed: float  # m/s, at t
    gravity: float = GRAVITY  # m/s^2

    @staticmethod
    def of(
        t: float,
        mass: float,
        length: float,
        leg: float,
        end: EndMotion,
        other: EndMotion,
        gravity: float = GRAVITY,
    ) -> Piece:
        """Return the piece of a rope whose leg at this end was `leg` long [m]."""
        if length <= leg:
            return Piece(t, mass, length, end.y - length, end.vy, gravity)
        return Piece(t, mass, length, end.y - (2.0 * leg - length), other.vy, gravity)

    def force(self, t: float, end: EndMotion) -> tuple[float, float]:
        """Return the vertical force on the conveyance [N] and the length that hangs from it [m]."""
        fallen = t - self.t
        r = end.y - (self.break_height + fallen * (self.break_speed - 0.5 * self.gravity * fallen))
        if r >= self.length:
            return -self.mass * self.length * (self.gravity + end.ay), self.length
        hanging, rate = 0.5 * (self.length + r), end.vy - self.break_speed + self.gravity * fallen
        return -self.mass * (hanging * (self.gravity + end.ay) + 0.5 * rate**2), hanging


class BreakingRope:
    """A RopePlant that breaks; `mass` per length [kg/m] and `length` [m] are the rope's."""

    def __init__(self, rope: WholeRope, mass: float, length: float, at: Break) -> None:
        if not 0.0 <= at.s <= length:
            raise ValueError(
                f"breaks_s = {at.s:g} m must be within 0 and rope.length = {length:g} m: move it there"
            )
        self._rope, self._mass, self._length, self._at = rope, mass, length, at
        self._ends: tuple[EndMotion, EndMotion] = (EndMotion(), EndMotion())
        self._pieces: tuple[Piece, Piece] | None = None
        self._shown: dict[str, float] = {}

    @property
    def whole(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""
        return self._rope.whole if self._pieces is None else None

    def data(self) -> RopeData:
        return self._rope.data()

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self._pieces, self._ends = None, (left, right)
        return self._rope.initialize(t0, left, right)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Advance to t + h; the rope breaks before the first step that begins at its time or later."""
        if self._pieces is None and t >= self._at.t:
            self._pieces = self._break(t)
            self._shown = self._forces(t, self._ends)
        self._ends = left, right
        if self._pieces is None:
            return self._rope.step(t, h, left, right)
        before, now = self._shown, self._forces(t + h, (left, right))
        self._shown = now | {
            f"{end}.fy_mean": 0.5 * (before[f"{end}.fy"] + now[f"{end}.fy"]) for end in ENDS
        }
        return Status(True)

    def _break(self, t: float) -> tuple[Piece, Piece]:
        left, right = self._ends
        at, leg = self._at, 0.5 * (self._length + left.y - right.y)
        return (
            Piece.of(t, self._mass, at.s, leg, left, right, at.gravity),
            Piece.of(
                t, self._mass, self._length - at.s, self._length - leg, right, left, at.gravity
            ),
        )

    def _forces(self, t: float, ends: tuple[EndMotion, EndMotion]) -> dict[str, float]:
        forces = dict.fromkeys(_NOTHING, 0.0)
        for name, piece, end in zip(ENDS, self._pieces or (), ends, strict=True):
            force, hanging = piece.force(t, end)
            forces |= {
                f"{name}.fy": force,
                f"{name}.fy_mean": force,
                f"{name}.added_mass": self._mass * hanging,
            }
        return forces

    def reader(self, names: Sequence[str]) -> Reader:
        """Return a reader of some outputs; after the break NaN for all but the forces."""
        read = self._rope.reader(names)

        def values() -> NDArray[np.float64]:
            if self._pieces is None:
                return read()
            return np.array([self._shown.get(name, math.nan) for name in names])

        return values

    def save(self) -> Any:
        rope_snapshot = self._rope.save()
        return (
            None
            if rope_snapshot is None
            else (rope_snapshot, self._ends, self._pieces, self._shown)
        )

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot, to before the break, too."""
        rope_snapshot, self._ends, self._pieces, self._shown = snapshot
        self._rope.restore(rope_snapshot)

    def to_bytes(self, snapshot: Any) -> bytes:
        """Return a snapshot as bytes, with the break that it is bound to."""
        rope_snapshot, ends, pieces, shown = snapshot
        return to_bytes((_TAG, self._at, self._rope.to_bytes(rope_snapshot), ends, pieces, shown))

    def from_bytes(self, data: bytes) -> Any:
        """Return the snapshot that `to_bytes` was given; ValueError for the state of another rope or break."""
        tag, at, rope, ends, pieces, shown = from_bytes(data)
        if (tag, at) != (_TAG, self._at):
            raise ValueError(
                f"the state must be that of a rope with breaks_at = {self._at.t:g} s and breaks_s = {self._at.s:g} m: "
                "give the hoist of that run"
            )
        return self._rope.from_bytes(rope), ends, pieces, shown

    def units(self) -> dict[str, str]:
        return self._rope.units()

    def close(self) -> None:
        self._rope.close()
