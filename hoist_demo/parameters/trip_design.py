"""Parameters of the design of a trip: controllers by name, the shaper's mode, optimisation."""

from dataclasses import dataclass
from typing import Literal

from hoist_demo.parameters.quantity import NONNEGATIVE, NumberRange, ValidatedData, parameter

#: Names; design.controllers has them.
CONTROLLERS = ("pi", "pi-feed-forward", "input-shaping", "optimised-trajectory")


@dataclass(frozen=True)
class Shaper(ValidatedData):
    """Mode that the shaper leaves at rest, measured or from the linear model.

    The metrics ``swing_frequency`` and ``swing_damping`` of a study measure it.
    """

    kind: Literal["ZV", "ZVD"] = parameter("ZVD", "")
    frequency: float = parameter(
        0.0,
        "Hz",
        "damped frequency of the mode; 0: the linear model gives frequency and damping",
        NONNEGATIVE,
    )
    damping: float = parameter(
        0.0, "1", "damping ratio of the mode", NumberRange(0.0, 0.999, cure="measure it")
    )


@dataclass(frozen=True)
class TrajectoryOptions(ValidatedData):
    """Options of the optimisation, with defaults of ours [assumed]."""

    swing_speed: float = parameter(
        0.01, "m/s", "speed of the conveyances after arrival that is worth swing_price"
    )
    swing_price: float = parameter(1.0, "s", "time that a swing at swing_speed is worth")
    hold: float = parameter(1.5, "s", "time after arrival over which the swing counts")
    intervals: int = parameter(
        120,
        "1",
        "number of intervals of the trip",
        NumberRange(20, 2000, cure="take about 8 per second"),
    )
