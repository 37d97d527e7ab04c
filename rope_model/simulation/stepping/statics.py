"""Static equilibrium by pseudo-transient continuation.

Each correction solves (K + M / tau^2) x = -R, an implicit Euler step of an inertia that the iteration is free to
choose; tau grows as the residual falls, and the method ends as Newton's.  Without a residual that falls, tau shrinks
and the iteration creeps like a real rope: it does not depend on a good first guess.  Each shape on the way is the
reference of the frame for the next, so that no tangent is far from it.

The tangent is symmetric and leaves out the part of Qk, which has no energy.  Near the end of the search this multiplies
the error by i r, a rotation by 90 degrees, where r may exceed 1; corrections shortened by 1 / (1 + r^2) reduce it
fastest.

If a motion costs no energy, such as the rotation of a buckled rod's helix about its axis, corrections along it never
become small.  The search ends when forces have been balanced to rounding often enough for other corrections to vanish.

Source: Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998), switched evolution relaxation.
"""

import math
from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.physics.element import PARAMETERS
from rope_model.physics.initial_shape import initial_shape, node_row
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.rules.bodies import least_passage
from rope_model.rules.messages import messages
from rope_model.rules.statics import (
    BALANCED,
    MAX_MOVE,
    PATIENCE,
    REST_TOLERANCE,
    SETTLED,
    lacks_symmetry,
    relaxation,
)
from rope_model.simulation.curvature import Director
from rope_model.simulation.rope_system import RopeSystem

_QA, _QS, _QK = (PARAMETERS.index(name) for name in ("Qa", "Qs", "Qk"))


class StaticsError(RuntimeError):
    """No equilibrium after so many ``corrections``; ``turned``: true if the rope turned too far on the way."""

    def __init__(self, message: str, corrections: int = 0, turned: bool = False) -> None:
        super().__init__(message)
        self.corrections, self.turned = corrections, turned


@dataclass(frozen=True)
class Equilibrium:
    """Configuration, reactions (zero where free, up to rounding) and number of corrections.

    Angles count along it; ``end_rotation`` (rad) is the increase of the angle at the right end against the guess.
    ``director`` is e1 of the permanent curvature at the left end.
    """

    q: Array
    reaction: Array
    iterations: int
    end_rotation: float
    director: Director


def find_equilibrium(
    system: RopeSystem,
    guess: Array,
    t: float = 0.0,
    max_iterations: int = 10000,
    max_turn: float = math.inf,
) -> Equilibrium:
    """Find the equilibrium near ``guess`` (nodes, 7), whose angles count along it, with the ends held as at ``t``.

    The search fails if ``end_rotation`` exceeds ``max_turn`` (rad).
    """
    q = np.where(system.free, guess, system.prescribed_motion(t)[0])
    zeros = np.zeros_like(q)
    scale = float(np.sum(system.lengths))
    rounding = 10.0 * float(np.finfo(float).eps * system.P[_QA] * scale / system.lengths.min())
    system, reaction, end_rotation, previous = system.with_reference(q), zeros, 0.0, 0.0
    largest = MAX_MOVE
    if system.obstacles is not None:
        largest = min(MAX_MOVE, 0.5 * least_passage(system.obstacles.scene))
    tau, relaxed, last, balanced = 0.1, 1.0, 0.0, 0
    for k in range(1, max_iterations + 1):
        x, residual = system.newton_step(q, zeros, zeros, reaction, np.array([1.0, 0.0, tau**-2]))
        move = float(np.max(np.abs(x[:, POSITION]))), float(np.max(np.abs(x[:, [3, 4, 5, 6]])))
        previous = _imbalance(system, residual)
        if not np.all(np.isfinite(x)):
            tau *= 0.1
            if tau < 1e-7:
                break
            continue
        error = -float(np.sum(residual * x))
        # the tangent, and so the correction, misses the part without energy
        if lacks_symmetry(system.P[_QS], system.P[_QK]) and tau > SETTLED and last > 0:
            relaxed = relaxation(error / last, relaxed)
        step = min(relaxed, largest / max(*move, 1e-300))
        # how a step that is cut changes the error tells nothing of the tangent
        last = 0.0 if step < relaxed else error
        trial = q + step * x
        following = system.evaluate(trial, zeros, zeros, residual).reaction
        force = _imbalance(system, following)
        # larger forces are accepted on the way, but no gain of energy: a force that grows with the cube of the way,
        # such as that of stretch by sideways motion, may take up the work of the first force.  Where the tangent is
        # indefinite for lack of inertia, the correction itself goes uphill
        climbs = error < 0 and previous > rounding
        uphill = 3.0 if k <= PATIENCE else 1.0
        ends_low = np.sum(following * x) <= uphill * error or force <= previous + rounding
        if climbs or not np.isfinite(force) or not ends_low:
            tau, last = 0.3 * tau, 0.0
            if tau < 1e-7:
                break
            continue
        more = system.frame_turn(trial)
        trial[:, ANGLE] += more
        end_rotation += float(more[-1])
        if abs(end_rotation) > max_turn:
            break
        system, q, reaction = system.with_reference(trial), trial, following
        balanced += force <= rounding
        if balanced > BALANCED or (tau > 1e8 and system.norm(x) < REST_TOLERANCE * scale):
            return Equilibrium(q, reaction, k, end_rotation, system.director)
        tau = min(tau * min(10.0, max(1.5, previous / max(force, 1e-300))), 1e12)
    raise StaticsError(messages.no_equilibrium(k, previous), k, abs(end_rotation) > max_turn)


def _imbalance(system: RopeSystem, reaction: Array) -> float:
    """Return the largest unbalanced force (N); moments and stretching forces are over the shortest element."""
    weight = np.ones(reaction.shape[1])
    weight[SLOPE] = 1.0 / system.lengths.min()
    return float(np.max(np.abs(np.where(system.free, reaction, 0.0)) * weight))


def hanging_guess(s: Array, left: Array, right: Array) -> Array:
    """Return two straight legs and a half circle between the suspension points ``left`` and ``right`` (nodes, 7).

    ``s`` are the arc lengths of the nodes.  The half circle lies in the vertical plane of the two points, see
    physics.initial_shape.
    """
    length = float(s[-1])
    across = np.array([right[0] - left[0], 0.0, right[2] - left[2]])
    width = float(np.hypot(across[0], across[2]))
    if width == 0:
        raise StaticsError(messages.ends_above_each_other(abs(left[1] - right[1])))
    across = across / width
    middle = 0.5 * (length + left[1] - right[1])  # arc length of the lowest point
    cell = float(np.interp(middle, 0.5 * (s[:-1] + s[1:]), np.diff(s)))
    legs = initial_shape(length, middle, width, cell)
    if min(legs.left_leg, legs.right_leg) <= legs.lean:
        raise StaticsError(messages.rope_too_short(length, width, abs(left[1] - right[1])))
    q = np.zeros((s.size, 7))
    for dof, values in enumerate(node_row(legs, left, across, s)):
        q[:, dof] = values
    return q
