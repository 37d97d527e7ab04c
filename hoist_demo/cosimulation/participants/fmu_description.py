"""Description of an FMU, read without loading it: its files, variables, units, types and bounds.

FMI 3.0 has arrays, and a type for each width of a number. Here a variable has the type that FMI 2.0
would give it, and an array's elements have their names of FMI 2.0: shape.x[1] ...
"""

import atexit
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile, ZipFile

import fmpy
from fmpy.model_description import ScalarVariable, ValidationError

from hoist_demo.parameters.quantity import FileParameter, NumberRange, Value, fmi_unit
from hoist_demo.recording.fidelity import FIDELITY
from rope_model.scene_names import choices_of

#: Versions of FMI that the host drives, as model descriptions state them.
FMI_VERSIONS = ("2.0", "3.0")
NUMBERS = ("Real", "Integer", "Enumeration", "Boolean")
#: Types whose values are doubles in C, in FMI 2.0 and 3.0.
DOUBLES = ("Real", "Float64")
_KINDS = {"Enumeration": "Integer"}
#: Folders that no instance reads.
_NOT_TO_RUN = ("sources/", "documentation/", "terminalsAndIcons/")


@dataclass(frozen=True, eq=False)
class DescribedVariable:
    """A variable as the model description states it; an array is one variable."""

    name: str
    reference: int
    causality: str
    type: str  # name in its version of FMI
    kind: str  # Real, Integer, Enumeration, Boolean, String, or another that no rope has
    unit: str  # FMI's spelling, "" for none
    elements: tuple[str, ...]  # names of an array's elements; else its own name
    starts: tuple[Value, ...]  # start of each element, or none
    minimum: float | None
    maximum: float | None
    items: Mapping[str, int]  # codes of an enumeration's items


def _variable(declaration: ScalarVariable) -> DescribedVariable:
    """Return a variable of FMPy's model description."""
    kind = _kind(declaration.type)
    declared = declaration.declaredType
    unit = declaration.unit
    if not unit and declared is not None:
        unit = declared.unit
    items: dict[str, int] = {}
    low = declaration.min
    high = declaration.max
    if kind == "Enumeration":
        items = {item.name: int(item.value) for item in declared.items}
    if items:
        low = min(items.values())
        high = max(items.values())
    return DescribedVariable(
        name=declaration.name,
        reference=int(declaration.valueReference),
        causality=declaration.causality,
        type=declaration.type,
        kind=kind,
        unit=str(unit or ""),
        elements=tuple(declaration.name + index for index in _indices(declaration.shape)),
        starts=tuple(_value(kind, text) for text in _start_texts(declaration)),
        minimum=None if low is None else float(low),
        maximum=None if high is None else float(high),
        items=items,
    )


def _indices(shape: Sequence[int]) -> list[str]:
    """Return the index of each element of an array as its name has it; "" for a scalar."""
    if not shape:
        return [""]
    ranges = [range(1, length + 1) for length in shape]
    return [f"[{','.join(map(str, index))}]" for index in product(*ranges)]


def _start_texts(declaration: ScalarVariable) -> tuple[str, ...]:
    """Return the start values of a variable, one for each element, as texts."""
    if declaration.start is None:
        return ()
    if declaration.shape:
        return tuple(declaration.start.split())
    return (declaration.start,)


def _kind(declared: str) -> str:
    """Return FMI 2.0's word for a type of either version."""
    if declared.startswith("Float"):
        return "Real"
    if declared.startswith(("Int", "UInt")):
        return "Integer"
    return declared


def _value(kind: str, text: str) -> Value:
    if kind == "Real":
        return float(text)
    if kind in ("Integer", "Enumeration"):
        return int(text)
    if kind == "Boolean":
        return text in ("true", "1")
    return text


class FileVersion(NamedTuple):
    """A file in one version, as a key of what is kept of it."""

    path: Path
    changed: int  # ns, when it was changed last
    size: int  # bytes


