"""Parameters of the design of a trip: controllers by name, the shaper's mode, optimisation."""

from dataclasses import dataclass
from typing import Literal

from hoist_demo.parameters.quantity import NONNEGATIVE, Bounds, ValidatedData, parameter

#: Names; design.controllers has them.
CONTROLLERS = ("pi", "pi-feed-forward", "input-shaping", "optimised-trajectory")


@dataclass(frozen=True)
class Shaper(ValidatedData):
    """Mode that the shaper leaves at rest, measured or from the linear model.

    The metrics `swing_frequency` and `swing_damping` of a study measure it.
    """

    kind: Literal["ZV", "ZVD"] = parameter("ZVD", "")
    frequency: float = parameter(
        0.0, "Hz", "damped, of the mode; 0: it and damping from the linear model", NONNEGATIVE
    )
    damping: float = parameter(
        0.0, "1", "damping ratio of the mode", Bounds(0.0, 0.999, cure="measure it")
    )


@dataclass(frozen=True)
class TrajectoryOptions(ValidatedData):
    """Options of the optimisation, with defaults of ours [assumed]."""

    swing_speed: float = parameter(
        0.01, "m/s", "of the conveyances after arrival, that is worth swing_price"
    )
    swing_price: float = parameter(1.0, "s")
    hold: float = parameter(1.5, "s", "after arrival, over which the swing counts")
    intervals: int = parameter(
        120, "1", "of the trip", Bounds(20, 2000, cure="take about 8 per second")
    )
