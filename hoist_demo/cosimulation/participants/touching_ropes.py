"""Ropes of a group that press each other: all take a step together, halved where they strike.

The neighbours' contact is rope_model's; here is what each rope's turn in a step is. The ends of a halved step lie on
the quintic that the whole has; the mean forces of its parts are put together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.schemes.interface import ENDS, Reader, RopePlant
from rope_model import BalanceRope, Contacts, EndMotion, Neighbours, Status

MEANS = tuple(f"{end}.fy_mean" for end in ENDS)
Ends = tuple[EndMotion, EndMotion]


class WholeRope(RopePlant, Protocol):
    """A RopePlant in this process."""

    @property
    def whole(self) -> BalanceRope | None:
        """The rope; None once it is broken."""


class Turn:
    """A rope's part in a step of all, which it may have to take several times, or in parts."""

    def __init__(self, rope: WholeRope, read: Reader, t: float, h: float, before: Ends, after: Ends) -> None:
        self.status, self.parts, self._impulse = Status(True), 0, np.zeros(len(MEANS))
        self._rope, self._read, self._t, self._h, self._before, self._after = rope, read, t, h, before, after
        self._part, self._kept = (t, h), None

    @property
    def rope(self) -> BalanceRope | None:
        """The rope; None once it is broken."""
        return self._rope.whole

    @property
    def means(self) -> NDArray[np.float64]:
        """MEANS of the whole step [N]."""
        return self._impulse / self._h

    def begin(self, t: float, h: float) -> None:
        """The next part is that to t + h [s]."""
        self._kept, self._part = self._rope.save(), (t, h)

    def go(self) -> bool:
        """Take it."""
        t, h = self._part
        done = t + h - self._t
        left, right = (
            after if done > (1.0 - 1e-9) * self._h else before.on_the_way(after, self._h, done)
            for before, after in zip(self._before, self._after, strict=True)
        )
        self.status = self._rope.step(t, h, left, right)
        return self.status.valid

    def back(self) -> None:
        """Back to where it begins."""
        self._rope.restore(self._kept)

    def accept(self) -> None:
        """Accept the step."""
        self.parts += 1
        self._impulse += self._part[1] * self._read()


class TouchingRopes:
    """The ropes of a group with their contact."""

    def __init__(self, ropes: Sequence[WholeRope], neighbours: Neighbours) -> None:
        self._ropes, self.neighbours = ropes, neighbours
        self._readers = [rope.reader(MEANS) for rope in ropes]
        self.means: list[NDArray[np.float64] | None] = []

    def initialize(self, t0: float, ends: Sequence[Ends]) -> list[Status]:
        """All ropes hang at t0 [s]."""
        statuses = [rope.initialize(t0, *pair) for rope, pair in zip(self._ropes, ends, strict=True)]
        whole = [rope.whole for rope in self._ropes if rope.whole is not None]
        if all(status.valid for status in statuses):
            self.neighbours.begin(t0, whole)
        self.means = [None] * len(self._ropes)
        return statuses

    def step(self, t: float, h: float, before: Sequence[Ends], after: Sequence[Ends]) -> list[Status]:
        """Advance all to t + h [s]."""
        turns = [
            Turn(rope, read, t, h, *ends)
            for rope, read, *ends in zip(self._ropes, self._readers, before, after, strict=True)
        ]
        self.neighbours.step(t, h, turns)
        self.means = [turn.means if turn.parts > 1 else None for turn in turns]
        return [turn.status for turn in turns]

    def save(self) -> Any:
        """Return the memory of the contact."""
        return self.neighbours.contacts, self.means

    def restore(self, snapshot: Any) -> None:
        """Go back to it."""
        contacts: Contacts
        contacts, self.means = snapshot
        self.neighbours.contacts = contacts
