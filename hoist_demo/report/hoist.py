"""A hoist before it is wound, as text: the table of what follows from it, and its check in words."""

import math
from collections.abc import Iterator, Mapping, Sequence

from hoist_demo.design.hoist_checks import HOLD, CheckRow, HoistCheck
from hoist_demo.design.statics import pulls
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.report.rows import SummaryRow, render
from hoist_demo.run.at_rest import RopeAtRest, with_colon

SHOWN_CLEARANCE = 1e3  #: Clearances below it are shown [m]: beyond there is no body.
_AT_REST = "Rope at rest, left conveyance at"


def consequences_text(hoist: Hoist, checks: Sequence[CheckRow], ropes: Sequence[RopeAtRest]) -> str:
    """Return the table of what follows from a hoist before anything is wound."""
    rows = [_check_row(check) for check in checks if check.group == HOLD]
    for height in (0.0, hoist.shaft_travel):
        left, right = pulls(hoist, height)
        label = f"{left / 1e3:.4g} and {right / 1e3:.4g} kN"
        heads = f"pull of all head ropes, left and right, left conveyance at {height:g} m"
        rows.append(SummaryRow(HOLD, heads, label))
    rows.append(SummaryRow(HOLD, "all moving masses", hoist.moving_mass, "kg"))
    rows += [_check_row(check) for check in checks if check.group != HOLD]
    for rope in ropes:
        rows += _rope_rows(rope)
    return render(rows)


def check_in_words(check: HoistCheck) -> str:
    """Return how many problems a check found."""
    count = len(check.problems)
    if count == 0:
        return "no problems found"
    plural = "s" if count > 1 else ""
    return f"{count} problem{plural} found"


def _check_row(check: CheckRow) -> SummaryRow:
    kept = "kept" if check.holds else "NOT KEPT"
    text = f"{check.value}, at least {check.bound}: {kept}"
    return SummaryRow(check.group, check.quantity, text)


def _rope_rows(rope: RopeAtRest) -> Iterator[SummaryRow]:
    """Yield the rows of a rope: at rest at each height, its model and its lowest modes."""
    prefix = with_colon(rope.rope.name)
    for position in rope.positions:
        yield from _rows_at_rest(f"{prefix}{_AT_REST} {position.height:g} m", position.signals)
    group = f"{prefix}Model"
    model = f"{rope.fidelity} with {rope.elements} elements ({rope.fidelity_reason})"
    yield SummaryRow(group, "fidelity and mesh", model)
    yield SummaryRow(group, "frequencies, mid-trip", _frequencies(rope))


def _rows_at_rest(group: str, signals: Mapping[str, float]) -> Iterator[SummaryRow]:
    """Yield the rows of a rope at rest, by its signals."""
    left_pull, right_pull = (-1e-3 * signals[f"{end}.fy"] for end in SIDES)
    pulls_text = f"{left_pull:.4g} and {right_pull:.4g} kN"
    yield SummaryRow(group, "its pull on the left and right conveyance", pulls_text)
    yield SummaryRow(group, "loop's lowest point", signals["loop.y"], "m")
    yield SummaryRow(group, "loop's yaw", math.degrees(signals["loop.yaw"]), "deg")
    yield SummaryRow(group, "torque at the left end", abs(signals["left.my"]), "N.m")
    for key, value in signals.items():
        if key.startswith("clearance.") and abs(value) < SHOWN_CLEARANCE:
            yield SummaryRow(group, key.replace(".", " to ", 1), value, "m")


def _frequencies(rope: RopeAtRest) -> str:
    """Return the lowest frequencies of a rope in words, or why it has none."""
    if rope.no_modes:
        return rope.no_modes
    texts = []
    for mode in rope.modes:
        direction = "out of" if mode.out_of_plane else "in"
        texts.append(f"{mode.frequency:.3g} Hz {direction} plane")
    return ", ".join(texts)
