"""A rope's functions as trip.c calls them, by pointers: those of FMI, or of rope.h."""

from collections.abc import Callable, Sequence
from ctypes import CFUNCTYPE, Array, addressof, c_void_p, cast
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.c_structures import CMember, SharedStructure, fields_of
from hoist_demo.recording.fidelity import code_of
from rope_model import Status

_FMI3_NUMBERS = (
    "Float32",
    "Float64",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
)
#: Functions that trip.c calls, each by its own type in C; trip.c knows them by their places here.
FUNCTIONS = (
    "rope_signals",
    "rope_fidelity",
    "rope_advance_to",
    *(f"fmi2Get{type_}" for type_ in ("Real", "Integer", "Boolean", "String")),
    "fmi2SetReal",
    "fmi2DoStep",
    *(f"fmi3Get{type_}" for type_ in (*_FMI3_NUMBERS, "Boolean", "String")),
    *(f"fmi3Set{type_}" for type_ in ("Float32", "Float64")),
    "fmi3DoStep",
)
CALLS = ("MOTIONS", "STEP", "VALID", "FORCES")  #: Calls of a step of the rope, in turn.
TEXT = np.dtype("S24")  #: Characters of a text that are stored.


class Access(SharedStructure):
    """Function of the rope that gets or sets values, row by row of an array."""

    members = (
        CMember("called_as", "int", "AS_ and the function's name: the member of the union"),
        CMember("function", "Function"),
        CMember("rope", "void *"),
        CMember("numbers", "const void *", "of the values"),
        CMember("count", "size_t", "of the numbers"),
        CMember("length", "size_t", "of a row"),
        CMember("bytes", "size_t", "of a row"),
        CMember("values", "char *"),
    )
    _fields_ = fields_of(members)


def make_access(
    name: str, function: Any, rope: int, numbers: Array[Any], values: NDArray[Any]
) -> Access:
    """Return the access to a C function, of the type of the function ``name``.

    ``numbers`` are references of the variables that the function gets or sets, each row of
    ``values`` is room for all of them.
    """
    access = Access(
        called_as=FUNCTIONS.index(name),
        function=cast(function, c_void_p),
        rope=rope,
        numbers=addressof(numbers),
        count=len(numbers),
        length=values.shape[1],
        bytes=values.strides[0],
        values=values.ctypes.data,
    )
    access.arrays = numbers, values  # the access itself has their addresses alone
    return access


def codes_of(fidelities: NDArray[Any]) -> NDArray[np.float64]:
    """Return the codes of fidelities that are stored as TEXT, of the same shape."""
    codes = {name: code_of(name.decode()) for name in set(fidelities.ravel().tolist())}
    return np.array([codes[name] for name in fidelities.ravel().tolist()]).reshape(fidelities.shape)


class OutputTable(NamedTuple):
    """Outputs in several rows, and the accesses by which C fills them."""

    accesses: Sequence[Access]
    read: Callable[[int], NDArray[np.float64]]  # the first rows, (rows, outputs)


@dataclass(frozen=True)
class RopeLibrary:
    """Functions of a rope that trip.c calls."""

    step: Access  # the function alone
    motions: Access  # motions of the ends, to be set
    table: Callable[[Sequence[str], int], OutputTable]  # makes a table of outputs with so many rows
    # of a step, by a name in CALLS and the status of that call
    status: Callable[[str, int], Status]
    valid: Access | None = None
    warning: Any = None  # rope_warning, of a rope that does not report its warnings itself
    warned: Any = None  # a flag for each warning, 1 once it is logged
    text: Any = None  # room for one warning
    log_warnings: Callable[[], object] = lambda: None  # logs new warnings, once C has gone on


LOG_WARNINGS = CFUNCTYPE(None)
