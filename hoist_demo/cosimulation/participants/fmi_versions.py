"""FMI 2.0 and FMI 3.0 under one set of words, through FMPy: all that this package knows of how they differ.

FMI 3.0 has other types, and other calls to instantiate, to set up and to step; fmu_description has the variables.
"""

import atexit
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Literal, NamedTuple
from weakref import WeakKeyDictionary, finalize

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.fmu_description import FMI_VERSIONS, Variable
from hoist_demo.cosimulation.participants.library_calls import TEXT, Access, access
from hoist_demo.parameters.quantity import Value

CallError = FMICallException  #: A call that the FMU answers with discard, error or fatal.
WARNING = (
    1  #: Status of a message that fails no call; those of errors are larger, in both versions.
)
DISCARD = 2  #: Status of a step that is not done.
_CLOSED = "the FMU is closed, its memory is gone: read from it before close(), or load it anew"
#: What every doStep says by noSetFMUStatePriorToCurrentPoint: the estimate of a coupling's stability goes back by
#: several steps, and callers may by any number, so the FMU must be able to.
_NO_STATE_PRIOR = False
Hear = Callable[[int, str], None]  #: Takes the status and the text of a message of the FMU.


class Buffer(NamedTuple):
    """Values that are read from or written to an FMU again and again."""

    names: Sequence[str]
    call: Callable[[], Any]  # fills the first row of `values`, or passes it on
    values: NDArray[Any]  # (rows, names)
    access: Access  # the same for C, with any row


@dataclass(frozen=True, eq=False)
class FmuState:
    """State in the FMU's memory, freed with its last reference."""

    handle: Any


@lru_cache
def _load(fmpy_class: Callable[..., Any], directory: Path, guid: str, identifier: str) -> Any:
    """FMPy's object with the FMU's library, which stays loaded for the next instance and until this process ends."""
    made = fmpy_class(
        guid=guid,
        modelIdentifier=identifier,
        unzipDirectory=str(directory),
        instanceName="balance_rope",
    )
    atexit.register(made.freeLibrary)
    return made


class Instance(ABC):
    """Instance for co-simulation. After `close` each call but that one raises RuntimeError."""

    _fmpy_class: Callable[..., Any]  #: FMPy's, of the version.
    _fmpy_module: Any
    _prefix: str  #: Of the names in C.
    _enumeration: str  #: Type whose functions get and set enumerations.
    _tells_lengths: bool  #: Whether getters and setters are told the number of the values.
    _do_step: Callable[[], None]

    def __init__(self, directory: Path, description: Any, hear: Hear) -> None:
        """Load from the FMU's files and instantiate; RuntimeError when that fails."""
        self._hear = hear
        self._loaded: Any = None  # FMPy's; None once it is freed
        self._t, self._h = c_double(), c_double()  # begin and length of the next step
        self._states = WeakKeyDictionary[
            FmuState, Callable[[], Any]
        ]()  # referenced states, and their finalizers
        identifier = description.coSimulation.modelIdentifier
        try:
            self._loaded = copy(_load(self._fmpy_class, directory, description.guid, identifier))
            self._instantiate()
        except Exception as error:  # FMPy raises the bare class here
            raise RuntimeError(str(error)) from error

    @property
    def fmpy(self) -> Any:
        """FMPy's instance, for calls that both versions have alike."""
        if self._loaded is None:
            raise RuntimeError(_CLOSED)
        return self._loaded

    @abstractmethod
    def _instantiate(self) -> None:
        """Instantiate with all messages to `_hear` (a Python FMU needs logging for that), and set `_do_step`."""

    def _pass_on(self, *message: Any) -> None:
        """Hear a message, of which status, category and text come last in both versions."""
        status, _, text = message[-3:]
        self._hear(status, text.decode("utf-8", errors="replace"))

    @abstractmethod
    def enter_initialization(self, t0: float) -> None:
        """Set up for a run from t0 [s] and enter initialization mode."""

    def step(self, t: float, h: float) -> None:
        """Step from t to t + h [s]."""
        self._t.value, self._h.value = t, h
        self._do_step()

    def buffer(
        self, what: Literal["Get", "Set"], variables: Sequence[Variable], rows: int = 1
    ) -> Buffer:
        """Return a reusable buffer for all elements of variables of one type."""
        names = [name for v in variables for name in v.elements]
        type_ = self._enumeration if variables[0].type == "Enumeration" else variables[0].type
        dtype = (
            TEXT
            if type_ == "String"
            else np.dtype(getattr(self._fmpy_module, f"{self._prefix}{type_}"))
        )
        values = np.zeros((rows, len(names)), dtype)
        references = (c_uint32 * len(variables))(*(v.reference for v in variables))
        name = f"{what}{type_}"
        function = self._function(name)
        rope = self.fmpy.component
        call = self._access(name, references, values.ctypes.data_as(c_void_p), len(names))
        if type_ == "String":
            text = self.text(variables[0])

            def call() -> None:
                values[0, 0] = text()

        return Buffer(
            names, call, values, access(self.name_in_c(name), function, rope, references, values)
        )

    def text(self, variable: Variable) -> Callable[[], str]:
        """Return a function that reads a String variable."""
        values = (c_char_p * 1)()
        call = self._access("GetString", (c_uint32 * 1)(variable.reference), values, 1)

        def read() -> str:
            call()
            return (values[0] or b"").decode("utf-8", errors="replace")

        return read

    @property
    def stepping(self) -> Access:
        """Access to the function DoStep."""
        function, rope = self._function("DoStep"), self.fmpy.component
        return access(self.name_in_c("DoStep"), function, rope, (c_uint32 * 0)(), np.zeros((0, 0)))

    def name_in_c(self, name: str) -> str:
        """Return the name of a function in the FMU's library."""
        return self._prefix + name

    def _function(self, name: str) -> Any:
        return self.fmpy.dll[self.name_in_c(name)]

    def _access(self, name: str, references: Any, values: Any, number: int) -> Callable[[], None]:
        length = [c_size_t(number)] if self._tells_lengths else []
        return self._checked(name, references, c_size_t(len(references)), values, *length)

    def _checked(self, name: str, *arguments: Any) -> Callable[[], None]:
        """A call of the library with these arguments, past FMPy's own frames; CallError where it fails.

        The arguments have their types of C, which a function without a prototype takes as they are, in half the time.
        """
        call: Callable[[], int] = partial(
            self._function(name), c_void_p(self.fmpy.component), *arguments
        )

        def checked() -> None:
            if self._loaded is None:
                raise RuntimeError(_CLOSED)
            status = call()
            if status > WARNING:
                raise CallError(self.name_in_c(name), status)

        return checked

    def set(self, variable: Variable, values: Sequence[Value]) -> None:
        """Set all elements of a variable."""
        type_ = self._enumeration if variable.kind == "Enumeration" else variable.type
        getattr(self.fmpy, f"set{type_}")([variable.reference], values)

    def save(self) -> FmuState:
        """Return a handle of the FMU's present state."""
        return self._held(self.fmpy.getFMUState())

    def restore(self, state: FmuState) -> None:
        """Restore a state that `save` or `from_bytes` returned."""
        self.fmpy.setFMUState(state.handle)

    def to_bytes(self, state: FmuState) -> bytes:
        """Return a state serialized by the FMU."""
        return bytes(self.fmpy.serializeFMUState(state.handle))

    def from_bytes(self, data: bytes) -> FmuState:
        """Deserialize a state into the FMU's memory."""
        return self._held(self.fmpy.deserializeFMUState(data))

    def _held(self, handle: Any) -> FmuState:
        state = FmuState(handle)
        self._states[state] = end = finalize(state, self._give_back, handle)
        end.atexit = False  # the library may be unloaded before
        return state

    def _give_back(self, handle: Any) -> None:
        """Free the memory of a state that nobody refers to any more."""
        with suppress(CallError):
            self.fmpy.freeFMUState(handle)

    def close(self) -> None:
        """Free the instance; may be called more than once."""
        if self._loaded is None:
            return
        for give_back in [*self._states.values()]:
            give_back()
        fmu, self._loaded = self._loaded, None
        getattr(fmu, self.name_in_c("FreeInstance"))(
            fmu.component
        )  # FMPy's freeInstance unloads the library, too


