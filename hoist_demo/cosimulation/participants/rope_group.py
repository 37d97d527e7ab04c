"""Several balance ropes between the same two conveyances: one RopePlant.

Each rope has its own data and suspension.
Forces and moments that the ropes put on the conveyances are added up (parameters.suspension). There
the growth of the yaw's rate is its change over the step.

Ropes that may press each other take a step together, halved where they strike: rope_model computes
their contact, and here is the part of each rope in a step. The ends of a halved step lie on the
quintic of the whole step; the mean forces of its parts are put together.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.plain_data import from_bytes, to_bytes
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES, Reader, RopePlant, end_signals
from hoist_demo.parameters.suspension import MOVED, SuspensionOffset, moment_at, motion_at
from rope_model import SIDES, Account, BalanceRope, EndMotion, Neighbours, Status

_TAG = "ropes of one hoist"
MEANS = end_signals("fy_mean")
_LOADS = ("fx", "fy", "fz", "mx", "my", "mz")
_END_LOADS = end_signals(*_LOADS)
_WITHOUT_LEVER = end_signals("fy_mean", "added_mass")  #: Signals that no suspension changes.
#: Signals of the group: sums over its ropes, moments about the conveyances' centres.
SUMS = (*_END_LOADS, *_WITHOUT_LEVER)
#: Of ropes that press each other: stored, done on them, dissipated, and error of the steps [J].
CONTACT_ENERGIES = tuple(f"neighbours.{name}" for name in ("energy", "work", "dissipated", "made"))
_END_OF_STEP = 1.0 - 1e-9  #: Part of a step from which on, up to rounding, its end is reached.
_Ends = tuple[EndMotion, EndMotion]
_Array = NDArray[np.float64]


class WholeRope(RopePlant, Protocol):
    """A RopePlant in this process."""

    @property
    def whole(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""

    def data(self) -> RopeData:
        """Identity of the rope for the reports."""


@dataclass(frozen=True)
class GroupedRope:
    """One rope of a group, with its name and suspension."""

    name: str
    rope: RopePlant
    suspension: SuspensionOffset

    @property
    def prefix(self) -> str:
        """Beginning of the names of its signals in the group."""
        return f"{self.name}."


class GroupSnapshot(NamedTuple):
    """State of a RopeGroup in memory."""

    ropes: list[Any]  # snapshots of the ropes
    conveyances: _Ends  # motions of the conveyances
    rope_ends: list[_Ends]  # motions of each rope's ends
    means: list[_Array | None]  # mean forces of a halved step
    contacts: Any  # of Neighbours; None for ropes that pass each other


class RopeGroup:
    """A RopePlant of several; signals of a member begin with its name."""

    def __init__(
        self, members: Sequence[GroupedRope], neighbours: Neighbours | None = None
    ) -> None:
        """With ``neighbours`` the members, each a WholeRope, press each other."""
        names = [member.name for member in members]
        if not names or len({*names}) < len(names):
            raise ValueError(
                f"the ropes' names {', '.join(names)} must be different: name each rope"
            )
        self.members = tuple(members)
        self.neighbours = neighbours
        self._conveyances: _Ends = (EndMotion(), EndMotion())
        self._rope_ends: list[_Ends] = []  # motions of the ropes' ends
        self._means: list[_Array | None] = [None] * len(names)  # mean forces of a halved step
        self._read_means: list[Reader] = []
        if neighbours is not None:
            self._read_means = [member.rope.reader(MEANS) for member in members]

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self._conveyances = (left, right)
        self._rope_ends = [self._ends(m.suspension, 0.0, left, right) for m in self.members]
        statuses = [
            member.rope.initialize(t0, *ends)
            for member, ends in zip(self.members, self._rope_ends, strict=True)
        ]
        if self.neighbours is not None and all(status.valid for status in statuses):
            ropes = [_whole(member.rope) for member in self.members]
            self.neighbours.begin(t0, [rope for rope in ropes if rope is not None])
        self._means = [None] * len(self.members)
        return self._combined(statuses)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        before = self._rope_ends
        ends = [self._ends(m.suspension, h, left, right) for m in self.members]
        self._conveyances = (left, right)
        self._rope_ends = ends
        if self.neighbours is None:
            statuses = [
                member.rope.step(t, h, *pair)
                for member, pair in zip(self.members, ends, strict=True)
            ]
            return self._combined(statuses)
        parts = zip(self.members, self._read_means, before, ends, strict=True)
        turns = [
            Turn(member.rope, read, Interval(t, h), start, end)
            for member, read, start, end in parts
        ]
        self.neighbours.step(t, h, turns)
        self._means = [turn.means if turn.parts > 1 else None for turn in turns]
        return self._combined([turn.status for turn in turns])

    def reader(self, names: Sequence[str]) -> Reader:
        summed: list[str] = []
        if not set(names).isdisjoint(SUMS):
            summed = [*_END_LOADS, *(name for name in _WITHOUT_LEVER if name in names)]
        columns = [*self._contact(), *summed]
        readers = []
        for member in self.members:
            of_member = [name for name in names if name.startswith(member.prefix)]
            in_rope = [name.removeprefix(member.prefix) for name in of_member]
            readers.append(member.rope.reader([*summed, *in_rope]))
            columns += of_member
        index = {name: k for k, name in enumerate(columns)}
        missing = len(columns)
        order = [index.get(name, missing) for name in names]

        def read() -> _Array:
            values = [self._over_parts(k, summed, r()) for k, r in enumerate(readers)]
            total = np.zeros(len(summed))
            for member, row in zip(self.members, values, strict=True):
                if summed:
                    total += row[: len(summed)]
                    total[: len(_END_LOADS)] += _moments(row, member.suspension, self._conveyances)
            contact = [*self._contact().values()]
            of_members = [row[len(summed) :] for row in values]
            return np.concatenate([contact, total, *of_members, [math.nan]])[order]

        return read

    def units(self) -> dict[str, str]:
        """Unit of SUMS but the added masses, and of each member's signals under its name."""
        first = self.members[0].rope.units()
        units = {name: first.get(name, "") for name in SUMS if name not in ADDED_MASSES}
        for name in self._contact():
            units[name] = "N" if name.endswith(".force") else "J"
        for member in self.members:
            units |= {f"{member.prefix}{n}": unit for n, unit in member.rope.units().items()}
        return units

    def save(self) -> GroupSnapshot | None:
        """Return the snapshots of all ropes; None if one of them cannot save."""
        ropes = [member.rope.save() for member in self.members]
        if any(rope is None for rope in ropes):
            return None
        if self.neighbours is None:
            contacts = None
        else:
            contacts = self.neighbours.contacts
        return GroupSnapshot(ropes, self._conveyances, self._rope_ends, self._means, contacts)

    def restore(self, snapshot: GroupSnapshot) -> None:
        self._conveyances = snapshot.conveyances
        self._rope_ends = snapshot.rope_ends
        self._means = snapshot.means
        if self.neighbours is not None:
            self.neighbours.contacts = snapshot.contacts
        for member, rope in zip(self.members, snapshot.ropes, strict=True):
            member.rope.restore(rope)

    def to_bytes(self, snapshot: GroupSnapshot) -> bytes:
        """Return a snapshot of all ropes as bytes; ParticipantFailed if a rope's cannot be written."""
        pairs = zip(self.members, snapshot.ropes, strict=True)
        ropes = [member.rope.to_bytes(rope) for member, rope in pairs]
        of_group = tuple(snapshot[1:])
        return to_bytes((_TAG, [member.name for member in self.members], ropes, of_group))

    def from_bytes(self, data: bytes) -> GroupSnapshot:
        """Return the snapshot of ``to_bytes``; ValueError for the state of other ropes."""
        tag, names, ropes, of_group = from_bytes(data)
        here = [member.name for member in self.members]
        if (tag, names) != (_TAG, here):
            raise ValueError(
                f"the state must be that of the ropes {', '.join(here)}: give one of this hoist"
            )
        pairs = zip(self.members, ropes, strict=True)
        return GroupSnapshot([member.rope.from_bytes(rope) for member, rope in pairs], *of_group)

    def close(self) -> None:
        for member in self.members:
            member.rope.close()

    def accounts(self) -> dict[tuple[str, str], Account]:
        """Contact accounts of each two ropes that may press each other, by their names."""
        if self.neighbours is None:
            return {}
        return {
            (self.members[i].name, self.members[j].name): account
            for (i, j), account in self.neighbours.contacts.accounts.items()
        }

    def _contact(self) -> dict[str, float]:
        """Return the signals of contact between the ropes; none if they pass each other."""
        if self.neighbours is None:
            return {}
        accounts = self.accounts()
        forces = {
            f"neighbours.{one}.{other}.force": account.pressure
            for (one, other), account in accounts.items()
        }
        energies = [(x.energy, x.work, x.dissipated, x.created) for x in accounts.values()]
        sums = np.array(energies).reshape(-1, len(CONTACT_ENERGIES)).sum(axis=0)
        return forces | dict(zip(CONTACT_ENERGIES, sums.tolist(), strict=True))

    def _over_parts(self, k: int, summed: Sequence[str], values: _Array) -> _Array:
        """Return a rope's values, with the mean forces of the whole step where it was halved."""
        means = self._means[k]
        if means is not None:
            for name, mean in zip(MEANS, means, strict=True):
                if name in summed:
                    values[summed.index(name)] = mean
        return values

    def _ends(
        self, suspension: SuspensionOffset, h: float, left: EndMotion, right: EndMotion
    ) -> _Ends:
        """Motions of a rope's ends at the end of a step."""
        left_before, right_before = self._conveyances
        return (
            _end(left, suspension.at("left"), left_before.yaw_rate, h),
            _end(right, suspension.at("right"), right_before.yaw_rate, h),
        )

    def _combined(self, statuses: Sequence[Status]) -> Status:
        """Return one status for all ropes, valid if all are."""
        failed = [(m.name, s) for m, s in zip(self.members, statuses, strict=True) if not s.valid]
        return Status(not failed, "; ".join(f"{name}: {status.message}" for name, status in failed))


