"""The balance rope as an FMU for co-simulation.

The FMU is a black box: variables are found by name in its model description. fmi_versions has the
calls of FMI 2.0 and 3.0. The host computes t = start + k H; doStep(t, H) gets the end motions of t
+ H (parameter ``inputs_at_step_end`` = true).
"""

import hashlib
import logging
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

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
    DOUBLES,
    NUMBERS,
    DescribedVariable,
    FileVersion,
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
from hoist_demo.cosimulation.schemes.interface import (
    ADDED_MASSES,
    ROPE_FORCES,
    SUCCESS,
    ParticipantFailed,
    Reader,
    end_signals,
)
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.fidelity import FIDELITY
from rope_model import SIDES, EndMotion, Status

_log = logging.getLogger(__name__)
END_INPUTS = tuple(field.name for field in fields(EndMotion))  #: Names of an end's inputs.
_MOTIONS = end_signals(*END_INPUTS)  #: Inputs of both ends, left then right.


class FmuRope:
    """A RopePlant that lives in an .fmu file."""

    def __init__(
        self,
        path: Path,
        parameters: Mapping[str, Value] | None = None,
        recorded: Collection[str] | None = None,
    ) -> None:
        """Load the FMU and set its parameters.

        ``recorded`` outputs are read, by default all but the added masses.
        """
        self._started = False
        self._warned: set[str] = set()  # warnings that were logged
        self._errors: list[str] = []  # the FMU's messages about the call that fails
        self._path = Path(path)
        fmu = read_fmu(self._path)
        self._description = fmu.description
        self._described = fmu.parameters
        self._variables = fmu.by_name
        inputs = [self._variable(name) for name in _MOTIONS]
        self._require_interface(inputs, fmu.outputs)
        if recorded is None:
            recorded = fmu.outputs.keys() - {*ADDED_MASSES}
        self._units = {name: unit for name, unit in fmu.outputs.items() if name in recorded}
        self._chosen: dict[str, Value] = {"inputs_at_step_end": True, **(parameters or {})}
        self._fmu = self._instance()
        self._motions = self._buffers("Set", inputs, rows=1)
        self._motion_columns = [_columns(buffer, _MOTIONS) for buffer in self._motions]
        valid = self._variables.get("status.valid")
        self._valid: Buffer | None = None
        if valid is not None:
            self._valid = self._fmu.buffer("Get", [valid])
        try:
            for variable in dict.fromkeys(self._variable(name) for name in self._chosen):
                self._set(variable)
        except BaseException:
            self.close()
            raise

    def _require_interface(
        self, inputs: Sequence[DescribedVariable], outputs: Collection[str]
    ) -> None:
        """Raise ValueError unless the FMU has all motions and forces as real numbers."""
        if missing := [name for name in ROPE_FORCES if name not in outputs]:
            raise ValueError(
                f"FMU '{self._path}' must have the outputs {', '.join(missing)}: export it anew"
            )
        for variable in (*inputs, *(self._variable(name) for name in ROPE_FORCES)):
            if variable.kind != "Real":
                raise ValueError(
                    f"FMU '{self._path}' must have {variable.name} as a real number, not of the "
                    f"type {variable.type}: export it anew"
                )

    def _instance(self) -> Instance:
        """Return a new instance of the FMU; ValueError if it cannot be made."""
        kind = VERSIONS[self._description.fmiVersion]
        directory = unpacked(version_of(self._path))
        try:
            return kind(directory, self._description, self._log_message)
        except RuntimeError as error:
            raise ValueError(
                f"the FMU must instantiate, but: {self._explanation(error)}: export it anew"
            ) from error

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
        """A function that reads some outputs, and the fidelity by its code.

        Arrays are read whole.
        """
        buffers, values = self._outputs(names, 1)

        def read() -> NDArray[np.float64]:
            with self._translate_failures():
                for buffer in buffers:
                    buffer.call()
            return np.asarray(values(1)[0])

        return read

    def library(self) -> RopeLibrary | None:
        """Return the FMU's functions for trip.c; None for an FMU of other types than trip.c takes.

        trip.c has the motions, the rope's forces and its side forces as rows of doubles.
        """
        side_forces = [name for name in SIDE_FORCES if name in self._variables]
        if side_forces and len(side_forces) < len(SIDE_FORCES):
            return None
        exchanged = (*_MOTIONS, *ROPE_FORCES, *side_forces)
        if not all(_is_double(self._variable(name)) for name in exchanged):
            return None
        (motions,) = self._motions
        valid = None if self._valid is None else self._valid.access
        return RopeLibrary(
            step=self._fmu.step_access,
            motions=motions.access,
            table=self._table,
            status=self._status_of,
            valid=valid,
        )

    def _table(self, names: Sequence[str], rows: int) -> OutputTable:
        buffers, values = self._outputs(names, rows)
        return OutputTable([buffer.access for buffer in buffers], values)

    def _outputs(
        self, names: Sequence[str], rows: int
    ) -> tuple[list[Buffer], Callable[[int], NDArray[np.float64]]]:
        """Return buffers of outputs by type, and a function that reads their first rows.

        It puts the values in the order of the names.
        """
        variables = dict.fromkeys(
            self._variables[name] for name in names if name in self._variables
        )
        readable = [v for v in variables if v.kind in NUMBERS or v.name == FIDELITY]
        buffers = self._buffers("Get", readable, rows)
        columns = [_columns(buffer, names) for buffer in buffers]

        def values(count: int) -> NDArray[np.float64]:
            table = np.full((count, len(names)), np.nan)
            for buffer, column in zip(buffers, columns, strict=True):
                part = buffer.values[:count, column.in_buffer]
                if part.dtype == TEXT:
                    part = codes_of(part)
                table[:, column.in_table] = part
            return table

        return buffers, values

    def _buffers(
        self, direction: Literal["Get", "Set"], variables: Sequence[DescribedVariable], rows: int
    ) -> list[Buffer]:
        """Return a buffer for the variables of each type."""
        buffers = []
        for type_ in dict.fromkeys(v.type for v in variables):
            of_type = [v for v in variables if v.type == type_]
            buffers.append(self._fmu.buffer(direction, of_type, rows))
        return buffers

    def _status_of(self, call: str, status: int) -> Status:
        """Return the status of a step that has failed in one of its calls, which C has made."""
        names = {
            "MOTIONS": f"Set{self._variable(f'{SIDES[0]}.{END_INPUTS[0]}').type}",
            "STEP": "DoStep",
        }
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
            "SHA-256": _digest(version_of(self._path)),
            "model and version": f"{description.modelName} {description.version or ''}".strip(),
            "exported by": str(description.generationTool or "not said"),
            "FMI version": str(description.fmiVersion),
        }
        units = {name: parameter.unit for name, parameter in self._described.items()}
        reason = ""
        with suppress(CallError):  # a failed FMU may refuse
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
                f"the state must be one of '{self._path.name}', {self._tag.decode().strip()}; "
                "it is of another rope: go on with the one that wrote it "
                "(--fmu FILE or --in-process)"
            )
        data = unstamp(data.removeprefix(self._tag), self._parameters())
        try:
            return self._fmu.from_bytes(data)
        except CallError as error:
            raise ValueError(
                f"the FMU must know these {len(data)} bytes as a state of its own, "
                f"but: {self._explanation(error)}"
            ) from error

    def units(self) -> dict[str, str]:
        """Unit of each signal of the record, as the model description states it."""
        return dict(self._units)

    def close(self) -> None:
        """Terminate and free the instance.

        The extracted files serve the next one of this process.
        """
        if self._started:
            with suppress(CallError):
                self._fmu.fmpy.terminate()
        self._started = False
        self._fmu.close()

    def _parameters(self) -> dict[str, Value]:
        """Return all parameters by name with the values in use."""
        return {name: self._value(name) for name in self._described}

    def _value(self, name: str) -> Value:
        """Return the value of a parameter: the chosen one, or its start."""
        if name in self._chosen:
            return self._chosen[name]
        return self._described[name].start

    def _variable(self, name: str) -> DescribedVariable:
        if name not in self._variables:
            raise ValueError(f"the FMU must have a variable '{name}': export it anew")
        return self._variables[name]

    def _set(self, variable: DescribedVariable) -> None:
        """Set a parameter, of an array all elements, to the values chosen, by its FMI type."""
        values = [_typed(variable, self._value(name)) for name in variable.elements]
        try:
            self._fmu.set(variable, values)
        except CallError as error:
            raise ValueError(
                f"the FMU must take {variable.name}, but: {self._explanation(error)}"
            ) from error

    def _set_motions(self, left: EndMotion, right: EndMotion) -> None:
        motions = np.array([*vars(left).values(), *vars(right).values()])
        for buffer, column in zip(self._motions, self._motion_columns, strict=True):
            buffer.values[0, column.in_buffer] = motions[column.in_table]
            buffer.call()

    def _status(self) -> Status:
        """Return the status by ``status.valid`` and ``status.message``.

        An FMU without them is valid.
        """
        if self._valid is None:
            return SUCCESS
        self._valid.call()
        if self._valid.values[0, 0]:
            return SUCCESS
        return Status(False, self._text("status.message"))

    def _text(self, name: str) -> str:
        """Return a String output; "" if the FMU lacks it."""
        if name not in self._variables:
            return ""
        return self._fmu.text(self._variables[name])()

    @property
    def _tag(self) -> bytes:
        """Return the head of a serialized state, which keeps states of two flavours apart."""
        return f"{self._description.modelName} by {self._description.generationTool}\n".encode()

    def _failure_status(self, error: CallError) -> Status:
        """Return the status of a failed call, with the FMU's own message if it still has one."""
        self._started = False
        message = ""
        with suppress(CallError):
            message = self._text("status.message")
        return Status(False, message or self._explanation(error))

    @contextmanager
    def _translate_failures(self) -> Iterator[None]:
        """Raise a failed call as ParticipantFailed, so that callers need no FMPy."""
        try:
            yield
        except CallError as error:
            raise ParticipantFailed(f"the FMU fails: {self._explanation(error)}") from error

    def _explanation(self, error: Exception) -> str:
        """Return the cause of a failed call, with the FMU's messages."""
        messages = "; ".join(dict.fromkeys(self._errors))
        self._errors = []
        if not messages:
            return str(error)
        return f"{error} {messages}"

    def _log_message(self, status: int, text: str) -> None:
        """Log the FMU's warnings, each once; keep its errors for the call that fails."""
        if status > WARNING:
            self._errors.append(text)
        if status != WARNING:
            _log.debug("%s", text)
        elif text not in self._warned:
            self._warned.add(text)
            _log.warning("%s", text)


