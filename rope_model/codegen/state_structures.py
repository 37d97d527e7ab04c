"""Layout of the state in memory, for ctypes and for C: structures, and the arrays behind them.

A class is the structure; its docstring becomes the comment in C.  The header state.h is printed from here.
"""

from __future__ import annotations

import ctypes
from ctypes import Structure, c_char, c_double, c_int, c_int64
from inspect import cleandoc
from itertools import pairwise
from typing import Any

from rope_model.physics.accuracy import ErrorSums
from rope_model.physics.contact_error import ContactSums
from rope_model.physics.guard import CAUSES, GuardState
from rope_model.physics.shaft import KINDS
from rope_model.simulation.ends.ends import Phase
from rope_model.simulation.ends.following import Following
from rope_model.simulation.ends.paths import PATH
from rope_model.simulation.ends.switching import CHATTER
from rope_model.simulation.outputs.audit import Audit
from rope_model.simulation.state import Counts, Crossing, EnergyBalance, Nearest
from rope_model.simulation.wires import NO_MEMORY

MESSAGE, SEGMENTS, CHATTER_EVENTS, LOGGED_EVENTS = 512, 7, CHATTER[0], 128
#: kinds of events
HAPPENINGS = ("transformed", "sticks", "slips_forward", "slips_back", "raised")
#: arrays of the nodes, 7 numbers each; behind them the lengths of the elements and the arc lengths of the nodes
ARRAYS = ("q", "v", "a", "b", "a_rate", "reaction")
_NUMBERS: dict[Any, str] = {c_double: "double", c_int: "int", c_int64: "int64_t", c_char: "char"}


def _array_type(zero: Any) -> Any:
    """The type of a number, or of nested tuples of numbers alike."""
    return _array_type(zero[0]) * len(zero) if isinstance(zero, tuple) else c_double


class PathStructure(Structure):
    """A quintic in s = t - start for each of x, y, z and yaw; held from stop on."""

    _fields_ = (("start", c_double), ("stop", c_double), ("coefficients", c_double * 6 * len(PATH)))


class FollowingStructure(Structure):
    """rope_model.simulation.ends.following.Following."""

    _fields_ = tuple((name, _array_type(zero)) for name, zero in Following()._asdict().items())


class SwivelStructure(Structure):
    """State of a swivel: relative angle b while it holds, sign of b_t while it slips."""

    _fields_ = (("angle", c_double), ("sign", c_double), ("phase", c_int), ("unused", c_int))


class EnergyStructure(Structure):
    """rope_model.simulation.state.EnergyBalance."""

    _fields_ = tuple((name, c_double) for name in EnergyBalance._fields)


class ErrorStructure(Structure):
    """rope_model.physics.accuracy.ErrorSums."""

    _fields_ = tuple((name, _array_type(zero)) for name, zero in ErrorSums()._asdict().items())


class ContactStructure(Structure):
    """rope_model.physics.contact_error.ContactSums."""

    _fields_ = tuple(
        (name, c_double * len(zero) if isinstance(zero, tuple) else c_double)
        for name, zero in ContactSums()._asdict().items()
    )


class AuditStructure(Structure):
    """rope_model.simulation.outputs.audit.Audit."""

    _fields_ = tuple((name, _array_type(zero)) for name, zero in Audit()._asdict().items())


class NearestStructure(Structure):
    """rope_model.simulation.state.Nearest."""

    _fields_ = tuple((name, c_double) for name in Nearest._fields)


class CrossingStructure(Structure):
    """rope_model.simulation.state.Crossing."""

    _fields_ = tuple((name, c_double) for name in Crossing._fields)


class GuardStructure(Structure):
    """rope_model.physics.guard.GuardState."""

    _fields_ = tuple((name, _array_type(zero)) for name, zero in GuardState()._asdict().items())


class CountsStructure(Structure):
    """rope_model.simulation.state.Counts."""

    _fields_ = tuple((name, c_int64) for name in Counts._fields)


class PatternStructure(Structure):
    """The pattern of TMN-ETM; coarse = 0 for EEM."""

    _fields_ = (("coarse", c_double), ("grading_length", c_double), ("counts", c_int * SEGMENTS), ("end_levels", c_int))


class EventStructure(Structure):
    """An event; which: side of the swivel, or the new fidelity."""

    _fields_ = (("t", c_double), ("kinetic", c_double), ("potential", c_double), ("what", c_int), ("which", c_int))


