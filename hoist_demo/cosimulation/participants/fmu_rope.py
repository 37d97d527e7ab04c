"""The balance rope as an FMU for co-simulation (FMI 2.0), driven through FMPy.

Nothing is known of the FMU's inside: variables are found by name in its model description. The host computes
t = start + k H; doStep(t, H) is given the end motions of t + H (parameter `inputs_at_step_end` = true).
"""

from __future__ import annotations

import hashlib
import logging
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from ctypes import byref
from dataclasses import fields
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    free,
)

from hoist_demo.cosimulation.participants.fmu_parameters import parameters_of, read_description
from hoist_demo.cosimulation.participants.rope_data import RopeData, Value, stamped, unstamped
from hoist_demo.cosimulation.participants.rope_plant import REQUIRED_SIGNALS, EndMotion, RopeStatus
from hoist_demo.recording.rungs import RUNG, code_of

_log = logging.getLogger(__name__)

ParameterValue = Value

INPUTS = tuple(field.name for field in fields(EndMotion))
"""Names of an end's inputs."""

NOT_READ = frozenset({"left.added_mass", "right.added_mass"})
"""Outputs left alone by default: the host does not use them, and a rope may compute them only when they are read."""

_WARNING = 1
"""Status of a message that fails no call."""


class FmuRope:
    """A RopePlant that lives in an .fmu file."""

    def __init__(
        self,
        path: Path,
        parameters: Mapping[str, ParameterValue] | None = None,
        not_read: Collection[str] = NOT_READ,
    ) -> None:
        """Extract and load the FMU, and set its parameters, each by its FMI type (enumerations by item name).

        Outputs named in `not_read` are not among the signals.
        """
        self._slave: Any = None
        self._started = False
        self._warned: set[str] = set()  # what has been in the log
        self._errors: list[str] = []  # what the FMU has said of the call that fails
        self._path = Path(path)
        self._description: Any = read_description(self._path)
        self._variables: dict[str, Any] = {v.name: v for v in self._description.modelVariables}
        self._inputs = [self._reference(f"{end}.{name}") for end in ("left", "right") for name in INPUTS]
        self._outputs = _numeric_outputs(self._description, not_read)
        self._tells_rung = RUNG in self._variables and RUNG not in not_read
        self._chosen: dict[str, ParameterValue] = {"inputs_at_step_end": True, **(parameters or {})}
        missing = [name for name in REQUIRED_SIGNALS if name not in self._units_of_outputs()]
        if missing:
            raise ValueError(f"FMU '{path}' must have the outputs {', '.join(missing)}: export it anew")
        self._directory = Path(fmpy.extract(str(path)))
        try:
            self._slave = self._instantiate()
            for name, value in self._chosen.items():
                self._set(name, value)
        except BaseException:
            self.close()
            raise

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """Set-up, initialization mode with the ends' start motion, and the first status."""
        try:
            self._slave.setupExperiment(startTime=t0)
            self._slave.enterInitializationMode()
            self._set_motions(left, right)
            self._slave.exitInitializationMode()
            self._started = True
        except FMICallException as error:
            return self._failed(error)
        return self._status()

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """One doStep(t, h) with the motions of its end."""
        try:
            self._set_motions(left, right)
            self._slave.doStep(t, h)
        except FMICallException as error:
            return self._failed(error)
        return self._status()

    def signals(self) -> dict[str, float]:
        """Real, Integer and Boolean outputs by name, but those that are not read, and the rung by its code."""
        values: dict[str, float] = {}
        for kind, variables in self._outputs.items():
            if variables:
                read = getattr(self._slave, f"get{kind}")([v.valueReference for v in variables])
                values.update((v.name, float(value)) for v, value in zip(variables, read, strict=True))
        if self._tells_rung:
            values[RUNG] = code_of(self._text(RUNG))
        return values

    def data(self) -> RopeData:
        """What this rope is: its file, and all parameters with the values they were given."""
        description, parameters = self._description, parameters_of(self._description)
        with self._path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        model = {
            "FMU": self._path.name,
            "SHA-256": digest,
            "model and version": f"{description.modelName} {description.version or ''}".strip(),
            "exported by": str(description.generationTool or "not said"),
            "FMI version": str(description.fmiVersion),
        }
        return RopeData(model, self._parameters(), {name: p.unit for name, p in parameters.items()}, self._reason())

    def read(self, names: Iterable[str]) -> dict[str, float]:
        """Some Real outputs by name, in the order asked for."""
        wanted = [name for name in names if name in self._variables]
        with self._told():
            return dict(zip(wanted, self._slave.getReal([self._reference(name) for name in wanted]), strict=True))

    def save(self) -> Any:
        """A handle of the FMU's state; None when it cannot save."""
        if not self._description.coSimulation.canGetAndSetFMUstate:
            return None
        with self._told():
            return self._slave.getFMUState()

    def restore(self, snapshot: Any) -> None:
        """Go back to a handle of this instance."""
        with self._told():
            self._slave.setFMUState(snapshot)

    def free(self, snapshot: Any) -> None:
        """Give a handle back to the FMU."""
        if snapshot is not None:
            with suppress(FMICallException):
                self._slave.freeFMUState(snapshot)

    def to_bytes(self, snapshot: Any) -> bytes:
        """The FMU's serialized state."""
        with self._told():
            return self._tag + stamped(bytes(self._slave.serializeFMUState(snapshot)), self._parameters())

    def from_bytes(self, data: bytes) -> Any:
        """A handle from a serialized state."""
        if not data.startswith(self._tag):
            raise ValueError(
                f"the state must be one of '{self._path.name}', {self._tag.decode().strip()}; it is of another rope: "
                "go on with the one that wrote it (--fmu FILE or --in-process)"
            )
        data = unstamped(data.removeprefix(self._tag), self._parameters())
        try:
            return self._slave.deSerializeFMUstate(data)
        except FMICallException as error:
            raise ValueError(
                f"the FMU must know these {len(data)} bytes as a state of its own, but: {self._explained(error)}"
            ) from error

    def units(self) -> dict[str, str]:
        """Unit of each signal as the model description states it."""
        return self._units_of_outputs() | ({RUNG: "1"} if self._tells_rung else {})

    def close(self) -> None:
        """Terminate, free the instance and remove the extracted files."""
        slave, self._slave = self._slave, None
        if slave is not None:
            if self._started:
                with suppress(FMICallException):
                    slave.terminate()
            slave.freeInstance()
        shutil.rmtree(self._directory, ignore_errors=True)

    def _parameters(self) -> dict[str, Value]:
        """All parameters with the values they were given."""
        return {name: self._chosen.get(name, p.start) for name, p in parameters_of(self._description).items()}

    def _instantiate(self) -> Any:
        slave = FMU2Slave(
            guid=self._description.guid,
            modelIdentifier=self._description.coSimulation.modelIdentifier,
            unzipDirectory=str(self._directory),
            instanceName="balance_rope",
        )
        # FMPy prints by default; the callbacks must live as long as the instance
        self._callbacks: Any = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(self._hear)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        # formats C varargs where FMPy ships its proxy for this platform; without it the raw text is logged
        with suppress(ImportError, OSError, RuntimeError):
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(byref(self._callbacks))
        try:
            # a Python FMU passes on no warning without logging
            slave.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:  # FMPy raises the bare class here
            slave.freeLibrary()
            raise ValueError(f"the FMU must instantiate, but: {self._explained(error)}: export it anew") from error
        return slave

    def _reference(self, name: str) -> int:
        if name not in self._variables:
            raise ValueError(f"the FMU must have a variable '{name}': export it anew")
        return int(self._variables[name].valueReference)

    def _set(self, name: str, value: ParameterValue) -> None:
        """Set one parameter by its FMI type."""
        reference = [self._reference(name)]
        variable = self._variables[name]
        if variable.type == "Real":
            self._slave.setReal(reference, [float(value)])
        elif variable.type == "Boolean":
            self._slave.setBoolean(reference, [bool(value)])
        elif variable.type == "String":
            self._slave.setString(reference, [str(value)])
        elif variable.type == "Enumeration" and isinstance(value, str):
            self._slave.setInteger(reference, [_item(variable, value)])
        else:
            self._slave.setInteger(reference, [int(value)])

    def _set_motions(self, left: EndMotion, right: EndMotion) -> None:
        self._slave.setReal(self._inputs, [getattr(end, name) for end in (left, right) for name in INPUTS])

    def _status(self) -> RopeStatus:
        """What `status.valid` and `status.message` say; an FMU without them is valid."""
        valid = True
        if "status.valid" in self._variables:
            valid = bool(self._slave.getBoolean([self._reference("status.valid")])[0])
        return RopeStatus(valid, "" if valid else self._message())

    def _message(self) -> str:
        return self._text("status.message")

    def _text(self, name: str) -> str:
        """A String output; "" where there is none."""
        if name not in self._variables:
            return ""
        text = self._slave.getString([self._reference(name)])[0]
        return str(text.decode("utf-8", errors="replace")) if text else ""

    def _reason(self) -> str:
        """Why the rung runs that runs, where the FMU still speaks."""
        with suppress(FMICallException):
            return self._text("status.rung_reason")
        return ""

    @property
    def _tag(self) -> bytes:
        """What stands before a serialized state: states of two flavours do not fit one another."""
        return f"{self._description.modelName} by {self._description.generationTool}\n".encode()

    def _failed(self, error: FMICallException) -> RopeStatus:
        """A failed call as a status, with the FMU's own words where it still speaks; it need not be terminated."""
        self._started, message = False, ""
        with suppress(FMICallException):
            message = self._message()
        return RopeStatus(False, message or self._explained(error))

    @contextmanager
    def _told(self) -> Iterator[None]:
        """A failed call as RuntimeError, so that nobody else needs FMPy."""
        try:
            yield
        except FMICallException as error:
            raise RuntimeError(f"the FMU fails: {self._explained(error)}") from error

    def _explained(self, error: Exception) -> str:
        """What a call failed of, with what the FMU has said meanwhile."""
        said, self._errors = "; ".join(dict.fromkeys(self._errors)), []
        return f"{error} {said}" if said else str(error)

    def _hear(self, component: Any, name: bytes, status: int, category: bytes, message: bytes) -> None:
        """The FMU's logger: warnings are told, each once; an error comes back with the call that fails of it."""
        text = message.decode("utf-8", errors="replace")
        if status > _WARNING:
            self._errors.append(text)
        if status != _WARNING:
            _log.debug("%s", text)
        elif text not in self._warned:
            self._warned.add(text)
            _log.warning("%s", text)

    def _units_of_outputs(self) -> dict[str, str]:
        return {v.name: _unit(v) for variables in self._outputs.values() for v in variables}


def _numeric_outputs(description: Any, not_read: Collection[str]) -> dict[str, list[Any]]:
    """Output variables by the type whose getter reads them."""
    getters = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}
    outputs: dict[str, list[Any]] = {"Real": [], "Integer": [], "Boolean": []}
    for variable in description.modelVariables:
        if variable.causality == "output" and variable.type in getters and variable.name not in not_read:
            outputs[getters[variable.type]].append(variable)
    return outputs


def _unit(variable: Any) -> str:
    declared = variable.declaredType
    return str(variable.unit or (declared.unit if declared is not None else None) or "")


def _item(variable: Any, value: str) -> int:
    """Number of an enumeration's item."""
    items = {item.name: int(item.value) for item in variable.declaredType.items}
    if value not in items:
        raise ValueError(f"parameter {variable.name} = '{value}' must be one of {', '.join(items)}: choose one")
    return items[value]
