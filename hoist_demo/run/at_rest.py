"""Ropes of a hoist at rest, before anything is wound: signals, lowest modes, remarks."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from hoist_demo.cases.case import Case
from hoist_demo.design.statics import at_rest
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import build_single_trip
from hoist_demo.run.ropes import OneRope, ropes_of
from rope_model import EndMotion, Scene, balance_rope
from rope_model.analysis.modes import NoModesError, natural_modes
from rope_model.engine import NativeRope

MODES = 4  #: Number of the rope's lowest modes.
#: Most yaw of a loop in a trip over that at rest [assumed]: 2.1 in a trip of 870 m at 16 m/s.
YAWS = 3.0
#: Part of a mode's motion out of plane from which on it counts as one out of plane.
_MOSTLY = 0.5


@dataclass(frozen=True)
class PositionAtRest:
    """Signals of a rope at rest with the left conveyance at a height [m]."""

    height: float
    signals: Mapping[str, float]


@dataclass(frozen=True)
class Mode:
    """Natural mode of a rope."""

    frequency: float  # Hz
    out_of_plane: bool


@dataclass(frozen=True)
class RopeAtRest:
    """What a rope is and does before it is wound."""

    rope: OneRope
    fidelity: str
    fidelity_reason: str
    elements: int
    warnings: tuple[str, ...]
    positions: tuple[PositionAtRest, ...]  # at both landings and between
    modes: tuple[Mode, ...]  # in the middle of the trip
    no_modes: str = ""  # reason, where there are none

    @property
    def largest_yaw(self) -> float:
        """Loop's yaw of the largest size [rad]."""
        return max((one.signals["loop.yaw"] for one in self.positions), default=0.0, key=abs)


def ropes_at_rest(case: Case, name: str, values: Mapping[str, Value]) -> list[RopeAtRest]:
    """Return the ropes of a hoist at rest; RuntimeError where one cannot hang.

    ``name`` is how the hoist is found, ``values`` are set beside its file.
    """
    run = build_single_trip(name, values)
    ropes = ropes_of(case, run, {}, case.level).ropes
    return [_at_rest(rope, case.hoist) for rope in ropes]


def _at_rest(rope: OneRope, hoist: Hoist) -> RopeAtRest:
    plant = balance_rope(rope.scene)
    heights = [0.0, 0.5 * hoist.shaft_travel, hoist.shaft_travel]
    positions = [PositionAtRest(*one) for one in at_rest(plant, hoist, heights)]
    modes: tuple[Mode, ...] = ()
    no_modes = ""
    try:
        modes = _lowest_modes(rope.scene, hoist.shaft_travel)
    except NoModesError as error:
        no_modes = str(error)
    return RopeAtRest(
        rope,
        fidelity=plant.fidelity,
        fidelity_reason=plant.fidelity_reason,
        elements=plant.elements,
        warnings=tuple(plant.warnings().values()),
        positions=tuple(positions),
        modes=modes,
        no_modes=no_modes,
    )


def _lowest_modes(scene: Scene, travel: float) -> tuple[Mode, ...]:
    """Return the lowest modes in the middle of the trip; NoModesError where the rope has none."""
    # a rope that is computed as rigid or planar swings out of its plane too
    rope = NativeRope(scene.with_(model=replace(scene.model, fidelity="torsional")))
    status = rope.initialize(0.0, EndMotion(y=0.5 * travel), EndMotion(y=0.5 * travel))
    if not status.valid:
        raise NoModesError(status.message)
    modes = natural_modes(rope, MODES)
    return tuple(
        Mode(float(frequency), bool(out_of_plane > _MOSTLY))
        for frequency, out_of_plane in zip(modes.frequencies, modes.out_of_plane, strict=True)
    )


def remarks_at_rest(ropes: Sequence[RopeAtRest]) -> list[str]:
    """Return the warnings of the ropes, and remarks on neighbours that may touch, each once."""
    remarks = [f"{with_colon(one.rope.name)}{text}" for one in ropes for text in one.warnings]
    return list(dict.fromkeys([*remarks, *_neighbours(ropes)]))


def with_colon(rope_name: str) -> str:
    """Return the name of one of several ropes before what is said of it; the only one has none."""
    if rope_name:
        return f"{rope_name}: "
    return ""


def _neighbours(ropes: Sequence[RopeAtRest]) -> Iterator[str]:
    """Yield remarks on ropes that may touch: their loops yaw more in a trip than at rest."""
    for one, other in combinations(ropes, 2):
        x, _, z = one.rope.suspension.origin
        x_other, _, z_other = other.rope.suspension.origin
        distance = abs(z - z_other)
        scene = one.rope.scene
        radii = 0.5 * (scene.rope.diameter + other.rope.scene.rope.diameter)
        required_distance = abs(_reach(one) - _reach(other)) + radii
        if abs(x - x_other) < scene.layout.spacing and distance < required_distance:
            angle = f"{math.degrees(one.largest_yaw):.2g}"
            angle_other = f"{math.degrees(other.largest_yaw):.2g}"
            yield (
                f"{one.rope.name} and {other.rope.name}, {distance:.3g} m apart in z, may touch: "
                f"their loops yaw by up to {angle} and {angle_other} degrees at rest, and in a "
                f"trip by up to {YAWS:g} times that [assumed]: hang them "
                f"{required_distance:.2g} m apart, or see their clearance in wind's verdict"
            )


def _reach(one: RopeAtRest) -> float:
    """Return how far a leg moves out of plane in a trip [m], by the loop's yaw at rest."""
    quarter_turn = 0.5 * math.pi
    yaw_in_trip = max(-quarter_turn, min(YAWS * one.largest_yaw, quarter_turn))
    return 0.5 * one.rope.scene.layout.spacing * math.sin(yaw_in_trip)
