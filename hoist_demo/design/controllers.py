"""The controllers of a study, chosen by name: what the drive follows, and with which gains.

pi                    PI speed loop under a position loop on the winding's S-curve, no feed-forward
pi-feed-forward       the same with acceleration, imbalance and friction fed forward
input-shaping         with feed-forward, the S-curve shaped so that one swing mode stays at rest
optimised-trajectory  with feed-forward, the fastest trip that leaves the ropes at rest
"""

from dataclasses import dataclass, replace

from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.design.optimal_trajectory import TrajectoryOptions, optimise, require_no_creep
from hoist_demo.design.shaping import Shaper, shape
from hoist_demo.parameters import Hoist, Winding

DESIGNED = ("input-shaping", "optimised-trajectory")
CONTROLLERS = ("pi", "pi-feed-forward", *DESIGNED)


@dataclass(frozen=True)
class Drive:
    """Gains and trajectory from which a host makes its controller."""

    gains: Gains
    trajectory: Trajectory


def drive(
    name: str, hoist: Hoist, winding: Winding, gains: Gains, shaper: Shaper, trajectory: TrajectoryOptions
) -> Drive:
    """The named controller for a trip; an optimised one is computed here, which takes seconds."""
    require_possible(name, winding)
    if name == "pi":
        return Drive(replace(gains, feed_forward=0.0), s_curve(winding))
    if name == "input-shaping":
        return Drive(gains, shape(s_curve(winding), shaper))
    if name == "optimised-trajectory":
        return Drive(gains, optimise(hoist, winding, gains, trajectory))
    return Drive(gains, s_curve(winding))


def require_possible(name: str, winding: Winding) -> None:
    """Reject an unknown controller, a designed trip with an emergency stop, and an optimised one with creep."""
    if name not in CONTROLLERS:
        raise ValueError(f"controller = {name!r} must be one of {', '.join(CONTROLLERS)}: choose one")
    if name in DESIGNED and winding.emergency_at is not None:
        raise ValueError(
            f"emergency_at = {winding.emergency_at:g} s must not be given with controller = {name!r}: "
            "stop a trip of pi or pi-feed-forward"
        )
    if name == "optimised-trajectory":
        require_no_creep(winding)
