"""Sources of a run's data: few by name and many by number in a summary, all of them in a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from hoist_demo.report.html.page import Row, number, unit_text
from hoist_demo.report.html.parameter_tables import Table
from hoist_demo.report.rows import SummaryRow
from hoist_demo.study.provenance import SETTING, STATUSES, Known

TITLE = "Data that this rests on, by status"
#: most names that are told one by one
NAMED = 8


def told(data: Sequence[Known]) -> list[SummaryRow]:
    """Return the summary of the data's sources: names of few, and the number of each kind of many."""
    rows = []
    for status in STATUSES:
        names = [one.name for one in data if one.status == status]
        if names and status != SETTING:
            kinds = Counter(name.rpartition(".")[0] for name in names)
            text = ", ".join(names if len(names) <= NAMED else (f"{count} of {kind}" for kind, count in kinds.items()))
            rows.append(SummaryRow(TITLE, status, text))
    return rows


def table(data: Sequence[Known]) -> Table:
    """All of the data but settings, the least certain status first in the order of STATUSES."""
    rows: list[Row] = [
        (one.name, one.value if isinstance(one.value, str) else number(one.value), unit_text(one.unit), one.status)
        for one in sorted(data, key=lambda one: STATUSES.index(one.status))
        if one.status != SETTING
    ]
    return TITLE, rows
