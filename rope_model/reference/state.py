"""State of the rope: all that its future depends on, and its form as bytes.

A state never changes: a step makes a new one, and the old one serves a return.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from typing import NamedTuple, TypeAlias, get_args, get_type_hints

import numpy as np

from rope_model.arrays import Array
from rope_model.method.generalized_alpha import Motion
from rope_model.method.swivel_phases import SwivelState
from rope_model.parameters import Scene
from rope_model.physics.inextensible import left_leg_length
from rope_model.physics.node import ANGLE, NODE_DOF
from rope_model.reference.ends import EndQuintic
from rope_model.reference.energies import Energies
from rope_model.reference.equations import Equations
from rope_model.reference.mesh import RopeMesh
from rope_model.reference.swivel import Ends
from rope_model.state import Crossing


@dataclass(frozen=True)
class StepCounts:
    """Numbers since the start."""

    steps: int = 0
    rejections: int = 0
    #: corrections of steps: accepted, rejected, and tried in the search for an event
    newton: int = 0
    transformations: int = 0
    swivel_events: int = 0


class LoggedEvent(NamedTuple):
    """LoggedEvent between two steps."""

    t: float  #: s
    what: str


@dataclass(frozen=True)
class State:
    """Complete state of a rope between conveyances."""

    motion: Motion
    mesh: RopeMesh
    paths: tuple[EndQuintic, EndQuintic]
    swivels: tuple[SwivelState, SwivelState]
    offsets: tuple[float, float]  #: rad, of theta at both ends: see ``swivel``
    loop_yaw: float  #: rad, at the lowest node, counted through full turns
    step_next: float  #: s, length of the next step
    calm_since: float  #: s, instant of the last step whose error was not small
    force_mean: tuple[float, float]  #: N, vertical force on the conveyances over the last advance
    energies: Energies
    counts: StepCounts = StepCounts()
    events: tuple[LoggedEvent, ...] = ()  #: of the last advance
    #: passages of the legs through each other
    crossing: Crossing = field(default_factory=Crossing)

    @property
    def last_interval(self) -> float:
        """Length (s) of the last advance."""
        path = self.paths[0]
        return path.stop - path.start

    def ends(self, scene: Scene) -> Ends:
        """Return the rope's ends."""
        return Ends(scene, self.paths, self.swivels, self.offsets)

    def equations(self, scene: Scene) -> Equations:
        """Return the equations of motion: the present shape is the reference of its frame."""
        return self.ends(scene).equations(self.mesh, self.motion.q)

    def bottom_s(self, scene: Scene, t: float) -> float:
        """Return the arc length (m) of the loop at ``t`` (s), from the heights of the ends."""
        left, right = (path.at(t)[0, 1] for path in self.paths)
        return float(left_leg_length(scene.rope.length, left, right))

    def with_angles(self, equations: Equations) -> State:
        """Return the state as the reference of its own frame, instead of that of ``equations``.

        Sections stay where they are, and the rates of theta become their spins.
        """
        m = self.motion
        angle, spin, acceleration = equations.turning(m.q, m.v, m.a)
        motion = replace(
            m,
            q=_with_more_angle(m.q, angle),
            v=_with_more_angle(m.v, spin),
            a=_with_more_angle(m.a, acceleration),
            b=_with_more_angle(m.b, acceleration),
        )
        left, right = self.offsets
        return replace(self, motion=motion, offsets=(left, right + float(angle[-1])))

    def counted(self, **more: int) -> State:
        """Return the state with some counts raised."""
        raised = {name: getattr(self.counts, name) + n for name, n in more.items()}
        return replace(self, counts=replace(self.counts, **raised))

    def to_bytes(self) -> bytes:
        """Return the state as JSON, whose numbers keep their bits."""
        return json.dumps(_to_json(self)).encode()

    @staticmethod
    def from_bytes(data: bytes) -> State:
        """Return the state that ``to_bytes`` wrote; ValueError for anything else."""
        try:
            state = _from_json(State, json.loads(data))
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f"these {len(data)} bytes are no state of the reference rope ({error})"
            ) from error
        assert isinstance(state, State)
        return state


def require_finite(state: State) -> None:
    """Raise ValueError unless the motion has finite numbers for each node of the mesh."""
    shape = (state.mesh.lengths.size + 1, NODE_DOF)
    m = state.motion
    arrays = {"q": m.q, "v": m.v, "a": m.a, "b": m.b, "a_rate": m.a_rate, "reaction": m.reaction}
    for name, values in arrays.items():
        if values.shape != shape or not np.isfinite(values).all():
            raise ValueError(
                f"{name} of the state must be finite numbers {shape} of the mesh's nodes: "
                "restore what state or save() of the reference rope returned"
            )
    for name, value in (("t", m.t), ("h", m.h), ("step_next", state.step_next)):
        if not math.isfinite(value):
            raise ValueError(
                f"{name} = {value:g} s of the state must be finite: "
                "restore what state or save() of the reference rope returned"
            )


def _with_more_angle(x: Array, more: Array) -> Array:
    """Return the rows of nodes ``x`` (nodes, 7) with ``more`` (nodes,) added to their angles."""
    x = x.copy()
    x[:, ANGLE] += more
    return x


#: what JSON has
JsonValue: TypeAlias = "float | str | list[JsonValue] | dict[str, JsonValue]"


def _to_json(x: object) -> JsonValue:
    """Return a record, an array, a choice or a number for JSON."""
    if isinstance(x, np.ndarray):
        values: list[JsonValue] = x.tolist()
        return values
    if is_dataclass(x):
        return {each.name: _to_json(getattr(x, each.name)) for each in fields(x)}
    if isinstance(x, tuple):
        return [_to_json(part) for part in x]
    if isinstance(x, Enum):
        return int(x.value)
    if isinstance(x, float | int | str):
        return x
    raise TypeError(f"a {type(x).__name__} has no place in a state")


def _from_json(kind: type, content: JsonValue) -> object:
    """Return the value of this ``kind`` that ``_to_json`` made ``content`` of."""
    if isinstance(content, dict):
        hints = get_type_hints(kind)
        return kind(**{name: _from_json(hints[name], value) for name, value in content.items()})
    if kind == Array:
        return np.array(content, dtype=np.float64)
    if isinstance(content, list) and hasattr(kind, "_fields"):
        parts = list(get_type_hints(kind).values())
        return kind(*(_from_json(part, x) for part, x in zip(parts, content, strict=True)))
    if isinstance(content, list):
        part = get_args(kind)[0]
        return tuple(_from_json(part, x) for x in content)
    return kind(content)
