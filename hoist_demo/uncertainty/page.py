"""Spread of results, as text for the terminal, as a table and as a page."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from hoist_demo.recording.time_series import Recording, write_csv
from hoist_demo.report.formatting import number
from hoist_demo.report.html.page import Bar, bars, paragraphs, untitled_table, write_sheet
from hoist_demo.report.rows import SummaryRow, in_display_unit, provenance_table, status_rows
from hoist_demo.run.metrics import METRICS, UNITS, name_without_rope
from hoist_demo.uncertainty.spread import QUANTILES, UNEXPLAINED, UncertaintyResult

MIN_LISTED_SHARE = 0.05  #: Share of a spread from which on a datum is named in the terminal.


def summary(result: UncertaintyResult) -> list[SummaryRow]:
    """Return the rows of the terminal's summary."""
    rows = [
        SummaryRow("Windings", "that count", f"{result.completed} of {result.file.header.samples}")
    ]
    for name in _measured(result):
        (low, middle, high), unit = _in_display_unit(
            result.quantiles(name), UNITS[name_without_rope(name)]
        )
        group = f"{name}, {METRICS[name_without_rope(name)][1]}"
        rows.append(SummaryRow(group, "half of the ropes below", middle, unit))
        rows.append(SummaryRow(group, "nine in ten within", f"{low} to {high}", unit))
        for key, share in _sorted_causes(result, name):
            if share > MIN_LISTED_SHARE:
                cause = key if key == UNEXPLAINED else f"caused by {key}"
                rows.append(SummaryRow(group, cause, f"{100 * share:.0f} %"))
    return [*rows, *status_rows(result.file.provenance())]


def too_few(result: UncertaintyResult) -> str:
    """Return a warning of results without windings, and of too few windings for causes.

    '' for neither.
    """
    return "; ".join(_too_few(result))


def _too_few(result: UncertaintyResult) -> Iterator[str]:
    measures = result.file.measured
    none = [name for name in measures if result.completed and not result.has(name).any()]
    if none:
        yield (
            f"no winding shows {', '.join(none)}: the rope's model does not compute it (set "
            "model.fidelity = torsional), or its event did not happen"
        )
    if not result.completed:
        yield (
            "no winding counts, so that nothing is known: see why above, and change the rope, "
            "what is near it, or the trip, not the samples"
        )
        return
    need = result.needed
    counts = {name: int(result.has(name).sum()) for name in measures}
    few = [f"{name} {count}" for name, count in counts.items() if 0 < count < need]
    if few:
        yield (
            f"no causes are known of {', '.join(few)}: {len(result.file.data)} varied data need "
            f"{need} completed windings, 64 for a first look; raise samples = "
            f"{result.file.header.samples}"
        )
    ratios = {name: result.spoiled(name) for name in measures}
    spoiled = [f"{name} {number(ratio)}" for name, ratio in ratios.items() if ratio]
    if spoiled:
        yield (
            f"no causes are known of {', '.join(spoiled)}: the shares of the data add up to so "
            f"many times their spread; {result.file.header.samples} windings are too few to "
            "separate the data; raise samples"
        )


def remarks(result: UncertaintyResult) -> list[str]:
    """Return the rope's warnings and why windings do not count, with numbers of windings."""
    return [
        f"in {count} of {result.file.header.samples} windings: {text}"
        for text, count in result.remarks.items()
    ]


def write_table(result: UncertaintyResult, path: Path) -> Path:
    """Write a CSV file with a row per winding, and return its path."""
    units = {name: datum.unit for name, datum in result.file.data.items()}
    units |= {name: UNITS[name_without_rope(name)] for name in result.file.measured}
    write_csv(Recording(result.columns, units), path)
    return path


def write_page(result: UncertaintyResult, path: Path) -> Path:
    """Write the HTML page of the spread, and return its path."""
    file = result.file
    head = ("result", "", *(f"{100 * q:.0f} % below" for q in QUANTILES), "unit")
    results = []
    for name in _measured(result):
        quantiles, unit = _in_display_unit(result.quantiles(name), UNITS[name_without_rope(name)])
        results.append((name, METRICS[name_without_rope(name)][1], *quantiles, unit))
    causes = "".join(_picture_of_causes(result, name) for name in file.measured)
    data = []
    for name, datum in file.data.items():
        bounds, unit = _in_display_unit((datum.low, datum.high), datum.unit)
        data.append((name, " to ".join(bounds), unit, datum.status, datum.source))
    count = f"{result.completed} of {file.header.samples} windings count"
    wound = f"{count}: hoist {file.header.hoist}, level {file.level}."
    hint = "Share of the spread of ranks; grey: what the data do not explain one by one."
    title, rows = provenance_table(file.provenance())
    parts = [
        ("", paragraphs([wound, *remarks(result)])),
        ("What the results may be", untitled_table(head, results)),
        ("Which datum causes it", paragraphs([hint, *filter(None, [too_few(result)])]) + causes),
        (
            "What varies, evenly over its range, in logarithms where it does not begin at 0",
            untitled_table(("datum", "range", "unit", "status", "source"), data),
        ),
        (title, untitled_table(("datum", "value", "unit", "status"), rows)),
    ]
    return write_sheet(path, file.header.title, parts)


def _in_display_unit(values: Iterable[float], unit: str) -> tuple[list[str], str]:
    """Format numbers in their display unit, and return that unit."""
    return [number(in_display_unit(x, unit)[0]) for x in values], in_display_unit(0.0, unit)[1]


def _picture_of_causes(result: UncertaintyResult, name: str) -> str:
    """Return a picture of the causes of a spread under its name; "" where none are known."""
    causes = _sorted_causes(result, name)
    if not causes:
        return ""
    rows = [
        Bar(key.replace("_", " "), low=0.0, high=share, at=share, solid=key != UNEXPLAINED)
        for key, share in causes
    ]
    return paragraphs([name]) + bars(rows, _TICKS, name)


_TICKS = [(x / 4, f"{25 * x} %") for x in range(5)]


def _measured(result: UncertaintyResult) -> list[str]:
    """Return the measures that at least one winding has."""
    return [name for name in result.file.measured if result.has(name).any()]


def _sorted_causes(result: UncertaintyResult, name: str) -> list[tuple[str, float]]:
    """Return the causes of a spread, the largest first, the unexplained share last."""
    causes = result.causes(name)
    keys = sorted(causes, key=lambda key: (key == UNEXPLAINED, -causes[key]))
    return [(key, causes[key]) for key in keys]
