"""Result of a fit as text for the terminal, as a page, and as a parameter file."""

import textwrap
from pathlib import Path
from typing import NamedTuple

from hoist_demo.calibration.findings import Finding
from hoist_demo.calibration.fit import CONFIDENCE, SIGNIFICANCE
from hoist_demo.calibration.identify import CalibrationResult
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.report.formatting import engineering, number, unit_text
from hoist_demo.report.html.page import Bar, bars, paragraphs, untitled_table, write_sheet
from hoist_demo.report.rows import TEXT_WIDTH, SummaryRow, provenance_table, status_rows
from rope_model import SIGNALS
from rope_model.files import write_text
from rope_model.texts import printable, toml_string

SIDE = 4.0  #: Standard errors to either side in the picture of the residuals.


def summary(result: CalibrationResult) -> list[SummaryRow]:
    """Return the rows of the terminal's summary.

    They list properties, undetermined directions, correlations and next measurements.
    """
    group = f"Properties, with the interval of {100 * CONFIDENCE:.0f} %"
    rows = [SummaryRow(group, *row) for row in _properties(result)]
    rows += [SummaryRow("At an end of its range", *row) for row in at_ends(result)]
    rows += [SummaryRow("Undetermined by the data", text, "") for text in _open(result)]
    rows += [SummaryRow("Determined only together", *row) for row in _pairs(result)]
    group = "Best next measurement, and its remaining error"
    unit = _wanted_unit(result)
    now = f"now: {result.measurement_file.wanted.signal}, {number(result.wanted)} {unit}"
    rows.append(SummaryRow(group, now, _error(result)))
    rows += [SummaryRow(group, c.measurement.name, c.error, unit) for c in result.candidates[:3]]
    rows += [SummaryRow("As found, the rope says", "warning", text) for text in result.warnings]
    return [*rows, *status_rows(result.provenance())]


def misfit(result: CalibrationResult) -> str:
    """Return a warning if the measurements contradict the model, else ''."""
    if not result.fit.contradicted:
        return ""
    worst, value = max(_residuals(result), key=lambda row: abs(row[1]))
    return (
        "the measurements contradict the model or one another: the best fit misses them by more "
        f"than sigma allows (probability {result.fit.p_value:.1g}, usual is {SIGNIFICANCE:g} or "
        f"more). Worst is {worst}, by {value:.3g} sigma: look at it, at its sigma and at the "
        "ranges. What was found is a compromise: no interval is stated, the ranges stand, and its "
        "status is contradicted"
    )


def at_ends(result: CalibrationResult) -> list[tuple[str, str]]:
    """Return name and sentence of each property whose best value is beyond an end of its range."""
    rows = []
    for name, held in zip(result.names, result.fit.held.tolist(), strict=True):
        if not held:
            continue
        datum = result.measurement_file.problem.data[name]
        factor, unit = engineering(datum.high, datum.unit)
        end = datum.low
        side = "lower"
        direction = "less"
        if held > 0:
            end = datum.high
            side = "upper"
            direction = "more"
        text = f"{number(factor * end)} {unit_text(unit)}".rstrip()
        text += f" is the {side} end of its range, and the measurements ask for {direction}: "
        if end:  # a range that begins at 0 ends there by nature
            is_sought = name in result.measurement_file.problem.sought
            table = "[sought]" if is_sought else "[known]"
            text += f"widen the range of {name} in {table}, if the rope may lie beyond it, or "
        rows.append((name, f"{text}check the measured values, their units, signs and sigma"))
    return rows


def complaints(result: CalibrationResult) -> list[str]:
    """Return the warnings on a fit: measurements that it misses, ends of ranges reached."""
    reached = [
        f"{name} = {text}; no interval is stated, the range stands"
        for name, text in at_ends(result)
    ]
    return [*filter(None, [misfit(result)]), *reached]


