"""Description of an FMU, read without loading it: variables with unit, type and bounds, and its files.

FMI 3.0 has arrays, and a type for each width of a number. Here a variable has the type that FMI 2.0 would give it, and
an array's elements have their names of FMI 2.0: shape.x[1] ...
"""

import atexit
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import fmpy
from fmpy.model_description import ValidationError

from hoist_demo.parameters.quantity import Bounds, Parameter, Value, fmi_unit
from hoist_demo.recording.fidelity import FIDELITY
from rope_model.scene_names import choices_of

FMI_VERSIONS = (
    "2.0",
    "3.0",
)  #: Versions of FMI that the host drives, as model descriptions state them.
NUMBERS = ("Real", "Integer", "Enumeration", "Boolean")
_KINDS = {"Enumeration": "Integer"}
_NOT_TO_RUN = (
    "sources/",
    "documentation/",
    "terminalsAndIcons/",
)  #: Folders that no instance reads.


@dataclass(frozen=True, eq=False)
class Variable:
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


def _variable(stated: Any) -> Variable:
    """Return a variable of FMPy's model description."""
    kind = _kind(stated.type)
    declared = stated.declaredType
    ranges = [range(1, length + 1) for length in stated.shape]
    indices = [f"[{','.join(map(str, index))}]" for index in product(*ranges)] if ranges else [""]
    texts = () if stated.start is None else stated.start.split() if ranges else (stated.start,)
    items = {item.name: int(item.value) for item in declared.items} if kind == "Enumeration" else {}
    low, high = (min(items.values()), max(items.values())) if items else (stated.min, stated.max)
    return Variable(
        name=stated.name,
        reference=int(stated.valueReference),
        causality=stated.causality,
        type=stated.type,
        kind=kind,
        unit=str(stated.unit or (declared.unit if declared is not None else None) or ""),
        elements=tuple(stated.name + index for index in indices),
        starts=tuple(_value(kind, text) for text in texts),
        minimum=None if low is None else float(low),
        maximum=None if high is None else float(high),
        items=items,
    )


def _kind(declared: str) -> str:
    """Return FMI 2.0's word for a type of either version."""
    if declared.startswith("Float"):
        return "Real"
    return "Integer" if declared.startswith(("Int", "UInt")) else declared


def _value(kind: str, text: str) -> Value:
    if kind == "Real":
        return float(text)
    if kind in ("Integer", "Enumeration"):
        return int(text)
    return text in ("true", "1") if kind == "Boolean" else text


@lru_cache(maxsize=8)
def unpacked(path: Path, changed: int, size: int) -> Path:
    """Folder with the files of an FMU that was changed last at that time [ns], for this process and until it ends."""
    directory = Path(fmpy.extract(str(path), include=lambda file: not file.startswith(_NOT_TO_RUN)))
    atexit.register(shutil.rmtree, directory, ignore_errors=True)
    return directory


def read_parameters(path: Path) -> dict[str, Parameter]:
    """Return the parameters of an FMU by name."""
    return read_fmu(path).parameters


def read_outputs(path: Path, hoist: str = "") -> tuple[str, ...]:
    """Names of all outputs of the FMU that are numbers, and of the fidelity, which is recorded by its code."""
    return tuple(read_fmu(path, hoist).shown)


@dataclass(frozen=True)
class Fmu:
    """Contents of an FMU's description."""

    description: Any  # FMPy's
    variables: tuple[Variable, ...]

    @cached_property
    def named(self) -> dict[str, Variable]:
        """Variable of each name; an array has one for each of its elements."""
        return {name: v for v in self.variables for name in v.elements}

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """Parameters by name, each element of an array on its own."""
        return {
            name: Parameter(
                name,
                fmi_unit(v.unit),
                _KINDS.get(v.kind, v.kind),
                start,
                Bounds(v.minimum, v.maximum),
                choices_of(name),
            )
            for v in self.variables
            if v.causality == "parameter"
            for name, start in zip(v.elements, v.starts, strict=True)
        }

    @cached_property
    def shown(self) -> dict[str, str]:
        """Unit of each output that is a number, and of the fidelity, which is recorded by its code."""
        outputs = ((name, v) for name, v in self.named.items() if v.causality == "output")
        shown = ((name, v) for name, v in outputs if v.kind in NUMBERS or name == FIDELITY)
        return {name: "1" if name == FIDELITY else v.unit for name, v in shown}


def read_fmu(path: Path, hoist: str = "") -> Fmu:
    """Model description of an FMU that this host can drive; `hoist` is that of its rope."""
    if not path.is_file():
        named = f"{hoist} " if hoist else ""
        command = f"balance-rope export {named}--native --platform host --out {path}"
        raise ValueError(
            f"FMU '{path}' is missing: `{command}` makes it, with a C compiler; without --native --platform host it "
            "needs none, and its rope is slower"
        )
    return _read(*version_of(path))


def version_of(path: Path) -> tuple[Path, int, int]:
    """A file as it is now: its place, when it was changed last [ns], and its number of bytes."""
    seen = path.stat()
    return path.resolve(), seen.st_mtime_ns, seen.st_size


@lru_cache(maxsize=8)  # a study reads the same file for every run
def _read(path: Path, changed: int, size: int) -> Fmu:
    try:
        with ZipFile(path) as archive:
            if "modelDescription.xml" not in archive.namelist():
                system = "SystemStructure.ssd" in archive.namelist()
                what = (
                    "a system of FMUs (SSP)"
                    if system
                    else "an archive without modelDescription.xml"
                )
                raise ValueError(f"'{path}' must be an FMU, it is {what}: give the rope's .fmu")
        description = fmpy.read_model_description(str(path))
    except (ValidationError, BadZipFile) as error:
        raise ValueError(
            f"FMU '{path}' must be a valid FMU, but: {error}: export it anew"
        ) from error
    if description.coSimulation is None or description.fmiVersion not in FMI_VERSIONS:
        kind = "co-simulation" if description.coSimulation is not None else "no co-simulation"
        raise ValueError(
            f"FMU '{path}' is of FMI {description.fmiVersion}, {kind}; this host drives co-simulation of FMI "
            f"{' and '.join(FMI_VERSIONS)}: give the FMU of `balance-rope export`, or run with --in-process"
        )
    return Fmu(description, tuple(map(_variable, description.modelVariables)))
