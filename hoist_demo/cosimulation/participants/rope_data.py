"""Identity of a rope for the reports: source, parameters, and level of accuracy."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from hoist_demo.parameters import SIDES
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import Level, Scene, at_level
from rope_model.physics.initial_curvature import CURVATURES
from rope_model.scene_names import choices_of, named_parameters

_LEVEL_GROUPS = (
    "mesh.",
    "solver.",
    "model.",
)  #: Groups of the numbers that a level of accuracy sets.
_LEVEL_CHOICES = ("mesh.kind", "model.fidelity")  #: Choices that a level of accuracy sets.
_FREE = "solver.kernels"  #: What may differ when a run goes on.
_TORQUE = tuple(f"rope.{name}" for name in ("Qb", "Qc", "installed_twist", *CURVATURES))


def stamp(state: bytes, parameters: Mapping[str, Value]) -> bytes:
    """Prepend a line with the parameters that a rope's state belongs to."""
    return json.dumps(dict(parameters), sort_keys=True).encode() + b"\n" + state


def unstamp(data: bytes, parameters: Mapping[str, Value]) -> bytes:
    """Return the state that `stamp` was given; ValueError if it belongs to other parameters."""
    stamp, _, state = data.partition(b"\n")
    try:
        there = json.loads(stamp)
    except ValueError as error:
        raise ValueError(
            "the state must tell its rope's parameters: give a checkpoint of this version"
        ) from error
    names = sorted({*there, *parameters} - {_FREE})
    differences = [
        f"{name} is {there.get(name, 'missing')} there, {parameters.get(name, 'missing')} here"
        for name in names
        if there.get(name) != parameters.get(name)
    ]
    if differences:
        raise ValueError(
            f"the rope's parameters must be those of the state, but {', '.join(differences)}: set them so"
        )
    return state


@dataclass(frozen=True)
class RopeData:
    """One rope of a run; parameters by FMI name."""

    model: Mapping[str, str]  # kind and origin
    parameters: Mapping[str, Value]
    units: Mapping[str, str]  # FMI's spelling, "1" for a pure number
    fidelity_reason: str = ""  # why the fidelity runs that runs
    name: str = ""  # prefix of its signals where there are several ropes
    suspension: SuspensionOffset = field(default_factory=SuspensionOffset)
    breaks: tuple[float, float] | None = (
        None  # time [s] and place of its break [m], along the rope from its left end
    )

    @property
    def prefix(self) -> str:
        """Beginning of the names of its signals and of its parameters, where there are several ropes."""
        return f"{self.name}." if self.name else ""

    def whose(self, text: str) -> str:
        """Return words on the rope, with its name where there are several."""
        return f"{text}, {self.name}" if self.name else text

    @property
    def torque_free(self) -> bool:
        """Return True if the rope carries no torque with ends that do not turn; unknown parameters count as torque."""
        return all(self.parameters.get(name) == 0.0 for name in _TORQUE)

    @property
    def locked(self) -> tuple[str, ...]:
        """List the ends whose swivel is locked."""
        locked = choices_of("swivel.mode").index("locked")
        return tuple(end for end in SIDES if self.parameters.get(f"{end}.swivel.mode") == locked)

    def display(self, name: str) -> Value:
        """Return a parameter's value, a code with its word."""
        value, words = self.parameters[name], choices_of(name)
        return (
            f"{value} ({words[value]})"
            if isinstance(value, int) and 0 <= value < len(words)
            else value
        )

    @property
    def level(self) -> str:
        """Name of the level whose mesh, solver and model these are, "" for none."""
        for level in get_args(Level):
            numbers = [
                p
                for p in named_parameters(at_level(Scene(), level))
                if p.name.startswith(_LEVEL_GROUPS)
            ]
            wanted = {
                p.name: p.value
                for p in numbers
                if isinstance(p.value, float) or p.name in _LEVEL_CHOICES
            }
            if all(self.parameters.get(name) == value for name, value in wanted.items()):
                return str(level)
        return ""


UNKNOWN = RopeData({}, {}, {})  #: A rope of which nothing is known.
