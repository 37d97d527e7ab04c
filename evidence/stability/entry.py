"""What a stability entry is, and what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evidence.claims import Measurement

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """One line of an entry's figure."""

    label: str
    x: Array
    y: Array
    style: str = "-"


@dataclass(frozen=True)
class Figure:
    """What an entry shows."""

    title: str
    x_label: str  # with unit
    y_label: str
    curves: tuple[Curve, ...]
    log_x: bool = False
    log_y: bool = False


@dataclass(frozen=True)
class Finding:
    """What the failing counterexample did and what ours did in the same scene, and a figure where looking helps."""

    counterexample: tuple[Measurement, ...]  # what the counterexample does wrong
    ours: tuple[Measurement, ...]  # what ours does right
    figure: Figure | None = None
    message: str = ""  # what the user is told where ours stops instead of holding

    @property
    def holds(self) -> bool:
        """Whether all claims are true."""
        return all(m.holds for m in (*self.counterexample, *self.ours))


@dataclass(frozen=True)
class Entry:
    """A scene: ``key`` names it in tests, files and the chapter's template, which tells what happens and why.

    ``slow`` entries take more than some 4 s.
    """

    key: str
    title: str
    measure: Callable[[], Finding]
    slow: bool = False
