"""Memory layout of the state, for ctypes and for C (state.h): structures, and the arrays behind them.

A class is a structure, its docstring the comment in C; a part of RopeState has a structure with the members of its
named tuple.
"""

import ctypes
from ctypes import Structure, c_char, c_double, c_int, c_int64
from inspect import cleandoc
from itertools import pairwise
from typing import Any, get_args, get_origin, get_type_hints

from rope_model.physics.guard import CAUSES
from rope_model.physics.shaft import KINDS
from rope_model.simulation.ends.switching import CHATTER_EVENTS
from rope_model.simulation.ends.swivel_phases import Phase, SwivelState
from rope_model.simulation.mesh.partition import NO_DIVIDERS
from rope_model.simulation.state import Counts, RopeState
from rope_model.simulation.wires import NO_HYSTERESIS

MESSAGE = 512  #: bytes of a message
SEGMENTS = 7  #: segments of TMN-ETM
LOGGED_EVENTS = 128  #: largest number of events of an advance in the state
#: kinds of events
HAPPENINGS = ("transformed", "sticks", "slips_forward", "slips_back", "raised")
#: arrays of the nodes, 7 numbers each; behind them are element lengths and arc lengths of the nodes
ARRAYS = ("q", "v", "a", "b", "a_rate", "reaction")
_NUMBERS: dict[Any, str] = {c_double: "double", c_int: "int", c_int64: "int64_t", c_char: "char"}


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
        name, where = hint.__name__.removeprefix("End"), f"{hint.__module__}.{hint.__name__}."
        members = [(member, _type_of(part)) for member, part in get_type_hints(hint).items()]
        PARTS[hint] = type(
            f"{name}Structure", (Structure,), {"__doc__": where, "_fields_": members}
        )
    return PARTS[hint]


class PatternStructure(Structure):
    """Pattern of TMN-ETM; coarse = 0 for EEM."""

    _fields_ = (
        *(
            ("coarse", c_double),
            ("grading_length", c_double),
            ("counts", c_int * SEGMENTS),
            ("end_levels", c_int),
        ),
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
_OTHERS = ("motion", "partition", "fidelity", "fidelity_reason", "events", "powers", "hysteresis")
_REAL = tuple(name for name, hint in _HINTS.items() if hint in (float, tuple[float, float]))
#: members of RopeState with the same name here
ALIKE = tuple(name for name in RopeState._fields if name not in _OTHERS)


class StateStructure(Structure):
    """Complete state, and events of the last advance, followed by the arrays.

    state.c depends on this order: real numbers before the swivels, and from the energy balance to the counts.  rubs:
    true if the wires rub and have a z.  switchings: instants of the latest swivel events of this advance, newest first.
    switched and event_count stop at the size of the arrays of events.
    """

    _fields_ = (
        ("t", c_double),
        ("h", c_double),
        *((name, _type_of(_HINTS[name])) for name in _REAL),
        ("power_ends", c_double),
        ("power_swivel", c_double),
        ("switchings", c_double * CHATTER_EVENTS),
        *((name, _type_of(_HINTS[name])) for name in ALIKE if name not in (*_REAL, "counts")),
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
    """Return the text of state.h."""
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
        "/* The state: generated by rope_model.codegen.state_structures. */\n#ifndef STATE_H\n#define STATE_H\n\n"
        '#include <stdint.h>\n\n#include "rope.h"\n\n'
        f"enum {{ {phases} }};\n/* kinds of bodies */\nenum {{ {kinds}, KINDS }};\n"
        f"enum {{ GUARDS = {len(CAUSES)}, {sizes} }};\n/* what happened */\nenum {{ {happenings} }};\n\n"
        + "\n".join(map(structure_code, parts))
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
    lengths = ""
    while issubclass(of, ctypes.Array):
        lengths, of = f"{lengths}[{of._length_}]", of._type_
    return f"{_NUMBERS.get(of) or _name_of(of)} {field}{lengths}"


def _name_of(kind: type[Structure]) -> str:
    return kind.__name__.removesuffix("Structure")


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
