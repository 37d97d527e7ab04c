"""The report of a study: all runs in parallel coordinates, a scatter plot and a sortable table, in one file.

`meta` may hold `title`, `parameters` (names of the columns that were varied; the other columns are metrics) and
`best` = {"metric": name, "sense": "min" or "max"}, by which the best run is chosen among those that did not fail.
Whatever else it holds, a text or a number, is shown under Data, and so are parameters that are the same in all runs.
Only what differs between runs has an axis. A run has failed when its `cause` is not empty.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from hoist_demo.recording.passages import PASSED
from hoist_demo.report.html import page
from hoist_demo.report.html.parameter_tables import Table
from rope_model.texts import html_text

STATUS, CAUSE = "status", "cause"
WARNINGS = "warnings"  # texts, of no axis
RUN, KEY = "run", "key"  # the page counts the runs itself; a hash is no axis
ROUNDING = 1e-9  # values that differ by less are one
_OWN = ("title", "parameters", "best")


def study_report(
    table: pd.DataFrame,
    stated: Mapping[str, str],
    meta: Mapping[str, Any],
    path: str | Path,
    more: Sequence[Table] = (),
) -> Path:
    """Write the report to `path`: one row of `table` per run, units `stated` by column name ("" or "1" for none).

    `more` are tables of the data.
    """
    path = Path(path)
    parameters, asked = [str(name) for name in meta.get("parameters", ())], meta.get("best")
    best = None if asked is None else (str(asked["metric"]), str(asked["sense"]))
    causes = ["" if pd.isna(cause) else str(cause) for cause in table[CAUSE]]
    values, units = _in_engineering_units(
        {str(name): [_plain(value) for value in table[name]] for name in table.columns}, stated
    )
    names = [name for name in values if name not in (STATUS, CAUSE, RUN, KEY)]
    varied = {name for name in names if len(set(values[name])) > 1}
    fixed = [name for name in parameters if name in names and name not in varied]
    nowhere = [name for name in names if name not in parameters and set(values[name]) <= {None}]
    listed = [name for name in names if name not in {*fixed, *nowhere}]
    # parameters first: they are read before what follows from them
    order = sorted(listed, key=lambda name: (name == WARNINGS, name not in parameters)) + [KEY] * (KEY in values)
    columns = [
        {
            "name": name,
            "unit": page.unit_text(units.get(name, "")),
            "role": "parameter" if name in parameters else "metric",
            # without anything that differs, as with a single run, all numbers have one
            "axis": (name in varied if varied else name != KEY) and name != WARNINGS,
            "values": values[name],
        }
        for name in order
    ]
    chosen = _best(table, causes, best)
    data = {
        "columns": columns,
        "statuses": [str(status) for status in table[STATUS]],
        "causes": causes,
        "best": chosen,
        "by": None if best is None else best[0],
    }
    title = str(meta.get("title", "Study"))
    rest = [(str(name), _text(value), "") for name, value in meta.items() if name not in _OWN]
    body = page.fill(
        "study.html",
        outcome=html_text(
            _passed(table) + _outcome(causes, chosen, best, table, stated) + _warned(table) + _early(table)
        ),
        given=page.table("Study", rest)
        + page.table(
            "The same in all runs", [(n, _describe(values[n]), page.unit_text(units.get(n, ""))) for n in fixed]
        )
        + page.table("Not shown by any run", [(name, "", "") for name in nowhere])
        + "".join(page.table(title, rows) for title, rows in more),
    )
    return page.write(path, page.render("study", title, body, scripts=page.running(("study.js",), data)))


def _in_engineering_units(
    values: Mapping[str, list[float | str | None]], stated: Mapping[str, str]
) -> tuple[dict[str, list[float | str | None]], dict[str, str]]:
    """The columns and their units, with prefixes where the numbers are large."""
    shown, units = dict(values), dict(stated)
    for name, column in values.items():
        numbers = [abs(value) for value in column if isinstance(value, float) and math.isfinite(value)]
        factor, units[name] = page.engineering(max(numbers, default=0.0), stated.get(name, ""))
        shown[name] = [factor * value if isinstance(value, float) else value for value in column]
    return shown, units


def _passed(table: pd.DataFrame) -> str:
    """A sentence about runs in which the rope passed through something; "" where there are none."""
    runs = [k + 1 for k, text in enumerate(table[STATUS]) if PASSED in str(text)]
    return f"In {_listed(runs)} the rope passed into or through something, the status says what. " if runs else ""


def _warned(table: pd.DataFrame) -> str:
    """A sentence where runs have warned; "" where none has."""
    if WARNINGS not in table.columns:
        return ""
    runs = [k + 1 for k, text in enumerate(table[WARNINGS]) if isinstance(text, str) and text]
    return f" Of {_listed(runs)} there are warnings, the last column of the table." if runs else ""


def _best(table: pd.DataFrame, causes: Sequence[str], best: tuple[str, str] | None) -> int | None:
    """Place of the best run; None when none is asked for or none can be compared."""
    if best is None:
        return None
    metric, sense = best
    values = pd.to_numeric(table[metric])
    candidates = [(float(value), k) for k, value in enumerate(values) if causes[k] == "" and not pd.isna(value)]
    if not candidates:
        return None
    sign = 1.0 if sense == "min" else -1.0
    return min(candidates, key=lambda pair: (sign * pair[0], pair[1]))[1]


def _outcome(
    causes: Sequence[str],
    chosen: int | None,
    best: tuple[str, str] | None,
    table: pd.DataFrame,
    units: Mapping[str, str],
) -> str:
    failed = sum(cause != "" for cause in causes)
    text = f"{len(causes)} runs, {failed} failed."
    if best is None:
        return f"{text} No metric was named by which a best run could be chosen: minimise or maximise in [study]."
    if chosen is None:
        return f"{text} No run that can be compared by {best[0]}."
    smallest = "smallest" if best[1] == "min" else "largest"
    values = pd.to_numeric(table[best[0]])
    factor, unit = page.engineering(abs(float(values.iloc[chosen])), units.get(best[0], ""))
    value = f"{page.number(factor * float(values.iloc[chosen]))} {page.unit_text(unit)}".rstrip()
    text += f" Best run: {chosen + 1}, with the {smallest} {best[0]} of {value}"
    equal = [
        k + 1
        for k, other in enumerate(values)
        if k != chosen and causes[k] == "" and math.isclose(other, values.iloc[chosen], rel_tol=ROUNDING)
    ]
    return f"{text}, the first of {len(equal) + 1} with this value: also {_listed(equal)}." if equal else f"{text}."


def _listed(runs: Sequence[int], most: int = 8) -> str:
    """Numbers of runs, the first of many."""
    more = f" and {len(runs) - most} more" if len(runs) > most else ""
    return ("run " if len(runs) == 1 else "runs ") + ", ".join(map(str, runs[:most])) + more


def _early(table: pd.DataFrame) -> str:
    """A sentence where conveyances have arrived before their reference; "" where none has."""
    if not {"cycle_time", "trajectory_time"} <= set(table.columns):
        return ""
    cycle, trajectory = (pd.to_numeric(table[name]) for name in ("cycle_time", "trajectory_time"))
    early = [k + 1 for k, sooner in enumerate(cycle < trajectory) if sooner]
    if not early:
        return ""
    return (
        f" cycle_time is shorter than trajectory_time in {_listed(early)}: the conveyances were within the band of "
        "arrival, and stayed there, before the reference was at rest."
    )


def _plain(value: Any) -> float | str | None:
    """A cell as JSON knows it; booleans as words, because they are no quantity."""
    if pd.isna(value):
        return None
    if isinstance(value, str | bool) or pd.api.types.is_bool(value):
        return str(value)
    return float(value)


def _describe(values: Sequence[float | str | None]) -> str:
    return "none" if values[0] in (None, "") else _text(values[0])


def _text(value: Any) -> str:
    return page.number(value) if isinstance(value, float) else str(value)
