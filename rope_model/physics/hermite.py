"""Cubic Hermite interpolation in an element of length l, at xi = x / l from 0 to 1.

A field has the values r1, r2 and the derivatives s1, s2 with respect to arc length at the element's nodes.  Works on
numbers, numpy arrays and CasADi expressions.
"""

from __future__ import annotations

from typing import Any

#: 420 times the mean products of the shapes of r1, s1, r2, s2 along an element of length 1; for length l those of s
#: bring a factor l each, and the integral another
PRODUCTS = ((156, 22, 54, -13), (22, 4, 13, -3), (54, 13, 156, -22), (-13, -3, -22, 4))


def interpolate(xi: Any, l: Any, r1: Any, s1: Any, r2: Any, s2: Any) -> tuple[Any, Any]:
    """Value, and derivative with respect to arc length."""
    d1, d2, rest = l * s1, l * s2, 1 - xi
    return (
        r1 + xi * xi * (3 - 2 * xi) * (r2 - r1) + xi * (rest * rest) * d1 + xi * xi * (xi - 1) * d2,
        (6 * xi * rest * (r2 - r1) + rest * (1 - 3 * xi) * d1 + xi * (3 * xi - 2) * d2) / l,
    )


def shares(xi: Any, l: Any) -> tuple[Any, Any, Any, Any]:
    """What the value takes of r1, s1, r2, s2."""
    rest = 1 - xi
    return 1 - xi * xi * (3 - 2 * xi), xi * rest * rest * l, xi * xi * (3 - 2 * xi), xi * xi * (xi - 1) * l


def share_products(l: Any) -> tuple[Any, ...]:
    """Integrals of the products of two shares: the lower half of (4, 4), row by row, from the diagonal leftwards."""
    part, powers = l / 420, (1.0, l, l * l)
    pairs = ((m, m - k) for m in range(4) for k in range(m + 1))
    return tuple(part * (PRODUCTS[m][n] * powers[m % 2 + n % 2]) for m, n in pairs)


def integral(l: Any, r1: Any, s1: Any, r2: Any, s2: Any) -> Any:
    """Integral over the element."""
    return l * (0.5 * (r1 + r2) + l * (s1 - s2) / 12)


def integral_to(xi: Any, l: Any, r1: Any, s1: Any, r2: Any, s2: Any) -> Any:
    """Integral from the left node to ``xi``."""
    return l * (
        xi * (1 - xi * xi * (1 - 0.5 * xi)) * r1
        + xi * xi * xi * (1 - 0.5 * xi) * r2
        + l * xi * xi * ((0.5 - xi * (2 / 3 - 0.25 * xi)) * s1 - xi * (1 / 3 - 0.25 * xi) * s2)
    )