class _Instance2(Instance):
    _fmpy_class, _fmpy_module, _prefix, _enumeration = (
        fmpy.fmi2.FMU2Slave,
        fmpy.fmi2,
        "fmi2",
        "Integer",
    )
    _tells_lengths = False

    def _instantiate(self) -> None:
        # FMPy prints by default; the callbacks must live as long as the instance
        self._callbacks: Any = fmpy.fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._pass_on)
        self._callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
        self._callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
        # formats C varargs where FMPy ships its proxy for this platform; without it the raw text is logged
        with suppress(ImportError, OSError, RuntimeError):
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(byref(self._callbacks))
        self.fmpy.instantiate(callbacks=self._callbacks, loggingOn=True)
        self._do_step = self._checked("DoStep", self._t, self._h, c_int(_NO_STATE_PRIOR))

    def enter_initialization(self, t0: float) -> None:
        self.fmpy.setupExperiment(startTime=t0)
        self.fmpy.enterInitializationMode()


class _Instance3(Instance):
    _fmpy_class, _fmpy_module, _prefix, _enumeration = (
        fmpy.fmi3.FMU3Slave,
        fmpy.fmi3,
        "fmi3",
        "Int64",
    )
    _tells_lengths = True

    def _instantiate(self) -> None:
        self.fmpy.instantiate(loggingOn=True, logMessage=self._pass_on)
        self._ended = c_bool()
        flags = byref(c_bool()), byref(self._ended), byref(c_bool()), byref(c_double())
        self._do_step = self._checked("DoStep", self._t, self._h, c_bool(_NO_STATE_PRIOR), *flags)

    def enter_initialization(self, t0: float) -> None:
        self.fmpy.enterInitializationMode(startTime=t0)

    def step(self, t: float, h: float) -> None:
        super().step(t, h)
        if self._ended.value:  # succeeds here, and is a discarded step in FMI 2.0
            raise CallError("fmi3DoStep", DISCARD)


VERSIONS: Mapping[str, type[Instance]] = dict(
    zip(FMI_VERSIONS, (_Instance2, _Instance3), strict=True)
)