@lru_cache(maxsize=8)
def unpacked(fmu: FileVersion) -> Path:
    """Return a folder with the files of an FMU, for this process and until it ends."""
    path = str(fmu.path)
    directory = Path(fmpy.extract(path, include=lambda file: not file.startswith(_NOT_TO_RUN)))
    atexit.register(shutil.rmtree, directory, ignore_errors=True)
    return directory


def read_parameters(path: Path) -> dict[str, FileParameter]:
    """Return the parameters of an FMU by name."""
    return read_fmu(path).parameters


def read_outputs(path: Path, hoist: str = "") -> tuple[str, ...]:
    """Names of all outputs that are numbers, and of the fidelity, which is recorded by its code."""
    return tuple(read_fmu(path, hoist).outputs)


@dataclass(frozen=True)
class Fmu:
    """Contents of an FMU's description."""

    description: Any  # FMPy's
    variables: tuple[DescribedVariable, ...]

    @cached_property
    def by_name(self) -> dict[str, DescribedVariable]:
        """Variable of each name; the names of an array's elements have the array."""
        by_name: dict[str, DescribedVariable] = {}
        for variable in self.variables:
            by_name |= dict.fromkeys(variable.elements, variable)
        return by_name

    @cached_property
    def parameters(self) -> dict[str, FileParameter]:
        """Parameters by name, each element of an array on its own."""
        parameters: dict[str, FileParameter] = {}
        for variable in self.variables:
            if variable.causality == "parameter":
                starts = zip(variable.elements, variable.starts, strict=True)
                parameters |= {name: _parameter(name, variable, start) for name, start in starts}
        return parameters

    @cached_property
    def outputs(self) -> dict[str, str]:
        """Unit of each output that is a number, and of the fidelity, recorded by its code."""
        units: dict[str, str] = {}
        for name, variable in self.by_name.items():
            if variable.causality != "output":
                continue
            if name == FIDELITY:
                units[name] = "1"
            elif variable.kind in NUMBERS:
                units[name] = variable.unit
        return units


def _parameter(name: str, variable: DescribedVariable, start: Value) -> FileParameter:
    """Return one element of a variable as a parameter."""
    return FileParameter(
        name,
        fmi_unit(variable.unit),
        _KINDS.get(variable.kind, variable.kind),
        start,
        NumberRange(variable.minimum, variable.maximum),
        choices_of(name),
    )


def read_fmu(path: Path, hoist: str = "") -> Fmu:
    """Model description of an FMU that this host can drive; ``hoist`` is that of its rope."""
    if not path.is_file():
        argument = f"{hoist} " if hoist else ""
        command = f"balance-rope export {argument}--native --platform host --out {path}"
        raise ValueError(
            f"FMU '{path}' is missing: `{command}` makes it, with a C compiler; "
            "without --native --platform host it needs none, and its rope is slower"
        )
    return _read(version_of(path))


def version_of(path: Path) -> FileVersion:
    """Return a file as it is now."""
    status = path.stat()
    return FileVersion(path.resolve(), status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)  # a study reads the same file for every run
def _read(file: FileVersion) -> Fmu:
    path = file.path
    try:
        with ZipFile(path) as archive:
            members = archive.namelist()
        if "modelDescription.xml" not in members:
            kind = "an archive without modelDescription.xml"
            if "SystemStructure.ssd" in members:
                kind = "a system of FMUs (SSP)"
            raise ValueError(f"'{path}' must be an FMU, it is {kind}: give the rope's .fmu")
        description = fmpy.read_model_description(str(path))
    except (ValidationError, BadZipFile) as error:
        raise ValueError(
            f"FMU '{path}' must be a valid FMU, but: {error}: export it anew"
        ) from error
    if description.coSimulation is None or description.fmiVersion not in FMI_VERSIONS:
        if description.coSimulation is not None:
            kind = "co-simulation"
        else:
            kind = "no co-simulation"
        versions = " and ".join(FMI_VERSIONS)
        raise ValueError(
            f"FMU '{path}' is of FMI {description.fmiVersion}, {kind}; "
            f"this host drives co-simulation of FMI {versions}: "
            "give the FMU of `balance-rope export`, or run with --in-process"
        )
    return Fmu(description, tuple(map(_variable, description.modelVariables)))
