"""Variables as FMI 3.0 shows them: arrays gathered, or each element a scalar."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from fmu_src.interface import Variable
from rope_model.scene_names import Value

#: descriptions of the arrays as a whole
DESCRIPTIONS = {
    "mesh.counts": "numbers of elements of the segments II to VI, kind 0",
    **{f"shape.{axis}": f"{axis.upper()} of points along the rope, denser around the loop" for axis in "xyz"},
    "shape.s": "places of these points along the rope, from its left end",
    "shape.tension": "tension at these points",
    "shape.bending": "nominal bending stress at these points",
    "shape.torsion": "nominal torsional stress at these points",
    "station.tension": "tension at places that stay in the rope",
    "station.curvature": "curvature at these places, RMS along an element",
    "station.torque": "torque about the tangent at these places",
}


class Array(NamedTuple):
    """Consecutive scalars; ``length`` is 1, and ``name`` the variable's own, where there is no array."""

    reference: int
    name: str
    variable: Variable
    starts: tuple[Value | None, ...]

    @property
    def length(self) -> int:
        """Number of elements."""
        return len(self.starts)


def arrays(described: Mapping[int, Variable]) -> list[Array]:
    """``shape.x[1]``, ``shape.x[2]`` ... become ``shape.x`` with the first one's value reference."""
    found: list[Array] = []
    for reference, variable in described.items():
        match = re.fullmatch(r"(.+)\[(\d+)\]", variable.name)
        if match and match[2] != "1":
            found[-1] = found[-1]._replace(starts=(*found[-1].starts, variable.start))
        else:
            name = match[1] if match else variable.name
            whole = variable._replace(description=DESCRIPTIONS.get(name, variable.description))
            found.append(Array(reference, name, whole, (variable.start,)))
    return found


def scalars(described: Mapping[int, Variable]) -> list[Array]:
    """Every element on its own, with its own value reference."""
    return [Array(reference, v.name, v, (v.start,)) for reference, v in described.items()]


#: how described variables are shown: ``arrays`` or ``scalars``
Form = Callable[[Mapping[int, Variable]], list[Array]]
