"""Communication steps, rounding of inputs, fidelities and small coupling: within the errors that a run says it has."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from ctypes import c_double

import numpy as np
from signal_names import SIDES

from invariants.books import require
from invariants.case import Array, Case
from invariants.features import Draws
from invariants.motions import Ends
from invariants.runs import (
    COUNTS,
    FORCES,
    MEANS,
    PLACE,
    Compared,
    Record,
    Refused,
    rms,
    start,
    step,
    wind,
)
from invariants.symmetries import ALL, SHARE, both, compared, values_of, with_changes
from rope_model import EndMotion
from rope_model.engine import NativeRope
from rope_model.signals.signal_table import LOADS

#: relative rounding of a motion that went through 14 decimals
ROUNDED = 1e-14
#: of the largest derivative: Newton's method leaves some of a step's force, and differences as much
#: of theirs
DERIVATIVE = 0.05
#: m/s^3 (rad/s^3), jerk of the largest change of an input: the input filter follows no larger one
#: at once
JERK = 0.05
#: rad, largest change of a lean
LEAN = 1e-6
#: shares of the largest change that are tried
SHARES = (1.0, 0.1, 0.01)
#: of the largest load: what Newton's corrections leave in a difference
LEFT_BY_NEWTON = 1e-9
#: of the largest force: what forces of two runs differ by that both call exact
NOISE = 1e-5


def other_steps(case: Case, draws: Draws) -> Iterator[Compared]:
    """Twice as many communication steps; each run is within its own estimate."""
    case = case.with_(late=False)
    values = values_of(case.scene) | {"inputs.given": 0}
    case = case.with_(scene=with_changes(case.scene, values))
    one = wind(case)
    times = one.case.times
    halves = np.sort(np.concatenate((times, 0.5 * (times[1:] + times[:-1]))))
    try:
        two = wind(case.with_(times=halves), work=np.inf)
    except Refused as refusal:
        raise Refused(f"halved steps: {refusal}") from refusal
    last = min(len(one.rows), (len(two.rows) + 1) // 2)
    yield from within_estimates(one, two, _until(one, last), _until(two, 2 * last - 1)[::2])


def _until(record: Record, rows: int) -> Array:
    return record.table[:rows]


def within_estimates(one: Record, two: Record, first: Array, second: Array) -> Iterator[Compared]:
    """RMS of the end forces and the largest error of the loop's place, of rows of READ at the same instants."""
    from invariants.runs import READ

    forces = [*map(READ.index, FORCES)]
    places = [*map(READ.index, PLACE)]
    difference = second[:, forces] - first[:, forces]
    worst = max(rms(difference[:, k]) for k in range(difference.shape[1]))
    errors = one.force_error + two.force_error
    yield Compared("RMS of an end force", worst, SHARE * errors + NOISE * one.force)
    apart = float(np.abs(second[:, places] - first[:, places]).max())
    yield Compared("loop's place", apart, SHARE * (one.loop_error + two.loop_error) + 1e-5)


def rounded_inputs(case: Case, draws: Draws) -> Iterator[Compared]:
    """Motions rounded in the fifteenth digit."""

    def rounded(motion: EndMotion) -> EndMotion:
        return EndMotion(
            **{
                name: x * (1.0 + ROUNDED * draws.evenly(-1.0, 1.0))
                for name, x in vars(motion).items()
            }
        )

    def motion(t: float) -> Ends:
        left, right = case.at(t)
        return rounded(left), rounded(right)

    one, two = both(case, case.with_(motion=motion))
    yield from compared(one, two, {name: one[name] for name in ALL})


def small_coupling(case: Case, draws: Draws) -> Iterator[Compared]:
    """Coupling of a billionth of the usual one, and none."""
    values = values_of(case.scene) | {"model.fidelity": 1, "rope.Qb": 0.0, "rope.Qc": 0.0}
    case = case.with_(scene=with_changes(case.scene, values))
    tiny = {"rope.Qb": 1e-9 * case.scene.rope.Qa * case.scene.rope.diameter}
    tiny["rope.Qc"] = tiny["rope.Qb"] * draws.one_of(1.0, 1.0 + 1e-15, 0.9)
    one, two = both(
        case, case.with_(scene=with_changes(case.scene, {**values_of(case.scene), **tiny}))
    )
    yield from compared(one, two, {name: one[name] for name in ALL})


