"""Description of an FMU, read without loading it: parameters with unit, type and bounds, and outputs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile, ZipFile

import fmpy
from fmpy.model_description import ValidationError

from hoist_demo.cosimulation.participants.fmi_versions import VERSIONS, Variable, variables_of
from hoist_demo.cosimulation.participants.rope_data import Value
from hoist_demo.recording.fidelity import FIDELITY


@dataclass(frozen=True)
class FmuParameter:
    """One parameter as the model description states it."""

    name: str
    unit: str  # FMI unit, "1" where there is none
    kind: str  # Real, Integer, Boolean, String or Enumeration
    start: Value
    minimum: float | None
    maximum: float | None


def read_parameters(path: Path) -> dict[str, FmuParameter]:
    """All parameters of the FMU by name."""
    return parameters_of(read_fmu(path).variables)


def parameters_of(variables: Iterable[Variable]) -> dict[str, FmuParameter]:
    """All parameters among the variables by name, each element of an array on its own."""
    return {
        name: FmuParameter(name, v.unit or "1", v.kind, start, v.minimum, v.maximum)
        for v in variables
        if v.causality == "parameter"
        for name, start in zip(v.elements, v.starts, strict=True)
    }


def read_outputs(path: Path) -> tuple[str, ...]:
    """Names of all outputs of the FMU that are numbers, and of the fidelity, which is recorded by its code."""
    outputs = [v for v in read_fmu(path).variables if v.causality == "output"]
    return tuple(name for v in outputs if v.kind != "String" or v.name == FIDELITY for name in v.elements)


def fmi_version(path: Path) -> str:
    """The version of FMI that the FMU is of."""
    return str(read_fmu(path).description.fmiVersion)


class Fmu(NamedTuple):
    """Contents of an FMU's description."""

    description: Any  # FMPy's
    variables: tuple[Variable, ...]


def read_fmu(path: Path) -> Fmu:
    """Model description of an FMU that this host can drive."""
    if not path.is_file():
        raise ValueError(f"FMU '{path}' is missing: export it with `balance-rope export --out {path}`")
    return _read(*version_of(path))


def version_of(path: Path) -> tuple[Path, int, int]:
    """A file as it is now: its place, when it was changed last [ns], and its number of bytes."""
    seen = path.stat()
    return path.resolve(), seen.st_mtime_ns, seen.st_size


@lru_cache(maxsize=8)  # a study reads the same file for every run
def _read(path: Path, changed: int, size: int) -> Fmu:
    """Read a file in one version."""
    try:
        with ZipFile(path) as archive:
            if "modelDescription.xml" not in archive.namelist():
                system = "SystemStructure.ssd" in archive.namelist()
                what = "a system of FMUs (SSP)" if system else "an archive without modelDescription.xml"
                raise ValueError(f"'{path}' must be an FMU, it is {what}: give the rope's .fmu")
        description = fmpy.read_model_description(str(path))
    except (ValidationError, BadZipFile) as error:
        raise ValueError(f"FMU '{path}' must be a valid FMU, but: {error}: export it anew") from error
    if description.coSimulation is None or description.fmiVersion not in VERSIONS:
        kind = "co-simulation" if description.coSimulation is not None else "no co-simulation"
        raise ValueError(
            f"FMU '{path}' is of FMI {description.fmiVersion}, {kind}; this host drives co-simulation of FMI "
            f"{' and '.join(VERSIONS)}: give the FMU of `balance-rope export`, or run with --in-process"
        )
    return Fmu(description, variables_of(description))
