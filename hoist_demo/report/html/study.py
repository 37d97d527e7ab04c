"""The report of a study.

It has all runs in parallel coordinates, one column against another, and a sortable table.

``meta`` may hold ``title`` and ``parameters`` (names of the columns that were varied; the other columns
are metrics). Whatever else it holds, a text or a number, is shown under Data, and so are parameters
that are the same in all runs. Only what differs between runs has an axis. A run has failed when its
``cause`` is not empty. The page shows as many columns as it has room for: what varies, what the study
judges by, what tells of danger, then the rest.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from hoist_demo.recording.passages import PASSED
from hoist_demo.report import formatting
from hoist_demo.report.html import page
from hoist_demo.report.parameter_tables import TitledRows
from hoist_demo.run.metrics import MORE_IS_BETTER, NEUTRAL, UNITS
from hoist_demo.study.objective import Constraint, Objective
from hoist_demo.study.perform import MISSING, WARNINGS, StudyResult
from hoist_demo.study.store import SEPARATOR, Results, kind_of
from rope_model.texts import html_text

STATUS = "status"
CAUSE = "cause"
#: Columns of the table that the page does not plot.
_NO_COLUMNS = (STATUS, CAUSE, "run", "key", WARNINGS, MISSING)
EQUAL_WITHIN = 1e-9  #: Relative difference within which two numbers are one.
_META_OF_PAGE = ("title", "parameters")  #: Keys of ``meta`` that the page uses elsewhere.
LISTED_RUNS = 8  #: Most numbers of runs that a sentence lists.
#: columns that are shown first behind what varies and what is judged
_FIRST = (
    "judged",
    "within",
    "excess",
    "slip_safety",
    "clearance",
    "loop_turns",
    "rope_force_peak",
    "sway",
)


Cell = float | str | None


class _Column(NamedTuple):
    """Column of the table in a unit for people, and the factor that leads to it."""

    values: list[Cell]
    unit: str
    factor: float


class _Shown(NamedTuple):
    """Columns of a study's table, by how the page shows them."""

    columns: Mapping[str, _Column]
    parameters: Sequence[str]  # names of the columns that were varied
    varied: Collection[str]  # that differ between runs
    fixed: Sequence[str]  # parameters that do not
    empty: Sequence[str]  # metrics without a value
    listed: Sequence[str]  # in the order of the page


def study_report(
    results: Results,
    meta: Mapping[str, Any],
    path: str | Path,
    data_tables: Sequence[TitledRows] = (),
    result: StudyResult | None = None,
    objective: Objective | None = None,
) -> Path:
    """Write the report to ``path``, from one row of the results' table per run.

    ``data_tables`` are tables of the data, ``result`` the study's outcome, which is judged by ``objective``.
    """
    table = results.table
    judged = list(objective.metrics) if objective else []
    constraints = objective.constraints if objective else ()
    choices: Sequence[int] = range(len(table))
    trends: Sequence[str] = ()
    best = None
    if result:
        choices = result.choices
        trends = result.remarks
        best = result.best
    shown = _shown(results, [str(name) for name in meta.get("parameters", ())], judged)
    causes = ["" if pd.isna(cause) else str(cause) for cause in table[CAUSE]]
    data = {
        "columns": [_page_column(name, shown, constraints) for name in shown.listed],
        "statuses": [str(status) for status in table[STATUS]],
        "causes": causes,
        "choices": list(choices),
        "best": list(best.runs) if best else [],
        "by": judged,
    }
    failed = sum(cause != "" for cause in causes)
    sentences = [f"{len(causes)} runs, {failed} failed. {_passed(table)}{_early(table)}"]
    if best:
        sentences.append(f"{best.text[:1].upper()}{best.text[1:]}.")
    remarks = _list("Not monotonic", trends)
    remarks += _list("Warnings", _by_text(table, WARNINGS))
    remarks += _list("Missing", _by_text(table, MISSING))
    outcome = "</p><p>".join(html_text(text.strip()) for text in sentences if text)
    tables = _tables(shown, meta, data_tables)
    body = page.fill("study.html", outcome=outcome, remarks=remarks, tables=tables)
    title = str(meta.get("title", "Study"))
    scripts = page.running(("study.js",), data)
    return page.write_html(Path(path), page.render_page("study", title, body, scripts=scripts))


def _shown(results: Results, parameters: Sequence[str], judged: Sequence[str]) -> _Shown:
    """Return the columns as the page shows them; the study judges by those of ``judged``."""
    columns = _columns_in_engineering_units(results.table, results.units)
    varied = {name for name, column in columns.items() if _differ(column.values)}
    fixed = [name for name in parameters if name in columns and name not in varied]
    empty = [
        name
        for name, column in columns.items()
        if name not in parameters and set(column.values) <= {None}
    ]
    listed = [name for name in columns if name not in {*fixed, *empty}]
    # parameters first: they are read before what follows from them; what does not differ comes last
    first = list(dict.fromkeys([*parameters, *judged, *_FIRST]))
    place = {name: k for k, name in enumerate(first)}
    listed.sort(
        key=lambda name: (name not in parameters, name not in varied, place.get(name, len(place)))
    )
    return _Shown(columns, parameters, varied, fixed, empty, listed)


