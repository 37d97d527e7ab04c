"""The same rope elsewhere: mirrored, turned, seen from behind, shifted in space and time, in other units.

Equations without a preferred side, direction, place or instant give the same numbers, up to rounding.  Rounding may
change a decision (whether a step is halved or takes another of Newton's corrections, when a mesh is transformed); then
both runs are still within what each says of its own error.  So the bound is ROUNDING of the largest value, and SHARE of
both estimates where decisions differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from signal_names import SIDES, of_both_ends

from invariants.case import Array, Case
from invariants.features import Draws
from invariants.motions import Ends
from invariants.runs import (
    COUNTS,
    FORCES,
    MEANS,
    MOMENTS,
    PLACE,
    READ,
    Compared,
    Finding,
    Record,
    Refused,
    rms,
    same_end,
    wind,
)
from rope_model import FAR, SIGNALS, EndMotion, Scene
from rope_model.parameter_table import parameters_of
from rope_model.parameters import AT_START
from rope_model.scene_names import named_parameters, scene_with_values

#: of the largest value: forces of stiff elements amplify the rounding of positions of 1000 m,
#: 1e-13 m x EA / l = 1e-5 N; beside what one of Newton's corrections a step leaves, which the next steps
#: take over and the audit sees
ROUNDING = 1e-6
#: of the sum of both runs' estimates; an estimate is within a factor of 2 in 85 of 100 scenes
#: (docs/promise.md)
SHARE = 3.0
Values = dict[str, float | int]
ALL = (*FORCES, *MEANS, *MOMENTS, *PLACE)
PLACES = ("left", "1", "2", "middle", "4", "5", "right")
#: values that stand for "none" or "from the start", whatever the units
NONE = {
    "sump.level": -FAR,
    "guard.rise_y": -FAR,
    "guard.window_y": -FAR,
    "air.cross_height": FAR,
    "left.swivel.release_time": AT_START,
    "right.swivel.release_time": AT_START,
}
DIVIDERS = tuple(f"divider_{k}" for k in (1, 2, 3, 4))


def values_of(scene: Scene) -> Values:
    return {p.name: p.value for p in named_parameters(scene)}


def with_changes(scene: Scene, values: Values) -> Scene:
    try:
        return scene_with_values(scene, values)
    except ValueError as error:
        raise Refused(f"changed: {error}") from error


def negated(motion: EndMotion, names: tuple[str, ...]) -> EndMotion:
    return replace(motion, **{name: -getattr(motion, name) for name in names})


def both(case: Case, changed: Case) -> tuple[Record, Record]:
    """Both wound to the same step; a changed case that is refused alone breaks the relation."""
    return both_of(wind(case), changed)


def both_of(first: Record, changed: Case) -> tuple[Record, Record]:
    """As ``both``, of a case that has been wound."""
    try:
        second = wind(changed.with_(times=changed.times[: len(first.case.times)]), work=math.inf)
    except Refused as refusal:
        raise Finding(f"the changed scene alone is refused: {refusal}") from refusal
    same_end(first, second)
    return first, second


def meshes_agree(one: Record, other: Record, from_behind: bool = False) -> bool:
    """Whether elements have the same lengths."""
    lengths, others = (np.diff(record.rope.rows()[:, 0]) for record in (one, other))
    if from_behind:
        others = others[::-1]
    return len(lengths) == len(others) and bool(np.allclose(lengths, others, rtol=1e-9))


def is_clamped(case: Case) -> bool:
    return "clamped" in (case.scene.left.attachment, case.scene.right.attachment)


def decisions_agree(one: Record, other: Record) -> bool:
    return bool(np.array_equal(one.several(COUNTS), other.several(COUNTS)))


def compared(
    one: Record,
    other: Record,
    expected: Mapping[str, Array],
    names: tuple[str, ...] = ALL,
    exact: bool = True,
) -> Iterator[Compared]:
    """``other`` against ``expected``, the signals that follow from ``one``; ``exact`` up to rounding."""
    # what lies on the floor pulls at nothing: its place at rest is a matter of rounding, as is its
    # lowest point
    lies = one["contact.floor"][0] > 0.0
    names = tuple(name for name in names if not (lies and name in ("loop.x", "loop.z")))
    alike = exact and decisions_agree(one, other) and not lies
    if alike:
        estimate = 0.0
        note = ""
    else:
        estimate = SHARE
        note = ", steps differ"
    force = one.force
    loop_errors = estimate * (one.loop_error + other.loop_error)
    # a leg between its end and a loop that is beside its place leans: it pulls aside, and bends at
    # a clamp
    rope = one.case.scene.rope
    lean = loop_errors / (0.5 * rope.length)
    bend = lean * math.sqrt(max(rope.EI, rope.EI_stick) * force)
    unbalanced = one.largest_unbalanced + other.largest_unbalanced
    least = ROUNDING * force + unbalanced
    moment = float(np.abs(one.several(MOMENTS)).max())
    bounds = {
        FORCES: least + estimate * (one.force_error + other.force_error) + lean * force,
        MEANS: least + estimate * (one.force_error + other.force_error),
        # moments follow the loop and the forces: no better known than the worse of both
        MOMENTS: 10 * ROUNDING * moment
        + rope.diameter * least  # by coupling, moments follow the forces' rounding
        + estimate * moment * (one.force_error + other.force_error) / force
        + loop_errors / one.case.scene.layout.spacing * moment
        + bend,
        PLACE: 1e-6 + loop_errors,
    }
    if is_clamped(one.case) and one.rope.elements != other.rope.elements:
        del bounds[MOMENTS]  # no estimate knows how well a mesh follows the bend at a clamp
    for group, tolerance in bounds.items():
        chosen = [name for name in group if name in names]
        if not chosen:
            continue
        differences = {name: rms(other[name] - expected[name]) for name in chosen}
        worst = max(differences, key=lambda name: differences[name])
        yield Compared(f"RMS of {worst}{note}", differences[worst], tolerance)


def mirrored(case: Case, draws: Draws) -> Iterator[Compared]:
    """Reflected in the plane of the loop: a rope of the other lay."""
    flipped = (
        "rope.Qb",
        "rope.Qc",
        "rope.installed_twist",
        "rope.initial_curvature_angle",
        "lining.z",
        "air.vz",
    )
    flipped += tuple(f"rope.curvature_{place}_across" for place in PLACES)
    flipped += tuple(f"{name}.direction" for name in DIVIDERS)
    values = values_of(case.scene)
    for name in flipped:
        values[name] = -values[name]
    axes = ("z", "vz", "az", "yaw", "yaw_rate", "lean_z")

    def motion(t: float) -> Ends:
        left, right = case.at(t)
        return negated(left, axes), negated(right, axes)

    force = case.force and (case.force[0], case.force[1] * [1.0, 1.0, -1.0])
    other = case.with_(scene=with_changes(case.scene, values), motion=motion, force=force)
    one, two = both(case, other)
    signs = dict.fromkeys((*of_both_ends("fz", "mx", "my"), "loop.z"), -1.0)
    yield from compared(one, two, _with_signs(one, signs))


def seen_from_behind(case: Case, draws: Draws) -> Iterator[Compared]:
    """Turned by half a turn with the ends exchanged: the same rope, counted from its other end."""
    old = values_of(case.scene)
    values = dict(old)
    for name, x in old.items():
        for side, opposite in (SIDES, SIDES[::-1]):
            if name.startswith(f"{side}.swivel"):
                values[name.replace(side, opposite, 1)] = x
    for name in ("lining.x", "lining.z", "air.vx", "air.vz", *(f"{x}.offset" for x in DIVIDERS)):
        values[name] = -old[name]
    values["station.first"] = 1.0 - old["station.last"]
    values["station.last"] = 1.0 - old["station.first"]
    # the direction of the curvature is that at the other end, which the installed twist has turned
    if is_bent(case):
        angle = -old["rope.initial_curvature_angle"] - old["rope.installed_twist"]
        values["rope.initial_curvature_angle"] = math.remainder(angle, 2 * math.pi)
    for place, opposite in zip(PLACES, PLACES[::-1], strict=True):
        values[f"rope.curvature_{place}"] = old[f"rope.curvature_{opposite}"]
        values[f"rope.curvature_{place}_across"] = -old[f"rope.curvature_{opposite}_across"]
    axes = ("x", "vx", "ax", "z", "vz", "az", "lean", "lean_z")

    def motion(t: float) -> Ends:
        left, right = case.at(t)
        return negated(right, axes), negated(left, axes)

    force = case.force and (
        case.scene.rope.length - case.force[0],
        case.force[1] * [-1.0, 1.0, -1.0],
    )
    other = case.with_(scene=with_changes(case.scene, values), motion=motion, force=force)
    one, two = both(case, other)
    expected = {}
    for name in (*FORCES, *MEANS, *MOMENTS):
        side, rest = name.split(".")
        opposite = SIDES[1 - SIDES.index(side)]
        expected[name] = (1.0 if rest[1] == "y" else -1.0) * one[f"{opposite}.{rest}"]
    expected |= {"loop.x": -one["loop.x"], "loop.y": one["loop.y"], "loop.z": -one["loop.z"]}
    # where an odd number of elements is left for the windows of dividers, the left leg has one more
    exact = meshes_agree(one, two, from_behind=True)
    # the direction of a curvature is carried along from the left end: the ends' frames agree to the
    # order of the mesh
    exact &= not (is_bent(case) and any(end.lean_z for end in case.at(case.start)))
    yield from compared(one, two, expected, exact=exact)


def is_bent(case: Case) -> bool:
    """Whether the rope has a permanent curvature."""
    values = values_of(case.scene)
    return any(x != 0 for name, x in values.items() if "curvature" in name and "angle" not in name)


def _with_signs(one: Record, signs: Mapping[str, float]) -> dict[str, Array]:
    return {name: signs.get(name, 1.0) * one[name] for name in ALL}


def turned(case: Case, draws: Draws) -> Iterator[Compared]:
    """Turned about the vertical, shaft and wind too; boxes and rows of the conveyances, which do not yaw, are left out.

    Motions that the input filter completes or extrapolates are completed along X and Z, each within bounds of its own.
    """
    angle = draws.evenly(-3.0, 3.0)
    c = math.cos(angle)
    s = math.sin(angle)
    values = values_of(case.scene)
    values |= {"model.fidelity": 1, "conveyance.width": 0.0, "head_ropes.diameter": 0.0}
    if values["lining.depth"] != values["lining.width"] or values["lining.rounding"] != 1.0:
        values["lining.width"] = 0.0
    case = case.with_(scene=with_changes(case.scene, values))
    for x, z in (("lining.x", "lining.z"), ("air.vx", "air.vz")):
        at_x = values[x]
        at_z = values[z]
        values[x] = c * at_x + s * at_z
        values[z] = c * at_z - s * at_x
    for name in DIVIDERS:
        values[f"{name}.direction"] += angle
    half = 0.5 * case.scene.layout.spacing

    def end(motion: EndMotion, nominal: float) -> EndMotion:
        old = dict(vars(motion))
        old["x"] += nominal
        new = dict(old)
        for x, z in (("x", "z"), ("vx", "vz"), ("ax", "az"), ("lean", "lean_z")):
            new[x] = c * old[x] + s * old[z]
            new[z] = c * old[z] - s * old[x]
        new["x"] -= nominal
        new["yaw"] += angle
        return EndMotion(**new)

    def motion(t: float) -> Ends:
        left, right = case.at(t)
        return end(left, -half), end(right, half)

    force = None
    if case.force:
        fx, fy, fz = case.force[1]
        force = (case.force[0], np.array([c * fx + s * fz, fy, c * fz - s * fx]))
    one, two = both(
        case, case.with_(scene=with_changes(case.scene, values), motion=motion, force=force)
    )
    expected = {name: one[name] for name in ALL}
    for what in ("left.f", "left.m", "right.f", "right.m", "loop."):
        x = one[f"{what}x"]
        z = one[f"{what}z"]
        expected[f"{what}x"] = c * x + s * z
        expected[f"{what}z"] = c * z - s * x
    exact = not case.late and case.scene.inputs.given == "all"
    yield from compared(one, two, expected, exact=exact)


def shifted(case: Case, draws: Draws) -> Iterator[Compared]:
    """Elsewhere in the shaft's coordinates."""
    dx = draws.evenly(-20.0, 20.0)
    dz = draws.evenly(-20.0, 20.0)
    dy = draws.evenly(-300.0, 300.0)
    if case.scene.model.fidelity in ("planar", "rigid"):
        dz = 0.0  # they take no z at all
    values = values_of(case.scene)
    values["lining.x"] += dx
    values["lining.z"] += dz
    for name in DIVIDERS:
        direction = values[f"{name}.direction"]
        values[f"{name}.y"] += dy
        values[f"{name}.offset"] += math.cos(direction) * dx - math.sin(direction) * dz
    values["air.cross_y"] += dy
    for name in ("sump.level", "guard.rise_y", "guard.window_y"):
        if values[name] != NONE[name]:
            values[name] += dy

    def end(motion: EndMotion) -> EndMotion:
        at = vars(motion)
        return EndMotion(**{**at, "x": at["x"] + dx, "y": at["y"] + dy, "z": at["z"] + dz})

    def motion(t: float) -> Ends:
        left, right = case.at(t)
        return end(left), end(right)

    one, two = both(case, case.with_(scene=with_changes(case.scene, values), motion=motion))
    shift = {"loop.x": dx, "loop.y": dy, "loop.z": dz}
    expected = {name: one[name] + shift.get(name, 0.0) for name in ALL}
    # windows of dividers are made for legs at the nominal spacing, wherever the ends are
    yield from compared(one, two, expected, exact=meshes_agree(one, two))


