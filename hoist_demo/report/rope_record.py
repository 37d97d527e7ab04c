"""Record of one rope in a run, with its data: what the verdict reads of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.recording.time_series import Recording


@dataclass(frozen=True)
class RopeRecord:
    """Record of the signals of one rope, and its data."""

    recording: Recording
    data: RopeData

    def parameter(self, name: str) -> float:
        """Return a number of the rope's parameters, 0 if it lacks it."""
        value = self.data.parameters.get(name, 0.0)
        if isinstance(value, int | float):
            return float(value)
        return 0.0

    def last(self, name: str) -> float:
        """Return the value at the end of the record; NaN if it was not computed."""
        if name in self.recording:
            return float(self.recording[name][-1])
        return math.nan

    def has_numbers(self, *names: str) -> bool:
        """Return True if all these signals have numbers."""
        return self.recording.has(*names) and all(
            bool(np.isfinite(self.recording[name]).any()) for name in names
        )

    def at(self, row: int, name: str) -> str:
        """Return the instant of a row, and from when on the signal was computed."""
        instant = f"t = {self.recording.time[row]:.2f} s"
        since = self.since(name)
        if since:
            return f"{instant}, {since}"
        return instant

    def since(self, name: str) -> str:
        """Return from when on a signal was computed; "" if it always was."""
        computed = np.isfinite(self.recording[name])
        if computed.all():
            return ""
        return f"computed from t = {self.recording.time[np.argmax(computed)]:.2f} s on"

    @cached_property
    def loop_error(self) -> float:
        """Estimated error of the loop's place [m]."""
        return self.last("status.loop_error")


def rope_text(name: str) -> str:
    """Return a rope's name in a sentence; the only rope has none."""
    if name:
        return f"rope {name}"
    return "the rope"


def swinging(ropes: Sequence[RopeRecord]) -> list[Recording]:
    """Return the records that have the sideways swing of a loop."""
    return [rope.recording for rope in ropes if rope.has_numbers("loop.sideways")]
