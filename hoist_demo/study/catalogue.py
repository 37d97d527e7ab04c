"""Keys of a study: the host's data as `section.field`, and the FMU's parameters by name.

Every value is checked for its unit, its type and, one at a time, its bounds: the data classes check themselves, and
the FMU is asked to initialize with the value.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hoist_demo.control.controller import Gains
from hoist_demo.cosimulation.participants.fmu_parameters import FmuParameter
from hoist_demo.cosimulation.participants.rope_data import words_of
from hoist_demo.design.controllers import CONTROLLERS
from hoist_demo.design.optimal_trajectory import TrajectoryOptions
from hoist_demo.design.shaping import Shaper
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.units import fmi_unit
from hoist_demo.study.metrics import Arrival
from hoist_demo.study.nested import leaves

Value = float | int | bool | str

SECTIONS: dict[str, type[Any]] = {
    "hoist": Hoist,
    "winding": Winding,
    "coupling": Coupling,
    "gains": Gains,
    "shaper": Shaper,
    "trajectory": TrajectoryOptions,
    "arrival": Arrival,
}

RESERVED = {"inputs_at_step_end": "the host sets it"}
RENAMED = {"model.rung": ["model.fidelity"], "mesh.leg_growth": ["mesh.grading_length"]}
"""Names of version 0.1.0 and those of today."""


def word_of(choices: Iterable[str], value: object) -> str | None:
    """The choice that a text is, whatever its case; None where it is none."""
    return next((word for word in choices if isinstance(value, str) and word.lower() == value.lower()), None)


@dataclass(frozen=True)
class Parameter:
    """A key that a study may set."""

    key: str
    unit: str  # as FMI spells it
    kind: str  # Real, Integer, Boolean or String
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()  # words of a text, or of the codes of a number

    def read(self, value: object) -> Value:
        """The value in the parameter's type; a `ValueError` names key, value and cure."""
        bad = f"{self.key} = {value!r}"
        if self.kind == "Boolean":
            if not isinstance(value, bool):
                raise ValueError(f"{bad} must be true or false: write one of them")
            return value
        if self.kind == "String":
            word = word_of(self.choices, value) if self.choices else value
            if not isinstance(word, str):
                what = f"one of {', '.join(self.choices)}" if self.choices else "a text"
                raise ValueError(f"{bad} must be {what}: choose one")
            return word
        if self.choices:
            value = self._code(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ValueError(f"{bad} must be a finite number: give it in {self._unit}")
        if self.kind != "Real" and float(value) != round(value):
            raise ValueError(f"{bad} must be a whole number: round it")
        if (self.minimum is not None and value < self.minimum) or (self.maximum is not None and value > self.maximum):
            low, high = (-math.inf if self.minimum is None else self.minimum), self.maximum
            bound = f"at least {low:g}" if high is None else f"within {low:g} and {high:g}"
            raise ValueError(f"{bad} must be {bound}: give it in {self._unit}")
        return float(value) if self.kind == "Real" else round(value)

    def _code(self, value: object) -> object:
        """The code of a choice, given by code or by word."""
        code = self.choices.index(word) if (word := word_of(self.choices, value)) else value
        if isinstance(code, bool) or code not in range(len(self.choices)):
            known = ", ".join(f"{k} ({word})" for k, word in enumerate(self.choices))
            raise ValueError(f"{self.key} = {value!r} must be one of {known}: give code or word")
        return code

    @property
    def _unit(self) -> str:
        return "plain numbers" if self.unit == "1" else self.unit


class Catalogue:
    """All parameters of runs with a rope that has these parameters; {} for those of the host only."""

    def __init__(self, rope: Mapping[str, FmuParameter]) -> None:
        self._parameters = {"controller": Parameter("controller", "1", "String", choices=CONTROLLERS)}
        for section, data in SECTIONS.items():
            for leaf in leaves(data):
                key = f"{section}.{leaf.name}"
                self._parameters[key] = Parameter(key, leaf.unit, leaf.kind, choices=leaf.choices)
        for name, p in rope.items():
            if name not in RESERVED:
                kind = "Integer" if p.kind == "Enumeration" else p.kind
                self._parameters[name] = Parameter(name, fmi_unit(p.unit), kind, p.minimum, p.maximum, words_of(name))

    def __contains__(self, key: str) -> bool:
        return key in self._parameters

    def __getitem__(self, key: str) -> Parameter:
        """The parameter; a `ValueError` for an unknown key names the nearest ones."""
        if key in RESERVED:
            raise ValueError(f"{key} cannot be chosen, {RESERVED[key]}: leave it out")
        if key not in self._parameters:
            near = RENAMED.get(key) or [name for name in self._parameters if name.lower() == key.lower()]
            near = near or difflib.get_close_matches(key, self._parameters, n=3)
            near = near or [name for name in self._parameters if name.split(".")[-1] == key.split(".")[-1]]
            cure = (
                f"did you mean {' or '.join(near)}?" if near else f"sections are {', '.join(SECTIONS)}, or an FMU name"
            )
            raise ValueError(f"{key} is not a parameter: {cure}")
        return self._parameters[key]

    def units(self, keys: Mapping[str, Any]) -> dict[str, str]:
        """Unit of each key."""
        return {key: self[key].unit for key in keys}
