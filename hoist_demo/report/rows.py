"""Rows of a table for people, the table as plain text, and rows of the sources of a run's data."""

import math
import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from hoist_demo.report.formatting import Row, number, unit_text
from hoist_demo.report.parameter_tables import TitledRows
from hoist_demo.report.verdict import Verdict
from hoist_demo.report.verdict_row import COLUMNS
from hoist_demo.run.provenance import SETTING, STATUSES, SourcedValue

OUTCOME = "Outcome"  #: Group of the rows on how a run went.
WARNING = "warning"  #: Quantity of the rows that every report shows first.
#: Significant digits of a number in the summary, which the rope's standard accuracy leaves.
DIGITS = 4
WHOLE = 10  #: Significant digits of a whole number.
LONG = 40  #: Characters from which a text has lines of its own in the table.
TEXT_WIDTH = 110  #: Characters of a line of text.


@dataclass(frozen=True)
class SummaryRow:
    """Line of the summary table."""

    group: str
    quantity: str
    value: float | str
    unit: str = ""

    @property
    def text(self) -> str:
        """Value as text, in DIGITS."""
        if isinstance(self.value, str):
            return self.value
        whole = float(self.value).is_integer()
        return number(self.value, WHOLE if whole else DIGITS)


@dataclass(frozen=True)
class Report:
    """Content of a report, in reading order.

    ``changed`` are the settings that differ, ``data_tables`` have all data.
    """

    title: str
    verdict: Verdict
    changed: TitledRows = ("", [])
    rows: Sequence[SummaryRow] = ()
    data_tables: Sequence[TitledRows] = ()


def rows_by_group(rows: Sequence[SummaryRow]) -> dict[str, list[SummaryRow]]:
    """Return the rows by their groups, both in reading order."""
    groups: dict[str, list[SummaryRow]] = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    return groups


#: Head of the table of settings that differ.
CHANGED = ("parameter", "value", "unit", "of the case")


def in_display_unit(value: float, unit: str) -> tuple[float, str]:
    """Convert to a unit for people: angles to degrees, pure numbers to none."""
    if unit == "rad":
        return math.degrees(value), "deg"
    return value, unit_text(unit)


def render(rows: Sequence[SummaryRow]) -> str:
    """Return the summary as plain text."""
    width = max((len(row.quantity) for row in rows), default=0)
    lines: list[str] = []
    for k, row in enumerate(rows):
        if k == 0 or row.group != rows[k - 1].group:
            lines += ["", row.group]
        if len(row.text) > LONG:
            text = f"{row.quantity}: {row.text}"
            lines += textwrap.wrap(
                text, width=TEXT_WIDTH, initial_indent="  ", subsequent_indent="    "
            )
        else:
            line = f"  {row.quantity:<{width}}  {row.text:>14} {unit_text(row.unit)}"
            lines.append(line.rstrip())
    return "\n".join(lines[1:])


def render_verdict(verdict: Verdict) -> str:
    """Return the verdict as plain text: its words and its rows."""
    lines = [*textwrap.wrap(verdict.summary, TEXT_WIDTH), ""]
    if verdict.rows:
        lines += aligned_table([COLUMNS, *(row.cells for row in verdict.rows)])
    return "\n".join(lines)


def aligned_table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of a table whose columns are as wide as their widest cells."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        lines.append("  ".join(cells).rstrip())
    return lines


TITLE = "Data that this rests on, by status"
MAX_LISTED_NAMES = 8  #: Most names that are listed one by one.


def status_rows(data: Sequence[SourcedValue]) -> list[SummaryRow]:
    """Return a row for each status: names of few data, the number of each kind of many."""
    rows = []
    for status in STATUSES:
        names = [one.name for one in data if one.status == status]
        if names and status != SETTING:
            parts = names
            if len(names) > MAX_LISTED_NAMES:
                kinds = Counter(name.rpartition(".")[0] for name in names)
                parts = [f"{count} of {kind}" for kind, count in kinds.items()]
            rows.append(SummaryRow(TITLE, status, ", ".join(parts)))
    return rows


def provenance_table(data: Sequence[SourcedValue]) -> TitledRows:
    """Return the data without settings, sorted by STATUSES."""
    rows: list[Row] = []
    for one in sorted(data, key=lambda one: STATUSES.index(one.status)):
        if one.status != SETTING:
            if isinstance(one.value, str):
                value = one.value
            else:
                value = number(one.value)
            rows.append((one.name, value, unit_text(one.unit), one.status))
    return TITLE, rows
