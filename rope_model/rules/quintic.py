"""Quintic polynomials in time between two motions.

x(s) = c0 + c1 s + ... + c5 s^5 has position, speed and acceleration x0, v0, a0 at s = 0 and x1, v1, a1 at s = h.  Works
on numbers and CasADi expressions.
"""

from typing import Any


def coefficients(h: Any, x0: Any, v0: Any, a0: Any, x1: Any, v1: Any, a1: Any) -> tuple[Any, ...]:
    """Return c0 to c5 of the quintic over a time ``h``."""
    dx = x1 - x0 - h * v0 - 0.5 * h * h * a0
    dv = h * (v1 - v0 - h * a0)
    da = h * h * (a1 - a0)
    c3 = 10 * dx - 4 * dv + 0.5 * da
    c4 = -15 * dx + 7 * dv - da
    c5 = 6 * dx - 3 * dv + 0.5 * da
    return x0, v0, 0.5 * a0, c3 / h**3, c4 / h**4, c5 / h**5


def rates(c: Any, s: Any) -> tuple[Any, Any, Any]:
    """Return value, rate and acceleration at ``s``."""
    _, c1, c2, c3, c4, c5 = c
    return (
        value(c, s),
        c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5))),
        acceleration(c, s),
    )


def value(c: Any, s: Any) -> Any:
    """Return the value at ``s``."""
    return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))


def acceleration(c: Any, s: Any) -> Any:
    """Return the acceleration at ``s``."""
    return 2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]))


def extrapolate(x: Any, v: Any, a: Any, h: Any) -> tuple[Any, Any]:
    """Return position and speed after the time ``h`` at constant acceleration."""
    return x + v * h + 0.5 * a * h * h, v + a * h
