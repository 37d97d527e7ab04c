"""Cubic Hermite interpolation in an element of length l, at xi = x / l from 0 to 1.

A field has the values r1, r2 and the derivatives s1, s2 with respect to arc length at the element's
nodes.  Works on numbers, numpy arrays and CasADi expressions.
"""

from typing import Annotated

import numpy as np

from rope_model.physics.elementary import Scalar, Vector
from rope_model.physics.node import ElementRows

#: Gauss points in [0, 1] and weights; exact for the product of two cubics
GAUSS = tuple(
    (0.5 + 0.5 * float(x), 0.5 * float(w))
    for x, w in zip(*np.polynomial.legendre.leggauss(4), strict=True)
)
#: 420 times the mean products of the shape functions of r1, s1, r2, s2 for an element of length 1;
#: each s brings a factor l, and the integral another
PRODUCTS = ((156, 22, 54, -13), (22, 4, 13, -3), (54, 13, 156, -22), (-13, -3, -22, 4))


def interpolate(
    xi: Scalar, l: Scalar, r1: Scalar, s1: Scalar, r2: Scalar, s2: Scalar
) -> tuple[Scalar, Scalar]:
    """Return the value and its derivative with respect to arc length."""
    d1 = l * s1
    d2 = l * s2
    rest = 1 - xi
    return (
        r1 + xi * xi * (3 - 2 * xi) * (r2 - r1) + xi * (rest * rest) * d1 + xi * xi * (xi - 1) * d2,
        (6 * xi * rest * (r2 - r1) + rest * (1 - 3 * xi) * d1 + xi * (3 * xi - 2) * d2) / l,
    )


def through_three(
    s: Scalar, second: Scalar, third: Scalar, values: Annotated[Vector, 6]
) -> tuple[Scalar, Scalar]:
    """Return value and derivative at ``s`` (m) from a node of the quintic through it and the two nodes behind it.

    Those are ``second`` and ``third`` (m) from it; ``values`` are r and s at each of the three.  Newton's form with
    divided differences.
    """
    places = 0.0, 0.0, second, second, third, third
    table = [values[2 * (k // 2)] for k in range(6)]
    coefficients = [table[0]]
    for order in range(1, 6):
        differences = []
        for k in range(6 - order):
            if order == 1 and k % 2 == 0:
                differences.append(values[k + 1])
            else:
                differences.append((table[k + 1] - table[k]) / (places[k + order] - places[k]))
        table = differences
        coefficients.append(table[0])
    value = coefficients[5]
    slope: Scalar = 0.0
    for place, coefficient in zip(places[4::-1], coefficients[4::-1], strict=True):
        slope = slope * (s - place) + value
        value = value * (s - place) + coefficient
    return value, slope


def bend(xi: Scalar, l: Scalar, r1: Scalar, s1: Scalar, r2: Scalar, s2: Scalar) -> Scalar:
    """Return the second derivative with respect to arc length."""
    return ((6 - 12 * xi) * (r2 - r1) + l * ((6 * xi - 4) * s1 + (6 * xi - 2) * s2)) / (l * l)


def node_values(xi: Scalar, l: Scalar, nodes: ElementRows) -> Annotated[tuple[Scalar, ...], 7]:
    """Return r, r' and theta (7,) at ``xi`` between the ``nodes`` (14,) of an element; theta is linear."""
    theta = (1 - xi) * nodes[6] + xi * nodes[13]
    r = [interpolate(xi, l, nodes[k], nodes[3 + k], nodes[7 + k], nodes[10 + k]) for k in range(3)]
    return (*(x for x, _ in r), *(slope for _, slope in r), theta)


def shape_functions(xi: Scalar, l: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the shape functions at ``xi``: the factors of r1, s1, r2, s2 in the value."""
    rest = 1 - xi
    return (
        1 - xi * xi * (3 - 2 * xi),
        xi * rest * rest * l,
        xi * xi * (3 - 2 * xi),
        xi * xi * (xi - 1) * l,
    )


def shape_products(l: Scalar) -> Annotated[tuple[Scalar, ...], 10]:
    """Return integrals of products of two shape functions: the lower half of (4, 4), from the diagonal leftwards."""
    part = l / 420
    powers = (1.0, l, l * l)
    pairs = ((m, m - k) for m in range(4) for k in range(m + 1))
    return tuple(part * (PRODUCTS[m][n] * powers[m % 2 + n % 2]) for m, n in pairs)


def missing_load(
    start: Scalar,
    stop: Scalar,
    s: Scalar,
    l: Scalar,
    old_s: Scalar,
    old_l: Scalar,
    old: ElementRows,
    new: ElementRows,
) -> Annotated[tuple[Scalar, ...], 14]:
    """Integrate ``old`` minus ``new`` (14,) times the shape functions over the common part of both elements.

    The elements begin at ``s`` and ``old_s``.  The result (14,) has r1, s1, r2, s2 with three
    components each, then theta at both nodes.
    """
    parts = []
    for part_xi, weight in GAUSS:
        point = start + part_xi * (stop - start)
        weight_length = weight * (stop - start)
        xi = (point - s) / l
        old_xi = (point - old_s) / old_l
        before = node_values(old_xi, old_l, old)
        after = node_values(xi, l, new)
        missing = [weight_length * (b - a) for b, a in zip(before, after, strict=True)]
        cubic = (N * missing[k] for N in shape_functions(xi, l) for k in range(3))
        parts.append((*cubic, (1 - xi) * missing[6], xi * missing[6]))
    return tuple(a + b + c + d for a, b, c, d in zip(*parts, strict=True))


def integral(l: Scalar, r1: Scalar, s1: Scalar, r2: Scalar, s2: Scalar) -> Scalar:
    """Return the integral over the element."""
    return l * (0.5 * (r1 + r2) + l * (s1 - s2) / 12)


def integral_to(xi: Scalar, l: Scalar, r1: Scalar, s1: Scalar, r2: Scalar, s2: Scalar) -> Scalar:
    """Return the integral from the left node to ``xi``."""
    return l * (
        xi * (1 - xi * xi * (1 - 0.5 * xi)) * r1
        + xi * xi * xi * (1 - 0.5 * xi) * r2
        + l * xi * xi * ((0.5 - xi * (2 / 3 - 0.25 * xi)) * s1 - xi * (1 / 3 - 0.25 * xi) * s2)
    )
