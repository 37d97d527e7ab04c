"""Memory layout of the state, for ctypes and for C (state_structures.h): structures, and the arrays behind them.

A class is a structure, its docstring the comment in C; a part of RopeState has a structure with the members of its
named tuple.
"""

import ctypes
from collections.abc import Iterator
from ctypes import Structure, c_bool, c_char, c_double, c_int, c_int64, c_size_t, c_void_p
from inspect import cleandoc
from itertools import pairwise, product
from math import prod
from typing import Any, get_args, get_origin, get_type_hints

from rope_model.method.mesh_fit import NO_DIVIDERS
from rope_model.method.swivel_phases import CHATTER_EVENTS, Phase, SwivelState
from rope_model.physics.guard import CAUSES
from rope_model.physics.shaft import KINDS
from rope_model.solver_parameters import INNER_SEGMENTS
from rope_model.state import NO_HYSTERESIS, Counts, RopeState

MESSAGE = 512  #: bytes of a message
SEGMENTS = len(INNER_SEGMENTS) + 2  #: segments of TMN-ETM, with I and VII
LOGGED_EVENTS = 128  #: largest number of events of an advance in the state
#: kinds of events
HAPPENINGS = ("transformed", "sticks", "slips_forward", "slips_back", "raised")
#: arrays of the nodes, 7 numbers each; behind them are element lengths and arc lengths of the nodes
ARRAYS = ("q", "v", "a", "b", "a_rate", "reaction")
_NUMBERS: dict[Any, str] = {
    c_double: "double",
    c_int: "int",
    c_int64: "int64_t",
    c_char: "char",
    c_bool: "bool",
}
#: types of functions' arguments and results
_TYPES: dict[Any, str] = {c_size_t: "size_t", c_void_p: "void *", None: "void "}


class SwivelStateStructure(Structure):
    """State of a swivel: relative angle b while it holds, sign of b_t while it slips."""

    _fields_ = (("angle", c_double), ("sign", c_double), ("phase", c_int), ("unused", c_int))


#: structures of the parts of RopeState in StateStructure
PARTS: dict[Any, type[Structure]] = {SwivelState: SwivelStateStructure}


def _type_of(hint: Any) -> Any:
    """Return the type of a member of a named tuple: a number, another named tuple, or a tuple of one of them."""
    if get_origin(hint) is tuple:
        parts = get_args(hint)
        return _type_of(parts[0]) * (len(KINDS) if Ellipsis in parts else len(parts))
    if not hasattr(hint, "_fields"):
        return c_int64 if hint is int else c_double
    if hint not in PARTS:
        where = f"{hint.__module__}.{hint.__name__}."
        members = [(member, _type_of(part)) for member, part in get_type_hints(hint).items()]
        PARTS[hint] = type(
            f"{hint.__name__}Structure", (Structure,), {"__doc__": where, "_fields_": members}
        )
    return PARTS[hint]


class PatternStructure(Structure):
    """Pattern of TMN-ETM; coarse = 0 for EEM."""

    _fields_ = (
        ("coarse", c_double),
        ("grading_length", c_double),
        ("counts", c_int * SEGMENTS),
        ("end_levels", c_int),
        ("windows", c_int * len(NO_DIVIDERS)),
    )


class EventStructure(Structure):
    """Event; which: side of the swivel, or the new fidelity."""

    _fields_ = (
        ("t", c_double),
        ("kinetic", c_double),
        ("potential", c_double),
        ("what", c_int),
        ("which", c_int),
    )


_HINTS = get_type_hints(RopeState)
_CONVERTED = (
    "motion",
    "partition",
    "fidelity",
    "fidelity_reason",
    "events",
    "powers",
    "hysteresis",
)
_REAL = tuple(name for name, hint in _HINTS.items() if hint in (float, tuple[float, float]))
#: members of RopeState with the same name here
SAME_NAMED = tuple(name for name in RopeState._fields if name not in _CONVERTED)


class StateStructure(Structure):
    """Complete state, and events of the last advance, followed by the arrays.

    rubs: true if the wires rub and have a z.  switchings: instants of the latest swivel events of this advance, newest
    first.  switched and event_count stop at the size of the arrays of events.
    """

    _fields_ = (
        ("t", c_double),
        ("h", c_double),
        *((name, _type_of(_HINTS[name])) for name in _REAL),
        ("power_ends", c_double),
        ("power_swivel", c_double),
        ("switchings", c_double * CHATTER_EVENTS),
        *((name, _type_of(_HINTS[name])) for name in SAME_NAMED if name not in (*_REAL, "counts")),
        ("counts", _type_of(Counts)),
        ("pattern", PatternStructure),
        ("events", EventStructure * LOGGED_EVENTS),
        *(
            (name, c_int)
            for name in ("elements", "fidelity", "switched", "event_count", "rubs", "unused")
        ),
        ("fidelity_reason", c_char * MESSAGE),
    )


