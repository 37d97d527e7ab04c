"""FMI 2.0 and FMI 3.0 behind one interface, through FMPy: the differences between them.

FMI 3.0 has other types, and other calls to instantiate, to set up and to step; fmu_description has
the variables.
"""

import atexit
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from ctypes import Array, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import chain
from pathlib import Path
from typing import Any, Literal, NamedTuple
from weakref import WeakKeyDictionary, finalize

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.fmu_description import FMI_VERSIONS, DescribedVariable
from hoist_demo.cosimulation.participants.library_calls import TEXT, Access, make_access
from hoist_demo.parameters.quantity import Value

CallError = FMICallException  #: A call that the FMU answers with discard, error or fatal.
WARNING = 1  #: Status of a message that fails no call; errors have larger ones, in both versions.
DISCARD = 2  #: Status of a step that is not done.
_CLOSED = "the FMU is closed, its memory is gone: read from it before close(), or load it anew"
#: Argument noSetFMUStatePriorToCurrentPoint of every doStep: the estimate of a coupling's stability
#: goes back by several steps, and callers may by any number, so the FMU must be able to.
_NO_STATE_PRIOR = False
MessageLog = Callable[[int, str], None]  #: Takes the status and the text of a message of the FMU.
Handle = c_void_p  #: Of a state in the FMU's memory.


class Buffer(NamedTuple):
    """Values that are read from or written to an FMU again and again."""

    names: Sequence[str]
    call: Callable[[], Any]  # fills the first row of `values`, or passes it on
    values: NDArray[Any]  # (rows, names)
    access: Access  # the same for C, with any row


@dataclass(frozen=True, eq=False)
class FmuState:
    """State in the FMU's memory, freed with its last reference."""

    handle: Handle


@lru_cache
def _load(fmpy_class: Callable[..., Any], directory: Path, guid: str, identifier: str) -> Any:
    """Return FMPy's object with the FMU's library.

    The library stays loaded for the next instance and until this process ends.
    """
    fmu = fmpy_class(
        guid=guid,
        modelIdentifier=identifier,
        unzipDirectory=str(directory),
        instanceName="balance_rope",
    )
    atexit.register(fmu.freeLibrary)
    return fmu


