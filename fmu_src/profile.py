"""Presentation of an FMU: its described outputs, arrays or scalars, the length of its default run.

The code inside is the same for all profiles, as are the value references: outputs that are not described are not
asked for, and so not computed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fmu_src.interface import Variable

#: group of outputs -> its contents
GROUPS = {
    "ends": "forces and moments on the conveyances, mean vertical forces, added masses; `contact.*` and `audit.*`",
    "swivels": "angle, rate and torque of the swivels, and whether they slip",
    "loop": "place, yaw and clearance of the loop, turns of the legs about each other",
    "stress": "largest nominal stresses; twist at the ends and in the loop",
    "energy": "energies; works and dissipation since the start; the energy balance",
    "count": "time steps, iterations, transformations, swivel events",
    "shape": "points along the rope, with tension and stresses there: 567 numbers",
    "station": "tension, curvature and torque at places that stay in the rope: 243 numbers",
    "clearance": "distances of the rope from the bodies in its shaft",
    "nearest": "the smallest of these so far, when and where",
    "guard": "whether a guard of the loop has tripped, which one and when",
    "status": "whether results are valid, messages, the fidelity of the model",
}
#: groups that every FMU describes
ALWAYS = ("ends", "status")
#: groups that an FMU describes by default
DEFAULT = tuple(group for group in GROUPS if group not in ("shape", "station"))
ALL = tuple(GROUPS)


@dataclass(frozen=True)
class Profile:
    """Choices of an export that change no result."""

    outputs: tuple[str, ...] = DEFAULT  # names of GROUPS; ALWAYS are added
    arrays: bool = True  # of FMI 3.0; without, each element is a scalar variable
    stop: float = 30.0  # s, of the default experiment

    def __post_init__(self) -> None:
        if unknown := sorted(set(self.outputs) - set(GROUPS)):
            raise ValueError(f"there is no group of outputs {', '.join(unknown)}; choose of {', '.join(GROUPS)}")
        if not (math.isfinite(self.stop) and self.stop > 0.0):
            raise ValueError(f"stop = {self.stop!r} s is out of range: it must be above 0; give the run's length")

    def select(self, table: Sequence[Variable]) -> dict[int, Variable]:
        """The variables that the description shows, by value reference."""
        shown = {*self.outputs, *ALWAYS}
        return {i: v for i, v in enumerate(table) if v.causality != "output" or group_of(v.name) in shown}


FULL = Profile(ALL)


def group_of(name: str) -> str:
    """The group of an output."""
    first, _, rest = name.partition(".")
    if rest == "twist":
        return "stress"
    if first in GROUPS:
        return first
    return "swivels" if rest.startswith("swivel.") else "ends"
