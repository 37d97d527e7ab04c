"""CasADi symbols for the arguments of a formula, with the names of its numbers in C.

A structure becomes an object like it.  It lacks members that have another form in C; only those
that the formula reads become text.
"""

import ctypes
from enum import Enum
from types import SimpleNamespace
from typing import Any, Literal, get_args, get_origin, get_type_hints

import casadi as ca

from rope_model.codegen.signatures import Argument, is_structure, shape_of
from rope_model.codegen.state_structures import PatternStructure
from rope_model.method.mesh_pattern import Pattern
from rope_model.parameters import Scene

#: choices with other names in C
SPELT = {"kind": "MESH"}
#: names of members in C, where they differ
_MEMBERS = {"left": "swivels[LEFT]", "right": "swivels[RIGHT]"}


class Word:
    """Choice that is compared with its words."""

    def __init__(self, text: str, name: str, words: tuple[Any, ...]) -> None:
        self.text = text
        self.words = words
        self._name = name

    def __eq__(self, word: object) -> Any:
        return ca.SX.sym(self.text) == self._code(word)

    def __ne__(self, word: object) -> Any:
        return ca.SX.sym(self.text) != self._code(word)

    def _code(self, word: object) -> ca.SX:
        if word not in self.words:
            raise ValueError(f"{self.text} is never {word!r}: compare it with one of {self.words}")
        return ca.SX.sym(word.name if isinstance(word, Enum) else code_name(self._name, str(word)))

    __hash__ = None  # type: ignore[assignment]


def code_name(name: str, word: str) -> str:
    """Return the name in C of the code of a ``word`` of the choice ``name``."""
    if word == "auto" or name in ("given", "mode", "start"):
        suffix = f"_{SPELT.get(name, name.upper())}"
    else:
        suffix = ""
    return word.upper() + suffix


def symbols_of(argument: Argument) -> Any:
    """Return an argument of a formula: symbols with the names of its numbers in C."""
    if argument.structure is Pattern:
        return members_at(PatternStructure, f"{argument.name}->")
    if argument.structure is not None:
        return structure_at(argument.structure, f"{argument.name}->")
    if argument.words:
        return Word(argument.name, argument.name, argument.words)
    return _array(argument.name, argument.shape, argument.whole)


def structure_at(kind: type[Any], prefix: str) -> Any:
    """Return an object like one of ``kind`` with symbols, without members that have another form in C."""
    hints = get_type_hints(kind, include_extras=True)
    values: dict[str, Any] = {}
    for name, hint in hints.items():
        expression = prefix + (_MEMBERS.get(name, name) if kind is Scene else name)
        numbers = set(_leaves(hint))
        if get_origin(hint) is Literal:
            values[name] = Word(expression, name, get_args(hint))
        elif isinstance(hint, type) and issubclass(hint, Enum):
            values[name] = Word(expression, name, tuple(hint))
        elif is_structure(hint):
            values[name] = structure_at(hint, f"{expression}.")
        elif numbers in ({float}, {int}):
            values[name] = _array(expression, shape_of(hint), numbers == {int})
    if issubclass(kind, tuple):
        return kind(**values) if values.keys() == hints.keys() else SimpleNamespace(**values)
    symbolic = object.__new__(kind)  # skip checks, which are for numbers; properties are formulas
    vars(symbolic).update(values)
    return symbolic


def members_at(kind: Any, expression: str) -> Any:
    """Return symbols for the numbers of a ctypes structure or array with the expression ``expression`` in C."""
    if issubclass(kind, ctypes.Structure):
        expression += "" if expression.endswith("->") else "."
        return SimpleNamespace(
            **{name: members_at(part, f"{expression}{name}") for name, part in kind._fields_}
        )
    if issubclass(kind, ctypes.Array):
        return tuple(members_at(kind._type_, f"{expression}[{k}]") for k in range(kind._length_))
    return _array(expression, (), whole=kind is not ctypes.c_double)


def _leaves(hint: Any) -> list[Any]:
    """Return the types in nested tuples, of ``hint`` alone where it is none."""
    if get_origin(hint) is not tuple:
        return [hint]
    return [leaf for part in get_args(hint) for leaf in _leaves(part)]


def _array(name: str, shape: tuple[int, ...], whole: bool = False) -> Any:
    """Return symbols for an array; integers become real numbers, so that C divides as Python does."""
    if not shape:
        return ca.SX.sym(f"(double){name}" if whole else name)
    return tuple(_array(f"{name}[{k}]", shape[1:], whole) for k in range(shape[0]))