class Interval(NamedTuple):
    """Interval of time from t to t + h."""

    t: float  # s
    h: float  # s


class Turn:
    """A rope's part in a step of all, which it may have to take several times, or in parts."""

    def __init__(
        self, rope: RopePlant, read: Reader, step: Interval, before: _Ends, after: _Ends
    ) -> None:
        """``read`` reads MEANS; ``before`` and ``after`` are the ends' motions around the step."""
        self.status = Status(True)
        self.parts = 0
        self._impulse = np.zeros(len(MEANS))
        self._rope = rope
        self._read = read
        self._step = step
        self._before = before
        self._after = after
        self._part = step
        self._snapshot: Any = None  # state in which the part begins

    @property
    def rope(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""
        return _whole(self._rope)

    @property
    def means(self) -> _Array:
        """MEANS over the whole step [N], (2,)."""
        return self._impulse / self._step.h

    def begin(self, t: float, h: float) -> None:
        """Save the rope's state and set the next part of the step, to t + h [s]."""
        self._snapshot = self._rope.save()
        self._part = Interval(t, h)

    def go(self) -> bool:
        """Advance the rope over the part; return True if it succeeds."""
        t, h = self._part
        left, right = self._ends_after(t + h - self._step.t)
        self.status = self._rope.step(t, h, left, right)
        return self.status.valid

    def _ends_after(self, elapsed: float) -> _Ends:
        """Return the motions of the ends so many seconds after the step's start."""
        h = self._step.h
        if elapsed > _END_OF_STEP * h:
            return self._after
        left, right = (
            before.on_the_way(after, h, elapsed)
            for before, after in zip(self._before, self._after, strict=True)
        )
        return left, right

    def back(self) -> None:
        """Restore the state in which the part begins."""
        self._rope.restore(self._snapshot)

    def accept(self) -> None:
        """Count the part, and add its impulse to the step's."""
        self.parts += 1
        self._impulse += self._part.h * self._read()


def _whole(rope: RopePlant) -> BalanceRope | None:
    """Return the rope of a WholeRope; None once it is broken."""
    return getattr(rope, "whole", None)


def _end(
    conveyance: EndMotion, offset: tuple[float, float], rate_before: float, h: float
) -> EndMotion:
    """Return the motion of a conveyance's point at this offset, from its own nominal position."""
    yaw = conveyance.yaw
    yaw_rate = conveyance.yaw_rate
    if offset == (0.0, 0.0) or yaw == yaw_rate == rate_before == 0.0:
        return conveyance
    yaw_acceleration = 0.0
    if h > 0.0:
        yaw_acceleration = (yaw_rate - rate_before) / h
    motion = [getattr(conveyance, name) for name in MOVED]
    moved = motion_at(offset, motion, yaw, yaw_rate, yaw_acceleration)
    return replace(conveyance, **dict(zip(MOVED, moved, strict=True)))


def _moments(values: _Array, suspension: SuspensionOffset, conveyances: _Ends) -> _Array:
    """Return the moments of a rope's forces about the centres, in the order of _END_LOADS."""
    loads = values[: len(_END_LOADS)].reshape(len(SIDES), len(_LOADS))
    moments = np.zeros(loads.shape)
    for k, end in enumerate(SIDES):
        force = loads[k, :3].tolist()
        moments[k, 3:] = moment_at(suspension.at(end), conveyances[k].yaw, force)
    return moments.ravel()
