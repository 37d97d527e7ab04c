"""Keys of a study: the host's data as `section.field`, and the FMU's parameters by name.

Every value is checked for its unit, its type and, one at a time, its bounds: the data classes check themselves, and
the FMU is asked to initialize with the value.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

from hoist_demo.control.controller import Gains
from hoist_demo.design.controllers import CONTROLLERS
from hoist_demo.design.optimal_trajectory import TrajectoryOptions
from hoist_demo.design.shaping import Shaper
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.parameter import Parameter
from hoist_demo.study.metrics import Arrival
from hoist_demo.study.nested import leaves

SECTIONS: dict[str, type[Any]] = {
    "hoist": Hoist,
    "winding": Winding,
    "coupling": Coupling,
    "gains": Gains,
    "shaper": Shaper,
    "trajectory": TrajectoryOptions,
    "arrival": Arrival,
}

RESERVED = {"inputs_at_step_end": "the host sets it"}
RENAMED = {
    "model.rung": ["model.fidelity"],
    "mesh.leg_growth": ["mesh.grading_length"],
    **{f"hoist.shaft.{name}": [f"hoist.drive_shaft.{name}"] for name in ("motor_mass", "stiffness", "damping")},
}
"""Names of earlier versions and those of today."""


class Catalogue:
    """All parameters of runs with a rope that has these parameters; {} for those of the host only."""

    def __init__(self, rope: Mapping[str, Parameter]) -> None:
        self._parameters = {"controller": Parameter("controller", "1", "String", choices=CONTROLLERS)}
        for section, data in SECTIONS.items():
            self._parameters |= {leaf.name: leaf for leaf in leaves(data, f"{section}.")}
        self._parameters |= {name: p for name, p in rope.items() if name not in RESERVED}

    def __contains__(self, key: str) -> bool:
        return key in self._parameters

    def __getitem__(self, key: str) -> Parameter:
        """The parameter; a `ValueError` for an unknown key names the nearest ones."""
        if key in RESERVED:
            raise ValueError(f"{key} cannot be chosen, {RESERVED[key]}: leave it out")
        if key not in self._parameters:
            near = RENAMED.get(key) or [name for name in self._parameters if name.lower() == key.lower()]
            near = near or difflib.get_close_matches(key, self._parameters, n=3)
            near = near or [name for name in self._parameters if name.split(".")[-1] == key.split(".")[-1]]
            cure = (
                f"did you mean {' or '.join(near)}?" if near else f"sections are {', '.join(SECTIONS)}, or an FMU name"
            )
            raise ValueError(f"{key} is not a parameter: {cure}")
        return self._parameters[key]

    def units(self, keys: Mapping[str, Any]) -> dict[str, str]:
        """Unit of each key."""
        return {key: self[key].unit for key in keys}