class Instance(ABC):
    """Instance for co-simulation. After ``close`` each call but that one raises RuntimeError."""

    _fmpy_class: Callable[..., Any]  #: FMPy's, of the version.
    _fmpy_module: Any
    _prefix: str  #: Of the names in C.
    _enumeration: str  #: Type whose functions get and set enumerations.
    _has_lengths: bool  #: Whether getters and setters take the number of the values.
    _do_step: Callable[[], None]

    def __init__(self, directory: Path, description: Any, log: MessageLog) -> None:
        """Load from the FMU's files and instantiate; RuntimeError when that fails."""
        self._log = log
        self._loaded: Any = None  # FMPy's; None once it is freed
        self._t = c_double()  # start of the next step
        self._h = c_double()  # length of the next step
        #: Referenced states, and their finalizers.
        self._states = WeakKeyDictionary[FmuState, Callable[[], Any]]()
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
        """Instantiate with all messages to ``_log_message``, and set ``_do_step``.

        A Python FMU sends messages only with logging on.
        """

    def _log_message(self, *message: Any) -> None:
        """Log a message, of which status, category and text come last in both versions."""
        status, _, text = message[-3:]
        self._log(status, text.decode("utf-8", errors="replace"))

    @abstractmethod
    def enter_initialization(self, t0: float) -> None:
        """Set up for a run from t0 [s] and enter initialization mode."""

    def step(self, t: float, h: float) -> None:
        """Step from t to t + h [s]."""
        self._t.value = t
        self._h.value = h
        self._do_step()

    def buffer(
        self,
        direction: Literal["Get", "Set"],
        variables: Sequence[DescribedVariable],
        rows: int = 1,
    ) -> Buffer:
        """Return a reusable buffer for all elements of variables of one type.

        ValueError for variables of several types: one function of FMI serves one type.
        """
        names = [*chain.from_iterable(variable.elements for variable in variables)]
        types = sorted({self._function_type(variable) for variable in variables})
        if len(types) > 1:
            raise ValueError(
                f"a buffer of {', '.join(names)} must hold one type of FMI, not "
                f"{' and '.join(types)}: make one for each type"
            )
        (type_,) = types
        values = np.zeros((rows, len(names)), self._dtype(type_))
        references = (c_uint32 * len(variables))(*(v.reference for v in variables))
        name = f"{direction}{type_}"
        access = make_access(
            self.name_in_c(name), self._function(name), self.fmpy.component, references, values
        )
        call = self._call(name, references, values.ctypes.data_as(c_void_p), len(names))
        if type_ == "String":
            text = self.text(variables[0])

            def call() -> None:
                values[0, 0] = text()

        return Buffer(names, call, values, access)

    def _function_type(self, variable: DescribedVariable) -> str:
        """Return the type in the names of the functions that get and set a variable."""
        if variable.type == "Enumeration":
            return self._enumeration
        return variable.type

    def _dtype(self, type_: str) -> np.dtype[Any]:
        """Return the type of an array for values of a type of FMI."""
        if type_ == "String":
            return TEXT
        dtype: np.dtype[Any] = np.dtype(getattr(self._fmpy_module, self.name_in_c(type_)))
        return dtype

    def text(self, variable: DescribedVariable) -> Callable[[], str]:
        """Return a function that reads a String variable."""
        values = (c_char_p * 1)()
        call = self._call("GetString", (c_uint32 * 1)(variable.reference), values, 1)

        def read() -> str:
            call()
            return (values[0] or b"").decode("utf-8", errors="replace")

        return read

    @property
    def step_access(self) -> Access:
        """Access to the function DoStep."""
        return make_access(
            self.name_in_c("DoStep"),
            self._function("DoStep"),
            self.fmpy.component,
            numbers=(c_uint32 * 0)(),
            values=np.zeros((0, 0)),
        )

    def name_in_c(self, name: str) -> str:
        """Return the name of a function in the FMU's library."""
        return self._prefix + name

    def _function(self, name: str) -> Any:
        return self.fmpy.dll[self.name_in_c(name)]

    def _call(
        self, name: str, references: Array[c_uint32], values: Any, number: int
    ) -> Callable[[], None]:
        """Return a call of a getter or setter of so many values."""
        length = [c_size_t(number)] if self._has_lengths else []
        return self._checked(name, references, c_size_t(len(references)), values, *length)

    def _checked(self, name: str, *arguments: Any) -> Callable[[], None]:
        """Return a call of the library with these arguments, past FMPy's own frames.

        It raises CallError where it fails. The arguments have their types of C, which a function
        without a prototype takes as they are, in half the time.
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

    def set(self, variable: DescribedVariable, values: Sequence[Value]) -> None:
        """Set all elements of a variable."""
        type_ = self._function_type(variable)
        getattr(self.fmpy, f"set{type_}")([variable.reference], values)

    def save(self) -> FmuState:
        """Return a handle of the FMU's present state."""
        return self._state_of(self.fmpy.getFMUState())

    def restore(self, state: FmuState) -> None:
        """Restore a state that ``save`` or ``from_bytes`` returned."""
        self.fmpy.setFMUState(state.handle)

    def to_bytes(self, state: FmuState) -> bytes:
        """Return a state serialized by the FMU."""
        return bytes(self.fmpy.serializeFMUState(state.handle))

    def from_bytes(self, data: bytes) -> FmuState:
        """Deserialize a state into the FMU's memory."""
        return self._state_of(self.fmpy.deserializeFMUState(data))

    def _state_of(self, handle: Handle) -> FmuState:
        """Return the state of a handle, which is freed with its last reference."""
        state = FmuState(handle)
        finalizer = finalize(state, self._free_state, handle)
        finalizer.atexit = False  # the library may be unloaded before
        self._states[state] = finalizer
        return state

    def _free_state(self, handle: Handle) -> None:
        """Free the memory of a state without references."""
        with suppress(CallError):
            self.fmpy.freeFMUState(handle)

    def close(self) -> None:
        """Free the instance; may be called more than once."""
        if self._loaded is None:
            return
        for free_state in [*self._states.values()]:
            free_state()
        fmu = self._loaded
        self._loaded = None
        # FMPy's freeInstance unloads the library, too
        free_instance = getattr(fmu, self.name_in_c("FreeInstance"))
        free_instance(fmu.component)


class _Instance2(Instance):
    _fmpy_class = fmpy.fmi2.FMU2Slave
    _fmpy_module = fmpy.fmi2
    _prefix = "fmi2"
    _enumeration = "Integer"
    _has_lengths = False

    def _instantiate(self) -> None:
        # FMPy prints by default; the callbacks must live as long as the instance
        self._callbacks: Any = fmpy.fmi2.fmi2CallbackFunctions()
        self._callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._log_message)
        self._callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
        self._callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
        # FMPy's proxy formats C varargs; on a platform without it the raw text is logged
        with suppress(ImportError, OSError, RuntimeError):
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(byref(self._callbacks))
        self.fmpy.instantiate(callbacks=self._callbacks, loggingOn=True)
        self._do_step = self._checked("DoStep", self._t, self._h, c_int(_NO_STATE_PRIOR))

    def enter_initialization(self, t0: float) -> None:
        self.fmpy.setupExperiment(startTime=t0)
        self.fmpy.enterInitializationMode()


class _Instance3(Instance):
    _fmpy_class = fmpy.fmi3.FMU3Slave
    _fmpy_module = fmpy.fmi3
    _prefix = "fmi3"
    _enumeration = "Int64"
    _has_lengths = True

    def _instantiate(self) -> None:
        self.fmpy.instantiate(loggingOn=True, logMessage=self._log_message)
        self._ended = c_bool()
        self._do_step = self._checked(
            "DoStep",
            self._t,
            self._h,
            c_bool(_NO_STATE_PRIOR),
            byref(c_bool()),  # event handling needed
            byref(self._ended),
            byref(c_bool()),  # early return
            byref(c_double()),  # last successful time
        )

    def enter_initialization(self, t0: float) -> None:
        self.fmpy.enterInitializationMode(startTime=t0)

    def step(self, t: float, h: float) -> None:
        super().step(t, h)
        if self._ended.value:  # succeeds here, and is a discarded step in FMI 2.0
            raise CallError("fmi3DoStep", DISCARD)


VERSIONS: Mapping[str, type[Instance]] = dict(
    zip(FMI_VERSIONS, (_Instance2, _Instance3), strict=True)
)
