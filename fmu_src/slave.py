"""The class that pythonfmu loads: every callback handed on to RopeComponent.

The export copies this file into the FMU under a name that carries the build's hash, and the packages it imports
under another, because modules of the same name from two FMUs would be one module in the host's process.  pythonfmu
finds the class by its text, which must read ``class Name(Fmi2Slave):``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from fmu_src.component import RopeComponent, Severity
from fmu_src.interface import preset_with
from fmu_src.model_description import MODEL, Build, model_description
from fmu_src.profile import Profile
from fmu_src.wrapper_library import release_at_exit

_LOGGED: dict[Severity, tuple[Fmi2Status, str]] = {
    "note": (Fmi2Status.ok, "logAll"),
    "warning": (Fmi2Status.warning, "logStatusWarning"),
    "error": (Fmi2Status.error, "logStatusError"),
}


class BalanceRope(Fmi2Slave):  # type: ignore[misc]
    """A balance rope for co-simulation."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(kwargs["resources"])
        release_at_exit(resources.parent / "binaries" / "linux64" / f"{MODEL}.so")
        self.modelName = MODEL
        self.build = json.loads((resources / "build.json").read_text(encoding="utf-8"))
        preset = preset_with(self.build["preset"], self.build["level"], self.build["start"])
        self.component = RopeComponent(preset, resources / "kernels", self._log)

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """The model description from our own table: pythonfmu's has no units and no initial unknowns."""
        build, table = self.build, self.component.table
        tolerance = float(self.component.values["solver.tolerance"])
        facts = Build(build["guid"], build["version"], build["tool"], build["date"], build["stop"], tolerance)
        return model_description(Profile(tuple(build["outputs"])).described(table), facts)

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        self.component.setup(start_time)

    def enter_initialization_mode(self) -> None:
        self.component.enter_initialization()

    def exit_initialization_mode(self) -> None:
        self.component.exit_initialization()

    def do_step(self, current_time: float, step_size: float) -> bool:
        return self.component.do_step(current_time, step_size)

    def get_real(self, vrs: list[int]) -> list[float]:
        return self.component.get(vrs, "Real")

    def get_integer(self, vrs: list[int]) -> list[int]:
        return self.component.get(vrs, "Integer")

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return self.component.get(vrs, "Boolean")

    def get_string(self, vrs: list[int]) -> list[str]:
        return self.component.get(vrs, "String")

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self.component.set(vrs, values, "Real")

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self.component.set(vrs, values, "Integer")

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        self.component.set(vrs, values, "Boolean")

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        self.component.set(vrs, values, "String")

    def _get_fmu_state(self) -> dict[str, Any]:
        return self.component.get_state()

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self.component.set_state(state)

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return RopeComponent.state_to_bytes(state)

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        return RopeComponent.state_from_bytes(state)

    def _log(self, message: str, severity: Severity) -> None:
        self.log(message, *_LOGGED[severity])
