"""A rope that breaks: until then any other, from then on the pieces at both ends, in closed form.

The legs are taken for straight and the loop for a point, so a leg is h = (L +- (y_L - y_R)) / 2
long. Of a piece of the length p longer than its leg, the part beyond the loop falls freely behind
the break and stops as it passes the fold, without rebound. With r the end's height over the break,

    h = (p + r) / 2 ,    F = -m h (g + a) - m r'^2 / 2 ,

until r = p and the piece hangs,

    F = -m p (g + a) ,

which is the momentum of the whole piece, its falling part weightless. A piece shorter than its leg
hangs at once. Waves along the rope, the whip of its end and its impacts are not computed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.plain_data import from_bytes, to_bytes
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.participants.rope_group import WholeRope
from hoist_demo.cosimulation.schemes.interface import SUCCESS, Reader, end_signals
from hoist_demo.parameters import GRAVITY
from rope_model import SIDES, BalanceRope, EndMotion, Status
from rope_model.physics.inextensible import left_leg_length

_TAG = "rope that breaks"
_ZERO_LOADS = end_signals("fx", "fz", "mx", "my", "mz")  #: Loads that a broken rope does not have.
_Ends = tuple[EndMotion, EndMotion]


@dataclass(frozen=True)
class Break:
    """Place and time of a rope's break: the first communication point from ``t`` on."""

    t: float  # s
    s: float  # m, along the rope from its left end
    gravity: float = GRAVITY  # m/s^2, of the pieces


@dataclass(frozen=True)
class Piece:
    """Piece that hangs from one end after the break at ``t``."""

    t: float  # s
    mass: float  # kg/m
    length: float  # m
    break_height: float  # m, at t
    break_speed: float  # m/s, at t
    gravity: float = GRAVITY  # m/s^2

    @staticmethod
    def of(
        t: float, mass: float, length: float, leg: float, ends: _Ends, gravity: float = GRAVITY
    ) -> Piece:
        """Return the piece of a rope whose leg was ``leg`` long [m].

        ``ends`` are the motions of the end that the piece hangs from, and of the other one.
        """
        end, other = ends
        height = end.y - (2.0 * leg - length)
        speed = other.vy
        if length <= leg:
            height = end.y - length
            speed = end.vy
        return Piece(t, mass, length, break_height=height, break_speed=speed, gravity=gravity)

    def load(self, t: float, end: EndMotion) -> PieceLoad:
        """Return the load of the piece on its conveyance, which has the motion ``end`` at t [s]."""
        fallen = t - self.t
        r = end.y - (self.break_height + fallen * (self.break_speed - 0.5 * self.gravity * fallen))
        if r >= self.length:
            return PieceLoad(-self.mass * self.length * (self.gravity + end.ay), self.length)
        hanging = 0.5 * (self.length + r)
        rate = end.vy - self.break_speed + self.gravity * fallen
        force = -self.mass * (hanging * (self.gravity + end.ay) + 0.5 * rate**2)
        return PieceLoad(force, hanging)


class PieceLoad(NamedTuple):
    """Load of a piece on its conveyance."""

    force: float  # N, vertical
    hanging: float  # m, length that hangs from the conveyance


class BreakingRopeSnapshot(NamedTuple):
    """State of a BreakingRope in memory."""

    rope: Any  # snapshot of the rope before it breaks
    ends: _Ends  # motions of the ends
    pieces: tuple[Piece, Piece] | None  # None before the break
    outputs: dict[str, float]  # of the broken rope


