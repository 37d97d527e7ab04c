"""Result of a fit: as text for the terminal, as a page, and as the parameter file for other commands."""

import textwrap
from pathlib import Path

from hoist_demo.calibration.fit import CONFIDENCE, UNLIKELY
from hoist_demo.calibration.identify import Identified
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.report.html.page import Bar, bars, engineering, grid, number, paragraphs, unit_text, write_sheet
from hoist_demo.report.rows import SummaryRow, told
from hoist_demo.report.rows import table as data_table
from rope_model import SIGNALS
from rope_model.texts import printable, toml_string

#: standard errors to either side that the picture of the residuals shows
SIDE = 4.0


def summary(found: Identified) -> list[SummaryRow]:
    """Return the text for the terminal."""
    group = f"Properties, with the interval of {100 * CONFIDENCE:.0f} %"
    rows = [SummaryRow(group, *row[:2], row[2]) for row in _properties(found)]
    rows += [SummaryRow("Undetermined by the data", text, "") for text in _open(found)]
    rows += [SummaryRow("Determined only together", *row) for row in _pairs(found)]
    group = "Best next measurement, and its remaining error"
    unit = _wanted_unit(found)
    rows.append(SummaryRow(group, f"now: {found.measured.wanted.signal}, {number(found.wanted)} {unit}", _error(found)))
    rows += [SummaryRow(group, c.measurement.name, c.error, unit) for c in found.candidates[:3]]
    rows += [SummaryRow("As found, the rope says", "warning", text) for text in found.warnings]
    return [*rows, *told(found.provenance())]


def misfit(found: Identified) -> str:
    """A warning where the measurements contradict the model; '' where they do not."""
    if not found.fit.contradicted:
        return ""
    worst, value = max(_residuals(found), key=lambda row: abs(row[1]))
    return (
        f"the measurements contradict the model or one another: it misses them by more than sigma allows (probability "
        f"{found.fit.likelihood:.1g}, usual is {UNLIKELY:g} or more). Worst is {worst}, by {value:.3g} sigma: look at "
        "it, at its sigma and at the ranges. What was found is a compromise: no interval is stated, the ranges stand, "
        "and its status is contradicted"
    )


def write_page(found: Identified, path: Path) -> Path:
    """Write the page."""
    bench = found.measured.bench
    ranges = [
        Bar(f"{name.replace('_', ' ')}", float(low), float(high), float(share), found.told(name))
        for name, share, (low, high) in zip(found.names, found.fit.shares, found.intervals, strict=True)
    ]
    residuals = [Bar(name, 0.5, 0.5 + x / (2 * SIDE), 0.5 + x / (2 * SIDE)) for name, x in _residuals(found)]
    steps = [(0.5 + x / (2 * SIDE), f"{x:+.0f}" if x else "0") for x in (-4, -3, -2, -1, 0, 1, 2, 3, 4)]
    with_interval = f"found, with the interval of {100 * CONFIDENCE:.0f} %"
    known = [
        (*row, f"{number(factor * datum.low)} to {number(factor * datum.high)}", f"{datum.status}: {datum.source}")
        for row, name in zip(_properties(found), found.names, strict=True)
        for datum in (bench.data[name],)
        for factor, _ in [engineering(found.data[name].high, datum.unit)]
    ]
    fitted = [
        (name, number(value), number(predicted), number(sigma), unit_text(unit))
        for name, value, predicted, sigma, unit in _values(found)
    ]
    left = [(c.measurement.name, f"{number(c.error)} {_wanted_unit(found)}") for c in found.candidates]
    title, data = data_table(found.provenance())
    pairs = _pairs(found)
    notes = [text for text in (misfit(found), *found.warnings) if text]
    parts = [
        ("", paragraphs(notes) + grid(("property", with_interval, "unit", "known before", "status before"), known)),
        (
            "Values in the ranges known before",
            paragraphs(["Axis: the range known before, from its lower to its upper end. Grey: undetermined."])
            + bars(ranges, [(0.0, "lower end"), (0.5, "middle"), (1.0, "upper end")], "intervals in the ranges"),
        ),
        (
            "Model less measurement",
            paragraphs(["In standard errors."]) + bars(residuals, steps, "residuals in standard errors"),
        ),
        ("Measured and fitted", grid(("measurement", "measured", "fitted", "sigma", "unit"), fitted)),
        ("Undetermined by the data", paragraphs(_open(found) or ["None."])),
        ("Determined only together", grid(("properties", "correlation"), pairs) if pairs else paragraphs(["None."])),
        (
            f"Best next measurement of {found.measured.wanted.signal}",
            paragraphs([f"It is {number(found.wanted)} {_wanted_unit(found)}, its standard error {_error(found)}."])
            + grid(("measurement", "standard error that it leaves"), left),
        ),
        (title, grid(("datum", "value", "unit", "status"), data)),
    ]  # fmt: skip
    return write_sheet(path, f"A rope from measurements: {found.measured.path.name}", parts)