def flat(case: Case, draws: Draws) -> Iterator[Compared]:
    """A rope that nothing leads out of its plane: planar and spatial fidelity against the complete one."""
    require(case.moves_in_plane(), "motion out of plane")
    values = values_of(case.scene)
    for name in values:
        if name.startswith(
            ("rope.curvature_", "rope.initial_curvature", "rope.installed_twist", "guard.")
        ):
            values[name] = 0.0
    for name in ("guard.rise_y", "guard.window_y"):
        values[name] = -1e6
    values |= {
        "rope.Qb": 0.0,
        "rope.Qc": 0.0,
        "air.vz": 0.0,
        "air.vx": 0.0,
        "air.buffet": 0.0,
        "rope.EI_stick": 0.0,
    }
    values |= {
        "lining.width": 0.0,
        "conveyance.width": 0.0,
        "head_ropes.diameter": 0.0,
        "sump.level": -1e6,
    }
    values |= {f"divider_{k}.size": 0.0 for k in (1, 2, 3, 4)} | {
        "contact.rope_stiffness": 0.0,
        "air.density": 0.0,
    }
    coarse = draws.one_of(2, 3)
    case = case.with_(scene=with_changes(case.scene, {**values, "model.fidelity": 1}), force=None)
    other = case.with_(scene=with_changes(case.scene, {**values, "model.fidelity": coarse}))
    one, two = both(case, other)
    names = ("left.fx", "left.fy", "right.fx", "right.fy", *MEANS, "loop.x", "loop.y")
    yield from compared(one, two, {name: one[name] for name in names}, names)


def derivatives(case: Case, draws: Draws) -> Iterator[Compared]:
    """Derivatives of the end loads to an input against differences of the last step."""
    case = case.with_(scene=with_changes(case.scene, values_of(case.scene) | {"inputs.given": 0}))
    rope = start(case).rope
    assert isinstance(rope, NativeRope)
    last = min(len(case.times) - 1, 1 + int(draws.evenly(0.0, 20.0)))
    for k in range(1, last):
        if said := step(case, rope, k):
            raise Refused(said)
    kept = rope.native_state()
    fields = [*EndMotion.__dataclass_fields__]
    names = ("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "yaw", "yaw_rate")
    side = int(draws.chance(0.5))
    end = (case.scene.left, case.scene.right)[side]
    leans: tuple[str, ...] = ()
    if end.attachment == "clamped":
        leans = ("lean", "lean_z")
    name = draws.one_of("y", "vy", "ay", "ay", *names, *leans)
    order = (name[0] == "v" or name == "yaw_rate") + 2 * (name[0] == "a")
    size = JERK * float(case.times[last] - case.times[last - 1]) ** (3 - order)
    if name in leans:
        size = LEAN

    def loads(change: float) -> tuple[Array, list[float]]:
        rope.restore_native(kept)

        def motion(t: float) -> Ends:
            ends = [*case.at(t)]
            ends[side] = EndMotion(**{**vars(ends[side]), name: getattr(ends[side], name) + change})
            return ends[0], ends[1]

        if said := step(case.with_(motion=motion), rope, last):
            raise Refused(said)
        found = rope.signals((*LOADS, *COUNTS))
        return np.array([found[x] for x in LOADS]), [found[x] for x in COUNTS]

    _, taken = loads(0.0)
    lib = rope.library.lib
    handle = rope.library.rope
    found = (c_double * 12)()
    number = len(fields) * side + fields.index(name)
    if not lib.rope_load_derivative(handle, number, int(not case.late), found):
        raise Refused(rope.status_of(0).message)
    derivative = np.array(found)

    def against(change: float) -> list[Compared]:
        more, steps_more = loads(change)
        less, steps_less = loads(-change)
        if not steps_more == steps_less == taken:
            return []
        difference = (more - less) / (2 * change)
        rounding = LEFT_BY_NEWTON * float(np.abs(more).max()) / change
        return [
            Compared(
                f"derivative of a {kind} to {SIDES[side]}.{name}",
                float(np.abs(derivative[mine] - difference[mine]).max()),
                DERIVATIVE * float(np.abs(difference[mine]).max()) + rounding,
            )
            for kind, mine in (("force", [0, 1, 2, 6, 7, 8]), ("moment", [3, 4, 5, 9, 10, 11]))
        ]

    tried = [found for share in SHARES if (found := against(share * size))]
    require(bool(tried), "steps of other lengths or with other corrections")
    # a large change is not followed as a small one is, and a small one is lost in rounding
    yield from min(tried, key=lambda both: max(x.ratio for x in both))


RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (
    other_steps,
    rounded_inputs,
    small_coupling,
    flat,
    derivatives,
)
