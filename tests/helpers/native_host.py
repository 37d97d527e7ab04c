"""A host for the rope's FMUs: one instance of FMI 2.0 or 3.0, variables by name, any call in any order, the log."""

import ctypes
import math
import os
import struct
import time
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import fmi3LogMessageCallback
from fmpy.model_description import ModelDescription, ModelVariable
from signal_names import of_both_ends

H = 0.01
OK = 0
WARNING = 1
DISCARD = 2
ERROR = 3
#: s of processor time that one call may take
LONGEST_CALL = 20.0
_DOUBLE = ctypes.c_double
_POINTER = ctypes.c_void_p
_ONE = ctypes.c_size_t(1)
#: types of values by the version of FMI and the name in its functions
_C: dict[int, dict[str, Any]] = {
    2: {
        "Real": _DOUBLE,
        "Integer": ctypes.c_int,
        "Boolean": ctypes.c_int,
        "String": ctypes.c_char_p,
    },
    3: {
        "Float64": _DOUBLE,
        "Int32": ctypes.c_int32,
        "Int64": ctypes.c_int64,
        "Boolean": ctypes.c_bool,
        "String": ctypes.c_char_p,
    },
}
#: a rope of nine equal elements, or of TMN-ETM's fewest
SMALL: dict[str, float] = {
    "mesh.kind": 1,
    "mesh.elements": 9,
    "mesh.coarse_length": 1.5,
    "mesh.counts[3]": 8,
    "mesh.end_levels": 0,
    "rope.length": 30.0,
    "right.y": 0.0,
    "inputs_at_step_end": 1,
}


@cache
def _description(path: Path, written: int) -> ModelDescription:
    """Read once per file: fmpy takes 0.1 s."""
    return fmpy.read_model_description(str(path))


class Access(NamedTuple):
    """Kind of the function that reads or sets a variable, its arguments, and the array of values among them."""

    kind: str
    arguments: list[Any]
    array: Any


