"""Data of the hoist, of the winding and of the coupling: SI units, checked once, here."""

from hoist_demo.parameters.coupling import Coupling
from hoist_demo.parameters.hoist import ASSUMED_DATA, GRAVITY, Hoist
from hoist_demo.parameters.winding import (
    EmergencyLaw,
    Winding,
    require_jams_on_the_way,
    require_trip_fits,
    start_heights,
)

__all__ = [
    "ASSUMED_DATA",
    "GRAVITY",
    "Coupling",
    "EmergencyLaw",
    "Hoist",
    "Winding",
    "require_jams_on_the_way",
    "require_trip_fits",
    "start_heights",
]