def write_page(result: CalibrationResult, path: Path) -> Path:
    """Write the HTML page of an identification and return its path."""
    none = paragraphs(["None."])
    pairs = none
    if _pairs(result):
        pairs = untitled_table(("properties", "correlation"), _pairs(result))
    data_title, data = provenance_table(result.provenance())
    parts = [
        ("", paragraphs([*complaints(result), *result.warnings]) + _property_table(result)),
        ("Values in the ranges known before", _range_bars(result)),
        ("Model less measurement", _residual_bars(result)),
        ("Measured and fitted", _fitted_table(result)),
        ("Undetermined by the data", paragraphs(_open(result)) or none),
        ("Determined only together", pairs),
        (
            f"Best next measurement of {result.measurement_file.wanted.signal}",
            _candidate_table(result),
        ),
        (data_title, untitled_table(("datum", "value", "unit", "status"), data)),
    ]
    title = f"A rope from measurements: {result.measurement_file.path.name}"
    return write_sheet(path, title, parts)


def _property_table(result: CalibrationResult) -> str:
    """Return the properties found, beside what was known of them before."""
    interval = f"found, with the interval of {100 * CONFIDENCE:.0f} %"
    head = ("property", interval, "unit", "known before", "status before")
    rows = []
    for row, name in zip(_properties(result), result.names, strict=True):
        datum = result.measurement_file.problem.data[name]
        factor, _ = engineering(result.data[name].high, datum.unit)
        range_before = f"{number(factor * datum.low)} to {number(factor * datum.high)}"
        rows.append((*row, range_before, f"{datum.status}: {datum.source}"))
    return untitled_table(head, rows)


def _range_bars(result: CalibrationResult) -> str:
    """Return a picture of the intervals in the ranges known before."""
    ranges = []
    shares = zip(result.names, result.fit.norm_params, result.intervals, strict=True)
    for name, share, (low, high) in shares:
        label = name.replace("_", " ")
        is_determined = result.is_determined(name)
        ranges.append(Bar(label, float(low), float(high), float(share), solid=is_determined))
    axis = "Axis: the range known before, from its lower to its upper end. Grey: undetermined."
    places = [(0.0, "lower end"), (0.5, "middle"), (1.0, "upper end")]
    return paragraphs([axis]) + bars(ranges, places, "intervals in the ranges")


def _residual_bars(result: CalibrationResult) -> str:
    """Return a picture of the residuals in standard errors, from 0 in the middle."""
    middle = 0.5
    per_error = middle / SIDE
    residuals = []
    for name, x in _residuals(result):
        place = middle + per_error * x
        residuals.append(Bar(name, low=middle, high=place, at=place))
    errors = range(-round(SIDE), round(SIDE) + 1)
    steps = [(middle + per_error * x, f"{x:+d}" if x else "0") for x in errors]
    text = paragraphs(["In standard errors."])
    return text + bars(residuals, steps, "residuals in standard errors")


def _fitted_table(result: CalibrationResult) -> str:
    """Return each value as measured and as the fit predicts it."""
    head = ("measurement", "measured", "fitted", "sigma", "unit")
    rows = []
    for one in _fitted_values(result):
        numbers = (number(one.measured), number(one.predicted), number(one.sigma))
        rows.append((one.name, *numbers, unit_text(one.unit)))
    return untitled_table(head, rows)


def _candidate_table(result: CalibrationResult) -> str:
    """Return the output wanted, and what each further measurement would leave of its error."""
    text = f"It is {number(result.wanted)} {_wanted_unit(result)}, its standard error "
    text += f"{_error(result)}."
    unit = _wanted_unit(result)
    rows = [(c.measurement.name, f"{number(c.error)} {unit}") for c in result.candidates]
    head = ("measurement", "standard error that it leaves")
    return paragraphs([text]) + untitled_table(head, rows)


