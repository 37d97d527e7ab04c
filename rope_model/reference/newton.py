"""Newton's method for R(q, v, a) = 0, where v and a follow a correction x of q.

    J x = -R,   q += c0 x,   v += c1 x,   a += c2 x,   J = c0 dR/dq + c1 dR/dv + c2 dR/da

(docs/theory/time.md, eq-tangent).  A tangent serves as long as corrections become ten times smaller
with each.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.reference.equations import Equations, Factors

MAX_CORRECTIONS = 20
CONTRACTION = 0.1  #: a correction over the one before it, above which a new tangent is made
#: m and rad, correction beyond which the method diverges: many times what a rope moves in a step
DIVERGED = 1e3


class Cause(Enum):
    """Cause of a failure; the value is a sentence's end."""

    NOT_CONVERGED = f"Newton's method did not converge in {MAX_CORRECTIONS} corrections"
    DIVERGED = "Newton's method diverged"
    SINGULAR = "the matrix of the equations is singular"
    NEW_MESH = "Newton's method does not converge, however stiffly the rope is restrained"
    ERROR = "the local error of the step is too large"
    CHATTER = "a swivel changes between stick and slip faster than a rope can move"
    STEPS = "the communication step takes too many steps"


@dataclass(frozen=True)
class Failure:
    """Step or transformation of the mesh that fails."""

    cause: Cause
    t: float  #: s, instant at which it begins
    what: str  #: that fails, such as "a step of 0.01 s"


class Guess(NamedTuple):
    """Configuration from which the solution is sought, each (nodes, 7)."""

    q: Array
    v: Array
    a: Array


@dataclass(frozen=True)
class Solution:
    """Configuration with R = 0 where the rope is free; arrays are (nodes, 7)."""

    q: Array
    v: Array
    a: Array
    reaction: Array  #: R, N and N m: zero up to the tolerance where the rope is free
    corrections: int
    cause: Cause | None  #: of a search that found none


def solve(
    equations: Equations,
    guess: Guess,
    c: tuple[float, float, float],
    tolerance: float,
    prestress: Array,
) -> Solution:
    """Return the solution near ``guess``, up to a last correction of ``tolerance`` (m and rad).

    ``c`` are c0, c1 and c2 of eq-tangent: 1, 1/s and 1/s^2.

    The first guess may overstretch the rope: the first tangent takes its axial strains from
    ``prestress``.
    """
    q, v, a = guess
    factors: Factors | None = None
    before = np.inf
    with np.errstate(all="ignore"):  # a correction that is not finite ends the search
        for k in range(1, MAX_CORRECTIONS + 1):
            if factors is None:
                R, factors = equations.linearised(q, v, a, c, prestress)
            else:
                R = equations.residual(q, v, a)
            if factors.singular:
                return Solution(q, v, a, R, k, Cause.SINGULAR)
            x = factors.solve(-R)
            size = equations.size(x)
            if not size < DIVERGED:
                return Solution(q, v, a, R, k, Cause.DIVERGED)
            q = q + c[0] * x
            v = v + c[1] * x
            a = a + c[2] * x
            if size <= tolerance:
                return Solution(q, v, a, equations.residual(q, v, a), k, None)
            if size > CONTRACTION * before:
                factors = None
                prestress = q
            before = size
    return Solution(q, v, a, R, MAX_CORRECTIONS, Cause.NOT_CONVERGED)
