"""A line of the page's table."""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from typing import Literal

from evidence.tables import Table, table


@dataclass(frozen=True)
class Row:
    """What deviates from ``reference``, by how much, and the least deviation that is not accepted; NaN: none stated."""

    id: str
    kind: Literal["measured", "theory", "code"]
    reference: str
    what: str
    value: float
    unit: str  # '1' without one
    bound: float
    test: str  # in tests/evidence/test_validation.py, or 'make validate'

    @property
    def shown(self) -> bool:
        """Whether no acceptance is stated."""
        return math.isnan(self.bound)

    @property
    def misses(self) -> bool:
        """Whether a stated acceptance is missed; also by NaN."""
        return not self.shown and not self.value < self.bound


_NAMES = [field.name for field in fields(Row)]


def as_table(rows: Sequence[Row]) -> Table:
    return table(_NAMES, [astuple(row) for row in rows])


def from_table(t: Table) -> list[Row]:
    return [Row(*values) for values in zip(*(t[name] for name in _NAMES), strict=True)]
