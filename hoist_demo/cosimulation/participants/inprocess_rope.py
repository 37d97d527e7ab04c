"""The balance rope in this process: the same RopePlant as the FMU, without the FMU.

It stands in for the FMU in comparisons and for debugging, and winds what one FMU cannot: duties, and several ropes.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, replace
from importlib.metadata import version
from operator import attrgetter
from typing import Any, Literal, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.fmu_parameters import FmuParameter
from hoist_demo.cosimulation.participants.rope_data import RopeData, Value, stamp, unstamp
from hoist_demo.cosimulation.schemes.interface import Reader
from hoist_demo.parameters.quantity import units_of
from hoist_demo.recording.fidelity import FIDELITY, code_of
from rope_model import (
    SIGNALS,
    BalanceRope,
    EndMotion,
    Level,
    RopeState,
    Scene,
    Shaft,
    Snapshot,
    Status,
    at_level,
    balance_rope,
)

_log = logging.getLogger(__name__)

_PARTS = {
    **{name: name for name in ("rope", "layout", "mesh", "accuracy", "solver", "model", "station")},
    **{f"{side}.swivel": side for side in ("left", "right")},
    **{field.name: f"shaft.{field.name}" for field in fields(Shaft)},
}
"""Part of the rope's data for each group of FMI names."""

_TAG = b"rope in process\n"


class InProcessRope:
    """A RopePlant around rope_model's BalanceRope."""

    def __init__(self, scene: Scene, read: Collection[str] | None = None) -> None:
        """`read` are the outputs that a run records; None: all."""
        self._rope = balance_rope(scene)
        self._told = None if read is None else tuple(name for name in SIGNALS if name in read)
        self._warned: set[str] = set()  # subjects of what was logged

    @property
    def whole(self) -> BalanceRope:
        """The rope itself."""
        return self._rope

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        """Find the hanging shape at t0 [s]."""
        self._warned.clear()
        return self._log_warnings(self._rope.initialize(t0, left, right))

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        """Advance to t + h [s]; the motions hold there."""
        return self._log_warnings(self._rope.advance_to(t + h, left, right))

    def _log_warnings(self, status: Status) -> Status:
        """The status; warnings about a valid state are logged, each of them once, as the FMU does it."""
        for subject, text in self._rope.warnings().items() if status.valid else ():
            if subject not in self._warned:
                self._warned.add(subject)
                _log.warning("%s", text)
        return status

    def signals(self) -> dict[str, float]:
        """All outputs by FMI name, and the fidelity by its code."""
        return self._rope.signals(self._told) | {FIDELITY: code_of(self._rope.fidelity)}

    def data(self) -> RopeData:
        """Identity of the rope: its engine, and all parameters by FMI name."""
        model = {"rope": f"in process, {type(self._rope).__name__}", "version": version("balance-rope")}
        reason = ""
        with suppress(RuntimeError):  # a rope that could not be initialised has no state
            reason = self._rope.fidelity_reason
        return replace(scene_parameters(self._rope.scene), model=model, fidelity_reason=reason)

    def reader(self, names: Sequence[str]) -> Reader:
        """A function that reads some outputs."""
        places = [k for k, name in enumerate(names) if name in SIGNALS]
        fidelities = [k for k, name in enumerate(names) if name == FIDELITY]
        read = self._rope.reader([names[k] for k in places])

        def values() -> NDArray[np.float64]:
            found = np.full(len(names), np.nan)
            found[places] = read()
            if fidelities:
                found[fidelities] = code_of(self._rope.fidelity)
            return found

        return values

    def save(self) -> Snapshot:
        """The state, which nothing changes."""
        return self._rope.snapshot()

    def restore(self, snapshot: Snapshot | RopeState) -> None:
        """Go on from a state."""
        self._rope.restore(snapshot)

    def to_bytes(self, snapshot: Snapshot) -> bytes:
        """The state as bytes."""
        return _TAG + stamp(snapshot.state.to_bytes(), self.data().parameters)

    def from_bytes(self, data: bytes) -> RopeState:
        """The state that these bytes hold."""
        if not data.startswith(_TAG):
            raise ValueError("the state must be that of a rope in process, it is of an FMU: give that with --fmu FILE")
        return RopeState.from_bytes(unstamp(data.removeprefix(_TAG), self.data().parameters))

    def units(self) -> dict[str, str]:
        """Unit of each output."""
        return {name: str(signal.unit) for name, signal in SIGNALS.items()} | {FIDELITY: "1"}

    def close(self) -> None:
        """Nothing is held."""