def later(case: Case, draws: Draws) -> Iterator[Compared]:
    """Begun later."""
    delay = draws.one_of(1.0, 64.0, draws.evenly(0.0, 3000.0))
    values = values_of(case.scene)
    for side in SIDES:
        if values[f"{side}.swivel.release_time"] > 0:
            values[f"{side}.swivel.release_time"] += delay
    scene = with_changes(case.scene, values)
    one, two = both(
        case, case.with_(scene=scene, motion=lambda t: case.at(t - delay), times=case.times + delay)
    )
    yield from compared(one, two, _with_signs(one, {}))


@dataclass(frozen=True)
class Units:
    """Units of length, time and mass over those of the SI."""

    m: float
    s: float
    kg: float

    def factor(self, unit: str) -> float:
        """How a number of this unit changes, as of N.m2 or kg/m."""
        sizes = {
            "m": self.m,
            "s": self.s,
            "kg": self.kg,
            "N": self.kg * self.m / self.s**2,
            "rad": 1.0,
            "Hz": 1.0 / self.s,
        }
        sizes |= {"Pa": sizes["N"] / self.m**2, "J": sizes["N"] * self.m, "": 1.0}
        factor = 1.0
        sign = 1
        for part in unit.split("/"):
            for word in part.split("."):
                name = word.rstrip("0123456789")
                power = int(word[len(name) :] or 1)
                factor *= sizes[name] ** (sign * power)
            sign = -1
        return factor


