"""The controllers of a study, chosen by name: what the drive follows, and with which gains.

pi                    PI speed loop under a position loop on the winding's S-curve, no feed-forward
pi-feed-forward       the same with acceleration, imbalance and friction fed forward
input-shaping         with feed-forward, the S-curve shaped so that one swing mode stays at rest
optimised-trajectory  with feed-forward, the fastest trip that leaves the ropes at rest
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.design.optimal_trajectory import optimise, require_no_creep
from hoist_demo.design.shaping import shape
from hoist_demo.parameters import Hoist, Winding, start_heights
from hoist_demo.parameters.trip_design import CONTROLLERS, Shaper, TrajectoryOptions


@dataclass(frozen=True)
class Drive:
    """Gains and trajectory from which a host makes its controller."""

    gains: Gains
    trajectory: Trajectory


@dataclass(frozen=True)
class DesignTask:
    """A controller by its name, the trip that it is for, and its tuning."""

    controller: str
    hoist: Hoist
    winding: Winding
    gains: Gains
    shaper: Shaper
    trajectory: TrajectoryOptions
    # hoist of the design; None: the one that is wound
    nominal: Hoist | None = field(default=None, kw_only=True)
    # m, left conveyance before the trip; None: at a landing
    start: float | None = field(default=None, kw_only=True)

    @property
    def start_height(self) -> float:
        """Height of the left conveyance before the trip [m]."""
        left, _ = start_heights(self.hoist, self.winding)
        return left if self.start is None else self.start

    def require_possible(self) -> None:
        """Reject an unknown controller, a designed trip with an emergency stop, and an optimised one with creep."""
        if self.controller not in DESIGNS:
            raise ValueError(
                f"controller = {self.controller!r} must be one of {', '.join(DESIGNS)}: choose one"
            )
        if self.controller in _DESIGNED_TRIPS and self.winding.emergency_at is not None:
            raise ValueError(
                f"emergency_at = {self.winding.emergency_at:g} s must not be given with controller = "
                f"{self.controller!r}: stop a trip of pi or pi-feed-forward"
            )
        if self.controller == "optimised-trajectory":
            require_no_creep(self.winding)


def design_drive(task: DesignTask) -> Drive:
    """Return the gains and the trajectory of the task's controller; an optimised one takes seconds."""
    return DESIGNS[task.controller](task)


DESIGNS: dict[str, Callable[[DesignTask], Drive]] = {
    "pi": lambda t: Drive(replace(t.gains, feed_forward=0.0), s_curve(t.winding)),
    "pi-feed-forward": lambda t: Drive(t.gains, s_curve(t.winding)),
    "input-shaping": lambda t: Drive(t.gains, shape(s_curve(t.winding), t.shaper)),
    "optimised-trajectory": lambda t: Drive(t.gains, _optimised(t)),
}


def _optimised(task: DesignTask) -> Trajectory:
    hoist = task.hoist if task.nominal is None else task.nominal
    return optimise(hoist, task.winding, task.gains, task.trajectory, task.start_height)


_DESIGNED_TRIPS = ("input-shaping", "optimised-trajectory")
assert tuple(DESIGNS) == CONTROLLERS
