"""The report of a study.

It has all runs in parallel coordinates, one column against another, and a sortable table.

`meta` may hold `title` and `parameters` (names of the columns that were varied; the other columns
are metrics). Whatever else it holds, a text or a number, is shown under Data, and so are parameters
that are the same in all runs. Only what differs between runs has an axis. A run has failed when its
`cause` is not empty. The page shows as many columns as it has room for: what varies, what the study
judges by, what tells of danger, then the rest.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from hoist_demo.recording.passages import PASSED
from hoist_demo.report.html import page
from hoist_demo.report.html.parameter_tables import TitledRows
from hoist_demo.study.metrics import MORE_IS_BETTER, NEUTRAL, UNITS
from hoist_demo.study.objective import Objective
from hoist_demo.study.perform import MISSING, WARNINGS, StudyResult
from hoist_demo.study.store import SEPARATOR, kind_of
from rope_model.texts import html_text

STATUS = "status"
CAUSE = "cause"
#: Columns of the table that the page does not plot.
_NO_COLUMNS = (STATUS, CAUSE, "run", "key", WARNINGS, MISSING)
ROUNDING = 1e-9  #: Relative difference within which two numbers are one.
_OWN = ("title", "parameters")
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


def study_report(
    table: pd.DataFrame,
    stated: Mapping[str, str],
    meta: Mapping[str, Any],
    path: str | Path,
    more: Sequence[TitledRows] = (),
    result: StudyResult | None = None,
    objective: Objective | None = None,
) -> Path:
    """Write the report to `path`, from one row of `table` per run.

    `stated` has the units by column name ("" or "1" for none).

    `more` are tables of the data, `result` the study's outcome, which is judged by `objective`.
    """
    best = result.best if result else None
    by, limits = (
        tuple(objective.metrics) if objective else (),
        objective.constraints if objective else (),
    )
    parameters = [str(name) for name in meta.get("parameters", ())]
    causes = ["" if pd.isna(cause) else str(cause) for cause in table[CAUSE]]
    values, units, factors = _in_engineering_units(
        {str(name): [_plain(value) for value in table[name]] for name in table.columns}, stated
    )
    names = [name for name in values if name not in _NO_COLUMNS]
    varied = {name for name in names if _differ(values[name])}
    fixed = [name for name in parameters if name in names and name not in varied]
    nowhere = [name for name in names if name not in parameters and set(values[name]) <= {None}]
    first = [*parameters, *by, *_FIRST]
    listed = [name for name in names if name not in {*fixed, *nowhere}]
    # parameters first: they are read before what follows from them; what does not differ comes last
    place = {name: k for k, name in enumerate(dict.fromkeys(first))}
    listed.sort(
        key=lambda name: (name not in parameters, name not in varied, place.get(name, len(first)))
    )
    columns = [
        {
            "name": name,
            "unit": page.unit_text(units.get(name, "")),
            "role": "parameter" if name in parameters else "metric",
            # without anything that differs, as with a single run, all numbers have one
            "axis": name in varied if varied else True,
            "values": values[name],
            "bounds": [
                [factors[name] * one.value, one.sense] for one in limits if one.metric == name
            ],
            "better": 0
            if name in NEUTRAL or name not in UNITS
            else -1
            if name in MORE_IS_BETTER
            else 1,
        }
        for name in listed
    ]
    data = {
        "columns": columns,
        "statuses": [str(status) for status in table[STATUS]],
        "causes": causes,
        "choices": list(result.choices if result else range(len(causes))),
        "best": list(best.runs) if best else [],
        "by": list(by),
    }
    title = str(meta.get("title", "Study"))
    rest = [(str(name), _text(value), "") for name, value in meta.items() if name not in _OWN]
    sentences = [
        f"{len(causes)} runs, {sum(cause != '' for cause in causes)} failed. "
        f"{_passed(table)}{_early(table)}"
    ]
    sentences += [f"{best.text[:1].upper()}{best.text[1:]}."] if best else []
    body = page.fill(
        "study.html",
        outcome="</p><p>".join(html_text(text.strip()) for text in sentences if text),
        remarks=_list("Not monotonic", result.remarks if result else ())
        + _list("Warnings", _by_text(table, WARNINGS))
        + _list("Missing", _by_text(table, MISSING)),
        tables=page.titled_table("Study", rest)
        + page.titled_table(
            "The same in all runs",
            [(n, _describe(values[n]), page.unit_text(units.get(n, ""))) for n in fixed],
        )
        + page.titled_table("Not shown by any run", [(name, "", "") for name in nowhere])
        + "".join(page.titled_table(title, rows) for title, rows in more),
    )
    scripts = page.running(("study.js",), data)
    return page.write_html(Path(path), page.render_page("study", title, body, scripts=scripts))


def _differ(values: Sequence[float | str | None]) -> bool:
    """Return True if the values differ by more than rounding does."""
    numbers = [value for value in values if isinstance(value, float)]
    if len(numbers) < len(values):
        return len(set(values)) > 1
    return max(numbers) - min(numbers) > ROUNDING * max(map(abs, numbers))


def _list(title: str, lines: Sequence[str]) -> str:
    """Return a titled list; "" without lines."""
    items = "".join(f"<li>{html_text(line)}</li>" for line in lines)
    return f"<h2>{html_text(title)}</h2><ul>{items}</ul>" if lines else ""


def _by_text(table: pd.DataFrame, column: str) -> list[str]:
    """Return each text of a column behind its runs; texts that differ in numbers only are one."""
    kinds: dict[str, tuple[str, list[int]]] = {}
    for k, cell in enumerate(table[column] if column in table.columns else ()):
        for text in cell.split(SEPARATOR) if isinstance(cell, str) and cell else ():
            kinds.setdefault(kind_of(text), (text, []))[1].append(k + 1)
    return [f"{_listed(runs)}: {text}" for text, runs in kinds.values()]


def _in_engineering_units(
    values: Mapping[str, list[float | str | None]], stated: Mapping[str, str]
) -> tuple[dict[str, list[float | str | None]], dict[str, str], dict[str, float]]:
    """Return the columns, their units, with prefixes where numbers are large, and the factors."""
    shown, units, factors = dict(values), dict(stated), dict[str, float]()
    for name, column in values.items():
        numbers = [
            abs(value) for value in column if isinstance(value, float) and math.isfinite(value)
        ]
        factors[name], units[name] = page.engineering(
            max(numbers, default=0.0), stated.get(name, "")
        )
        shown[name] = [
            factors[name] * value if isinstance(value, float) else value for value in column
        ]
    return shown, units, factors


def _passed(table: pd.DataFrame) -> str:
    """Return a sentence on runs in which the rope passed through something; "" for none."""
    runs = [k + 1 for k, text in enumerate(table[STATUS]) if PASSED in str(text)]
    return (
        f"In {_listed(runs)} the rope passed into or through something, the status says what."
        if runs
        else ""
    )


def _listed(runs: Sequence[int]) -> str:
    """Return the numbers of the first eight runs, and how many more there are."""
    more = f" and {len(runs) - 8} more" if len(runs) > 8 else ""
    return ("run " if len(runs) == 1 else "runs ") + ", ".join(map(str, runs[:8])) + more


def _early(table: pd.DataFrame) -> str:
    """Return a sentence on conveyances that arrived before their reference; "" for none."""
    if not {"cycle_time", "trajectory_time"} <= set(table.columns):
        return ""
    cycle, trajectory = (pd.to_numeric(table[name]) for name in ("cycle_time", "trajectory_time"))
    early = [k + 1 for k, sooner in enumerate(cycle < trajectory) if sooner]
    words = (
        "the conveyances were within the band of arrival, and stayed there, before the reference "
        "was at rest."
    )
    return (
        f" cycle_time is shorter than trajectory_time in {_listed(early)}: {words}" if early else ""
    )


def _plain(value: Any) -> float | str | None:
    """Convert a cell to a number or text for JSON; booleans become words."""
    if pd.isna(value):
        return None
    if isinstance(value, str | bool) or pd.api.types.is_bool(value):
        return str(value)
    return float(value)


def _describe(values: Sequence[float | str | None]) -> str:
    return "none" if values[0] in (None, "") else _text(values[0])


def _text(value: Any) -> str:
    return page.number(value) if isinstance(value, float) else str(value)
