"""Quintic polynomials in time between two motions.

x(s) = c0 + c1 s + ... + c5 s^5 has position, speed and acceleration x0, v0, a0 at s = 0 and x1, v1,
a1 at s = h.  Works on numbers and CasADi expressions.
"""

from typing import Any

from rope_model.physics.elementary import Scalar, Vector

#: coefficients of 1, s, s^2 ... of one coordinate
Quintic = tuple[float, float, float, float, float, float]


def coefficients(h: Scalar, start: Vector, stop: Vector) -> Quintic:
    """Return c0 to c5 of the quintic over a time ``h`` between two motions (x, v, a)."""
    x0, v0, a0 = start
    x1, v1, a1 = stop
    dx = x1 - x0 - h * v0 - 0.5 * h * h * a0
    dv = h * (v1 - v0 - h * a0)
    da = h * h * (a1 - a0)
    c3 = 10 * dx - 4 * dv + 0.5 * da
    c4 = -15 * dx + 7 * dv - da
    c5 = 6 * dx - 3 * dv + 0.5 * da
    half_a0: Any = 0.5 * a0
    return x0, v0, half_a0, c3 / h**3, c4 / h**4, c5 / h**5


def rates(c: Vector, s: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return value, rate and acceleration at ``s``."""
    _, c1, c2, c3, c4, c5 = c
    return (
        value(c, s),
        c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5))),
        acceleration(c, s),
    )


def value(c: Vector, s: Scalar) -> Scalar:
    """Return the value at ``s``."""
    return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))


def acceleration(c: Vector, s: Scalar) -> Scalar:
    """Return the acceleration at ``s``."""
    return 2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]))


def extrapolate(x: Scalar, v: Scalar, a: Scalar, h: Scalar) -> tuple[Scalar, Scalar]:
    """Return position and speed after the time ``h`` at constant acceleration."""
    return x + v * h + 0.5 * a * h * h, v + a * h
