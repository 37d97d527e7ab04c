"""Equilibrium by pseudo-transient continuation.

Each correction solves (K + M / tau^2) x = -R, an implicit Euler step of an inertia that the iteration is free to
choose; tau grows as the residual falls, and the method ends as Newton's.  Without a residual that falls, tau shrinks
and the iteration creeps like the real rope would: it does not depend on a good first guess.

Source: Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998), switched evolution relaxation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .rope_system import POSITION, SLOPE, Array, RopeSystem


class StaticsError(RuntimeError):
    """No equilibrium found."""


@dataclass(frozen=True)
class Equilibrium:
    """Configuration, reactions (zero where free, up to rounding) and the corrections it took."""

    q: Array
    reaction: Array
    iterations: int


def find_equilibrium(
    system: RopeSystem, guess: Array, t: float = 0.0, tolerance: float = 1e-11, max_iterations: int = 2000
) -> Equilibrium:
    """Equilibrium near ``guess`` (nodes, 7) with the ends where the system holds them at ``t``.

    ``tolerance`` is for the last full Newton correction in ``system.norm`` relative to the rope's length.
    """
    q = np.where(system.free, guess, system.prescribed(t)[0])
    rest = np.zeros_like(q)
    scale = float(np.sum(system.lengths))
    reaction = system.assess(t, q, rest, rest, rest).reaction
    tau, largest_move, previous = 0.1, 0.3, _force(system, reaction)
    for k in range(1, max_iterations + 1):
        x, _ = system.direction(t, q, rest, rest, reaction, np.array([1.0, 0.0, tau**-2]))
        move = float(np.max(np.abs(x[:, POSITION]))), float(np.max(np.abs(x[:, [3, 4, 5, 6]])))
        if not np.all(np.isfinite(x)):
            tau *= 0.1
            continue
        step = min(1.0, largest_move / max(*move, 1e-300))
        trial = q + step * x
        trial_reaction = system.assess(t, trial, rest, rest, reaction).reaction
        force = _force(system, trial_reaction)
        if not np.isfinite(force) or force > 4.0 * previous + 1e-6:
            tau *= 0.3
            if tau < 1e-7:
                break
            continue
        q, reaction = trial, trial_reaction
        if tau > 1e8 and step == 1.0 and system.norm(x) < tolerance * scale:
            return Equilibrium(q, reaction, k)
        tau *= min(10.0, max(1.5, previous / max(force, 1e-300)))
        tau = min(tau, 1e12)
        previous = force
    raise StaticsError(
        f"no equilibrium within {max_iterations} iterations: {previous:.3g} N are left unbalanced; "
        "the rope may have none in this configuration (too much twist), or the elements may be too long for EI"
    )


def _force(system: RopeSystem, reaction: Array) -> float:
    """Largest unbalanced force in N; moments and stretching forces count per the shortest element's length."""
    weight = np.ones(reaction.shape[1])
    weight[SLOPE] = 1.0 / system.lengths.min()
    return float(np.max(np.abs(np.where(system.free, reaction, 0.0)) * weight))


def hanging_guess(s: Array, left: Array, right: Array) -> Array:
    """(nodes, 7): two vertical legs and a half circle between the suspension points ``left`` and ``right`` (3,).

    ``s`` are the arc lengths of the nodes.  The half circle lies in the vertical plane of the two points.
    """
    length = float(s[-1])
    across = np.array([right[0] - left[0], 0.0, right[2] - left[2]])
    width = float(np.hypot(across[0], across[2]))
    across = across / width
    radius = 0.5 * width
    left_leg = 0.5 * (length - np.pi * radius + left[1] - right[1])
    if left_leg < 0 or length - np.pi * radius - left_leg < 0:
        raise StaticsError(
            f"the rope of {length:g} m cannot hang between ends {width:g} m apart with a height difference of "
            f"{left[1] - right[1]:g} m; give a longer rope or bring the ends together"
        )
    phi = np.clip((s - left_leg) / radius, 0.0, np.pi)
    along = radius * (1 - np.cos(phi))
    down = np.minimum(s, left_leg) + radius * np.sin(phi) - np.maximum(s - left_leg - np.pi * radius, 0.0)
    q = np.zeros((s.size, 7))
    q[:, POSITION] = left + along[:, None] * across
    q[:, 1] -= down
    q[:, SLOPE] = np.sin(phi)[:, None] * across
    q[:, 4] = -np.cos(phi)
    return q
