"""The balance rope as an FMU for co-simulation.

Nothing is known of the FMU's inside: variables are found by name in its model description. fmi_versions has the calls
of FMI 2.0 and 3.0. The host computes
t = start + k H; doStep(t, H) is given the end motions of t + H (parameter `inputs_at_step_end` = true).
"""

import hashlib
import logging
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.fmi_versions import (
    VERSIONS,
    WARNING,
    Buffer,
    CallError,
    Instance,
)
from hoist_demo.cosimulation.participants.fmu_description import (
    NUMBERS,
    Variable,
    read_fmu,
    unpacked,
    version_of,
)
from hoist_demo.cosimulation.participants.library_calls import (
    TEXT,
    OutputTable,
    RopeLibrary,
    codes_of,
)
from hoist_demo.cosimulation.participants.rope_data import RopeData, stamp, unstamp
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES, ENDS, ROPE_FORCES, Reader
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.fidelity import FIDELITY
from rope_model import EndMotion, Status

_log = logging.getLogger(__name__)
INPUTS = tuple(field.name for field in fields(EndMotion))  #: Names of an end's inputs.
_VALID = Status(True)


class FmuRope:
    """A RopePlant that lives in an .fmu file."""

    def __init__(
        self,
        path: Path,
        parameters: Mapping[str, Value] | None = None,
        recorded: Collection[str] | None = None,
    ) -> None:
        """Load the FMU and set its parameters; `recorded` outputs are read, by default all but the added masses."""
        self._started = False
        self._warned: set[str] = set()  # warnings that were logged
        self._errors: list[str] = []  # the FMU's messages about the call that fails
        self._path = Path(path)
        fmu = read_fmu(self._path)
        self._description, self._described, self._variables = (
            fmu.description,
            fmu.parameters,
            fmu.named,
        )
        inputs = [self._variable(f"{end}.{name}") for end in ENDS for name in INPUTS]
        if missing := [name for name in ROPE_FORCES if name not in fmu.shown]:
            raise ValueError(
                f"FMU '{path}' must have the outputs {', '.join(missing)}: export it anew"
            )
        wanted = fmu.shown.keys() - {*ADDED_MASSES} if recorded is None else recorded
        self._units = {name: unit for name, unit in fmu.shown.items() if name in wanted}
        self._chosen: dict[str, Value] = {"inputs_at_step_end": True, **(parameters or {})}
        try:
            self._fmu: Instance = VERSIONS[self._description.fmiVersion](
                unpacked(*version_of(self._path)), self._description, self._hear
            )
        except RuntimeError as error:
            raise ValueError(
                f"the FMU must instantiate, but: {self._explanation(error)}: export it anew"
            ) from error
        self._motions = self._fmu.buffer("Set", inputs)
        valid = self._variables.get("status.valid")
        self._valid = self._fmu.buffer("Get", [valid]) if valid is not None else None
        try:
            for variable in dict.fromkeys(self._variable(name) for name in self._chosen):
                self._set(variable)
        except BaseException:
            self.close()
            raise

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        """Set-up, initialization mode with the ends' start motion, and the first status."""
        try:
            self._fmu.enter_initialization(t0)
            self._set_motions(left, right)
            self._fmu.fmpy.exitInitializationMode()
            self._started = True
            return self._status()
        except CallError as error:
            return self._failure_status(error)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Step from t to t + h with the ends' motions of t + h."""
        try:
            self._set_motions(left, right)
            self._fmu.step(t, h)
            return self._status()
        except CallError as error:
            return self._failure_status(error)

    def reader(self, names: Sequence[str]) -> Reader:
        """A function that reads some outputs, and the fidelity by its code; arrays are read whole."""
        buffers, values = self._outputs(names, 1)

        def read() -> NDArray[np.float64]:
            with self._translate_failures():
                for buffer in buffers:
                    buffer.call()
            return np.asarray(values(1)[0])

        return read

    def library(self) -> RopeLibrary:
        """Return the FMU's functions for trip.c."""
        valid = None if self._valid is None else self._valid.access
        return RopeLibrary(
            self._fmu.stepping, self._motions.access, self._table, self._status_of, valid
        )

    def _table(self, names: Sequence[str], rows: int) -> OutputTable:
        buffers, values = self._outputs(names, rows)
        return OutputTable([buffer.access for buffer in buffers], values)

    def _outputs(
        self, names: Sequence[str], rows: int
    ) -> tuple[list[Buffer], Callable[[int], NDArray[np.float64]]]:
        """Buffers of outputs by type, and a function that puts their first rows in the order of the names."""
        variables = dict.fromkeys(
            self._variables[name] for name in names if name in self._variables
        )
        readable = [v for v in variables if v.kind in NUMBERS or v.name == FIDELITY]
        parts = []
        for type_ in dict.fromkeys(v.type for v in readable):
            buffer = self._fmu.buffer("Get", [v for v in readable if v.type == type_], rows)
            index = {name: k for k, name in enumerate(buffer.names)}
            there, here = np.array(
                [(index[name], k) for k, name in enumerate(names) if name in index]
            ).T
            parts.append((buffer, there, here))

        def values(count: int) -> NDArray[np.float64]:
            table = np.full((count, len(names)), np.nan)
            for buffer, there, here in parts:
                part = buffer.values[:count, there]
                table[:, here] = codes_of(part) if part.dtype == TEXT else part
            return table

        return [buffer for buffer, _, _ in parts], values

    def _status_of(self, call: str, status: int) -> Status:
        """Return the status of a step that has failed in one of its calls, which C has made."""
        names = {"MOTIONS": f"Set{self._variable(f'{ENDS[0]}.{INPUTS[0]}').type}", "STEP": "DoStep"}
        if call in names:
            return self._failure_status(CallError(self._fmu.name_in_c(names[call]), status))
        try:
            return self._status()
        except CallError as error:
            return self._failure_status(error)

    def data(self) -> RopeData:
        """Identity of the rope: its file, and all parameters with their values."""
        description = self._description
        model = {
            "FMU": self._path.name,
            "SHA-256": _digest(*version_of(self._path)),
            "model and version": f"{description.modelName} {description.version or ''}".strip(),
            "exported by": str(description.generationTool or "not said"),
            "FMI version": str(description.fmiVersion),
        }
        units = {name: parameter.unit for name, parameter in self._described.items()}
        reason = ""
        with suppress(CallError):  # a failed FMU need not answer
            reason = self._text("status.fidelity_reason")
        return RopeData(model, self._parameters(), units, reason)

    def save(self) -> Any:
        """A handle of the FMU's state; None when it cannot save."""
        if not self._description.coSimulation.canGetAndSetFMUstate:
            return None
        with self._translate_failures():
            return self._fmu.save()

    def restore(self, snapshot: Any) -> None:
        with self._translate_failures():
            self._fmu.restore(snapshot)

    def to_bytes(self, snapshot: Any) -> bytes:
        with self._translate_failures():
            return self._tag + stamp(self._fmu.to_bytes(snapshot), self._parameters())

    def from_bytes(self, data: bytes) -> Any:
        if not data.startswith(self._tag):
            raise ValueError(
                f"the state must be one of '{self._path.name}', {self._tag.decode().strip()}; it is of another rope: "
                "go on with the one that wrote it (--fmu FILE or --in-process)"
            )
        data = unstamp(data.removeprefix(self._tag), self._parameters())
        try:
            return self._fmu.from_bytes(data)
        except CallError as error:
            raise ValueError(
                f"the FMU must know these {len(data)} bytes as a state of its own, but: {self._explanation(error)}"
            ) from error

    def units(self) -> dict[str, str]:
        """Unit of each signal of the record, as the model description states it."""
        return dict(self._units)

    def close(self) -> None:
        """Terminate and free the instance; the extracted files serve the next one of this process."""
        if self._started:
            with suppress(CallError):
                self._fmu.fmpy.terminate()
        self._started = False
        self._fmu.close()

    def _parameters(self) -> dict[str, Value]:
        """Return all parameters by name with the values in use."""
        return {name: self._chosen.get(name, p.start) for name, p in self._described.items()}

    def _variable(self, name: str) -> Variable:
        if name not in self._variables:
            raise ValueError(f"the FMU must have a variable '{name}': export it anew")
        return self._variables[name]

    def _set(self, variable: Variable) -> None:
        """Set a parameter, of an array all elements, to what is chosen, by its FMI type."""
        chosen = [
            self._chosen[n] if n in self._chosen else self._described[n].start
            for n in variable.elements
        ]
        values = [_typed(variable, value) for value in chosen]
        try:
            self._fmu.set(variable, values)
        except CallError as error:
            raise ValueError(
                f"the FMU must take {variable.name}, but: {self._explanation(error)}"
            ) from error

    def _set_motions(self, left: EndMotion, right: EndMotion) -> None:
        self._motions.values[0] = *vars(left).values(), *vars(right).values()
        self._motions.call()

    def _status(self) -> Status:
        """Return the status by `status.valid` and `status.message`; an FMU without them is valid."""
        if self._valid is None:
            return _VALID
        self._valid.call()
        return _VALID if self._valid.values[0, 0] else Status(False, self._text("status.message"))

    def _text(self, name: str) -> str:
        """Return a String output; "" if the FMU lacks it."""
        return self._fmu.text(self._variables[name])() if name in self._variables else ""

    @property
    def _tag(self) -> bytes:
        """Return the head of a serialized state, which keeps states of two flavours apart."""
        return f"{self._description.modelName} by {self._description.generationTool}\n".encode()

    def _failure_status(self, error: CallError) -> Status:
        """Return the status of a failed call, in the FMU's own words if it still speaks."""
        self._started = False
        message = ""
        with suppress(CallError):
            message = self._text("status.message")
        return Status(False, message or self._explanation(error))

    @contextmanager
    def _translate_failures(self) -> Iterator[None]:
        """Raise a failed call as RuntimeError, so that nobody else needs FMPy."""
        try:
            yield
        except CallError as error:
            raise RuntimeError(f"the FMU fails: {self._explanation(error)}") from error

    def _explanation(self, error: Exception) -> str:
        """Return the cause of a failed call, with the FMU's messages."""
        messages = "; ".join(dict.fromkeys(self._errors))
        self._errors = []
        return f"{error} {messages}" if messages else str(error)

    def _hear(self, status: int, text: str) -> None:
        """Log the FMU's warnings, each once; keep its errors for the call that fails."""
        if status > WARNING:
            self._errors.append(text)
        if status != WARNING:
            _log.debug("%s", text)
        elif text not in self._warned:
            self._warned.add(text)
            _log.warning("%s", text)


@lru_cache(maxsize=8)  # a study winds with the same file in every run
def _digest(path: Path, changed: int, size: int) -> str:
    """SHA-256 of a file in one version."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _typed(v: Variable, value: Value) -> Value:
    """Convert a value to the variable's FMI type, an enumeration's item to its number."""
    if v.kind == "Enumeration" and isinstance(value, str):
        if value not in v.items:
            raise ValueError(
                f"parameter {v.name} = '{value}' must be one of {', '.join(v.items)}: choose one"
            )
        return v.items[value]
    types: Mapping[str, type[Value]] = {"Real": float, "Boolean": bool, "String": str}
    return types.get(v.kind, int)(value)
