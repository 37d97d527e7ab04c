"""Ropes in files: known data, and the parameter files that balance-rope identify writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, WithJsonSchema

from hoist_demo.files.reading import (
    EMPTY,
    File,
    TomlTable,
    contents,
    flat,
    path_from_file,
    read,
    reading_chain,
)
from hoist_demo.files.registry import group_table, rope_parameters
from hoist_demo.files.values import (
    DERIVED,
    GIVEN,
    VARIED,
    ParameterValue,
    ParameterValues,
    Text,
    read_text,
    value_type,
    values_of,
)
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import NONNEGATIVE, POSITIVE, FileParameter
from rope_model import Datum, KnownRope, rope
from rope_model.catalogue import PROPERTIES, Lay
from rope_model.texts import printable

#: a property that is known may lie outside of the catalogue's range, but not so many times: then
#: its unit is wrong
FAR_OFF = 10.0
#: parameters of a rope that follow from the properties, and those of rope and hoist by the property
#: that decides them
CATALOGUE_PARAMETERS = ("mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ")
FOLLOWING = (*CATALOGUE_PARAMETERS, "length", "diameter")
_FOLLOWING = {
    "mass_per_length": ("rope.mass_per_length", "rope.rhoJ", "hoist.tail_rope_mass"),
    "axial_stiffness": ("rope.Qa",),
    "torque_factor": ("rope.Qb", "rope.Qc"),
    "torsional_stiffness": ("rope.Qd",),
    "bending_stiffness": ("rope.EI",),
}
_DERIVED = ("rope.rhoJ", "hoist.tail_rope_mass")  #: Those that are no property themselves.


def following_statuses(statuses: Mapping[str, str]) -> dict[str, str]:
    """Return the statuses of a rope's parameters, by the statuses of its properties."""
    following: dict[str, str] = {}
    for key, status in statuses.items():
        for name in _FOLLOWING.get(key, ()):
            by_rule = name in _DERIVED and status != VARIED
            following[name] = DERIVED if by_rule else status
    return following


def _read_other(content: Any, info: ValidationInfo) -> KnownFile | None:
    """Return the file that [rope] names by ``from``."""
    if not content:
        return None
    return read(path_from_file(info, read_text(content)), _OtherFile, reading_chain(info))


class CatalogueQuery(TomlTable):
    """Table [rope]: the query to the catalogue."""

    file: Annotated[Any, BeforeValidator(_read_other), WithJsonSchema({"type": "string"})] = Field(
        None, alias="from"
    )
    construction: Text = ""
    diameter: value_type(rope_parameters()["rope.diameter"]) = None  # type: ignore[valid-type]
    length: value_type(rope_parameters()["rope.length"]) = None  # type: ignore[valid-type]
    lay: Lay = "right-hand"


_BOUNDS = dict.fromkeys(PROPERTIES, POSITIVE) | {"torque_factor": NONNEGATIVE}
_PROPERTY_TABLE = [
    FileParameter(name, p.unit, "Real", bounds=_BOUNDS[name], meaning=name)
    for name, p in PROPERTIES.items()
]
Properties = Annotated[
    ParameterValues, flat("Properties", {p.name: (value_type(p), None) for p in _PROPERTY_TABLE})
]


class KnownFile(File):
    """File with known properties of a rope."""

    rope: CatalogueQuery = EMPTY
    known: Properties = EMPTY

    @cached_property
    def ranges(self) -> dict[str, Datum]:
        """Known ranges by property, those of the file that [rope] names included."""
        ranges: dict[str, Datum] = dict(self.rope.file.ranges) if self.rope.file else {}
        for name, entry in self.known.items():
            ranges[name] = Datum(
                low=float(entry.value if entry.low is None else entry.low),
                high=float(entry.value if entry.high is None else entry.high),
                unit=PROPERTIES[name].unit,
                status=entry.status or GIVEN,  # type: ignore[arg-type]
                source=entry.source or printable(self.path.name),
            )
        return ranges

    @cached_property
    def catalogue_arguments(self) -> dict[str, Any]:
        """Arguments for the catalogue, those of the file that [rope] names included."""
        here = values_of({key: entry for key, entry in contents(self.rope) if key != "from"})
        if self.rope.file:
            return {**self.rope.file.catalogue_arguments, **here}
        return here

    @cached_property
    def catalogue_rope(self) -> KnownRope:
        """Rope of the catalogue with these ranges, or of these alone.

        A ValueError lists all that is wrong.
        """
        arguments = {key: entry for key, entry in self.catalogue_arguments.items() if entry != ""}
        needed: list[str] = []
        if "construction" not in arguments:
            needed = [name for name in PROPERTIES if name not in self.ranges]
        if "diameter" not in arguments or needed:
            text = "[rope] construction or diameter is missing: the catalogue needs both"
            if needed:
                text += f", without a construction [known] {', '.join(needed)}"
            raise ValueError(text)
        if "construction" not in arguments:
            return KnownRope("", **arguments, data={name: self.ranges[name] for name in PROPERTIES})
        try:
            whole = rope(**arguments)
        except ValueError as error:
            raise ValueError(f"[rope] {error}") from error
        with Problems() as problems:
            for name, datum in self.ranges.items():
                low = whole.data[name].low / FAR_OFF
                high = FAR_OFF * whole.data[name].high
                if not (low <= datum.low and datum.high <= high):
                    text = f"{datum.high:g}"
                    if datum.low < datum.high:
                        text = f"{datum.low:g} to {text}"
                    problems.append(
                        f"[known] {name} = {text} must be within {low:.3g} and {high:.3g} "
                        f"{datum.unit}, {FAR_OFF:g} times less and more than the catalogue has: "
                        "check its unit"
                    )
        return replace(whole, data={**whole.data, **self.ranges})


class _OtherFile(KnownFile, extra="ignore"):
    """A file that another one names for its rope; it may have more."""


class RopeFile(_OtherFile):
    """Parameter file of a rope, as balance-rope identify writes it."""

    fixed: Annotated[
        ParameterValues,
        flat("Fixed", {group: (group_table(group, value_type), None) for group in ("rope", "air")}),
    ]

    def values(self) -> dict[str, ParameterValue]:
        """Return the values of a rope and of its air with their statuses."""
        following = following_statuses({name: datum.status for name, datum in self.ranges.items()})
        return {
            name: ParameterValue(
                entry.value, entry.status or following.get(name, GIVEN), printable(self.path.name)
            )
            for name, entry in self.fixed.items()
        }


def _values_there(content: Any, info: ValidationInfo) -> dict[str, ParameterValue]:
    return read(path_from_file(info, read_text(content)), RopeFile, reading_chain(info)).values()


#: the type of ``from = "FILE"``: values of a rope's parameter file
RopeValues = Annotated[
    dict[str, ParameterValue],
    BeforeValidator(_values_there),
    WithJsonSchema(
        {"type": "string", "description": "parameter file that balance-rope identify wrote"}
    ),
]
