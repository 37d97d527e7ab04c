"""Identity of a rope for the reports: source, parameters, and level of accuracy."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

from rope_model import CHOICES

Value = float | int | bool | str

Levels = Mapping[str, Mapping[str, Value]]
"""Parameters of the mesh, the solver and the model by FMI name, for each level of accuracy."""

_FREE = "solver.kernels"
"""What may differ when a run goes on."""

_TORQUE = ("rope.Qb", "rope.Qc", "rope.installed_twist", "rope.initial_curvature")


def code(name: str, word: str) -> int | None:
    """The code of a word that a parameter may have; None where it has no such word."""
    words = words_of(name)
    return words.index(word) if word in words else None


def words_of(name: str) -> tuple[str, ...]:
    """The words of a parameter's codes; none where it has no choices."""
    return tuple(CHOICES.get(".".join(name.split(".")[-2:]), ()))


def stamp(state: bytes, parameters: Mapping[str, Value]) -> bytes:
    """A rope's state behind a line with the parameters that it belongs to."""
    return json.dumps(dict(parameters), sort_keys=True).encode() + b"\n" + state


def unstamp(data: bytes, parameters: Mapping[str, Value]) -> bytes:
    """The state that `stamp` was given; ValueError where it belongs to other parameters."""
    stamp, _, state = data.partition(b"\n")
    try:
        there = json.loads(stamp)
    except ValueError as error:
        raise ValueError("the state must tell its rope's parameters: give a checkpoint of this version") from error
    names = sorted({*there, *parameters} - {_FREE})
    differences = [
        f"{name} is {there.get(name, 'missing')} there, {parameters.get(name, 'missing')} here"
        for name in names
        if there.get(name) != parameters.get(name)
    ]
    if differences:
        raise ValueError(f"the rope's parameters must be those of the state, but {', '.join(differences)}: set them so")
    return state


@dataclass(frozen=True)
class RopeData:
    """One rope of a run; parameters by FMI name."""

    model: Mapping[str, str]  # what it is and where it comes from
    parameters: Mapping[str, Value]
    units: Mapping[str, str]  # as FMI spells them, "1" for a pure number
    fidelity_reason: str = ""  # why the fidelity runs that runs

    @property
    def torque_free(self) -> bool:
        """Return True if the rope carries no torque with ends that do not turn; unknown parameters count as torque."""
        return all(self.parameters.get(name) == 0.0 for name in _TORQUE)

    @property
    def locked(self) -> tuple[str, ...]:
        """List the ends whose swivel is locked."""
        modes = {end: f"{end}.swivel.mode" for end in ("left", "right")}
        return tuple(end for end, mode in modes.items() if self._code(mode) == code(mode, "locked"))

    def display(self, name: str) -> Value:
        """A parameter's value, a code with its word."""
        value, words = self.parameters[name], words_of(name)
        return f"{value} ({words[value]})" if isinstance(value, int) and 0 <= value < len(words) else value

    def level(self, levels: Levels) -> str:
        """Name of the level whose parameters these are, "" for none."""
        for name, wanted in levels.items():
            if all(self._code(key) == value for key, value in wanted.items()):
                return name
        return ""

    def _code(self, name: str) -> Value | None:
        """A parameter's value, a word as its code: a rope in process has words where an FMU has codes."""
        value = self.parameters.get(name)
        return value if not isinstance(value, str) or (number := code(name, value)) is None else number
