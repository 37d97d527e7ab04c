"""A host for the rope's FMUs: one instance of FMI 2.0 or 3.0, variables by name, the log kept."""

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi2 import defaultCallbacks as default2
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelDescription

H = 0.01


@cache
def _description(path: Path, written: int) -> ModelDescription:
    """Read once per file: fmpy takes 0.1 s."""
    return fmpy.read_model_description(str(path))


class Host:
    """``name``, ``log`` (status, message) of all that the FMU said, and the calls of both standards under one name."""

    def __init__(self, path: Path, folder: str, token: str | None = None) -> None:
        self.description = _description(path, path.stat().st_mtime_ns)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmi = int(self.description.fmiVersion[0])
        self.log: list[tuple[int, str]] = []
        kind = FMU2Slave if self.fmi == 2 else FMU3Slave
        self.fmu = kind(
            guid=self.description.guid if token is None else token,
            unzipDirectory=folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="rope",
        )
        if self.fmi == 2:
            self._callbacks = fmi2CallbackFunctions()
            self._callbacks.logger = fmi2CallbackLoggerTYPE(self._heard)
            self._callbacks.allocateMemory = default2.allocateMemory
            self._callbacks.freeMemory = default2.freeMemory
            self.fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        else:
            self.fmu.instantiate(loggingOn=True, logMessage=self._heard)
        self.instance = self.fmu.component

    def _heard(self, *told: Any) -> None:
        """In FMI 2.0 and 3.0 the last that is told are status, category and message."""
        status, _, message = told[-3:]
        self.log.append((status, message.decode()))

    def call(self, name: str, *arguments: Any) -> int:
        """``fmi2Name`` or ``fmi3Name`` as it is in the library; the status."""
        function = getattr(self.fmu.dll, f"fmi{self.fmi}{name}")
        function.restype, function.argtypes = ctypes.c_int, None
        return int(function(ctypes.c_void_p(self.instance), *arguments))

    def error(self) -> str:
        return next(message for status, message in reversed(self.log) if status == 3)

    def set(self, **values: Any) -> None:
        for name, value in values.items():
            variable = self.variables[name.replace("__", ".")]
            kind = "Int64" if variable.type == "Enumeration" else variable.type
            many = list(value) if isinstance(value, list | tuple) else [value]
            getattr(self.fmu, f"set{kind}")([variable.valueReference], many)

    def get(self, *names: str) -> list[Any]:
        out = []
        for name in names:
            variable = self.variables[name]
            kind = "Int64" if variable.type == "Enumeration" else variable.type
            number = {"nValues": int(variable.dimensions[0].start)} if self.fmi == 3 and variable.dimensions else {}
            values = getattr(self.fmu, f"get{kind}")([variable.valueReference], **number)
            value = list(values) if number else values[0]
            out.append(value.decode() if isinstance(value, bytes) else value)
        return out

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)

    def start(self, **parameters: Any) -> None:
        self.set(**parameters)
        self.enter()
        self.fmu.exitInitializationMode()

    def step(self, t: float, h: float = H) -> str:
        """'' or what the FMU says when the step fails."""
        try:
            self.fmu.doStep(t, h)
        except FMICallException:
            return self.error()
        return ""

    def run(self, first: int, last: int) -> list[list[float]]:
        """Steps of H with the right end lowered by 1 m/s; the forces after each."""
        record = []
        for k in range(first, last):
            self.set(**{"right.y": 90.0 - (k + 1) * H, "right.vy": -1.0})
            assert self.step(k * H) == ""
            record.append(self.get("left.fy", "right.fy"))
        return record

    def state(self) -> Any:
        return self.fmu.getFMUstate() if self.fmi == 2 else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUstate(state) if self.fmi == 2 else self.fmu.setFMUState(state)

    def free(self, state: Any) -> None:
        self.fmu.freeFMUstate(state) if self.fmi == 2 else self.fmu.freeFMUState(state)

    def serialize(self, state: Any) -> bytes:
        return bytes(self.fmu.serializeFMUstate(state) if self.fmi == 2 else self.fmu.serializeFMUState(state))

    def deserialize(self, data: bytes) -> Any:
        return self.fmu.deSerializeFMUstate(data) if self.fmi == 2 else self.fmu.deserializeFMUState(data)

    def derivative(self, unknown: str, known: str, seed: float = 1.0) -> float:
        references = [self.variables[name].valueReference for name in (unknown, known)]
        return float(self.fmu.getDirectionalDerivative(references[:1], references[1:], [seed])[0])
