"""Identity of a rope for the reports: source, parameters, and level of accuracy."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from hoist_demo.cosimulation.participants.identity import differences
from hoist_demo.parameters import SIDES
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import Level, Scene, at_level
from rope_model.physics.initial_curvature import CURVATURES
from rope_model.scene_names import choices_of, named_parameters

_LEVEL_GROUPS = ("mesh.", "solver.", "model.")  #: Groups of numbers that a level of accuracy sets.
_LEVEL_CHOICES = ("mesh.kind", "model.fidelity")  #: Choices that a level of accuracy sets.
_TORQUE = tuple(f"rope.{name}" for name in ("Qb", "Qc", "installed_twist", *CURVATURES))


def stamp(state: bytes, parameters: Mapping[str, Value]) -> bytes:
    """Prepend a line with parameters that a rope's state belongs to, and does not hold itself."""
    return json.dumps(dict(parameters), sort_keys=True).encode() + b"\n" + state


def unstamp(data: bytes, parameters: Mapping[str, Value]) -> bytes:
    """Return the state that ``stamp`` was given; ValueError if it belongs to other parameters."""
    stamp, _, state = data.partition(b"\n")
    try:
        there = json.loads(stamp)
    except ValueError as error:
        raise ValueError(
            "the state must tell its rope's parameters: give a checkpoint of this version"
        ) from error
    changes = differences(there, parameters)
    if changes:
        raise ValueError(
            f"the rope's parameters must be those of the state, but {changes}: set them so"
        )
    return state


@dataclass(frozen=True)
class RopeData:
    """One rope of a run; parameters by FMI name."""

    model: Mapping[str, str]  # kind and origin
    parameters: Mapping[str, Value]
    units: Mapping[str, str]  # FMI's spelling, "1" for a pure number
    fidelity_reason: str = ""  # why this fidelity runs
    name: str = ""  # prefix of its signals where there are several ropes
    suspension: SuspensionOffset = field(default_factory=SuspensionOffset)
    # time [s] and place [m, from the left end] of a break
    breaks: tuple[float, float] | None = None

    @property
    def prefix(self) -> str:
        """Beginning of the names of its signals and parameters, where there are several ropes."""
        if not self.name:
            return ""
        return f"{self.name}."

    def with_name(self, text: str) -> str:
        """Return words on the rope, with its name where there are several."""
        if not self.name:
            return text
        return f"{text}, {self.name}"

    @property
    def torque_free(self) -> bool:
        """Return True if the rope carries no torque with ends that do not turn.

        Unknown parameters count as torque.
        """
        return all(self.parameters.get(name) == 0.0 for name in _TORQUE)

    @property
    def locked(self) -> tuple[str, ...]:
        """List the ends whose swivel is locked."""
        locked = choices_of("swivel.mode").index("locked")
        return tuple(end for end in SIDES if self.parameters.get(f"{end}.swivel.mode") == locked)

    def display(self, name: str) -> Value:
        """Return a parameter's value, a code with its word."""
        value = self.parameters[name]
        words = choices_of(name)
        if isinstance(value, int) and 0 <= value < len(words):
            return f"{value} ({words[value]})"
        return value

    @property
    def level(self) -> str:
        """Name of the level whose mesh, solver and model these are, "" for none."""
        for level in get_args(Level):
            values = _level_values(level).items()
            if all(self.parameters.get(name) == value for name, value in values):
                return str(level)
        return ""


def _level_values(level: Level) -> dict[str, Value]:
    """Return the parameters that a level sets, by FMI name."""
    parameters = named_parameters(at_level(Scene(), level))
    groups = [p for p in parameters if p.name.startswith(_LEVEL_GROUPS)]
    return {
        p.name: p.value for p in groups if isinstance(p.value, float) or p.name in _LEVEL_CHOICES
    }


NO_DATA = RopeData({}, {}, {})  #: A rope of which nothing is known.