def _properties(found: Identified) -> list[tuple[str, str, str]]:
    """Name, value with interval, and unit."""
    rows = []
    for name in found.names:
        datum = found.data[name]
        factor, unit = engineering(datum.high, datum.unit)
        value, low, high = (number(factor * x) for x in (found.value(name), datum.low, datum.high))
        if not found.told(name):
            text = f"undetermined: {low} to {high} as before"
        elif found.fit.contradicted:
            text = f"{value} as a compromise, contradicted: {low} to {high} as before"
        else:
            text = f"{value} ({low} to {high})"
        rows.append((name, text, unit_text(unit)))
    return rows


def _open(found: Identified) -> list[str]:
    return [f"{text}: the range stands" for text in found.open_directions()]


def _pairs(found: Identified) -> list[tuple[str, str]]:
    return [(f"{one} and {other}", f"{value:+.2f}") for one, other, value in found.strong_correlations()]


def _error(found: Identified) -> str:
    return f"{number(found.wanted_error)} {_wanted_unit(found)}"


def _wanted_unit(found: Identified) -> str:
    return unit_text(SIGNALS[found.measured.wanted.signal].unit)


def _values(found: Identified) -> list[tuple[str, float, float, float, str]]:
    """Name, measured, predicted, sigma and unit of each value."""
    predicted, rows = iter(found.predicted), []
    for m in found.measured.measurements:
        if isinstance(m, Markers):
            of_places = [float(next(predicted)) ** 2 for _ in m.values][: -m.nuisance]
            rms = (sum(of_places) / len(of_places)) ** 0.5
            rows.append((f"{m.name or m.file}, RMS", 0.0, rms, m.sigma, "m"))
            continue
        for k, value in enumerate(m.values, 1):
            name = f"{m.title} {k}" if len(m.values) > 1 else m.title
            rows.append((name, value, float(next(predicted)), m.sigma, m.unit))
    return rows


def _residuals(found: Identified) -> list[tuple[str, float]]:
    return [(name, (predicted - value) / sigma) for name, value, predicted, sigma, _ in _values(found)]


def write_rope_file(found: Identified, path: Path) -> Path:
    """Write what was found."""
    known = found.known
    rope = found.measured.bench.rope(found.fit.shares)
    lines = [
        f"# Found by balance-rope identify from {printable(found.measured.path.name)}. wind and export take it as",
        '# --rope FILE, studies, duties and ropes as [fixed] from = "FILE".',
        *(f"# {printable(line)}" for line in textwrap.wrap(misfit(found), 110)),
        "[rope]",
        f"construction = {toml_string(known.construction)}",
        f"diameter = {known.diameter!r}",
        f"length = {known.length!r}",
        f"lay = {toml_string(known.lay)}",
        "",
        "[known]",
    ]
    for name, datum in known.data.items():
        facts = f"status = {toml_string(datum.status)}, source = {toml_string(datum.source)}"
        lines.append(f"{name} = {{ low = {datum.low:.6g}, high = {datum.high:.6g}, {facts} }}")
    lines += ["", "[fixed]", *(f"rope.{name} = {getattr(rope, name):.8g}" for name in FOLLOWING)]
    for name in found.measured.bench.sought:
        status = toml_string(found.data[name].status)
        lines.append(f"{name} = {{ value = {found.value(name):.6g}, status = {status} }}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return path
