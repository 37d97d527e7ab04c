"""Motions of the ends: trips and stops, holds, small moves, ends that go aside, yaw and lean."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from scenes import smooth_step
from signal_names import SIDES

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from invariants.features import Drawn, Draws
from rope_model import EndMotion
from rope_model.scene_names import choices_of

#: position, speed and acceleration of one coordinate at an instant
Along = tuple[float, float, float]
Coordinate = Callable[[float], Along]
Ends = tuple[EndMotion, EndMotion]
#: parts of the rope's length that the ends may be apart in height
APART = (-0.75, 0.75)
#: share of cases that have each feature of the motion
_CANNOT_FOLLOW = {
    "spatial": ("yaw",),
    "planar": ("aside", "yaw", "apart"),
    "rigid": ("aside", "yaw", "apart"),
}
MOVES = {"unequal ends": 0.25, "aside": 0.3, "yaw": 0.25, "lean": 0.7, "apart": 0.2}


def _rest(at: float) -> Coordinate:
    return lambda t: (at, 0.0, 0.0)


def _move(at: float, by: float, start: float, duration: float) -> Coordinate:
    """From rest to rest along a polynomial of fifth order."""

    def coordinate(t: float) -> Along:
        y, v, a = smooth_step(t, start, duration)
        return at + by * y, by * v, by * a

    return coordinate


def _sum(parts: list[Coordinate]) -> Coordinate:
    def coordinate(t: float) -> Along:
        values = [part(t) for part in parts]
        y, v, a = map(sum, zip(*values, strict=True))
        return y, v, a

    return coordinate


def _trip(at: float, winding: Winding) -> Coordinate:
    reference = s_curve(winding)

    def coordinate(t: float) -> Along:
        point = reference.at(t)
        return at + point.position, point.speed, point.acceleration

    return coordinate


def _scaled(one: Coordinate, at: float, factor: float) -> Coordinate:
    """As ``one`` times ``factor``, from ``at`` on."""
    begin = one(0.0)[0]

    def coordinate(t: float) -> Along:
        y, v, a = one(t)
        return at + factor * (y - begin), factor * v, factor * a

    return coordinate


@dataclass(frozen=True)
class Motion:
    """Coordinates of both ends; those that are left out rest at 0."""

    ends: tuple[dict[str, Coordinate], dict[str, Coordinate]]

    def __call__(self, t: float) -> Ends:
        left, right = (self._at(coordinates, t) for coordinates in self.ends)
        return left, right

    @staticmethod
    def _at(coordinates: dict[str, Coordinate], t: float) -> EndMotion:
        values: dict[str, float] = {}
        for name, coordinate in coordinates.items():
            y, v, a = coordinate(t)
            values[name] = y
            if name in ("x", "y", "z"):
                values |= {f"v{name}": v, f"a{name}": a}
            elif name == "yaw":
                values["yaw_rate"] = v
        return EndMotion(**values)


def _vertical(draws: Draws, length: float, duration: float, start: float) -> tuple[str, Coordinate]:
    """One of trip, emergency stop, hold and small moves, from height 0; at least half of the height is left."""
    kind = draws.one_of("trip", "trip", "emergency stop", "hold", "small moves")
    reach = 0.1 * length
    sign = -math.copysign(1.0, start)
    if abs(start) < 0.5 * length:
        sign = draws.sign()
    if kind == "hold":
        return kind, _rest(0.0)
    if kind == "small moves":
        moves = [
            _move(
                0.0,
                draws.evenly(-0.05, 0.05),
                draws.evenly(0.0, 0.6) * duration,
                draws.evenly(0.5, 1.0),
            )
            for _ in range(3)
        ]
        return kind, _sum(moves)
    winding = Winding(
        travel=sign * min(draws.evenly(0.2, 1.0) * reach, 40.0),
        speed=draws.evenly(1.0, 16.0),
        acceleration=draws.evenly(0.5, 2.0),
        jerk=draws.in_logarithms(0.5, 10.0),
        start_delay=draws.evenly(0.0, 0.3),
    )
    if kind == "emergency stop":
        winding = replace(
            winding,
            emergency_at=draws.evenly(0.3, 0.8) * duration,
            emergency_deceleration=draws.evenly(2.0, 5.0),
            emergency_jerk=draws.in_logarithms(10.0, 50.0),
        )
    return kind, _trip(0.0, winding)


def _moves_aside(draws: Draws, duration: float, size: float) -> Coordinate:
    begin = draws.evenly(0.05, 0.3) * duration
    return _move(0.0, draws.evenly(-size, size), begin, draws.evenly(1.0, 2.0))


def draw_motion(
    seed: int, number: int, drawn: Drawn, without: frozenset[str]
) -> tuple[list[str], Motion]:
    """The motion of a case, and the names of its features."""
    code = drawn.values.get("model.fidelity", 0)

    def has(name: str) -> bool:
        told = Draws(seed, number, f"has {name}").chance(MOVES[name]) and name not in without
        return told and name not in _CANNOT_FOLLOW.get(choices_of("model.fidelity")[code], ())

    length = drawn.length
    duration = drawn.duration
    names = list[str]()
    draws = Draws(seed, number, "vertical")
    apart = draws.evenly(*APART) * length
    kind, left_y = _vertical(draws, length, duration, apart)
    if kind in without:
        kind = "hold"
        left_y = _rest(0.0)
    names.append(kind)
    factor = -1.0
    if has("unequal ends"):
        names.append("unequal ends")
        factor = Draws(seed, number, "unequal ends").one_of(0.0, -0.8, -1.1, 0.5)
    # the higher end is at height 0 at the start, so that bodies below are below both
    lift = -max(apart, 0.0)
    left: dict[str, Coordinate] = {"y": _scaled(left_y, apart + lift, 1.0)}
    right: dict[str, Coordinate] = {"y": _scaled(left_y, lift, factor)}
    ends = (left, right)
    if has("apart"):
        names.append("apart")
        draws = Draws(seed, number, "apart")
        for end in ends:
            end["z"] = _rest(draws.evenly(-0.3, 0.3))
            end["x"] = _rest(draws.evenly(-0.1, 0.1) * drawn.spacing)
    if has("aside"):
        names.append("aside")
        draws = Draws(seed, number, "aside")
        for end in ends:
            for axis in ("x", "z"):
                by = _moves_aside(draws, duration, min(0.3, 0.01 * length))
                if axis in end:
                    by = _sum([end[axis], by])
                end[axis] = by
    if has("yaw"):
        names.append("yaw")
        draws = Draws(seed, number, "yaw")
        for end in ends:
            at = draws.sometimes_evenly(0.5, -1.0, 1.0)
            end["yaw"] = _sum([_rest(at), _moves_aside(draws, duration, 0.5)])
    if has("lean"):
        draws = Draws(seed, number, "lean")
        for side, end in zip(SIDES, ends, strict=True):
            name = f"{side}.swivel.attachment"
            leans = {
                axis: (draws.evenly(-0.3, 0.3), draws.evenly(-0.05, 0.05))
                for axis in ("lean", "lean_z")
            }
            if drawn.values.get(name) == drawn.code(name, "clamped"):
                model = choices_of("model.fidelity")[code]
                names.append(f"{side} lean")
                for axis, (at, by) in leans.items():
                    if model == "rigid" or (axis == "lean_z" and model == "planar"):
                        continue  # it cannot follow them
                    end[axis] = _move(at, by, 0.3 * duration, 1.0)
    return names, Motion(ends)
