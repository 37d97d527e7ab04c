"""C text of the signals that are formulas of the state: the header state_signals.h."""

from __future__ import annotations

import ctypes
from types import SimpleNamespace
from typing import Any

import casadi as ca

from ..numerics.program import no_simplification
from ..simulation.outputs.state_signals import STATE_SIGNALS
from .formulas import texts_of
from .state_structures import StateStructure
from .tables import constant


def state_signals() -> str:
    """The text of state_signals.h: the signals of simulation.outputs.state_signals."""
    state = members_at(StateStructure, "state->")
    values = [value(state) for value in STATE_SIGNALS.values()]
    with no_simplification():
        lines, texts = texts_of(values)
    lines += [f"values[{constant(name)}] = {text};" for name, text in zip(STATE_SIGNALS, texts, strict=True)]
    return (
        "/* Generated from rope_model.simulation.outputs.state_signals by rope_model.codegen.state_values. */\n"
        "static void state_signals(Simulator *rope, double *values) {\n    const State *state = rope->state;\n"
        f"{''.join(f'    {line}{chr(10)}' for line in lines)}}}\n"
    )


def members_at(kind: Any, place: str) -> Any:
    """Symbols for the numbers of a structure, or of an array, at this place in C."""
    if issubclass(kind, ctypes.Structure):
        place += "" if place.endswith("->") else "."
        return SimpleNamespace(**{name: members_at(of, f"{place}{name}") for name, of in kind._fields_})
    if issubclass(kind, ctypes.Array):
        return tuple(members_at(kind._type_, f"{place}[{k}]") for k in range(kind._length_))
    return ca.SX.sym(place if kind is ctypes.c_double else f"(double){place}")
