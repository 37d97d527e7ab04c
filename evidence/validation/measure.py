"""All rows of the page, and the tables behind them."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from evidence.tables import Measures, Table, Tables, rows
from evidence.validation import buckle, cabledyn, chains, coupled, onset, poses, wires
from evidence.validation.row import Row, as_table, from_table

ALONE = "make validate"


def _wires(t: Table) -> Iterator[Row]:
    for k, wire in enumerate(wires.WIRES, 1):
        least = min(wire.twists)
        most = max(wire.twists)
        source = f"{wire.name} wire of {1e3 * wire.mass:.1f} g/m, {least:.0f} to {most:.0f} deg in five tests"
        for part, gaps, bound in (
            ("a", wires.GAPS, 0.5 * wires.STEP),
            ("b", (wires.GAP,), math.nan),
        ):
            span = " to ".join(f"{1e3 * gap:.0f}" for gap in dict.fromkeys((gaps[0], gaps[-1])))
            what = f"critical twist, ends {span} mm apart: outside computed range by"
            yield Row(
                f"W-{k}{part}",
                "measured",
                source,
                what,
                wires.outside(t, wire.name, gaps),
                "deg",
                bound,
                ALONE,
            )


def _poses(t: Table) -> Iterator[Row]:
    for k, pose in enumerate(poses.POSES, 1):
        source = f"wires of 0.4 m held by a robot, pose {k}, then turned by {pose.turn:g} deg"
        what = "shape, worst wire and stiffness: RMS deviation"
        value = float(np.max(rows(t, pose=k)["apart"]))
        yield Row(f"W-{k + 3}", "measured", source, what, value, "mm", math.nan, ALONE)


def _pulls(t: Table) -> Iterator[Row]:
    source = "folded chain: pull of the held end (1 + x)/2 + x (2 - x)/(4 (1 - x)), borne out by a measurement"
    for k, (x, ours, chain) in enumerate(zip(t["depth"], t["ours"], t["chain"], strict=True), 1):
        # the theory's fold has no size; ours takes FOLD of the 1 - x that still falls, which is no longer little at 0.9
        bound = chains.FOLD / (1 - x) if x < 0.8 else math.nan
        what = f"pull at a fall of {x:g} of the length: deviation"
        yield Row(f"C-{k}", "theory", source, what, abs(ours / chain - 1), "1", bound, ALONE)
    source = "folded chain that keeps its energy falls in 0.847 sqrt(2 L/g)"
    yield Row(
        "C-6",
        "theory",
        source,
        "fall time: deviation",
        abs(chains.fall_time()),
        "1",
        chains.FOLD,
        ALONE,
    )


def swing_rows(t: Table) -> Iterator[Row]:
    """Frequencies; 1e-4 leaves room for the stretch by rho g L/(2 Qa) = 4e-5 and, in the last mode, for EI."""
    test = "test_a_hanging_rope_swings_with_the_zeros_of_j0"
    for k, ours, chain in zip(t["mode"], t["ours"], t["chain"], strict=True):
        source = f"hanging chain, zero {k:.0f} of J0"
        yield Row(
            f"F-{k:.0f}",
            "theory",
            source,
            "frequency: deviation",
            abs(ours / chain - 1),
            "1",
            1e-4,
            test,
        )


def onset_rows(t: Table) -> Iterator[Row]:
    """Ours differ by half the stretch T/Qa, which the theory leaves out."""
    test = "test_a_clamped_rod_buckles_at_the_torque_of_the_theory"
    for k, (size, printed, exact, ours) in enumerate(zip(*t.values(), strict=True), 1):
        source = f"clamped rod, T L^2/EI = {size:.0f}: {printed:.4f} times 2 sqrt(EI T), as CableDyn's page prints it"
        # four decimals are printed
        yield Row(
            f"B-{k}a",
            "theory",
            source,
            "factor computed: deviation",
            abs(exact - printed),
            "1",
            5e-5,
            test,
        )
        yield Row(
            f"B-{k}b",
            "theory",
            source,
            "this model: deviation",
            abs(ours / exact - 1),
            "1",
            onset.STRETCH,
            test,
        )


def _winding(t: Table) -> Iterator[Row]:
    """A tenth of what half the step or twice the elements changed in a lift of 40 m in 8 s, which is not this one."""
    ours = rows(t, code="ours")
    theirs = rows(t, code="CableDyn")
    rope = "120 m of rope, clamped as a U, twisted by 90 deg"
    source = f"CableDyn 0.3.0: {rope}, one end raised by 60 m in 10 s, then 4 s at rest"
    for k, name, what, bound in (
        (1, "moving", "pull of the moving end", 9e-4),
        (2, "held", "pull of the held end", 1.2e-4),
        (3, "torque", "torque", 2e-4),
    ):
        off = float(np.max(np.abs(ours[name] - theirs[name])) / np.max(np.abs(theirs[name])))
        yield Row(
            f"D-{k}", "code", source, f"{what}: deviation / largest value", off, "1", bound, ALONE
        )
    yield Row(
        "D-4",
        "code",
        source,
        "node positions: deviation",
        float(np.max(ours["apart"])),
        "m",
        4e-4,
        ALONE,
    )


def _coupled_rest(t: Table) -> Iterator[Row]:
    """At the height where the difference is the largest part of what is accepted."""
    heights = ", ".join(f"{height:g}" for height in coupled.HEIGHTS)
    source = f"CableDyn 0.3.0 by equivalence: 120 m of coupled rope at rest, ends {heights} m apart in height"
    for k, (quantity, unit) in enumerate(coupled.QUANTITIES, 5):
        r = rows(t, quantity=quantity)
        worst = int(np.argmax(r["difference"] / r["accepted"]))
        off, bound = (float(r[name][worst]) for name in ("difference", "accepted"))
        yield Row(f"D-{k}", "code", source, f"{quantity}: deviation", off, unit, bound, ALONE)


def _coupled_winding(t: Table) -> Iterator[Row]:
    """What twice the elements and half the step changed in ours, together."""
    ours = rows(t, code="ours")
    theirs = rows(t, code="CableDyn")
    source = "CableDyn 0.3.0 by equivalence: 120 m of coupled rope, one end raised by 60 m in 10 s, then 4 s at rest"
    off = {name: np.abs(ours[name] - theirs[name]) for name in ("torque", "moving", "held")}
    value = float(np.sqrt(np.mean(off["torque"] ** 2)))
    torque = float(np.sqrt(np.mean(theirs["torque"] ** 2)))
    yield Row(
        "D-8",
        "code",
        source,
        f"torque of {torque:.2g} N m RMS: RMS deviation",
        value,
        "N m",
        5e-3,
        ALONE,
    )
    for k, name, what, bound in (
        (9, "moving", "pull of the moving end: deviation", 1.3),
        (10, "held", "pull of the held end: deviation", 0.35),
    ):
        yield Row(f"D-{k}", "code", source, what, float(np.max(off[name])), "N", bound, ALONE)
    yield Row(
        "D-11",
        "code",
        source,
        "node positions: deviation",
        float(np.max(ours["apart"])),
        "m",
        0.01,
        ALONE,
    )


def _buckles(t: Table) -> Iterator[Row]:
    """The theory's rod is endless and does not stretch; ours is 25 of its buckle's lengths long."""
    for k, (turns, *values) in enumerate(zip(*t.values(), strict=True), 3):
        source = f"a rod with slack, its end turned by {turns:g} turns: localised buckle"
        for part, what, (ours, exact) in (("a", "torque", values[:2]), ("b", "pull", values[2:])):
            yield Row(
                f"B-{k}{part}",
                "theory",
                source,
                f"{what}: deviation",
                abs(ours / exact - 1),
                "1",
                1e-3,
                ALONE,
            )


#: by table: what measures it, and what its rows are
PARTS: dict[str, tuple[Callable[[], Table], Callable[[Table], Iterator[Row]]]] = {
    "wires": (wires.measure, _wires),
    "poses": (poses.measure, _poses),
    "pulls": (chains.pulls, _pulls),
    "swings": (chains.swings, swing_rows),
    "onsets": (onset.measure, onset_rows),
    "buckles": (buckle.measure, _buckles),
    "winding": (cabledyn.winding, _winding),
    "coupled_rest": (coupled.rest, _coupled_rest),
    "coupled_winding": (coupled.winding, _coupled_winding),
}


#: tables that the page shows besides the rows
SHOWN = ("wires", "poses", "pulls", "coupled_rest", "coupled_winding")


def tables() -> Tables:
    """Measure all rows; some ten minutes."""
    found = {name: part[0]() for name, part in PARTS.items()}
    judged = [row for name, part in PARTS.items() for row in part[1](found[name])]
    return {**{name: found[name] for name in SHOWN}, "rows": as_table(judged)}


def missed(recorded: Tables) -> Iterator[str]:
    """Yield the rows that miss their acceptance."""
    return (
        f"{row.id} {row.what} {row.value:.3g}" for row in from_table(recorded["rows"]) if row.misses
    )


MEASURES: Measures = {"rows": tables}
