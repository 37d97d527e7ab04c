"""Data of the hoist, of the winding and of the coupling: SI units, checked once, here."""

from hoist_demo.parameters.coupling import Coupling as Coupling
from hoist_demo.parameters.hoist import ASSUMED_DATA as ASSUMED_DATA
from hoist_demo.parameters.hoist import GRAVITY as GRAVITY
from hoist_demo.parameters.hoist import Hoist as Hoist
from hoist_demo.parameters.hoist import hoist_with as hoist_with
from hoist_demo.parameters.winding import Arrival as Arrival
from hoist_demo.parameters.winding import EmergencyLaw as EmergencyLaw
from hoist_demo.parameters.winding import Winding as Winding
from hoist_demo.parameters.winding import require_jams_on_the_way as require_jams_on_the_way
from hoist_demo.parameters.winding import require_trip_fits as require_trip_fits
from hoist_demo.parameters.winding import start_heights as start_heights
from rope_model.physics.node import SIDES as SIDES
