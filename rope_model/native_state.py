"""State of the native rope as bytes: the structures of the C engine to the words of ``RopeState``, and back.

``unpack`` and ``pack`` are inverse to each other.  Bytes that are kept in a file begin with a digest
of the memory layout, which another version of rope_model may have changed.
"""

import ctypes
import hashlib
from collections.abc import Callable
from functools import cache
from itertools import cycle
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from rope_model.codegen import state_structures as layout
from rope_model.method.generalized_alpha import Motion
from rope_model.method.partition import Partition
from rope_model.method.swivel_phases import Phase
from rope_model.physics.energy_balance import Powers
from rope_model.physics.node import NODE_DOF, SIDES
from rope_model.solver_parameters import FidelityChoice
from rope_model.state import NO_HYSTERESIS, Event, RopeState

_SWITCHES = ("sticks", "slips +", "slips -")
_FIDELITY_NAMES = get_args(FidelityChoice)


def _event(event: layout.EventStructure) -> Event:
    """Return the event with its words."""
    side = SIDES[event.which % 2]
    fidelity = _FIDELITY_NAMES[event.which]
    words = (
        "transformation",
        *(f"{side} swivel {does}" for does in _SWITCHES),
        f"model {fidelity}",
    )
    return Event(event.t, words[event.what], event.kinetic, event.potential)


@cache
def _layout_digest() -> bytes:
    """Return a digest of the memory layout: another version of rope_model may have another one."""
    return hashlib.sha256(layout.state_structures().encode()).digest()


def with_layout_digest(native: bytes) -> bytes:
    """Return a state in the memory layout, behind the digest of the layout, for a file."""
    return _layout_digest() + native


def without_layout_digest(data: bytes) -> bytes:
    """Return the state that ``with_layout_digest`` was given; ValueError if the layout is another one."""
    if not data.startswith(_layout_digest()):
        raise ValueError(
            "the saved state has the layout of another version of rope_model: "
            "restore it with that version, or save it anew"
        )
    return data.removeprefix(_layout_digest())


def unpack(data: bytes) -> RopeState:
    """Return the state in ``data``: a StateStructure, and behind it the arrays of nodes and elements.

    These are ARRAYS (n + 1, 7) in turn, n lengths, n + 1 arc lengths, and z (n, ...) of a rope whose
    wires rub.
    """
    s = layout.StateStructure.from_buffer_copy(data)
    n = s.elements
    numbers = np.frombuffer(data, dtype=np.float64, offset=ctypes.sizeof(layout.StateStructure))
    size = NODE_DOF * (n + 1)
    x = {
        name: numbers[i * size : (i + 1) * size].reshape(n + 1, NODE_DOF).copy()
        for i, name in enumerate(layout.ARRAYS)
    }
    lengths_at = len(layout.ARRAYS) * size
    hysteresis_at = lengths_at + n + (n + 1)
    hysteresis = NO_HYSTERESIS
    if s.rubs:
        z = numbers[hysteresis_at : hysteresis_at + n * NO_HYSTERESIS.shape[1]]
        hysteresis = z.reshape(n, -1).copy()
    return RopeState(
        **{name: read(getattr(s, name)) for name, read in _READERS.items()},
        motion=Motion(
            t=s.t,
            q=x["q"],
            v=x["v"],
            a=x["a"],
            b=x["b"],
            a_rate=x["a_rate"],
            h=s.h,
            reaction=x["reaction"],
        ),
        partition=Partition(
            lengths=numbers[lengths_at : lengths_at + n].copy(),
            counts=tuple(s.pattern.counts),
            coarse=s.pattern.coarse,
            end_levels=s.pattern.end_levels,
            grading_length=s.pattern.grading_length,
            windows=tuple(s.pattern.windows),
        ),
        fidelity=_FIDELITY_NAMES[s.fidelity],
        fidelity_reason=s.fidelity_reason.decode(),
        events=tuple(_event(event) for event in s.events[: s.event_count]),
        powers=Powers(s.power_ends, s.power_swivel),
        hysteresis=hysteresis,
    )


def pack(state: RopeState) -> bytes:
    """Return the state in the memory layout; the inverse of ``unpack``."""
    m = state.motion
    p = state.partition
    s = layout.StateStructure(
        **{name: _to_ctypes(getattr(state, name)) for name in layout.SAME_NAMED},
        t=m.t,
        h=m.h,
        power_ends=state.powers.ends,
        power_swivel=state.powers.swivel,
        pattern=layout.PatternStructure(
            p.coarse, p.grading_length, p.counts, p.end_levels, p.windows
        ),
        elements=p.lengths.size,
        fidelity=_FIDELITY_NAMES.index(state.fidelity),
        fidelity_reason=state.fidelity_reason.encode()[: layout.MESSAGE - 1],
        rubs=state.hysteresis.size > 0,
    )
    nodal = [getattr(m, name) for name in layout.ARRAYS]
    arrays = [*nodal, p.lengths, p.nodes_s, state.hysteresis]
    return bytes(s) + b"".join(array.tobytes() for array in arrays)


@cache
def _reader(hint: Any) -> Callable[[Any], Any]:
    """Return the function that makes the Python value, of the type ``hint``, of a ctypes value."""
    if get_origin(hint) is tuple:
        readers = [_reader(part) for part in get_args(hint) if part is not ...]
        return lambda x: tuple(read(part) for read, part in zip(cycle(readers), x, strict=False))
    if hint in layout.PARTS:
        members = [(name, _reader(part)) for name, part in get_type_hints(hint).items()]
        return lambda x: hint(*(read(getattr(x, name)) for name, read in members))
    if hint is Phase:
        return Phase
    return lambda x: x


_READERS = {
    name: _reader(hint)
    for name, hint in get_type_hints(RopeState).items()
    if name in layout.SAME_NAMED
}


def _to_ctypes(x: Any) -> Any:
    """Return ``x`` as a ctypes value; the inverse of ``_reader``."""
    if type(x) in layout.PARTS:
        return layout.PARTS[type(x)](**{name: _to_ctypes(getattr(x, name)) for name in x._fields})
    if isinstance(x, tuple):
        return tuple(map(_to_ctypes, x))
    if isinstance(x, Phase):
        return x.value
    return x
