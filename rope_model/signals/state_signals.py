"""Outputs that are functions of the state alone, as formulas: codegen.rules makes the C of them."""

from types import SimpleNamespace
from typing import Any

from rope_model.boundary.input_filter import InputFilter
from rope_model.physics.contact_error import ContactSums
from rope_model.physics.elementary import SMALLEST_DIVISOR, Scalar, less, maximum, sqrt
from rope_model.physics.energy_balance import EnergyBalance, residual, total
from rope_model.physics.guard import GuardState
from rope_model.physics.shaft import KINDS
from rope_model.state import NOT_NEAR, Counts, Crossing, Nearest, RopeState

#: counts that are signals count.*; that of steps with accuracy given up is one of status.*
COUNTED = tuple(name for name in Counts._fields if name != "given_up")


def remembered(state: RopeState) -> dict[str, Scalar]:
    """Return the values of these signals by name; entries of ``state`` may be symbols."""
    crossing = state.crossing
    guard = state.guard
    left, right = state.filters
    values = {
        "loop.crossings": crossing.number,
        "loop.crossed_at": crossing.since,
        "loop.crossed_y": crossing.y,
        "loop.overlap": crossing.overlap,
        "loop.touched_at": crossing.touched_at,
        "loop.touched_y": crossing.touched_y,
        "status.given_up": state.counts.given_up,
        "status.given_up_since": state.given_up_since,
        "guard.tripped": less(0.0, guard.cause),
        "inputs.repeated": maximum(left.repetitions.number, right.repetitions.number),
        "energy.total": total(state.energy_balance),
        "energy.residual": residual(state.energy_balance),
    }
    values |= {
        f"energy.{name}": getattr(state.energy_balance, name)
        for name in EnergyBalance._fields
        if name != "start"
    }
    values |= {"guard.cause": guard.cause, "guard.time": guard.time}
    values |= {f"count.{name}": getattr(state.counts, name) for name in COUNTED}
    for k, name in enumerate(("position", "speed", "acceleration")):
        values[f"inputs.misfit.{name}"] = maximum(
            *(getattr(x.misfits, name) for x in (left, right))
        )
        squares = maximum(left.misfits.squares[k], right.misfits.squares[k])
        mean = squares / maximum(left.misfits.time, SMALLEST_DIVISOR)
        values[f"inputs.misfit.{name}_rms"] = sqrt(mean)
    impulses = zip((*KINDS, "rope"), state.contact.impulses, strict=True)
    values |= {f"contact.{kind}.impulse": impulse for kind, impulse in impulses}
    for kind, nearest in zip(KINDS, state.nearest, strict=True):
        values |= {f"nearest.{kind}.{name}": getattr(nearest, name) for name in Nearest._fields}
    return values


#: the members of a state that these signals depend on
_START: Any = SimpleNamespace(
    crossing=Crossing(),
    guard=GuardState(),
    filters=(InputFilter(),) * 2,
    counts=Counts(),
    given_up_since=0.0,
    energy_balance=EnergyBalance(),
    contact=ContactSums(),
    nearest=NOT_NEAR,
)
#: names of these signals
STATE_SIGNALS = tuple(remembered(_START))
