"""Coordinates, states and inputs of a hoist: their names and their order.

Generalised coordinates q are phi, y_left, y_right and, where the hoist has the part: twist, the
motor's angle against the sheave; eta_j of either side, the head ropes' modes; x, z and yaw of either
conveyance; slip of ropes on a lining.
"""

from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import casadi as ca

from hoist_demo.parameters import SIDES, Hoist

#: First entries of every state.
STATE_NAMES = ("torque", "phi", "y_left", "y_right", "phi_rate", "v_left", "v_right")
INPUT_NAMES = (
    *("torque_command", "force_left", "force_right", "brake"),
    *(f"{name}_{side}" for side, name in product(SIDES, ("fx", "fz", "my"))),
)
WORK_NAMES = ("motor", "losses", "ropes", "left", "right")
LOSS_NAMES = ("rim", "guides", "brake", "shaft", "lining")  #: The parts of the losses.
TORQUE = STATE_NAMES.index("torque")  #: Place of the motor's torque in a state.
#: Place of the controller's command in an input.
TORQUE_COMMAND = INPUT_NAMES.index("torque_command")
#: Places of the two vertical forces in an input.
FORCES = tuple(INPUT_NAMES.index(f"force_{side}") for side in SIDES)
#: Places of the two vertical accelerations in the rates.
ACCELERATIONS = tuple(STATE_NAMES.index(f"v_{side}") for side in SIDES)
LATERAL = ("x", "z", "yaw")  #: Coordinates of a conveyance between its guides.


def extra_coordinates(hoist: Hoist) -> tuple[str, ...]:
    """Names of the coordinates that the hoist has beyond phi, y_left and y_right."""
    names: list[str] = []
    if hoist.drive_shaft is not None:
        names.append("twist")
    modes = range(1, hoist.head_rope_modes + 1)
    names += [f"eta{j}_{side}" for side, j in product(SIDES, modes)]
    if hoist.play is not None:
        names += [f"{name}_{side}" for side, name in product(SIDES, LATERAL)]
    if hoist.lining is not None:
        names.append("slip")
    return tuple(names)


def state_names(hoist: Hoist) -> tuple[str, ...]:
    """Names of all states of a hoist.

    They are STATE_NAMES, further coordinates, their rates, the brake's pressure, all deflections.
    Ropes that slide have the distance slip [m] that they have slid, positive as the sheave's
    rotation, and their sense.
    """
    extra = extra_coordinates(hoist)
    names = [*STATE_NAMES, *extra, *(f"{name}_rate" for name in extra)]
    if hoist.brake is not None:
        names += ["brake_pressure", "brake_deflection"]
    jammed = [side for side in SIDES if getattr(hoist, f"jam_{side}") is not None]
    names += [f"jam_deflection_{side}" for side in jammed]
    if hoist.lining is not None:
        names.append("sense")
    return tuple(names)


class Coordinate(NamedTuple):
    """Symbols of a coordinate and its rate; zeros where the hoist lacks it."""

    value: Any
    rate: Any


CoordinateLookup = Callable[[str], Coordinate]  #: Returns a coordinate by name.


class Coordinates:
    """Symbols of q and q' by name."""

    def __init__(self, structure: Hoist) -> None:
        self.names = ("phi", "y_left", "y_right", *extra_coordinates(structure))
        self.q = ca.SX.sym("q", len(self.names))
        self.v = ca.SX.sym("v", len(self.names))

    def __call__(self, name: str) -> Coordinate:
        """Coordinate and its rate; zeros where the hoist lacks it."""
        if name not in self.names:
            return Coordinate(0.0, 0.0)
        k = self.names.index(name)
        return Coordinate(self.q[k], self.v[k])
