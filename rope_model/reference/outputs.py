"""Outputs by the names of the signal table: end forces and torques, loop, twist, energies.

The conveyance carries the opposite of the rope's reactions: the force -R, and the moment of the
reaction to r' together with the torque M of the swivel (``physics.frame``).  The loop's lowest
point is that of quintics through three nodes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.method import sampling
from rope_model.method.swivel_phases import Phase
from rope_model.parameters import Scene
from rope_model.physics.centreline import nearest_turn, sample_s
from rope_model.physics.element import STRAINS
from rope_model.physics.estimates import loop_width
from rope_model.physics.frame import conveyance_load
from rope_model.physics.hermite import through_three
from rope_model.physics.node import END_NODE, POSITION, SIDES, SLOPE
from rope_model.physics.stress import material_values
from rope_model.reference.equations import HEIGHT
from rope_model.reference.state import State
from rope_model.reference.transfer import elements_at, interpolated
from rope_model.signals.signal_table import SHAPE_POINTS, SIGNALS

AXES = ("x", "y", "z")
#: outputs of ``Energies``
ENERGIES = (
    "kinetic",
    "strain",
    "gravity",
    "total",
    "work_ends",
    "dissipated_material",
    "dissipated_swivel",
    "nonconservative",
    "transformations",
    "residual",
)
COUNTS = ("steps", "rejections", "newton", "transformations", "swivel_events")

#: outputs by name
Values = dict[str, float]


@dataclass(frozen=True)
class LowestPoint:
    """Lowest point of the rope."""

    s: float  #: m, arc length from the left end
    position: Array  #: m (3,)
    yaw: float  #: rad, of the tangent about Y: 0 along X, positive towards -Z


def lowest_point(q: Array, s: Array) -> LowestPoint:
    """Return the lowest point of the rope ``q`` (nodes, 7) with nodes at arc lengths ``s`` (m).

    Quintics through three nodes are as accurate as the nodes: a cubic between two nodes keeps its
    length only roughly, and its tangent is off inside of an element.  The point is that of a parabola
    through three samples.
    """
    middle = int(np.clip(np.argmin(q[:, HEIGHT]), 1, s.size - 2))
    samples = np.linspace(s[middle - 1], s[middle + 1], sampling.FINE)
    heights = curve_beside(q, s, middle, samples, (HEIGHT,))[0][0]
    lowest = int(np.argmin(heights))
    shift = 0.0
    if 0 < lowest < samples.size - 1:
        before, at_lowest, after = heights[lowest - 1 : lowest + 2]
        bend = before - 2 * at_lowest + after
        if bend > 0:
            shift = 0.5 * (before - after) / bend
    at = samples[lowest] + shift * (samples[1] - samples[0])
    position, slope = (x[:, 0] for x in curve_beside(q, s, middle, np.array([at]), (0, 1, 2)))
    return LowestPoint(float(at), position, _yaw(slope))


def curve_beside(
    q: Array, s: Array, middle: int, at: Array, axes: tuple[int, ...]
) -> tuple[Array, Array]:
    """Return coordinates and their slopes (axes, n) at arc lengths ``at`` (m) (n,) beside the node ``middle``.

    The quintics about an element's nodes share it by their distance, so that nothing jumps where
    another node becomes the lowest.
    """
    values = np.empty((len(axes), at.size))
    slopes = np.empty_like(values)
    for element in (middle - 1, middle):
        here = (at < s[middle]) == (element < middle)
        l = s[element + 1] - s[element]
        xi = (at[here] - s[element]) / l
        left, right = (int(np.clip(node, 1, s.size - 2)) for node in (element, element + 1))
        for row, axis in enumerate(axes):
            r1, s1 = _quintic(q, s, left, at[here], axis)
            r2, s2 = _quintic(q, s, right, at[here], axis)
            values[row, here] = (1 - xi) * r1 + xi * r2
            slopes[row, here] = (1 - xi) * s1 + xi * s2 + (r2 - r1) / l
    return values, slopes


def _quintic(q: Array, s: Array, node: int, at: Array, axis: int) -> tuple[Array, Array]:
    """Return a coordinate and its slope (n,) of the quintic through a node and its neighbours."""
    first, second, third = s[node - 1 : node + 2]
    values = q[node - 1 : node + 2, [axis, 3 + axis]].ravel()
    r, slope = through_three(at - first, second - first, third - first, values)
    return np.asarray(r), np.asarray(slope)


def yaw_of(q: Array) -> float:
    """Return the yaw (rad) of the tangent at the lowest node."""
    return _yaw(q[np.argmin(q[:, HEIGHT]), SLOPE])


def _yaw(slope: Array) -> float:
    """Return the yaw (rad) of a tangent r' (3,)."""
    along, _, aside = slope
    return math.atan2(-aside, along)


