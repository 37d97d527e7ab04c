"""Several balance ropes between the same two conveyances: one RopePlant, each with its data and suspension.

Forces and moments that the ropes put on the conveyances are added up (parameters.suspension). There the
growth of the yaw's rate is its change over the step.

Ropes that may press each other take a step together, halved where they strike: their contact is rope_model's, here is
what each rope's turn in a step is. The ends of a halved step lie on the quintic that the whole has; the mean forces of
its parts are put together.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.plain_data import from_bytes, to_bytes
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES, ENDS, Reader, RopePlant
from hoist_demo.parameters.suspension import MOVED, SuspensionOffset, moment_at, motion_at
from rope_model import Account, BalanceRope, EndMotion, Neighbours, Status

_TAG = "ropes of one hoist"
MEANS = tuple(f"{end}.fy_mean" for end in ENDS)
_ACTIONS = tuple(f"{end}.{name}" for end in ENDS for name in ("fx", "fy", "fz", "mx", "my", "mz"))
_PLAIN = tuple(
    f"{end}.{name}" for end in ENDS for name in ("fy_mean", "added_mass")
)  #: What is added up as it is.
#: Signals of the group: those of all its ropes together, moments about the conveyances' centres.
SUMS = (*_ACTIONS, *_PLAIN)
#: Of ropes that press each other: stored, done on them, dissipated, and made by the steps [J].
CONTACT_ENERGIES = tuple(f"neighbours.{name}" for name in ("energy", "work", "dissipated", "made"))
_Ends = tuple[EndMotion, EndMotion]


class WholeRope(RopePlant, Protocol):
    """A RopePlant in this process."""

    @property
    def whole(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""

    def data(self) -> RopeData:
        """Identity of the rope for the reports."""


@dataclass(frozen=True)
class Member:
    """One rope of a group, with its name and suspension."""

    name: str
    rope: RopePlant
    suspension: SuspensionOffset


class RopeGroup:
    """A RopePlant of several; signals of a member begin with its name."""

    def __init__(self, members: Sequence[Member], neighbours: Neighbours | None = None) -> None:
        """With `neighbours` the members, each a WholeRope, press each other."""
        names = [member.name for member in members]
        if not names or len({*names}) < len(names):
            raise ValueError(
                f"the ropes' names {', '.join(names)} must be different: name each rope"
            )
        self.members, self.neighbours = tuple(members), neighbours
        self._last: _Ends = EndMotion(), EndMotion()  # motions of the conveyances
        self._placed = list[_Ends]()  # motions of the ropes' ends
        self._means: list[NDArray[np.float64] | None] = [None] * len(
            names
        )  # mean forces of a halved step
        self._read_means = (
            [] if neighbours is None else [member.rope.reader(MEANS) for member in members]
        )

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self._last = left, right
        self._placed = [self._ends(m.suspension, 0.0, left, right) for m in self.members]
        statuses = [
            m.rope.initialize(t0, *ends) for m, ends in zip(self.members, self._placed, strict=True)
        ]
        if self.neighbours is not None and all(status.valid for status in statuses):
            self.neighbours.begin(
                t0, [whole for m in self.members if (whole := _whole(m.rope)) is not None]
            )
        self._means = [None] * len(self.members)
        return self._all(statuses)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        ends = [self._ends(m.suspension, h, left, right) for m in self.members]
        self._last = left, right
        before, self._placed = self._placed, ends
        if self.neighbours is None:
            return self._all(
                [m.rope.step(t, h, *pair) for m, pair in zip(self.members, ends, strict=True)]
            )
        parts = zip(self.members, self._read_means, before, ends, strict=True)
        turns = [Turn(m.rope, read, t, h, *motions) for m, read, *motions in parts]
        self.neighbours.step(t, h, turns)
        self._means = [turn.means if turn.parts > 1 else None for turn in turns]
        return self._all([turn.status for turn in turns])

    def reader(self, names: Sequence[str]) -> Reader:
        name_set = set(names)
        plain = [name for name in _PLAIN if name in name_set]
        summed = [*_ACTIONS, *plain] if name_set.intersection(SUMS) else []
        own = [
            [n.removeprefix(f"{m.name}.") for n in names if n.startswith(f"{m.name}.")]
            for m in self.members
        ]
        readers = [
            m.rope.reader([*summed, *part]) for m, part in zip(self.members, own, strict=True)
        ]
        contact = [*self._contact()]
        shown = [
            *contact,
            *summed,
            *(f"{m.name}.{n}" for m, part in zip(self.members, own, strict=True) for n in part),
        ]
        index = {name: k for k, name in enumerate(shown)}
        order = [index.get(name, len(shown)) for name in names]

        def read() -> NDArray[np.float64]:
            values = [self._over_parts(k, summed, r()) for k, r in enumerate(readers)]
            total = np.zeros(len(summed))
            for member, one in zip(self.members, values, strict=True):
                if summed:
                    total += one[: len(summed)]
                    total[: len(_ACTIONS)] += _moments(one, member.suspension, self._last)
            parts = [one[len(summed) :] for one in values]
            return np.concatenate([[*self._contact().values()], total, *parts, [math.nan]])[order]

        return read

    def units(self) -> dict[str, str]:
        """Unit of SUMS but the added masses, and of each member's signals under its name."""
        first = self.members[0].rope.units()
        units = {name: first.get(name, "") for name in SUMS if name not in ADDED_MASSES}
        units |= {name: "N" if name.endswith(".force") else "J" for name in self._contact()}
        return units | {
            f"{m.name}.{name}": unit for m in self.members for name, unit in m.rope.units().items()
        }

    def save(self) -> Any:
        """Return the snapshots of all ropes; None if one of them cannot save."""
        snapshots = [m.rope.save() for m in self.members]
        contacts = None if self.neighbours is None else self.neighbours.contacts
        own = self._last, self._placed, self._means, contacts
        return None if any(one is None for one in snapshots) else (snapshots, own)

    def restore(self, snapshot: Any) -> None:
        snapshots, (self._last, self._placed, self._means, contacts) = snapshot
        if self.neighbours is not None:
            self.neighbours.contacts = contacts
        for member, one in zip(self.members, snapshots, strict=True):
            member.rope.restore(one)

    def to_bytes(self, snapshot: Any) -> bytes:
        """Return a snapshot of all ropes as bytes; RuntimeError for a rope whose state cannot be written."""
        snapshots, own = snapshot
        ropes = [m.rope.to_bytes(one) for m, one in zip(self.members, snapshots, strict=True)]
        return to_bytes((_TAG, [m.name for m in self.members], ropes, own))

    def from_bytes(self, data: bytes) -> Any:
        """Return the snapshot that `to_bytes` was given; ValueError for the state of other ropes."""
        tag, names, ropes, own = from_bytes(data)
        here = [m.name for m in self.members]
        if (tag, names) != (_TAG, here):
            raise ValueError(
                f"the state must be that of the ropes {', '.join(here)}: give one of this hoist"
            )
        return [m.rope.from_bytes(one) for m, one in zip(self.members, ropes, strict=True)], own

    def close(self) -> None:
        for member in self.members:
            member.rope.close()

    def accounts(self) -> dict[tuple[str, str], Account]:
        """Contact accounts of each two ropes that may press each other, by their names."""
        by_place = {} if self.neighbours is None else self.neighbours.contacts.accounts
        return {
            (self.members[i].name, self.members[j].name): account
            for (i, j), account in by_place.items()
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
        energies = [(x.energy, x.work, x.dissipated, x.made) for x in accounts.values()]
        sums = np.array(energies).reshape(-1, 4).sum(axis=0)
        return forces | dict(zip(CONTACT_ENERGIES, sums.tolist(), strict=True))

    def _over_parts(
        self, k: int, summed: Sequence[str], values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return a rope's values, with the mean forces of the whole step where it was halved."""
        if (means := self._means[k]) is not None:
            for name, mean in zip(MEANS, means, strict=True):
                if name in summed:
                    values[summed.index(name)] = mean
        return values

    def _ends(
        self, suspension: SuspensionOffset, h: float, left: EndMotion, right: EndMotion
    ) -> _Ends:
        """Motions of a rope's ends at the end of a step."""
        was_left, was_right = self._last
        return (
            _end(left, suspension.at("left"), was_left.yaw_rate, h),
            _end(right, suspension.at("right"), was_right.yaw_rate, h),
        )

    def _all(self, statuses: Sequence[Status]) -> Status:
        """Return one status for all ropes, valid if all are."""
        failed = [(m.name, s) for m, s in zip(self.members, statuses, strict=True) if not s.valid]
        return Status(not failed, "; ".join(f"{name}: {status.message}" for name, status in failed))


class Turn:
    """A rope's part in a step of all, which it may have to take several times, or in parts."""

    def __init__(
        self, rope: RopePlant, read: Reader, t: float, h: float, before: _Ends, after: _Ends
    ) -> None:
        self.status, self.parts, self._impulse = Status(True), 0, np.zeros(len(MEANS))
        self._rope, self._read, self._t, self._h, self._before, self._after = (
            rope,
            read,
            t,
            h,
            before,
            after,
        )
        self._part = (t, h)
        self._kept = None

    @property
    def rope(self) -> BalanceRope | None:
        """Rope before it breaks, else None."""
        return _whole(self._rope)

    @property
    def means(self) -> NDArray[np.float64]:
        """MEANS over the whole step [N], (2,)."""
        return self._impulse / self._h

    def begin(self, t: float, h: float) -> None:
        """Save the rope's state and set the next part of the step, to t + h [s]."""
        self._kept, self._part = self._rope.save(), (t, h)

    def go(self) -> bool:
        """Advance the rope over the part; return True if it succeeds."""
        t, h = self._part
        done = t + h - self._t
        left, right = (
            after if done > (1.0 - 1e-9) * self._h else before.on_the_way(after, self._h, done)
            for before, after in zip(self._before, self._after, strict=True)
        )
        self.status = self._rope.step(t, h, left, right)
        return self.status.valid

    def back(self) -> None:
        """Restore the state in which the part begins."""
        self._rope.restore(self._kept)

    def accept(self) -> None:
        """Count the part, and add its impulse to the step's."""
        self.parts += 1
        self._impulse += self._part[1] * self._read()


def _whole(rope: RopePlant) -> BalanceRope | None:
    """Return the rope of a WholeRope; None once it is broken."""
    return getattr(rope, "whole", None)


def _end(
    conveyance: EndMotion, offset: tuple[float, float], rate_before: float, h: float
) -> EndMotion:
    """Return the motion of a conveyance's point at this offset, from its own nominal position."""
    if offset == (0.0, 0.0) or (
        conveyance.yaw == 0.0 and conveyance.yaw_rate == 0.0 and rate_before == 0.0
    ):
        return conveyance
    yaw_rate, c = conveyance.yaw_rate, conveyance
    yaw_acceleration = (yaw_rate - rate_before) / h if h > 0.0 else 0.0
    moved = motion_at(
        offset, [getattr(c, name) for name in MOVED], c.yaw, yaw_rate, yaw_acceleration
    )
    return replace(c, **dict(zip(MOVED, moved, strict=True)))


def _moments(
    values: NDArray[np.float64], suspension: SuspensionOffset, conveyances: _Ends
) -> NDArray[np.float64]:
    """Return the moments of a rope's forces about the centres, in the order of _ACTIONS."""
    moments = np.zeros((len(ENDS), 6))
    for k, end in enumerate(ENDS):
        moments[k, 3:] = moment_at(
            suspension.at(end), conveyances[k].yaw, values[6 * k : 6 * k + 3].tolist()
        )
    return moments.ravel()
