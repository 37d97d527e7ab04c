"""Spread of results, as text for the terminal, as a table and as a page."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from hoist_demo.recording.time_series import Recording, write_csv
from hoist_demo.report.html.page import Bar, bars, grid, number, paragraphs, write_sheet
from hoist_demo.report.rows import SummaryRow, for_people, told
from hoist_demo.report.rows import table as data_table
from hoist_demo.study.metrics import METRICS, UNITS
from hoist_demo.uncertainty.spread import QUANTILES, Spread

#: share of a spread from which on a datum is named in the terminal
NAMED = 0.05


def summary(found: Spread) -> list[SummaryRow]:
    """Return the text for the terminal."""
    rows = [SummaryRow("Windings", "that count", f"{found.completed} of {found.asked.head.samples}")]
    for name in _measured(found):
        (low, middle, high), unit = _for_people(found.quantiles(name), UNITS[name])
        group = f"{name}, {METRICS[name][1]}"
        rows.append(SummaryRow(group, "half of the ropes below", middle, unit))
        rows.append(SummaryRow(group, "nine in ten within", f"{low} to {high}", unit))
        rows += [
            SummaryRow(group, key if key == "unexplained" else f"caused by {key}", f"{100 * x:.0f} %")
            for key, x in _sorted(found, name)
            if x > NAMED
        ]
    return [*rows, *told(found.asked.provenance())]


def too_few(found: Spread) -> str:
    """Return a warning of results without windings, and of too few windings for causes; '' for neither."""
    return "; ".join(_too_few(found))


def _too_few(found: Spread) -> Iterator[str]:
    measures = found.asked.head.measures
    if none := [name for name in measures if found.completed and not found.wound(name).any()]:
        yield (
            f"no winding shows {', '.join(none)}: the rope's model does not compute it (set model.fidelity = "
            "torsional), or its event did not happen"
        )
    if not found.completed:
        yield (
            "no winding counts, so that nothing is known: see why above, and change the rope, what is near it, or the "
            "trip, not the samples"
        )
        return
    counts, need = {name: int(found.wound(name).sum()) for name in measures}, found.needed
    if few := [f"{name} {count}" for name, count in counts.items() if 0 < count < need]:
        yield (
            f"no causes are known of {', '.join(few)}: {len(found.asked.data)} varied data need {need} completed "
            f"windings, 64 for a first look; raise samples = {found.asked.head.samples}"
        )
    if spoiled := [f"{name} {number(times)}" for name in measures if (times := found.spoiled(name))]:
        yield (
            f"no causes are known of {', '.join(spoiled)}: the shares of the data add up to so many times their "
            f"spread; {found.asked.head.samples} windings are too few to separate the data; raise samples"
        )


def remarks(found: Spread) -> list[str]:
    """Return the rope's warnings and why windings do not count, each with its number of windings."""
    return [f"in {count} of {found.asked.head.samples} windings: {text}" for text, count in found.remarks.items()]


def write_table(found: Spread, path: Path) -> Path:
    """A row per winding."""
    units = {name: datum.unit for name, datum in found.asked.data.items()} | UNITS
    write_csv(Recording(found.columns, units), path)
    return path


def write_page(found: Spread, path: Path) -> Path:
    """Write the page."""
    asked = found.asked
    head = ("result", "", *(f"{100 * q:.0f} % below" for q in QUANTILES), "unit")
    results = [
        (name, METRICS[name][1], *shown, unit)
        for name in _measured(found)
        for shown, unit in [_for_people(found.quantiles(name), UNITS[name])]
    ]
    causes = "".join(
        paragraphs([name])
        + bars([Bar(key.replace("_", " "), 0.0, x, x, key != "unexplained") for key, x in shares], _TICKS, name)
        for name in asked.head.measures
        if (shares := _sorted(found, name))
    )
    data = [
        (name, " to ".join(bounds), unit, datum.status, datum.source)
        for name, datum in asked.data.items()
        for bounds, unit in [_for_people((datum.low, datum.high), datum.unit)]
    ]
    wound = f"{found.completed} of {asked.head.samples} windings count: hoist {asked.head.hoist}, level {asked.level}."
    hint = "Share of the spread of ranks; grey: what the data do not explain one by one."
    title, rows = data_table(asked.provenance())
    parts = [
        ("", paragraphs([wound, *remarks(found)])),
        ("What the results may be", grid(head, results)),
        ("Which datum causes it", paragraphs([hint, *filter(None, [too_few(found)])]) + causes),
        (
            "What varies, evenly over its range, in logarithms where it does not begin at 0",
            grid(("datum", "range", "unit", "status", "source"), data),
        ),
        (title, grid(("datum", "value", "unit", "status"), rows)),
    ]
    return write_sheet(path, asked.head.title, parts)


def _for_people(values: Iterable[float], unit: str) -> tuple[list[str], str]:
    """Numbers as text, and their unit, as every summary has them."""
    return [number(for_people(x, unit)[0]) for x in values], for_people(0.0, unit)[1]


_TICKS = [(x / 4, f"{25 * x} %") for x in range(5)]


def _measured(found: Spread) -> list[str]:
    """The results that at least one winding has."""
    return [name for name in found.asked.head.measures if found.wound(name).any()]


def _sorted(found: Spread, name: str) -> list[tuple[str, float]]:
    """The largest cause first, what is unexplained last."""
    return sorted(found.causes(name).items(), key=lambda cause: (cause[0] == "unexplained", -cause[1]))
