"""The C functions of the rope's FMUs as they are: any call in any order, what it said and how long it took."""

import ctypes
import math
import struct
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import fmpy

OK, DISCARD, ERROR = 0, 2, 3
#: s of processor time that one call may take
LONGEST_CALL = 20.0
_DOUBLE, _SIZE, _POINTER = ctypes.c_double, ctypes.c_size_t, ctypes.c_void_p
_TAKE = ctypes.CFUNCTYPE(_POINTER, _SIZE, _SIZE)
_GIVE_BACK = ctypes.CFUNCTYPE(None, _POINTER)
_LOG2 = ctypes.CFUNCTYPE(None, _POINTER, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
_LOG3 = ctypes.CFUNCTYPE(None, _POINTER, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
_C = {"Real": _DOUBLE, "Float64": _DOUBLE, "Integer": ctypes.c_int, "Int32": ctypes.c_int32, "Int64": ctypes.c_int64}
#: a rope of nine equal elements, or of TMN-ETM's fewest
SMALL: dict[str, float] = {
    "mesh.kind": 1, "mesh.elements": 9, "mesh.coarse_length": 1.5, "mesh.counts[3]": 8, "mesh.end_levels": 0,
    "rope.length": 30.0, "right.y": 0.0, "inputs_at_step_end": 1,
}  # fmt: skip


class _Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", _LOG2), ("take", _POINTER), ("give_back", _POINTER), ("finished", _POINTER),
        ("environment", _POINTER),
    )  # fmt: skip


class Library:
    """An unpacked FMU: its library, its token, and type and value reference of its variables."""

    def __init__(self, path: Path, folder: str) -> None:
        description = fmpy.read_model_description(str(path))
        self.fmi, self.token = int(description.fmiVersion[0]), description.guid
        self.variables = {v.name: v for v in description.modelVariables}
        self.path = next(p for p in (Path(folder) / "binaries").rglob("BalanceRope.*"))
        resources = Path(folder).resolve() / "resources"
        self.resources = (resources.as_uri() if self.fmi == 2 else str(resources)).encode()
        self.dll = ctypes.CDLL(str(self.path))
        for name in ("fmi2Instantiate", "fmi3InstantiateCoSimulation"):
            if hasattr(self.dll, name):
                getattr(self.dll, name).restype = _POINTER


class Instance:
    """``said`` are its errors; ``memory`` replaces calloc and free of FMI 2."""

    def __init__(
        self, library: Library, memory: tuple[Callable[[int, int], int], Callable[[int], None]] | None = None
    ) -> None:
        self.library, self.said, self._token = library, list[str](), library.token.encode()
        if library.fmi == 2:
            c = ctypes.CDLL(None)
            self._memory = (_TAKE(memory[0]), _GIVE_BACK(memory[1])) if memory else (c.calloc, c.free)
            self._log: Any = _LOG2(lambda _e, _n, status, _c, message: self._record(status, message))
            addresses = (ctypes.cast(f, _POINTER) for f in self._memory)
            self._callbacks = _Callbacks(self._log, *addresses)
            self.pointer = library.dll.fmi2Instantiate(
                b"rope", 1, self._token, library.resources, ctypes.byref(self._callbacks), 0, 0
            )
        else:
            self._log = _LOG3(lambda _e, status, _c, message: self._record(status, message))
            self.pointer = library.dll.fmi3InstantiateCoSimulation(
                b"rope", self._token, library.resources, *[False] * 4, None, _SIZE(0), None, self._log, None
            )
        assert self.pointer, self.said[-1]

    def _record(self, status: int, message: bytes) -> None:
        if status >= ERROR:
            self.said.append(message.decode())

    def call(self, name: str, *arguments: Any) -> int:
        """``fmi2Name`` or ``fmi3Name``; the status, and what must hold for all calls."""
        before, start = len(self.said), time.thread_time()
        function = getattr(self.library.dll, f"fmi{self.library.fmi}{name}")
        status: int = function(_POINTER(self.pointer), *arguments)
        assert time.thread_time() - start < LONGEST_CALL, name
        assert status in (OK, DISCARD, ERROR), name
        if status == ERROR:
            assert len(self.said) > before, f"{name} failed without a word"
            assert len(self.said[-1]) > 20
            assert "(null)" not in self.said[-1]
        return status

    def set(self, name: str, value: float, reference: int | None = None, kind: str | None = None) -> int:
        """One scalar, as ``kind`` if not as what it is; elements of FMI 3's arrays are left alone."""
        if name not in self.library.variables:
            return OK
        variable = self.library.variables[name]
        kind = kind or variable.type
        kind = {"Enumeration": "Int64"}.get(kind, kind)
        boolean: Any = ctypes.c_bool if self.library.fmi == 3 else ctypes.c_int
        c = _C.get(kind, boolean)(value if kind in ("Real", "Float64") else int(value))
        if kind == "String":
            c = ctypes.c_char_p(b"text")
        number = (_SIZE(1),) if self.library.fmi == 3 else ()
        which = ctypes.c_uint(variable.valueReference if reference is None else reference)
        return self.call(f"Set{kind}", ctypes.byref(which), _SIZE(1), ctypes.byref(c), *number)

    def real(self, name: str) -> float:
        """A real output; NaN when there is none."""
        value, number = _DOUBLE(math.nan), (_SIZE(1),) if self.library.fmi == 3 else ()
        which = ctypes.c_uint(self.library.variables[name].valueReference)
        kind = self.library.variables[name].type
        self.call(f"Get{kind}", ctypes.byref(which), _SIZE(1), ctypes.byref(value), *number)
        return value.value

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        times = (_DOUBLE(start), ctypes.c_int(stop is not None), _DOUBLE(0.0 if stop is None else stop))
        if self.library.fmi == 3:
            return self.call("EnterInitializationMode", False, _DOUBLE(0.0), *times)
        return self.call("SetupExperiment", 0, _DOUBLE(0.0), *times) or self.call("EnterInitializationMode")

    def hang(self, values: Mapping[str, float] = SMALL, start: float = 0.0) -> int:
        """Reset and initialised with these values."""
        self.call("Reset")
        for name, value in values.items():
            if status := self.set(name, value):
                return status
        return self.enter(start) or self.call("ExitInitializationMode")

    def step(self, t: float, h: float) -> int:
        if self.library.fmi == 2:
            return self.call("DoStep", _DOUBLE(t), _DOUBLE(h), 1)
        flags, last = [ctypes.c_bool() for _ in range(3)], _DOUBLE()
        return self.call("DoStep", _DOUBLE(t), _DOUBLE(h), True, *map(ctypes.byref, flags), ctypes.byref(last))

    def move(self, t: float, h: float, amplitude: float = 0.5, since: float = 0.0) -> int:
        """A step with the ends swinging against each other and the left one turning; t is counted from ``since``."""
        w, at = 2.0, t + h
        y, v, a = 1 - math.cos(w * at), w * math.sin(w * at), w * w * math.cos(w * at)
        left = {"left.y": y, "left.vy": v, "left.ay": a, "left.yaw": y, "left.yaw_rate": v}
        for name, value in (left | {"right.y": -y, "right.vy": -v, "right.ay": -a}).items():
            if status := self.set(name, amplitude * value):
                return status
        return self.step(since + t, h)

    def forces(self) -> tuple[float, ...]:
        return tuple(self.real(f"{side}.{kind}") for side in ("left", "right") for kind in ("fx", "fy", "fz", "my"))

    # states

    def _state(self, name: str) -> str:
        return f"{name}FMUstate" if self.library.fmi == 2 else f"{name}FMUState"

    def save(self, state: ctypes.c_void_p) -> int:
        return self.call(self._state("Get"), ctypes.byref(state))

    def restore(self, state: ctypes.c_void_p) -> int:
        return self.call(self._state("Set"), state)

    def forget(self, state: ctypes.c_void_p) -> int:
        return self.call(self._state("Free"), ctypes.byref(state))

    def write(self, state: ctypes.c_void_p) -> bytes:
        size = _SIZE()
        assert self.call("SerializedFMUstateSize" if self.library.fmi == 2 else "SerializedFMUStateSize", state, ctypes.byref(size)) == OK  # fmt: skip  # noqa: E501
        data = ctypes.create_string_buffer(size.value)
        assert self.call(self._state("Serialize"), state, data, size) == OK
        return data.raw

    def read(self, data: bytes, state: ctypes.c_void_p) -> int:
        name = "DeSerializeFMUstate" if self.library.fmi == 2 else "DeserializeFMUState"
        return self.call(name, data, _SIZE(len(data)), ctypes.byref(state))

    def free(self) -> None:
        function = getattr(self.library.dll, f"fmi{self.library.fmi}FreeInstance")
        function.restype = None
        function(_POINTER(self.pointer))


def reseal(data: bytes) -> bytes:
    """A damaged state with the length and the checksum (FNV-1a over words) that component.c expects."""
    if len(data) < 24:
        return data
    body, checksum = data[24:], 14695981039346656037
    words = len(body) // 8
    for value in (*struct.unpack(f"<{words}Q", body[: 8 * words]), *body[8 * words :]):
        checksum = (checksum ^ value) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return data[:8] + struct.pack("<QQ", len(data), checksum) + body
