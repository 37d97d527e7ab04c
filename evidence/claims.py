"""Numbers and the claims about them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from typing import Literal

from evidence.rendering import with_unit
from evidence.tables import Table, Tables, table


@dataclass(frozen=True)
class Measurement:
    """One number, what it is, and the claim about it: ``value`` is ``relation`` ``bound``."""

    what: str
    value: float
    unit: str  # '1' without one
    relation: Literal["<", ">"]
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the claim is true; never for NaN."""
        return self.value < self.bound if self.relation == "<" else self.value > self.bound


def below(what: str, value: float, bound: float, unit: str = "1") -> Measurement:
    """Return the claim that ``value`` is below ``bound``."""
    return Measurement(what, float(value), unit, "<", bound)


def above(what: str, value: float, bound: float, unit: str = "1") -> Measurement:
    """Return the claim that ``value`` is above ``bound``."""
    return Measurement(what, float(value), unit, ">", bound)


def text(m: Measurement) -> str:
    """Return the value against its bound."""
    return f"{with_unit(m.value, m.unit, '.4g')} {m.relation} {with_unit(m.bound, m.unit, 'g')}"


def as_table(keys: Sequence[str], found: Iterable[tuple[Sequence[str], Measurement]]) -> Table:
    """Return claims as a table; ``keys`` are the columns that tell what each is about."""
    names = [field.name for field in fields(Measurement)]
    return table((*keys, *names), [(*about, *astuple(m)) for about, m in found])


def recorded(t: Table) -> list[tuple[tuple[str, ...], Measurement]]:
    """Return the claims of a table, each with what it is about."""
    size = len(fields(Measurement))
    rows = zip(*(column.tolist() for column in t.values()), strict=True)
    return [(row[:-size], Measurement(*row[-size:])) for row in rows]


def missed(tables: Tables) -> Iterator[str]:
    """Yield the claims that do not hold, of the tables that have claims."""
    for t in (t for t in tables.values() if "relation" in t):
        yield from (
            f"{', '.join(about)}: {m.what} {text(m)}" for about, m in recorded(t) if not m.holds
        )