class StateStructure(Structure):
    """Complete state, and events of the last advance; the arrays lie behind it.

    rubs: whether the wires rub on each other, and remember z.
    switchings: instants of the last swivel events of this advance, newest first.  switched and event_count end with the
    room for events.
    """

    _fields_ = (
        *(
            (name, c_double)
            for name in (
                *("t", "h", "step_next", "last_interval", "loop_yaw", "snapped_at", "calm_since"),
                "given_up_since",
                "looked_at",
            )
        ),
        ("offsets", c_double * 2),
        ("force_mean", c_double * 2),
        ("power_ends", c_double),
        ("power_swivel", c_double),
        ("switchings", c_double * CHATTER_EVENTS),
        ("swivels", SwivelStructure * 2),
        ("paths", PathStructure * 2),
        ("following", FollowingStructure * 2),
        ("pattern", PatternStructure),
        ("events", EventStructure * LOGGED_EVENTS),
        ("energy_balance", EnergyStructure),
        ("errors", ErrorStructure),
        ("contact", ContactStructure),
        ("audit", AuditStructure),
        ("nearest", NearestStructure * len(KINDS)),
        ("crossing", CrossingStructure),
        ("guard", GuardStructure),
        ("counts", CountsStructure),
        *((name, c_int) for name in ("elements", "fidelity", "switched", "event_count", "rubs", "unused")),
        ("fidelity_reason", c_char * MESSAGE),
    )


#: their names in C
NAMES: dict[Any, str] = {
    PathStructure: "Path",
    FollowingStructure: "Following",
    SwivelStructure: "SwivelState",
    EnergyStructure: "EnergyBalance",
    ErrorStructure: "ErrorSums",
    ContactStructure: "ContactSums",
    AuditStructure: "Audit",
    NearestStructure: "Nearest",
    CrossingStructure: "Crossing",
    GuardStructure: "GuardState",
    CountsStructure: "Counts",
    PatternStructure: "Pattern",
    EventStructure: "Event",
    StateStructure: "State",
}


def state_structures() -> str:
    """The text of state.h."""
    names = [phase.name for phase in Phase], HAPPENINGS, KINDS
    phases, happenings, kinds = (", ".join(map(str.upper, words)) for words in names)
    sizes = f"SEGMENTS = {SEGMENTS}, CHATTER_EVENTS = {CHATTER_EVENTS}, LOGGED_EVENTS = {LOGGED_EVENTS}"
    return (
        "/* The state: generated by rope_model.codegen.state_structures. */\n#ifndef STATE_H\n#define STATE_H\n\n"
        '#include <stdint.h>\n\n#include "rope.h"\n\n'
        f"enum {{ {phases} }};\n/* kinds of bodies */\nenum {{ {kinds}, KINDS }};\n"
        f"enum {{ GUARDS = {len(CAUSES)}, {sizes} }};\n/* what happened */\nenum {{ {happenings} }};\n\n"
        + "\n".join(structure_code(kind, name, NAMES) for kind, name in NAMES.items())
        + _arrays_code()
        + "\n#endif\n"
    )


def structure_code(kind: type[Structure], name: str, names: dict[Any, str]) -> str:
    """The definition in C of a structure; ``names`` has those of the structures in it."""
    members = "".join(f"    {_member(field, of, names)};\n" for field, of in kind._fields_)  # type: ignore[misc]
    comment = f"/* {cleandoc(kind.__doc__)} */\n" if kind.__doc__ else ""
    return f"{comment}typedef struct {{\n{members}}} {name};\n"


def _member(field: str, of: Any, names: dict[Any, str]) -> str:
    lengths = ""
    while issubclass(of, ctypes.Array):
        lengths, of = f"{lengths}[{of._length_}]", of._type_
    return f"{_NUMBERS.get(of) or names[of]} {field}{lengths}"


def _arrays_code() -> str:
    """The arrays behind a state, and where they are."""
    steps = "".join(f"    x.{after} = x.{before} + size;\n" for before, after in pairwise((*ARRAYS, "lengths")))
    return f"""
/* behind a state: nodes x DOF each, element lengths (elements), arc lengths of the nodes (nodes), and of a rope with
   friction between its wires z (elements x WIRE_Z) */
enum {{ FIELDS = {len(ARRAYS)}, WIRE_Z = {NO_MEMORY.shape[1]} }};
typedef struct {{
    double *{", *".join((*ARRAYS, "lengths", "s", "z"))};
    int elements, nodes;
}} Arrays;

static inline Arrays state_arrays(State *state) {{
    Arrays x;
    x.elements = state->elements;
    x.nodes = state->elements + 1;
    const size_t size = (size_t)x.nodes * DOF;
    x.{ARRAYS[0]} = (double *)(state + 1);
{steps}    x.s = x.lengths + x.elements;
    x.z = x.s + x.nodes;
    return x;
}}
"""
