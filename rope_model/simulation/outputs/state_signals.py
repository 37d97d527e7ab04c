"""Outputs that the state remembers, each as a formula of the state: codegen.rules makes the C of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import Any

from rope_model.physics.accuracy import TINY
from rope_model.physics.elementary import larger, less, sqrt
from rope_model.physics.energy_balance import residual, total
from rope_model.physics.shaft import KINDS
from rope_model.simulation.ends.paths import SIDES
from rope_model.simulation.outputs.signal_table import SIGNALS
from rope_model.simulation.state import EnergyBalance, Nearest


def _force_mean(side: int, state: Any) -> Any:
    return state.force_mean[side]


def _nearest(kind: int, key: str, state: Any) -> Any:
    return getattr(state.nearest[kind], key)


def _largest_misfit(name: str, state: Any) -> Any:
    left, right = state.following
    return larger(getattr(left, name), getattr(right, name))


def _misfit_rms(k: int, state: Any) -> Any:
    left, right = state.following
    return sqrt(larger(left.squares[k], right.squares[k]) / larger(left.time, TINY))


def _repeated(state: Any) -> Any:
    left, right = state.following
    return larger(left.repeats, right.repeats)


def _impulse(kind: int, state: Any) -> Any:
    return state.contact.impulses[kind]


def _guard_tripped(state: Any) -> Any:
    return less(0.0, state.guard.cause)


def _energy(sum_of: Callable[[Any], Any], state: Any) -> Any:
    return sum_of(state.energy_balance)


#: signals with the same name in a part of the state
_ALIKE = {"energy": ("energy_balance", EnergyBalance._fields), "guard": ("guard", ("cause", "time"))}
_ALIKE["count"] = "counts", tuple(name.removeprefix("count.") for name in SIGNALS if name.startswith("count."))

STATE_SIGNALS: dict[str, Callable[[Any], Any]] = {
    "loop.crossings": attrgetter("crossing.number"),
    "loop.crossed_at": attrgetter("crossing.since"),
    "loop.crossed_y": attrgetter("crossing.y"),
    "loop.overlap": attrgetter("crossing.overlap"),
    "loop.touched_at": attrgetter("crossing.touched_at"),
    "loop.touched_y": attrgetter("crossing.touched_y"),
    "status.given_up": attrgetter("counts.given_up"),
    "status.given_up_since": attrgetter("given_up_since"),
    "guard.tripped": _guard_tripped,
    "inputs.repeated": _repeated,
    "energy.total": partial(_energy, total),
    "energy.residual": partial(_energy, residual),
}
STATE_SIGNALS |= {
    f"{of}.{name}": attrgetter(f"{part}.{name}")
    for of, (part, names) in _ALIKE.items()
    for name in names
    if f"{of}.{name}" in SIGNALS
}
for _k, _name in enumerate(("position", "speed", "acceleration")):
    STATE_SIGNALS[f"inputs.misfit.{_name}"] = partial(_largest_misfit, _name)
    STATE_SIGNALS[f"inputs.misfit.{_name}_rms"] = partial(_misfit_rms, _k)
STATE_SIGNALS |= {f"{side}.fy_mean": partial(_force_mean, k) for k, side in enumerate(SIDES)}
STATE_SIGNALS |= {f"contact.{kind}.impulse": partial(_impulse, k) for k, kind in enumerate((*KINDS, "rope"))}
STATE_SIGNALS |= {
    f"nearest.{kind}.{key}": partial(_nearest, k, key) for k, kind in enumerate(KINDS) for key in Nearest._fields
}
