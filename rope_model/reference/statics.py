"""Equilibrium R(q, 0, 0) = 0 by pseudo-transient continuation, and the guess from which it starts.

Each correction is an implicit step of the inertia M in the time tau,

    (dR/dq + M / tau^2) x = -R

(docs/theory/element.md, eq-statics).  tau grows as the forces fall, and the search ends as Newton's
method.  Where forces grow, tau shrinks: the rope creeps to its equilibrium and does not depend on a
good guess.  Each shape on the way is the reference of the next one's frame (docs/theory/element.md,
"The frame of the section").

Source: Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998), switched evolution relaxation.
"""

from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.messages import messages
from rope_model.physics.element import PARAMETERS
from rope_model.physics.elementary import SMALLEST_DIVISOR
from rope_model.physics.inextensible import left_leg_length
from rope_model.physics.initial_shape import initial_shape, node_row
from rope_model.physics.node import ANGLE, SLOPE
from rope_model.reference.equations import HEIGHT, Equations

TOLERANCE = 1e-11  #: last correction, m over the rope's length
MAX_CORRECTIONS = 10_000
MAX_MOVE = 0.3  #: m and rad, largest move by a correction
FIRST_TIME = 1.0  #: s, first tau
SHORTEST_TIME = 1e-7  #: s, tau at which the search gives up
NEWTON_TIME = 1e8  #: s, tau above which corrections are Newton's
LONGEST_TIME = 1e12  #: s
SHRINK = 0.3  #: factor of tau after a correction that is not taken
GROW = (3.0, 10.0)  #: least and largest factor of tau after one that is taken
#: work of the forces after a correction over that before it, above which it is not taken: stretch
#: by a sideways motion grows with the third power of the way and takes up the work of the first
#: force
MAX_GAIN = 3.0
#: corrections with forces balanced to rounding after which the remaining motion costs no energy,
#: such as that of a buckled rod about its axis; tau takes at most 26 from its first value to its
#: last
BALANCED = 60


class StaticsError(RuntimeError):
    """No equilibrium was found; the message states the cause."""


@dataclass(frozen=True)
class Equilibrium:
    """Rope at rest."""

    q: Array  #: (nodes, 7), m, 1 and rad; angles count from its own frame
    reaction: Array  #: R (nodes, 7), N, N m and N m: zero where the rope is free
    corrections: int
    turn: float  #: rad, increase of the angle at the right end by changes of the frame


def find_equilibrium(equations: Equations, guess: Array, t: float = 0.0) -> Equilibrium:
    """Return the equilibrium near ``guess`` (nodes, 7), held as at ``t`` (s).

    Angles count from the frame of the rope itself (docs/theory/element.md, "The frame of the
    section"): those of the guess from the guess's, those of the equilibrium from its own.
    """
    q = np.where(equations.held, equations.held_motion(t)[0], guess)
    length = float(equations.lengths.sum())
    rounding = _rounding(equations)
    tau = FIRST_TIME
    turn = 0.0
    balanced = 0
    force = np.inf
    for k in range(1, MAX_CORRECTIONS + 1):
        equations = equations.with_reference(q)
        correction = _corrected(equations, q, tau)
        force = correction.force
        if not correction.is_taken(rounding):
            tau *= SHRINK
            if tau < SHORTEST_TIME:
                break
            continue

        q = correction.q
        gained = equations.turning(q, np.zeros_like(q), np.zeros_like(q))[0]
        q[:, ANGLE] += gained
        turn += float(gained[-1])
        balanced += correction.force_left <= rounding
        settled = tau > NEWTON_TIME and equations.size(correction.x) < TOLERANCE * length
        if settled or balanced > BALANCED:
            return Equilibrium(q, correction.reaction, k, turn)
        growth = force / max(correction.force_left, SMALLEST_DIVISOR)
        tau *= min(max(growth, GROW[0]), GROW[1])
        tau = min(tau, LONGEST_TIME)
    raise StaticsError(messages.no_equilibrium(k, force))


@dataclass(frozen=True)
class _Correction:
    """An implicit step of the inertia, and the forces before and after it."""

    x: Array  # (nodes, 7), correction, of which q has moved by a part
    q: Array  # (nodes, 7), after it
    reaction: Array  # R there
    force: float  # N, largest unbalanced one before it
    force_left: float  # N, after it
    gain: float  # J, work along x of the forces before it
    gain_left: float  # J, after it

    def is_taken(self, rounding: float) -> bool:
        """Whether it is finite, leads downhill, and the forces do not grow much along it."""
        finite = bool(np.isfinite(self.x).all()) and bool(np.isfinite(self.force_left))
        downhill = self.gain >= 0 or self.force <= rounding
        milder = (
            abs(self.gain_left) <= MAX_GAIN * abs(self.gain)
            or self.force_left <= self.force + rounding
        )
        return finite and downhill and milder


def _corrected(equations: Equations, q: Array, tau: float) -> _Correction:
    """Return the correction of ``q`` by a step of ``tau`` (s)."""
    zeros = np.zeros_like(q)
    R, tangent = equations.linearised(q, zeros, zeros, (1.0, 0.0, tau**-2), prestress=q)
    R = np.where(equations.held, 0.0, R)
    x = tangent.solve(-R)
    move = float(np.abs(x).max())
    if not np.isfinite(move):
        move = np.inf
    trial = q + min(1.0, MAX_MOVE / max(move, SMALLEST_DIVISOR)) * np.nan_to_num(x)
    reaction = equations.residual(trial, zeros, zeros)
    left = np.where(equations.held, 0.0, reaction)
    return _Correction(
        x=x,
        q=trial,
        reaction=reaction,
        force=_largest(equations, R),
        force_left=_largest(equations, left),
        gain=-float(np.sum(R * x)),
        gain_left=-float(np.sum(left * x)),
    )


def _largest(equations: Equations, R: Array) -> float:
    """Return the largest unbalanced force (N); that of r' is over the shortest element."""
    weights = np.ones(R.shape[1])
    weights[SLOPE] = 1.0 / equations.lengths.min()
    return float(np.max(np.abs(R) * weights))


def _rounding(equations: Equations) -> float:
    """Return ten times the force (N) by which rounding stretches the shortest element."""
    axial = equations.material[PARAMETERS.index("Qa")]
    strain = np.finfo(float).eps * equations.lengths.sum() / equations.lengths.min()
    return float(10.0 * axial * strain)


def hanging_guess(s: Array, left: Array, right: Array) -> Array:
    """Return straight legs and a half circle (nodes, 7) between two points (3,), at ``s`` (m)."""
    length = float(s[-1])
    across = np.array([right[0] - left[0], 0.0, right[2] - left[2]])
    width = float(np.linalg.norm(across))
    height = abs(float(left[HEIGHT] - right[HEIGHT]))
    if width == 0:
        raise StaticsError(messages.ends_above_each_other(height))
    middle = left_leg_length(length, left[HEIGHT], right[HEIGHT])
    cell = float(np.interp(middle, 0.5 * (s[:-1] + s[1:]), np.diff(s)))
    legs = initial_shape(length, middle, width, cell)
    if min(legs.left_leg, legs.right_leg) <= legs.lean:
        raise StaticsError(messages.rope_too_short(length, width, height))
    row = node_row(legs, left, across / width, s)
    return np.column_stack([np.broadcast_to(values, s.shape) for values in row])
