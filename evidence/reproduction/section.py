"""What a section of the page is, and what a claim of the source is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from evidence.claims import Measurement
from evidence.rendering import number
from evidence.tables import Tables


@dataclass(frozen=True)
class Claim:
    """What the source states in words, and the number of ours that decides whether we see it too.

    ``because`` says why ours differs; it is printed where the claim does not hold.
    """

    source: str
    measured: Measurement
    because: str = ""

    @property
    def holds(self) -> bool:
        """Whether ours shows what the source states."""
        return self.measured.holds

    @property
    def number(self) -> str:
        """Value with unit."""
        return _with_unit(self.measured.value, self.measured.unit)

    @property
    def bound(self) -> str:
        """Relation and bound with unit."""
        words = {"<": "below", ">": "above"}[self.measured.relation]
        return f"{words} {_with_unit(self.measured.bound, self.measured.unit)}"

    @property
    def verdict(self) -> str:
        """The line below the figure."""
        line = f"{self.source}: {self.measured.what} {self.number} (asked: {self.bound})"
        if self.holds:
            return f"reproduced: {line}"
        return f"not reproduced: {line}" + (f", because {self.because}" if self.because else "")


@dataclass(frozen=True)
class Picture:
    """A figure's file name without suffix, its text for readers who cannot see it, and how it is drawn."""

    name: str
    alt: str
    draw: Callable[[Tables], Figure]


@dataclass(frozen=True)
class Section:
    """``key`` names its template, which says what is run and what the ``numbers`` of the tables show."""

    key: str
    title: str
    pictures: Sequence[Picture]
    claims: Callable[[Tables], Sequence[Claim]]
    numbers: Callable[[Tables], Mapping[str, Any]]
    data: Sequence[str]  # tables that belong to it


def _with_unit(value: float, unit: str) -> str:
    return number(value) if unit == "1" else f"{number(value)} {unit}"
