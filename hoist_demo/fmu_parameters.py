"""What an FMU lets a host choose and read: parameters with unit, type and bounds, and outputs, without loading it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import fmpy
from fmpy.model_description import ValidationError


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
    return {
        variable.name: FmuParameter(
            name=variable.name,
            unit=str(variable.unit or "1"),
            kind=variable.type,
            start=_start(variable.type, variable.start),
            minimum=None if variable.min is None else float(variable.min),
            maximum=None if variable.max is None else float(variable.max),
        )
        for variable in _description(path).modelVariables
        if variable.causality == "parameter"
    }


def read_outputs(path: Path) -> tuple[str, ...]:
    """Names of all outputs of the FMU."""
    return tuple(v.name for v in _description(path).modelVariables if v.causality == "output")


def _description(path: Path) -> Any:
    if not path.is_file():
        raise ValueError(f"FMU '{path}' is missing: export it with `balance-rope export --out {path}`")
    try:
        return fmpy.read_model_description(str(path))
    except (ValidationError, BadZipFile) as error:
        raise ValueError(f"FMU '{path}' must be a valid FMU, but: {error}: export it anew") from error


def _start(kind: str, text: str) -> float | int | bool | str:
    if kind == "Real":
        return float(text)
    if kind in ("Integer", "Enumeration"):
        return int(text)
    return text in ("true", "1") if kind == "Boolean" else text