class BreakingRope:
    """A RopePlant that breaks; ``mass`` per length [kg/m] and ``length`` [m] are the rope's."""

    def __init__(self, rope: WholeRope, mass: float, length: float, at: Break) -> None:
        if not 0.0 <= at.s <= length:
            raise ValueError(
                f"breaks_s = {at.s:g} m must be within 0 and rope.length = {length:g} m: "
                "move it there"
            )
        self._rope = rope
        self._mass = mass
        self._length = length
        self._at = at
        self._ends: _Ends = (EndMotion(), EndMotion())
        self._pieces: tuple[Piece, Piece] | None = None
        self._outputs: dict[str, float] = {}  # of the broken rope

    @property
    def whole(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""
        if self._pieces is not None:
            return None
        return self._rope.whole

    def data(self) -> RopeData:
        return self._rope.data()

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self._pieces = None
        self._ends = (left, right)
        return self._rope.initialize(t0, left, right)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Advance to t + h.

        The rope breaks before the first step that begins at its time or later.
        """
        if self._pieces is None and t >= self._at.t:
            self._pieces = self._break(t)
            self._outputs = self._loads(t, self._ends)
        self._ends = (left, right)
        if self._pieces is None:
            return self._rope.step(t, h, left, right)
        before = self._outputs
        now = self._loads(t + h, self._ends)
        means = {f"{end}.fy_mean": 0.5 * (before[f"{end}.fy"] + now[f"{end}.fy"]) for end in SIDES}
        self._outputs = now | means
        return SUCCESS

    def _break(self, t: float) -> tuple[Piece, Piece]:
        """Return the pieces of a rope that breaks at t [s], left and right."""
        left, right = self._ends
        at = self._at
        leg = left_leg_length(self._length, left.y, right.y)
        return (
            Piece.of(t, self._mass, length=at.s, leg=leg, ends=(left, right), gravity=at.gravity),
            Piece.of(
                t,
                self._mass,
                length=self._length - at.s,
                leg=self._length - leg,
                ends=(right, left),
                gravity=at.gravity,
            ),
        )

    def _loads(self, t: float, ends: _Ends) -> dict[str, float]:
        """Return the outputs of the broken rope by name."""
        outputs = dict.fromkeys(_ZERO_LOADS, 0.0)
        for name, piece, end in zip(SIDES, self._pieces or (), ends, strict=True):
            load = piece.load(t, end)
            outputs[f"{name}.fy"] = load.force
            outputs[f"{name}.fy_mean"] = load.force
            outputs[f"{name}.added_mass"] = self._mass * load.hanging
        return outputs

    def reader(self, names: Sequence[str]) -> Reader:
        """Return a reader of some outputs; after the break NaN for all but the forces."""
        read = self._rope.reader(names)

        def values() -> NDArray[np.float64]:
            if self._pieces is None:
                return read()
            return np.array([self._outputs.get(name, math.nan) for name in names])

        return values

    def save(self) -> Any:
        rope_snapshot = self._rope.save()
        if rope_snapshot is None:
            return None
        return BreakingRopeSnapshot(rope_snapshot, self._ends, self._pieces, self._outputs)

    def restore(self, snapshot: BreakingRopeSnapshot) -> None:
        """Go back to a snapshot, to before the break, too."""
        self._ends = snapshot.ends
        self._pieces = snapshot.pieces
        self._outputs = snapshot.outputs
        self._rope.restore(snapshot.rope)

    def to_bytes(self, snapshot: BreakingRopeSnapshot) -> bytes:
        """Return a snapshot as bytes, with the break that it is bound to."""
        rope = self._rope.to_bytes(snapshot.rope)
        return to_bytes((_TAG, self._at, rope, snapshot.ends, snapshot.pieces, snapshot.outputs))

    def from_bytes(self, data: bytes) -> BreakingRopeSnapshot:
        """Return the snapshot of ``to_bytes``; ValueError for another rope or break."""
        tag, at, rope, ends, pieces, outputs = from_bytes(data)
        if (tag, at) != (_TAG, self._at):
            raise ValueError(
                f"the state must be that of a rope with breaks_at = {self._at.t:g} s "
                f"and breaks_s = {self._at.s:g} m: give the hoist of that run"
            )
        return BreakingRopeSnapshot(self._rope.from_bytes(rope), ends, pieces, outputs)

    def units(self) -> dict[str, str]:
        return self._rope.units()

    def close(self) -> None:
        self._rope.close()
