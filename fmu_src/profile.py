"""Presentation of an FMU: described outputs, arrays or scalars, length of the default run.

The code inside is the same for all profiles, as are the value references: outputs that are not
described are not requested, and so not computed.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from fmu_src.interface import Variable
from rope_model.scene_names import Value

#: contents of each group of outputs
OUTPUT_GROUPS = {
    "ends": (
        "forces and moments on the conveyances, mean vertical forces, added masses; "
        "`contact.*` and `audit.*`"
    ),
    "swivels": "angle, rate and torque of the swivels, and whether they slip",
    "loop": "place, yaw and clearance of the loop, turns of the legs about each other",
    "stress": "largest nominal stresses; twist at the ends and in the loop",
    "energy": "energies; works and dissipation since the start; the energy balance",
    "count": "time steps, iterations, transformations, swivel events",
    "shape": "points along the rope, with tension and stresses there: 567 numbers",
    "station": "place, tension, curvature and torque of points that stay in the rope: 486 numbers",
    "clearance": "distances of the rope from the bodies in its shaft",
    "nearest": "the smallest of these so far, when and where",
    "guard": "whether a guard of the loop has tripped, which one and when",
    "status": "whether results are valid, messages, the fidelity of the model",
}
#: groups that every FMU describes
ALWAYS = ("ends", "status")
#: groups that an FMU describes by default
DEFAULT = tuple(group for group in OUTPUT_GROUPS if group not in ("shape", "station"))
ALL = tuple(OUTPUT_GROUPS)
#: descriptions of the arrays as a whole
DESCRIPTIONS = {
    **{
        f"shape.{axis}": f"{axis.upper()} of points along the rope, denser around the loop"
        for axis in "xyz"
    },
    "shape.s": "places of these points along the rope, from its left end",
    "shape.tension": "tension at these points",
    "shape.bending": "nominal bending stress at these points",
    "shape.torsion": "nominal torsional stress at these points",
    "station.tension": "tension at places that stay in the rope",
    "station.curvature": "curvature at these places, RMS along an element",
    "station.torque": "torque about the tangent at these places",
    **{f"station.{axis}": f"{axis.upper()} of these places" for axis in "xyz"},
}


@dataclass(frozen=True)
class Profile:
    """Choices of an export that change no result."""

    outputs: tuple[str, ...] = DEFAULT  # names of OUTPUT_GROUPS; ALWAYS are added
    arrays: bool = True  # whether FMI 3.0 has arrays; without, each element is a scalar variable
    stop: float = 30.0  # s, of the default experiment

    def __post_init__(self) -> None:
        if unknown := sorted(set(self.outputs) - set(OUTPUT_GROUPS)):
            raise ValueError(
                f"there is no group of outputs {', '.join(unknown)}; "
                f"choose one of {', '.join(OUTPUT_GROUPS)}"
            )
        if not (math.isfinite(self.stop) and self.stop > 0.0):
            raise ValueError(
                f"stop = {self.stop!r} s is out of range: it must be above 0; give the run's length"
            )

    def select(self, table: Sequence[Variable]) -> dict[int, Variable]:
        """Return the variables of the description by value reference, in the order of reading."""
        shown = {*self.outputs, *ALWAYS}
        listed = {
            i: v
            for i, v in enumerate(table)
            if v.causality != "output" or output_group(v.name) in shown
        }
        return in_reading_order(listed)


FULL = Profile(ALL)
#: groups of parameters in the order in which a user comes to set them; others follow
_PARAMETERS = (
    "trip",
    "controller",
    "rope",
    "layout",
    "left",
    "right",
    "inputs_at_step_end",
    "inputs",
    "model",
    "accuracy",
    "air",
    "guard",
    "contact",
    "lining",
    "conveyance",
    "head_ropes",
    "divider_1",
    "divider_2",
    "divider_3",
    "divider_4",
    "sump",
    "station",
    "mesh",
    "solver",
)
_FIRST = ("input", "output")  #: Causalities that come before parameters.


def in_reading_order(described: Mapping[int, Variable]) -> dict[int, Variable]:
    """Return the variables with inputs first, then outputs, then parameters by use.

    Value references stay.
    """

    def place(item: tuple[int, Variable]) -> tuple[int, int]:
        reference, v = item
        if v.causality != "parameter":
            return _FIRST.index(v.causality), reference
        group = v.name.partition(".")[0]
        use = len(_PARAMETERS)
        if group in _PARAMETERS:
            use = _PARAMETERS.index(group)
        return len(_FIRST) + use, reference

    return dict(sorted(described.items(), key=place))


def output_group(name: str) -> str:
    """Return the group of an output."""
    first, _, rest = name.partition(".")
    if rest == "twist":
        return "stress"
    if first in OUTPUT_GROUPS:
        return first
    if rest.startswith("swivel."):
        return "swivels"
    return "ends"


class VariableArray(NamedTuple):
    """Consecutive scalars; without an array ``length`` is 1 and ``name`` the variable's own."""

    reference: int
    name: str
    variable: Variable
    starts: tuple[Value | None, ...]

    @property
    def length(self) -> int:
        """Number of elements."""
        return len(self.starts)


def arrays(described: Mapping[int, Variable]) -> list[VariableArray]:
    """Gather ``shape.x[1]``, ``shape.x[2]`` ... to ``shape.x``, with the first value reference.

    Parameters stay scalars: importers without arrays read them all, but only the requested outputs.
    """
    gathered: list[VariableArray] = []
    for reference, variable in described.items():
        match = variable.causality == "output" and re.fullmatch(r"(.+)\[(\d+)\]", variable.name)
        if match and match[2] != "1":
            gathered[-1] = gathered[-1]._replace(starts=(*gathered[-1].starts, variable.start))
        else:
            name = match[1] if match else variable.name
            description = DESCRIPTIONS.get(name, variable.description)
            described_array = variable._replace(description=description)
            gathered.append(VariableArray(reference, name, described_array, (variable.start,)))
    return gathered


def scalars(described: Mapping[int, Variable]) -> list[VariableArray]:
    """Return every element separately, with its own value reference."""
    return [VariableArray(reference, v.name, v, (v.start,)) for reference, v in described.items()]


#: ``arrays`` or ``scalars``
Grouping = Callable[[Mapping[int, Variable]], list[VariableArray]]