class _Columns(NamedTuple):
    """Columns of a buffer, and of the table that they belong to."""

    in_buffer: NDArray[np.int_]
    in_table: NDArray[np.int_]


def _columns(buffer: Buffer, names: Sequence[str]) -> _Columns:
    """Return the columns of a buffer's outputs, in a table of the outputs with these names."""
    index = {name: k for k, name in enumerate(buffer.names)}
    in_table = [k for k, name in enumerate(names) if name in index]
    in_buffer = [index[names[k]] for k in in_table]
    return _Columns(np.array(in_buffer), np.array(in_table))


def _is_double(variable: DescribedVariable) -> bool:
    """Return True for a scalar whose value is a double in C."""
    return variable.type in DOUBLES and variable.elements == (variable.name,)


@lru_cache(maxsize=8)  # a study winds with the same file in every run
def _digest(version: FileVersion) -> str:
    """SHA-256 of a file in one version."""
    with version.path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _typed(v: DescribedVariable, value: Value) -> Value:
    """Convert a value to the variable's FMI type, an enumeration's item to its number."""
    if v.kind == "Enumeration" and isinstance(value, str):
        if value not in v.items:
            raise ValueError(
                f"parameter {v.name} = '{value}' must be one of {', '.join(v.items)}: choose one"
            )
        return v.items[value]
    types: Mapping[str, type[Value]] = {"Real": float, "Boolean": bool, "String": str}
    return types.get(v.kind, int)(value)
