"""The hoist's safety circuit stops it, by the law of its winding.

A guard of the balance rope's loop opens it, or head ropes whose pull on a conveyance is below `Hoist.slack_tension`.

The stop begins at the first sample that sees the trip. One that is under way already stays as it is, and a reference
that has come to rest needs none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hoist_demo.control.trajectory import Trajectory, stopped_at
from hoist_demo.parameters import Winding


@dataclass(frozen=True)
class Course:
    """The trip as it is wound: its reference, and its data with the stop that there was."""

    trajectory: Trajectory
    winding: Winding

    def stopped(self, at: float) -> Course:
        """The course with an emergency stop from `at` [s] on, where none has begun before."""
        begun = self.winding.emergency_at
        if at >= self.trajectory.duration or (begun is not None and begun <= at):
            return self
        return Course(stopped_at(self.trajectory, at, self.winding), replace(self.winding, emergency_at=at))