class Host:
    """``log`` (status, message) is all that the FMU said, ``said`` its errors; what returns an int returns a status."""

    def __init__(
        self,
        path: Path,
        folder: str,
        token: Any = None,
        memory: Any = None,
        resources: Any = None,
        events: int = 0,
    ) -> None:
        self.description = _description(path, path.stat().st_mtime_ns)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmi = int(self.description.fmiVersion[0])
        self.log: list[tuple[int, str]] = []
        self.said: list[str] = []
        self.reached = _DOUBLE()  # s, by the last step, in FMI 3.0
        identifier = self.description.coSimulation.modelIdentifier
        place = Path(folder).resolve() / "resources"
        self.binary = next((Path(folder) / "binaries").rglob(f"{identifier}.*"))
        self.dll = ctypes.CDLL(str(self.binary))
        if token is None:
            token = self.description.guid
        code = token.encode()
        if self.fmi == 2:
            if resources is None:
                resources = place.as_uri().encode()
            make = self.dll.fmi2Instantiate
            self._callbacks = fmi2CallbackFunctions()
            self._callbacks.logger = fmi2CallbackLoggerTYPE(self._heard)
            functions = memory or (defaultCallbacks.allocateMemory, defaultCallbacks.freeMemory)
            self._callbacks.allocateMemory, self._callbacks.freeMemory = functions
            arguments: Any = b"rope", 1, code, resources, ctypes.byref(self._callbacks), 0, 1
        else:
            if resources is None:
                resources = f"{place}{os.sep}".encode()
            make = self.dll.fmi3InstantiateCoSimulation
            self._logger = fmi3LogMessageCallback(self._heard)
            flags = False, True, events, events
            arguments = (
                b"rope",
                code,
                resources,
                *flags,
                None,
                ctypes.c_size_t(0),
                None,
                self._logger,
                None,
            )
        make.restype = _POINTER
        self.instance = make(*arguments)
        assert self.instance, self.said[-1]

    def _heard(self, *told: Any) -> None:
        """In FMI 2.0 and 3.0 the last that is told are status, category and message."""
        status, _, message = told[-3:]
        self.log.append((status, message.decode()))
        if status >= ERROR:
            self.said.append(message.decode())

    def call(self, name: str, *arguments: Any) -> int:
        """``fmi2Name`` or ``fmi3Name`` as it is in the library, and what must hold for all calls."""
        before = len(self.said)
        start = time.thread_time()
        status: int = getattr(self.dll, f"fmi{self.fmi}{name}")(_POINTER(self.instance), *arguments)
        assert time.thread_time() - start < LONGEST_CALL, name
        assert status in (OK, DISCARD, ERROR), name
        if status == ERROR and self.instance:
            assert len(self.said) > before, f"{name} failed without a word"
            assert len(self.said[-1]) > 20
            assert "(null)" not in self.said[-1]
        return status

    def free(self) -> None:
        function = getattr(self.dll, f"fmi{self.fmi}FreeInstance")
        function.restype = None
        function(_POINTER(self.instance))

    # variables

    def _access(
        self, variable: ModelVariable, kind: str, reference: int | None, values: list[Any]
    ) -> Access:
        """Access to a variable by a function of this kind, with these values."""
        if kind == "Enumeration":
            kind = "Int64"
        if reference is None:
            reference = variable.valueReference
        which = ctypes.c_uint(reference)
        array = (_C[self.fmi][kind] * len(values))(*values)
        arguments = [ctypes.byref(which), _ONE, array]
        if self.fmi == 3:
            arguments.append(ctypes.c_size_t(len(values)))
        return Access(kind, arguments, array)

    def put(
        self, name: str, value: Any, reference: int | None = None, kind: str | None = None
    ) -> int:
        """One variable, as ``kind`` if not as what it is."""
        variable = self.variables[name]
        kind = kind or variable.type
        of = {"Real": float, "Float64": float, "String": lambda _: b"text"}.get(kind, int)
        if not isinstance(value, list | tuple):
            value = [value]
        access = self._access(variable, kind, reference, [*map(of, value)])
        return self.call(f"Set{access.kind}", *access.arguments)

    def give(self, values: Mapping[str, float]) -> int:
        """The first status that is not OK; elements of FMI 3's arrays are left alone."""
        for name, value in values.items():
            if name in self.variables and (status := self.put(name, value)):
                return status
        return OK

    def set(self, **values: Any) -> None:
        for name, value in values.items():
            assert self.put(name.replace("__", "."), value) == OK, self.said[-1]

    def fetch(self, name: str, reference: int | None = None) -> tuple[int, list[Any]]:
        """Status and values."""
        variable = self.variables[name]
        size = 1
        if variable.dimensions:
            size = int(variable.dimensions[0].start)
        nothing = None if variable.type == "String" else 0
        access = self._access(variable, variable.type, reference, [nothing] * size)
        return self.call(f"Get{access.kind}", *access.arguments), list(access.array)

    def get(self, *names: str) -> list[Any]:
        out = []
        for name in names:
            status, values = self.fetch(name)
            assert status == OK, self.said[-1]
            if self.variables[name].dimensions:
                out.append(values)
            elif isinstance(values[0], bytes):
                out.append(values[0].decode())
            else:
                out.append(values[0])
        return out

    def real(self, name: str) -> float:
        """A real output; NaN when there is none."""
        status, (value,) = self.fetch(name)
        if status != OK:
            return math.nan
        return value

    def forces(self) -> tuple[float, ...]:
        return tuple(map(self.real, of_both_ends("fx", "fy", "fz", "my")))

    def derive(self, unknown: int, known: int, seed: float = 1.0) -> tuple[int, float]:
        """Status and value of the directional derivative between two references."""
        u, k = map(ctypes.c_uint, (unknown, known))
        s = _DOUBLE(seed)
        value = _DOUBLE()
        sizes = (_ONE,) if self.fmi == 3 else ()
        arguments = [
            ctypes.byref(u),
            _ONE,
            ctypes.byref(k),
            _ONE,
            ctypes.byref(s),
            *sizes,
            ctypes.byref(value),
            *sizes,
        ]
        return self.call("GetDirectionalDerivative", *arguments), value.value

    def derivative(self, unknown: str, known: str) -> float:
        status, value = self.derive(
            *(self.variables[name].valueReference for name in (unknown, known))
        )
        assert status == OK, self.said[-1]
        return value

    # a run

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        times = (_DOUBLE(start), ctypes.c_int(stop is not None), _DOUBLE(stop or 0.0))
        if self.fmi == 3:
            return self.call("EnterInitializationMode", False, _DOUBLE(0.0), *times)
        return self.call("SetupExperiment", 0, _DOUBLE(0.0), *times) or self.call(
            "EnterInitializationMode"
        )

    def start(self, **parameters: Any) -> None:
        self.set(**parameters)
        assert self.enter() == OK, self.said[-1]
        assert self.call("ExitInitializationMode") == OK, self.said[-1]

    def hang(self, values: Mapping[str, float] = SMALL, start: float = 0.0) -> int:
        """Reset and initialised with these values."""
        self.call("Reset")
        return self.give(values) or self.enter(start) or self.call("ExitInitializationMode")

    def do_step(self, t: float, h: float) -> int:
        if self.fmi == 2:
            return self.call("DoStep", _DOUBLE(t), _DOUBLE(h), 1)
        flags = [ctypes.c_bool() for _ in range(3)]
        return self.call(
            "DoStep", _DOUBLE(t), _DOUBLE(h), True, *map(ctypes.byref, [*flags, self.reached])
        )

    def step(self, t: float, h: float = H) -> str:
        """'' or what the FMU says when the step fails."""
        if self.do_step(t, h) == OK:
            return ""
        return self.said[-1]

    def move(self, t: float, h: float, amplitude: float = 0.5, since: float = 0.0) -> int:
        """A step with the ends swinging against each other and the left one turning; t is counted from ``since``."""
        w = 2.0
        at = t + h
        y, v, a = (
            amplitude * x
            for x in (1 - math.cos(w * at), w * math.sin(w * at), w * w * math.cos(w * at))
        )
        left = {"left.y": y, "left.vy": v, "left.ay": a, "left.yaw": y, "left.yaw_rate": v}
        return self.give(left | {"right.y": -y, "right.vy": -v, "right.ay": -a}) or self.do_step(
            since + t, h
        )

    # states

    def _of_state(self, name: str) -> str:
        if self.fmi == 2:
            return name.replace("State", "state")
        return name

    def save(self, state: ctypes.c_void_p) -> int:
        return self.call(self._of_state("GetFMUState"), ctypes.byref(state))

    def restore(self, state: ctypes.c_void_p) -> int:
        return self.call(self._of_state("SetFMUState"), state)

    def forget(self, state: ctypes.c_void_p) -> int:
        return self.call(self._of_state("FreeFMUState"), ctypes.byref(state))

    def state(self) -> ctypes.c_void_p:
        state = ctypes.c_void_p()
        assert self.save(state) == OK
        return state

    def write(self, state: ctypes.c_void_p) -> bytes:
        size = ctypes.c_size_t()
        assert self.call(self._of_state("SerializedFMUStateSize"), state, ctypes.byref(size)) == OK
        data = ctypes.create_string_buffer(size.value)
        assert self.call(self._of_state("SerializeFMUState"), state, data, size) == OK
        return data.raw

    def read(self, data: bytes, state: ctypes.c_void_p) -> int:
        name = "DeSerializeFMUstate" if self.fmi == 2 else "DeserializeFMUState"
        return self.call(name, data, ctypes.c_size_t(len(data)), ctypes.byref(state))

    def go_on_from(self, data: bytes) -> None:
        """The state that was written is the instance's own."""
        state = ctypes.c_void_p()
        assert [self.read(data, state), self.restore(state), self.forget(state)] == [OK] * 3


def reseal(data: bytes) -> bytes:
    """A damaged state with the length and the checksum (FNV-1a over words) that component.c expects."""
    if len(data) < 24:
        return data
    body = data[24:]
    checksum = 14695981039346656037
    words = len(body) // 8
    for value in (*struct.unpack(f"<{words}Q", body[: 8 * words]), *body[8 * words :]):
        checksum = (checksum ^ value) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return data[:8] + struct.pack("<QQ", len(data), checksum) + body
