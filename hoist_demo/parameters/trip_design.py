"""Parameters of the design of a trip: the controllers by name, the shaper's mode, and the optimisation."""

from dataclasses import dataclass
from typing import Literal

from hoist_demo.parameters.quantity import NONNEGATIVE, Bounds, ValidatedData, parameter

CONTROLLERS = (
    "pi",
    "pi-feed-forward",
    "input-shaping",
    "optimised-trajectory",
)  #: Names; design.controllers has them.


@dataclass(frozen=True)
class Shaper(ValidatedData):
    """The mode to leave at rest, as measured (metrics `swing_frequency`, `swing_damping` of a study) or modelled."""

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