def end_values(scene: Scene, state: State) -> Values:
    """Return forces (N), moments (N m) and swivels of both ends."""
    m = state.motion
    ends = state.ends(scene)
    values: Values = {}
    for side, name in enumerate(SIDES):
        node = END_NODE[side]
        torque = ends.moment(side, m)
        load = conveyance_load(m.q[node], m.reaction[node], torque)
        angle, rate = ends.relative(side, m)
        for axis, force, moment in zip(AXES, load[:3], load[3:], strict=True):
            values[f"{name}.f{axis}"] = float(force)
            values[f"{name}.m{axis}"] = float(moment)
        values[f"{name}.fy_mean"] = state.force_mean[side]
        values[f"{name}.swivel.angle"] = angle
        values[f"{name}.swivel.rate"] = rate
        values[f"{name}.swivel.torque"] = torque
        values[f"{name}.swivel.slipping"] = float(state.swivels[side].phase is Phase.SLIP)
    return values


def loop_values(scene: Scene, state: State) -> Values:
    """Return position (m) and yaw (rad) of the loop at its lowest point."""
    lowest = lowest_point(state.motion.q, state.mesh.nodes_s)
    values = {f"loop.{axis}": float(x) for axis, x in zip(AXES, lowest.position, strict=True)}
    values["loop.yaw"] = float(nearest_turn(lowest.yaw, state.loop_yaw))
    return values


def strain_values(scene: Scene, state: State) -> Values:
    """Return twist (rad/m) at ends and loop, and the largest nominal stresses (Pa)."""
    m = state.motion
    s = state.mesh.nodes_s
    strains = state.equations(scene).strains(m.q, m.v)
    twist = strains[STRAINS.index("tau")]
    bending, torsion, _, _ = material_values(scene.rope, 1.0, strains)
    at_loop = elements_at(s, np.array([lowest_point(m.q, s).s]))[0]
    return {
        "left.twist": float(twist[0]),
        "right.twist": float(twist[-1]),
        "loop.twist": float(twist[at_loop]),
        "stress.bending_max": float(bending.max()),
        "stress.torsion_max": float(torsion.max()),
    }


def energy_values(scene: Scene, state: State) -> Values:
    """Return energies, work and losses (J)."""
    return {f"energy.{name}": float(getattr(state.energies, name)) for name in ENERGIES}


def count_values(scene: Scene, state: State) -> Values:
    """Return numbers of steps, corrections and events."""
    return {f"count.{name}": float(getattr(state.counts, name)) for name in COUNTS}


def shape_values(scene: Scene, state: State) -> Values:
    """Return points of the rope (m) from end to end, denser around the loop."""
    q = state.motion.q
    nodes = state.mesh.nodes_s
    bottom = lowest_point(q, nodes).s
    u = np.linspace(-1.0, 1.0, SHAPE_POINTS)
    reach = np.where(u < 0, -bottom, nodes[-1] - bottom)
    s = np.clip(sample_s(bottom, reach, np.abs(u), loop_width(scene)), 0.0, nodes[-1])
    points = interpolated(q, nodes, s)
    rows = {"s": s} | dict(zip(AXES, points[:, POSITION].T, strict=True))
    return {
        f"shape.{name}[{i}]": float(x)
        for name, row in rows.items()
        for i, x in enumerate(row, start=1)
    }


ValuesFunction = Callable[[Scene, State], Values]


def values_function(name: str) -> ValuesFunction | None:
    """Return the function that computes the output ``name`` and related ones, or None."""
    part, _, rest = name.partition(".")
    if name in ("left.twist", "right.twist", "loop.twist") or part == "stress":
        return strain_values
    if part in SIDES and rest != "added_mass":
        return end_values
    if part == "loop" and rest in (*AXES, "yaw"):
        return loop_values
    if part == "energy" and rest in ENERGIES:
        return energy_values
    if part == "count":
        return count_values
    if part == "shape" and rest.partition("[")[0] in (*AXES, "s"):
        return shape_values
    return None


#: names of all outputs, in the order of the signal table
COMPUTED_NAMES = tuple(name for name in SIGNALS if values_function(name))