def _properties(result: CalibrationResult) -> list[tuple[str, str, str]]:
    """Return name, value with interval, and unit of each property."""
    rows = []
    for name in result.names:
        datum = result.data[name]
        factor, unit = engineering(datum.high, datum.unit)
        value, low, high = (number(factor * x) for x in (result.value(name), datum.low, datum.high))
        finding = result.findings[name]
        if finding == Finding.UNDETERMINED:
            text = f"undetermined: {low} to {high} as before"
        elif finding == Finding.CONTRADICTED:
            text = f"{value} as a compromise, contradicted: {low} to {high} as before"
        elif finding.at_end:
            text = f"{value}, {finding.value}: {low} to {high} as before"
        else:
            text = f"{value} ({low} to {high})"
        rows.append((name, text, unit_text(unit)))
    return rows


def _open(result: CalibrationResult) -> list[str]:
    return [f"{text}: the range stands" for text in result.open_directions()]


def _pairs(result: CalibrationResult) -> list[tuple[str, str]]:
    return [
        (f"{one} and {other}", f"{value:+.2f}")
        for one, other, value in result.strong_correlations()
    ]


def _error(result: CalibrationResult) -> str:
    return f"{number(result.wanted_error)} {_wanted_unit(result)}"


def _wanted_unit(result: CalibrationResult) -> str:
    return unit_text(SIGNALS[result.measurement_file.wanted.signal].unit)


class _FittedValue(NamedTuple):
    """A measured value, and the prediction of the fit."""

    name: str
    measured: float
    predicted: float
    sigma: float
    unit: str


def _fitted_values(result: CalibrationResult) -> list[_FittedValue]:
    """Return each value; of a track's places their root mean square."""
    predicted = iter(result.predicted)
    values = []
    for m in result.measurement_file.measurements:
        if isinstance(m, Markers):
            of_places = [float(next(predicted)) ** 2 for _ in m.values][: -m.nuisance]
            rms = (sum(of_places) / len(of_places)) ** 0.5
            values.append(_FittedValue(f"{m.name or m.file}, RMS", 0.0, rms, m.sigma, "m"))
            continue
        for k, value in enumerate(m.values, 1):
            name = f"{m.title} {k}" if len(m.values) > 1 else m.title
            values.append(_FittedValue(name, value, float(next(predicted)), m.sigma, m.unit))
    return values


def _residuals(result: CalibrationResult) -> list[tuple[str, float]]:
    """Return name and residual in standard errors of each value."""
    return [
        (one.name, (one.predicted - one.measured) / one.sigma) for one in _fitted_values(result)
    ]


def write_rope_file(result: CalibrationResult, path: Path) -> Path:
    """Write the identified rope as the TOML file that --rope takes, and return its path."""
    calibrated_rope = result.calibrated_rope
    file = result.measurement_file
    rope = file.problem.rope(result.fit.norm_params)
    lines = [
        f"# Found by balance-rope identify from {printable(file.path.name)}. wind and export take "
        "it as",
        '# --rope FILE, studies, duties and ropes as [fixed] from = "FILE".',
    ]
    for text in complaints(result):
        lines += [f"# {printable(line)}" for line in textwrap.wrap(text, TEXT_WIDTH)]
    lines += [
        "[rope]",
        f"construction = {toml_string(calibrated_rope.construction)}",
        f"diameter = {calibrated_rope.diameter!r}",
        f"length = {calibrated_rope.length!r}",
        f"lay = {toml_string(calibrated_rope.lay)}",
        "",
        "[known]",
    ]
    for name, datum in calibrated_rope.data.items():
        facts = f"status = {toml_string(datum.status)}, source = {toml_string(datum.source)}"
        lines.append(f"{name} = {{ low = {datum.low:.6g}, high = {datum.high:.6g}, {facts} }}")
    lines += ["", "[fixed]", *(f"rope.{name} = {getattr(rope, name):.8g}" for name in FOLLOWING)]
    for name in result.measurement_file.problem.sought:
        status = toml_string(result.data[name].status)
        lines.append(f"{name} = {{ value = {result.value(name):.6g}, status = {status} }}")
    return write_text(path, "\n".join(lines) + "\n")
