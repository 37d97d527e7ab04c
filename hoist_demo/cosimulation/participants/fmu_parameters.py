"""What an FMU lets a host choose and read: parameters with unit, type and bounds, and outputs, without loading it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import fmpy
from fmpy.model_description import ValidationError

from hoist_demo.recording.rungs import RUNG


@dataclass(frozen=True)
class FmuParameter:
    """One parameter as the model description states it."""

    name: str
    unit: str  # FMI unit, "1" where there is none
    kind: str  # Real, Integer, Boolean, String or Enumeration
    start: float | int | bool | str
    minimum: float | None
    maximum: float | None


def read_parameters(path: Path) -> dict[str, FmuParameter]:
    """All parameters of the FMU by name."""
    return parameters_of(read_description(path))


def parameters_of(description: Any) -> dict[str, FmuParameter]:
    """All parameters of a model description by name."""
    return {
        variable.name: FmuParameter(
            name=variable.name,
            unit=str(variable.unit or "1"),
            kind=variable.type,
            start=_start(variable.type, variable.start),
            minimum=None if variable.min is None else float(variable.min),
            maximum=None if variable.max is None else float(variable.max),
        )
        for variable in description.modelVariables
        if variable.causality == "parameter"
    }


def read_outputs(path: Path) -> tuple[str, ...]:
    """Names of all outputs of the FMU that are numbers, and of the rung, which is recorded by its code."""
    outputs = [v for v in read_description(path).modelVariables if v.causality == "output"]
    return tuple(v.name for v in outputs if v.type != "String" or v.name == RUNG)


def read_description(path: Path) -> Any:
    """FMPy's model description of an FMU that this host can drive: FMI 2.0, co-simulation."""
    if not path.is_file():
        raise ValueError(f"FMU '{path}' is missing: export it with `balance-rope export --out {path}`")
    try:
        with ZipFile(path) as archive:
            if "modelDescription.xml" not in archive.namelist():
                system = "SystemStructure.ssd" in archive.namelist()
                what = "a system of FMUs (SSP)" if system else "an archive without modelDescription.xml"
                raise ValueError(f"'{path}' must be an FMU, it is {what}: give the rope's .fmu")
        description = fmpy.read_model_description(str(path))
    except (ValidationError, BadZipFile) as error:
        raise ValueError(f"FMU '{path}' must be a valid FMU, but: {error}: export it anew") from error
    if description.coSimulation is None or description.fmiVersion != "2.0":
        kind = "co-simulation" if description.coSimulation is not None else "no co-simulation"
        raise ValueError(
            f"FMU '{path}' is of FMI {description.fmiVersion}, {kind}; this host drives FMI 2.0 co-simulation: "
            "give the FMU of `balance-rope export` or `balance-rope export --native`, or run with --in-process"
        )
    return description


def _start(kind: str, text: str) -> float | int | bool | str:
    if kind == "Real":
        return float(text)
    if kind in ("Integer", "Enumeration"):
        return int(text)
    return text in ("true", "1") if kind == "Boolean" else text
