"""Boundary conditions at the rope's two ends: motion with the conveyances, and swivels.

An end is vertical (tangent -Y on the left, +Y on the right); its position and tangent direction are prescribed, only
the stretch |r'| is free.  A clamp prescribes r' = n along its axis, without stretch; at a hinge r' is free.  In both
cases the end's section follows the tangent without spin about it.  theta is prescribed while the swivel holds and free
while it slips:

    theta = offset + s yaw + b,   s = -1 on the left, +1 on the right

with the conveyance's yaw about Y, the swivel's relative angle b, and an offset that belongs to the frame: theta counts
along the rope from the left end (physics.frame), so the right end's offset changes as the rope turns in space.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rope_model.arrays import Array
from rope_model.parameters import Scene, Swivel
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.physics.swivel import friction_moment, tension_along
from rope_model.rules.end_conditions import YAW_SENSE, clamp_axis, held_end
from rope_model.rules.end_paths import (
    END_NODE,
    LEANS,
    MOTION_BOUNDS,
    PATH,
    SIDES,
    EndMotion,
    EndPath,
)
from rope_model.rules.input_filter import MAX_LAG, InputFilter, PathMeasures, settings_of
from rope_model.rules.messages import messages
from rope_model.rules.swivel_phases import Phase, SwivelState, moment_of_swivel, swivel_friction
from rope_model.solver_parameters import Inputs


@dataclass(frozen=True)
class HangingEnds:
    """A rope_system.Boundary with both ends on their paths and each swivel in its phase.

    ``points`` are the nominal suspension points (2, 3), ``offsets`` those of theta (2,).
    """

    points: Array
    paths: tuple[EndPath, EndPath]
    swivels: tuple[Swivel, Swivel]
    states: tuple[SwivelState, SwivelState]
    offsets: tuple[float, float]

    def free(self, nodes: int) -> NDArray[np.bool_]:
        free = np.ones((nodes, 7), dtype=bool)
        free[[0, -1]] = False
        for node, state, swivel in zip((0, -1), self.states, self.swivels, strict=True):
            free[node, SLOPE] = swivel.attachment == "hinged"
            free[node, 4] = swivel.attachment != "clamped"
            free[node, ANGLE] = state.phase is Phase.SLIP
        return free

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        motion = np.zeros((3, nodes, 7))
        for side, node in enumerate((0, -1)):
            angle = self.offsets[side] + self.states[side].angle
            motion[:, node] = held_end(
                self.paths[side], t, float(self.points[side, 0]), YAW_SENSE[side], angle
            )
            if self.swivels[side].attachment == "clamped":
                motion[:, node, SLOPE] = -YAW_SENSE[side] * np.array(
                    clamp_axis(*self.paths[side].lean_motion(t))
                )
        return motion

    def load(self, nodes: int) -> Array:
        return self._slip_moments(nodes, [x.seal_moment for x in self.swivels])

    def friction_load(self, nodes: int) -> Array:
        """Return the friction per newton of vertical reaction, which is the tension at plumb ends; zero at others."""
        moments = (friction_moment(x.mu_kinetic, x.mean_diameter, 0.0, 1.0) for x in self.swivels)
        plumb = (x.attachment == "plumb" for x in self.swivels)
        return self._slip_moments(
            nodes, [x if is_plumb else 0.0 for x, is_plumb in zip(moments, plumb, strict=True)]
        )

    def slanted_friction(self, q: Array, reaction: Array) -> Array | None:
        pairs = zip(self.swivels, self.states, strict=True)
        if not any(x.attachment != "plumb" and s.phase is Phase.SLIP for x, s in pairs):
            return None
        moments = [
            0.0
            if x.attachment == "plumb"
            else friction_moment(
                x.mu_kinetic, x.mean_diameter, 0.0, self.tension(side, q, reaction)
            )
            for side, x in enumerate(self.swivels)
        ]
        return self._slip_moments(q.shape[0], moments)

    def tension(self, side: int, q: Array, reaction: Array) -> float:
        """Return the tension (N) at an end."""
        force = reaction[END_NODE[side], POSITION].tolist()
        if self.swivels[side].attachment == "plumb":
            return float(force[1])
        return float(tension_along(YAW_SENSE[side], q[END_NODE[side], SLOPE].tolist(), force))

    def _slip_moments(self, nodes: int, moments: Sequence[float]) -> Array:
        """Return ``moments`` against the slip at the ends that slip (nodes, 7)."""
        load = np.zeros((nodes, 7))
        for node, state, swivel, moment in zip(
            (0, -1), self.states, self.swivels, moments, strict=True
        ):
            if state.phase is Phase.SLIP and swivel.mode != "free":
                load[node, ANGLE] = -state.sign * moment
        return load

    def friction(self, side: int, q: Array, reaction: Array, kinetic: bool) -> float:
        """Return the kinetic friction moment, or the largest static one, at the end's present tension (N m)."""
        swivel = self.swivels[side]
        mu = swivel.mu_kinetic if kinetic else swivel.mu_static
        return float(swivel_friction(swivel, mu, self.tension(side, q, reaction)))

    def moment(self, side: int, q: Array, reaction: Array) -> float:
        """Return the moment (N m, about the tangent) of the conveyance on the rope's end."""
        held, tension = float(reaction[END_NODE[side], ANGLE]), self.tension(side, q, reaction)
        return float(moment_of_swivel(self.swivels[side], self.states[side], tension, held))

    def relative(self, side: int, t: float, theta: float, theta_t: float) -> tuple[float, float]:
        """Return the swivel's angle b (rad) and rate b_t (rad/s)."""
        yaw, yaw_rate = self.paths[side].yaw(t)
        return theta - self.offsets[side] - YAW_SENSE[side] * yaw, theta_t - YAW_SENSE[
            side
        ] * yaw_rate


