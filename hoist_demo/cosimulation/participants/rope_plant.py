"""Protocol between the host loop and a balance rope, in an FMU or in this process.

Names of signals and inputs are those of the FMI interface, e.g. `left.fy` [N], the rope's force on the left
conveyance. Motions are given at the END of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.end_motion import EndMotion

__all__ = ["REQUIRED_SIGNALS", "EndMotion", "Reader", "RopePlant", "RopeStatus"]

Reader = Callable[[], NDArray[np.float64]]

REQUIRED_SIGNALS = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
"""Without these the loop cannot run; every other signal may be missing."""


@dataclass(frozen=True)
class RopeStatus:
    """Verdict on a step of the rope, with the cause of a failure."""

    valid: bool
    message: str = ""


class RopePlant(Protocol):
    """A balance rope between two moving ends."""

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """Find the hanging shape at time t0 [s]; signals() then gives the forces at rest."""
        ...

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """Advance from t to t + h [s]; `left` and `right` hold at t + h."""
        ...

    def signals(self) -> dict[str, float]:
        """All numeric outputs by FMI name, booleans as 0 and 1."""
        ...

    def reader(self, names: Sequence[str]) -> Reader:
        """A function that reads these outputs now, costly ones too, NaN for what the rope has not got.

        It may be made before the rope hangs; its array is the caller's.
        """
        ...

    def save(self) -> Any:
        """The complete state as a snapshot in memory, None where the rope cannot."""
        ...

    def restore(self, snapshot: Any) -> None:
        """Go back to a snapshot: whatever comes next is the same to the bit."""
        ...

    def free(self, snapshot: Any) -> None:
        """Forget a snapshot; None is allowed."""
        ...

    def to_bytes(self, snapshot: Any) -> bytes:
        """A snapshot for a file."""
        ...

    def from_bytes(self, data: bytes) -> Any:
        """The snapshot that `to_bytes` wrote, also that of another instance; ValueError when it does not fit."""
        ...

    def units(self) -> dict[str, str]:
        """FMI unit of each signal, "1" or "" where it has none."""
        ...

    def close(self) -> None:
        """Free what the rope holds; may be called more than once."""
        ...