def in_units(case: Case, units: Units) -> Case:
    """The case with all its numbers in other units; what stands for 'none' stays."""
    values: Values = {}
    for p in named_parameters(case.scene):
        stays = isinstance(p.value, int) or NONE.get(p.name) == p.value
        values[p.name] = p.value
        if not stays:
            values[p.name] *= units.factor(p.facts.unit)
    table = parameters_of(EndMotion)
    factors = {name: units.factor(table[name].unit) for name in table}

    def scaled(end: EndMotion) -> EndMotion:
        return EndMotion(**{name: x * factors[name] for name, x in vars(end).items()})

    def motion(t: float) -> Ends:
        left, right = map(scaled, case.at(t / units.s))
        return left, right

    force = case.force and (case.force[0] * units.m, case.force[1] * units.factor("N"))
    scene = with_changes(case.scene, values)
    return case.with_(scene=scene, motion=motion, times=case.times * units.s, force=force)


def other_masses(case: Case, draws: Draws) -> Iterator[Compared]:
    """A unit of mass that is a power of two: no rounding differs, so no bit does."""
    units = Units(1.0, 1.0, draws.one_of(0.25, 0.5, 2.0, 8.0))
    one, two = both(case, in_units(case, units))
    for name in (*FORCES, *MOMENTS, *MEANS, *PLACE, "energy.strain", "energy.residual", *COUNTS):
        difference = float(np.abs(two[name] - units.factor(SIGNALS[name].unit) * one[name]).max())
        yield Compared(name, difference, 0.0)


def other_units(case: Case, draws: Draws) -> Iterator[Compared]:
    """Units of length and time, too: only Newton's tolerance and a few bounds stay absolute, the fall is as free."""
    scale = draws.one_of(2.0, 0.5)
    units = Units(scale**2, scale, draws.one_of(0.5, 1.0, 4.0))
    one, two = both(case, in_units(case, units))
    yield from compared(
        one, in_units_of(two, units), {name: one[name] for name in ALL}, exact=False
    )


def in_units_of(record: Record, units: Units) -> Record:
    """The record with its numbers in the units of the SI again."""
    back = Record(record.case, record.rope)
    factors = np.array([1.0 / units.factor(SIGNALS[name].unit) for name in READ])
    back.rows = [row * factors for row in record.rows]
    return back


RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (
    mirrored,
    seen_from_behind,
    turned,
    shifted,
    later,
    other_masses,
    other_units,
)