def nominal_points(spacing: float) -> Array:
    """Return the suspension points at height zero (2, 3)."""
    return np.array([[-0.5 * spacing, 0.0, 0.0], [0.5 * spacing, 0.0, 0.0]])


def end_strain(scene: Scene, q: Array, x: Array, side: int) -> float:
    """Return the axial strain at an end, in an array ``x`` like q; of the next node where a clamp gives this one's."""
    attachment, node = getattr(scene, SIDES[side]).attachment, END_NODE[side]
    if attachment == "plumb":
        return float(x[node, SLOPE.start + 1])
    node += (1, -1)[side] if attachment == "clamped" else 0
    return float(x[node, SLOPE] @ q[node, SLOPE] / np.linalg.norm(q[node, SLOPE]))


def refusal(scene: Scene, target: EndMotion, measures: PathMeasures, side: str) -> str:
    """Return '' if an end can follow ``target`` on a path with these measures; else cause and cure."""
    inputs, clamped = scene.inputs, getattr(scene, side).attachment == "clamped"
    for name, bound in MOTION_BOUNDS.items():
        if -bound <= (value := getattr(target, name)) <= bound:
            if value != 0 and name.startswith("lean") and not clamped:
                return messages.no_clamp(side, name, value)
            continue
        if not math.isfinite(value):
            return messages.input_not_finite(side, name, value)
        return messages.input_out_of_range(side, name, value, bound)
    bounds = inputs.acceleration_max, inputs.misfit_max, inputs.misfit_max
    if all(size <= bound for sizes, bound in zip(measures, bounds, strict=True) for size in sizes):
        return ""
    worst = [_largest(sizes) for sizes in measures]
    for sizes, k, units in zip(
        measures[1:], worst[1:], (("m", "rad"), ("m/s", "rad/s")), strict=True
    ):
        if not sizes[k] <= inputs.misfit_max:
            if inputs.given != "all":
                bandwidth = float(settings_of(scene).estimate)
                lag = MAX_LAG / bandwidth
                return messages.input_jump(
                    side, PATH[k], sizes[k], units[k == 3], inputs.misfit_max, lag, bandwidth
                )
            return messages.input_misfit(side, PATH[k], sizes[k], units[k == 3], inputs.misfit_max)
    if not measures.peaks[worst[0]] <= inputs.acceleration_max:
        name, unit = (*PATH, *LEANS)[worst[0]], "m/s^2" if worst[0] < 3 else "rad/s^2"
        return messages.inputs_do_not_fit(
            side, name, measures.peaks[worst[0]], unit, inputs.acceleration_max
        )
    return ""


def _largest(sizes: Sequence[float]) -> int:
    """Return the index of the first NaN, or else of the largest number."""
    return max(range(len(sizes)), key=[math.inf if math.isnan(x) else x for x in sizes].__getitem__)


def stale_input_error(inputs: Inputs, t: float, end_filter: InputFilter, side: str) -> str:
    """Return '' while an end receives new samples; else how long it has not."""
    if end_filter.steps_held > 1 and t - end_filter.given_at > inputs.hold_max:
        return messages.inputs_frozen(side, t - end_filter.given_at, inputs.hold_max)
    return ""