def rope_in_process(
    case: str,
    kernels: Literal["auto", "compiled", "portable"] = "auto",
    level: Level = "standard",
    parameters: Mapping[str, Value] | None = None,
) -> InProcessRope:
    """The rope of a named case at a level of accuracy, with other parameters by FMI name."""
    data = rope_data({**find_case(case).rope, **(parameters or {})}, level)
    return InProcessRope(data.with_(solver=replace(data.solver, kernels=kernels)))


def scene_parameters(scene: Scene) -> RopeData:
    """All parameters of a scene by FMI name."""
    values, units = dict[str, Value](), dict[str, str]()
    for group, part in _PARTS.items():
        data = attrgetter(part)(scene)
        for item, unit in _units(data).items():
            value = getattr(data, item)
            values[f"{group}.{item}"] = str(value) if isinstance(value, tuple) else value
            units[f"{group}.{item}"] = unit
    return RopeData({}, values, units)


def assumed_parameters() -> frozenset[str]:
    """FMI names of those parameters of which the default is ours, as their fields say."""
    return frozenset(
        f"{group}.{item.name}"
        for group, part in _PARTS.items()
        for item in fields(attrgetter(part)(Scene()))
        if "[assumed]" in item.metadata.get("description", "")
    )


def rope_parameters() -> dict[str, FmuParameter]:
    """List the parameters of a rope in process as an FMU would; the data classes know the bounds."""
    found = {}
    for group, part in _PARTS.items():
        data = attrgetter(part)(Scene())
        units, hints = _units(data), get_type_hints(type(data))
        for item, unit in units.items():
            name, value, words = f"{group}.{item}", getattr(data, item), get_args(hints[item])
            if isinstance(value, float):
                found[name] = FmuParameter(name, unit, "Real", value, None, None)
            elif isinstance(value, int):
                found[name] = FmuParameter(name, unit, "Integer", value, None, None)
            elif isinstance(value, str):
                found[name] = FmuParameter(name, unit, "Integer", words.index(value), 0.0, len(words) - 1.0)
    return found


def _units(data: Any) -> dict[str, str]:
    """FMI unit of each value of a part of the scene."""
    stated = units_of(type(data))
    return {field.name: stated.get(field.name, "1") for field in fields(data)}


def rope_data(parameters: Mapping[str, Value], level: Level = "standard") -> Scene:
    """The rope's data at a level, with parameters by FMI name as an FMU takes them: choices by their code."""
    return with_parameters(at_level(Scene(), level), parameters)


def with_parameters(data: Scene, parameters: Mapping[str, Value]) -> Scene:
    """``data`` with other parameters by FMI name."""
    chosen: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
        group, _, item = name.rpartition(".")
        part = attrgetter(_PARTS[group])(data) if group in _PARTS else None
        if part is None or item not in {f.name for f in fields(part)}:
            raise ValueError(f"{name} = {value!r} must be a parameter of the rope: see docs/reference/variables.md")
        chosen.setdefault(group, {})[item] = _decode(part, name, value)
    for group, values in chosen.items():
        try:
            data = _with_values(data, _PARTS[group].split("."), values)
        except ValueError as error:
            raise ValueError(f"{group}: {error}") from error
    return data


def _with_values(data: Any, path: Sequence[str], values: Mapping[str, Any]) -> Any:
    """``data`` with other values in the part at the end of ``path``."""
    if not path:
        return replace(data, **values)
    return replace(data, **{path[0]: _with_values(getattr(data, path[0]), path[1:], values)})


def _decode(part: Any, name: str, value: Value) -> Any:
    """A value as the field of this FMI name takes it: the word for the code of one that chooses."""
    words = get_args(get_type_hints(type(part))[name.rpartition(".")[2]])
    if not words:
        return value
    if value not in range(len(words)):
        codes = ", ".join(f"{code} {word}" for code, word in enumerate(words))
        raise ValueError(f"{name} = {value!r} is none of the choices: {codes}")
    return words[int(value)]
