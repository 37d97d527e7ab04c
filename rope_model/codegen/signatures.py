"""Signatures in C of formulas: Python's names and annotations, with the lengths that these lack."""

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, is_dataclass
from types import ModuleType
from typing import Any, get_type_hints

from rope_model.boundary.end_paths import EndPath
from rope_model.state import RopeState

#: names of structures in C, where they differ
_IN_C: dict[type[Any], str] = {RopeState: "State"}


@dataclass(frozen=True)
class Argument:
    """Argument of a C function: a number, an array of numbers, or a structure."""

    name: str
    structure: type[Any] | None = None
    shape: tuple[int, ...] = ()  # lengths of an array

    def declaration(self, constant: bool = True) -> str:
        """Return the declaration in C.  Structures and arrays are ``constant``, or receive results."""
        qualifier = "const " if constant else ""
        if self.structure is not None:
            return f"{qualifier}{name_in_c(self.structure)} *{self.name}"
        if self.shape:
            lengths = "".join(f"[{length}]" for length in self.shape)
            return f"{qualifier}double {self.name}{lengths}"
        return f"double {self.name}"


@dataclass(frozen=True)
class Formula:
    """Python function that becomes a C function."""

    function: Callable[..., Any]
    #: numbers of each parameter that is an array
    lengths: Mapping[str, int] = field(default_factory=dict)
    #: array that receives the results; without it the function returns a number or a structure
    result: Argument | None = None
    #: structure of each parameter that Python annotates with a protocol
    structures: Mapping[str, type[Any]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name in C."""
        return function_in_c(self.function)

    @property
    def arguments(self) -> list[Argument]:
        """Arguments in C, without the array that receives the results."""
        hints = get_type_hints(self.function)
        return [
            self._argument(name, hints.get(name))
            for name in inspect.signature(self.function).parameters
        ]

    @property
    def returned(self) -> type[Any] | None:
        """Structure that the function returns; None for a number, or where an array receives the results."""
        hint = get_type_hints(self.function).get("return")
        return hint if self.result is None and is_structure(hint) else None

    @property
    def return_type(self) -> str:
        """Type of the function in C."""
        if self.result is not None:
            return "void"
        return "double" if self.returned is None else name_in_c(self.returned)

    def prototype(self) -> str:
        """Return the prototype in C."""
        declared = [argument.declaration() for argument in self.arguments]
        if self.result is not None:
            declared.append(self.result.declaration(constant=False))
        return f"{self.return_type} {self.name}({', '.join(declared)})"

    def _argument(self, name: str, hint: Any) -> Argument:
        if name == "self":
            return Argument("path", EndPath)  # no other class has formulas as methods
        if name in self.lengths:
            return Argument(name, shape=(self.lengths[name],))
        hint = self.structures.get(name, hint)
        return Argument(name, hint if is_structure(hint) else None)


def array(name: str, *shape: int) -> Argument:
    """Return an array of these lengths."""
    return Argument(name, shape=shape)


def function_in_c(function: Callable[..., Any]) -> str:
    """Return the name of a function in C, which tells its module, or of a method its class."""
    *owner, name = function.__qualname__.rpartition("<locals>.")[2].split(".")
    if owner:
        room = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", owner[0]).lower()
    else:
        room = function.__module__.rsplit(".")[-1]
    return _with_room(room, name)


def constant_in_c(module: ModuleType, name: str) -> str:
    """Return the name of a constant in C, which tells its module."""
    return _with_room(module.__name__.rsplit(".")[-1].upper(), name)


def _with_room(room: str, name: str) -> str:
    """Return ``name`` behind the name of its room, unless both have a word in common."""
    if set(room.split("_")) & set(name.split("_")):
        return name
    return f"{room}_{name}"


def name_in_c(kind: type[Any]) -> str:
    """Return the name of a structure in C."""
    return _IN_C.get(kind, kind.__name__)


def is_structure(hint: Any) -> bool:
    """Return whether a parameter with this annotation is a structure in C."""
    return is_dataclass(hint) or hasattr(hint, "_fields")
