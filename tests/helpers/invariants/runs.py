"""A case wound, what is read after each step, and the comparison of two records."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from signal_names import of_both_ends

from invariants.case import Array, Case
from rope_model import BalanceRope, balance_rope

FORCES = of_both_ends("fx", "fy", "fz")
MOMENTS = of_both_ends("mx", "my", "mz")
MEANS = of_both_ends("fy_mean")
PLACE = ("loop.x", "loop.y", "loop.z")
SWIVELS = of_both_ends("swivel.angle", "swivel.rate", "swivel.torque")
ENERGIES = ("energy.kinetic", "energy.strain", "energy.work_ends", "energy.residual")
COUNTS = (
    "count.steps",
    "count.rejections",
    "count.newton",
    "count.transformations",
    "count.swivel_events",
)
BODIES = tuple(
    f"contact.{kind}" for kind in ("lining", "conveyance", "head_ropes", "divider", "floor", "rope")
)
GUARDS = ("guard.tripped", "guard.cause", "guard.time")
ESTIMATES = ("status.end_force_error", "status.loop_error", "audit.momentum")
#: elements times steps of a run, some 0.2 s of a processor; a longer run is cut to the
#: communication steps so far
WORK = 40_000
#: work of an element in contact with the rope's others, over that without
PAIRS = 10
READ = (
    *FORCES,
    *MOMENTS,
    *MEANS,
    *PLACE,
    "loop.yaw",
    *SWIVELS,
    *ENERGIES,
    *COUNTS,
    *BODIES,
    *GUARDS,
    *ESTIMATES,
)
_STEPS = READ.index("count.steps")


class Refused(Exception):
    """The product refuses a start or a step, in words."""


class Finding(Exception):
    """A relation is broken where no two numbers can be compared."""


@dataclass
class Record:
    """What was read after the start and after each step, (instants, READ), and why the run ended before its time."""

    case: Case
    rope: BalanceRope
    rows: list[Array] = field(default_factory=list)
    failure: str = ""

    def __post_init__(self) -> None:
        self._index = {name: k for k, name in enumerate(READ)}

    @property
    def table(self) -> Array:
        return np.array(self.rows)

    @property
    def times(self) -> Array:
        return self.case.times[: len(self.rows)]

    def __getitem__(self, name: str) -> Array:
        return self.table[:, self._index[name]]

    def several(self, names: Sequence[str]) -> Array:
        """(instants, names)."""
        return self.table[:, [self._index[name] for name in names]]

    @property
    def force(self) -> float:
        """Largest end force, N; at least the rope's weight, so that a share of it means something."""
        rope = self.case.scene.rope
        weight = rope.mass_per_length * rope.length * self.case.scene.layout.gravity
        return max(float(np.abs(self.several(FORCES)).max()), weight)

    @property
    def force_error(self) -> float:
        """Estimated RMS error of the end forces, N."""
        return float(self["status.end_force_error"][-1]) * self.force

    @property
    def unbalanced(self) -> float:
        """Force that Newton's method left without balance, N."""
        return float(self["audit.momentum"][-1])

    @property
    def largest_unbalanced(self) -> float:
        """Largest force that Newton's method left without balance in any step, N."""
        return float(self["audit.momentum"].max())

    @property
    def loop_error(self) -> float:
        """Estimated largest error of the loop's place, m."""
        return float(self["status.loop_error"][-1])


def made(case: Case) -> BalanceRope:
    try:
        rope = balance_rope(case.scene, "native")
    except ValueError as error:
        raise Refused(f"made: {error}") from error
    forces = case.point_forces()
    if forces is not None:
        rope.apply(forces)
    return rope


def start(case: Case) -> Record:
    """The rope hung up; Refused if it cannot hang."""
    rope = made(case)
    status = rope.initialize(case.start, *case.at(case.start))
    if not status.valid:
        raise Refused(f"hung: {status.message}")
    record = Record(case, rope)
    _read(record)
    return record


#: does something to the rope before step k, and returns the rope that goes on
Before = Callable[[BalanceRope, int], BalanceRope]


def wind(case: Case, before: Before | None = None, work: float | None = None) -> Record:
    """The case from its start to its end, to the step that is refused, or until it has taken ``work`` (WORK)."""
    bound = WORK if work is None else work
    record = start(case)
    each = record.rope.elements
    if case.scene.shaft.contact.rope_stiffness > 0:
        each *= PAIRS
    for k in range(1, len(case.times)):
        if each * record.rows[-1][_STEPS] > bound:
            record.case = case.with_(times=case.times[:k])
            break
        if before is not None:
            record.rope = before(record.rope, k)
        status = step(case, record.rope, k)
        if status:
            record.failure = status
            break
        _read(record)
    return record


def step(case: Case, rope: BalanceRope, k: int) -> str:
    """Step ``k`` of the case; what the rope says if it refuses."""
    t = float(case.times[k])
    given_at = t
    if case.late:
        given_at = float(case.times[k - 1])
    status = rope.advance_to(t, *case.at(given_at), given_at)
    if status.valid:
        return ""
    if len(status.message) < 20:
        raise Finding(f"a step to {t:g} s fails without a sentence: {status.message!r}")
    return status.message


def _read(record: Record) -> None:
    values = record.rope.signals(READ)
    row = np.array([*values.values()])
    if not np.isfinite(row).all():
        bad = [name for name, value in values.items() if not np.isfinite(value)]
        raise Finding(f"{', '.join(bad)} not finite at {record.rope.time:g} s")
    record.rows.append(row)


@dataclass(frozen=True)
class Compared:
    """A difference, and what it may be."""

    what: str
    difference: float
    tolerance: float

    @property
    def ratio(self) -> float:
        if not np.isfinite(self.difference):
            return float("inf")
        if self.difference <= self.tolerance <= 0.0:
            return 0.0
        return self.difference / max(self.tolerance, 1e-300)

    def __str__(self) -> str:
        return f"{self.what}: {self.difference:.3g}, bound {self.tolerance:.3g}"


def same_end(one: Record, other: Record) -> None:
    """Both runs end at the same step, or a relation is broken."""
    if len(one.rows) != len(other.rows):
        ended, words = min((len(x.rows), x.failure) for x in (one, other))
        raise Finding(
            f"one run of two ends at step {ended} of {len(one.case.times) - 1}: {words[:200]}"
        )


def rms(x: Array) -> float:
    if x.size == 0:
        return 0.0
    return float(np.sqrt(np.mean(x * x)))