def state_structures() -> str:
    """Return the text of state_structures.h."""
    names = [phase.name for phase in Phase], HAPPENINGS, KINDS
    phases, happenings, kinds = (", ".join(map(str.upper, words)) for words in names)
    parts: tuple[type[Structure], ...] = (
        *PARTS.values(),
        PatternStructure,
        EventStructure,
        StateStructure,
    )
    sizes = (
        f"SEGMENTS = {SEGMENTS}, CHATTER_EVENTS = {CHATTER_EVENTS}, LOGGED_EVENTS = {LOGGED_EVENTS}"
    )
    return (
        "/* The state: generated by rope_model.codegen.state_structures. */\n"
        "#ifndef STATE_STRUCTURES_H\n#define STATE_STRUCTURES_H\n\n"
        '#include <stdint.h>\n\n#include "rope.h"\n\n'
        f"enum {{ {phases} }};\n/* kinds of bodies */\nenum {{ {kinds}, KINDS }};\n"
        f"enum {{ GUARDS = {len(CAUSES)}, {sizes} }};\n/* what happened */\nenum {{ {happenings} }};\n\n"
        + "\n".join(map(structure_code, parts))
        + _number_tables()
        + _arrays_code()
        + "\n#endif\n"
    )


def structure_code(kind: type[Structure]) -> str:
    """Return the definition of a structure in C."""
    members = ""
    for field, member_type in kind._fields_:  # type: ignore[misc]
        members += f"    {_member(field, member_type)};\n"
    comment = f"/* {cleandoc(kind.__doc__)} */\n" if kind.__doc__ else ""
    return f"{comment}typedef struct {{\n{members}}} {_name_of(kind)};\n"


def _member(field: str, of: Any) -> str:
    if hasattr(of, "_argtypes_"):
        taken = ", ".join(_TYPES[argument] for argument in of._argtypes_)
        return f"{_TYPES[of._restype_]}(*{field})({taken})"
    if isinstance(of, type(ctypes.POINTER(c_int))):
        return f"const {_member(f'(*{field})', of._type_)}"
    lengths, entry = _entries(of)
    array = "".join(f"[{length}]" for length in lengths)
    return f"{_NUMBERS.get(entry) or _name_of(entry)} {field}{array}"


def _name_of(kind: type[Structure]) -> str:
    return kind.__name__.removesuffix("Structure")


def _number_tables() -> str:
    """Return tables of the real numbers of a state, except those of its events, and of its counts."""
    reals = ", \\\n".join(
        f"    {{offsetof(State, {path}), {count}}}"
        for path, count in _numbers_in(StateStructure, c_double)
        if not path.startswith("events[")
    )
    counts = ", ".join(
        f"offsetof(Counts, {path})" for path, _ in _numbers_in(_type_of(Counts), c_int64)
    )
    return f"""
/* real numbers of a State, except those of its events: offsets, and how many lie there in a row */
#define STATE_REALS {{ \\
{reals}}}
#define COUNT_OFFSETS {{{counts}}}
"""


def _numbers_in(kind: type[Structure], number: Any, before: str = "") -> Iterator[tuple[str, int]]:
    """Return the members of this kind of number, by their path in C, with the number of them."""
    for field, member_type in kind._fields_:  # type: ignore[misc]
        lengths, of = _entries(member_type)
        path = f"{before}{field}"
        if of is number:
            yield path, prod(lengths)
        elif issubclass(of, Structure):
            for index in product(*map(range, lengths)):
                yield from _numbers_in(of, number, path + "".join(f"[{k}]" for k in index) + ".")


def _entries(of: Any) -> tuple[list[int], Any]:
    """Return the lengths of an array, [] for a number or structure, and the type of its entries."""
    lengths = []
    while issubclass(of, ctypes.Array):
        lengths.append(of._length_)
        of = of._type_
    return lengths, of


def _arrays_code() -> str:
    """Return the C text of the arrays behind a state."""
    steps = "".join(
        f"    x.{after} = x.{before} + size;\n" for before, after in pairwise((*ARRAYS, "lengths"))
    )
    return f"""
/* behind a state: nodes x DOF each, element lengths (elements), arc lengths of the nodes (nodes), and of a rope with
   friction between its wires z (elements x WIRE_Z) */
enum {{ FIELDS = {len(ARRAYS)}, WIRE_Z = {NO_HYSTERESIS.shape[1]} }};
typedef struct {{
    double *{", *".join((*ARRAYS, "lengths", "s", "z"))};
    int elements, nodes;
}} NodalArrays;

static inline NodalArrays state_arrays(State *state) {{
    NodalArrays x;
    x.elements = state->elements;
    x.nodes = state->elements + 1;
    const size_t size = (size_t)x.nodes * DOF;
    x.{ARRAYS[0]} = (double *)(state + 1);
{steps}    x.s = x.lengths + x.elements;
    x.z = x.s + x.nodes;
    return x;
}}
"""