def _page_column(name: str, shown: _Shown, constraints: Sequence[Constraint]) -> dict[str, Any]:
    """Return a column as the page's script takes it."""
    column = shown.columns[name]
    bounds = [bound for bound in constraints if bound.metric == name]
    return {
        "name": name,
        "unit": formatting.unit_text(column.unit),
        "role": "parameter" if name in shown.parameters else "metric",
        # without anything that differs, as with a single run, all numbers have one
        "axis": name in shown.varied or not shown.varied,
        "values": column.values,
        "bounds": [[column.factor * bound.value, bound.sense] for bound in bounds],
        "better": _better(name),
    }


def _tables(shown: _Shown, meta: Mapping[str, Any], data_tables: Sequence[TitledRows]) -> str:
    """Return the tables below the plots: the study, columns without an axis, and the data."""
    about: list[formatting.Row] = [
        (str(name), _text(value), "") for name, value in meta.items() if name not in _META_OF_PAGE
    ]
    equal: list[formatting.Row] = []
    for name in shown.fixed:
        column = shown.columns[name]
        equal.append((name, _describe(column.values), formatting.unit_text(column.unit)))
    tables = page.titled_table("Study", about)
    tables += page.titled_table("The same in all runs", equal)
    tables += page.titled_table("Not shown by any run", [(name, "", "") for name in shown.empty])
    for heading, rows in data_tables:
        tables += page.titled_table(heading, rows)
    return tables


def _better(metric: str) -> int:
    """Return 1 where less of a metric is better, -1 where more is, 0 where neither."""
    if metric in NEUTRAL or metric not in UNITS:
        return 0
    if metric in MORE_IS_BETTER:
        return -1
    return 1


def _differ(values: Sequence[float | str | None]) -> bool:
    """Return True if the values differ by more than rounding does."""
    numbers = [value for value in values if isinstance(value, float)]
    if len(numbers) < len(values):
        return len(set(values)) > 1
    return max(numbers) - min(numbers) > EQUAL_WITHIN * max(map(abs, numbers))


def _list(title: str, lines: Sequence[str]) -> str:
    """Return a titled list; "" without lines."""
    items = "".join(f"<li>{html_text(line)}</li>" for line in lines)
    if lines:
        return f"<h2>{html_text(title)}</h2><ul>{items}</ul>"
    return ""


def _by_text(table: pd.DataFrame, column: str) -> list[str]:
    """Return each text of a column behind its runs; texts that differ in numbers only are one."""
    kinds: dict[str, tuple[str, list[int]]] = {}
    if column not in table.columns:
        return []
    for number, cell in enumerate(table[column], 1):
        if isinstance(cell, str) and cell:
            for text in cell.split(SEPARATOR):
                _, runs = kinds.setdefault(kind_of(text), (text, []))
                runs.append(number)
    return [f"{_run_numbers(runs)}: {text}" for text, runs in kinds.values()]


def _columns_in_engineering_units(
    table: pd.DataFrame, units: Mapping[str, str]
) -> dict[str, _Column]:
    """Return the columns that the page plots, in units with prefixes where numbers are large."""
    columns: dict[str, _Column] = {}
    for name in map(str, table.columns):
        if name in _NO_COLUMNS:
            continue
        cells = [_cell(value) for value in table[name]]
        numbers = [
            abs(value) for value in cells if isinstance(value, float) and math.isfinite(value)
        ]
        largest = max(numbers, default=0.0)
        factor, unit = formatting.engineering(largest, units.get(name, ""))
        scaled = [factor * value if isinstance(value, float) else value for value in cells]
        columns[name] = _Column(scaled, unit, factor)
    return columns


def _passed(table: pd.DataFrame) -> str:
    """Return a sentence on runs in which the rope passed through something; "" for none."""
    runs = [number for number, text in enumerate(table[STATUS], 1) if PASSED in str(text)]
    if not runs:
        return ""
    numbers = _run_numbers(runs)
    return f"In {numbers} the rope passed into or through something, the status says what."


def _run_numbers(runs: Sequence[int]) -> str:
    """Return the numbers of the first LISTED_RUNS runs, and how many more there are."""
    text = "run " if len(runs) == 1 else "runs "
    text += ", ".join(map(str, runs[:LISTED_RUNS]))
    if len(runs) > LISTED_RUNS:
        text += f" and {len(runs) - LISTED_RUNS} more"
    return text


def _early(table: pd.DataFrame) -> str:
    """Return a sentence on conveyances that arrived before their reference; "" for none."""
    if not {"cycle_time", "trajectory_time"} <= set(table.columns):
        return ""
    earlier = pd.to_numeric(table["cycle_time"]) < pd.to_numeric(table["trajectory_time"])
    runs = [number for number, is_earlier in enumerate(earlier, 1) if is_earlier]
    if not runs:
        return ""
    return (
        f" cycle_time is shorter than trajectory_time in {_run_numbers(runs)}: the conveyances "
        "were within the band of arrival, and stayed there, before the reference was at rest."
    )


def _cell(value: Any) -> Cell:
    """Convert a cell to a number or text for JSON; booleans become words."""
    if pd.isna(value):
        return None
    if isinstance(value, str | bool) or pd.api.types.is_bool(value):
        return str(value)
    return float(value)


def _describe(values: Sequence[float | str | None]) -> str:
    if values[0] in (None, ""):
        return "none"
    return _text(values[0])


def _text(value: object) -> str:
    if isinstance(value, float):
        return formatting.number(value)
    return str(value)
