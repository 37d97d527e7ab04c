"""Elementary functions for formulas beyond + - * /, on numbers, numpy arrays and CasADi expressions.

A formula written with these has one text: Python evaluates it, and C is printed from its expression
(codegen.expressions).  Numbers go to the functions of libm, as in C.
"""

import math
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import add
from typing import Annotated, Any, TypeAlias

import casadi as ca
import numpy as np

#: what a formula takes: a number, an array of numbers, or a CasADi expression.  ``Any`` stands for
#: the latter two; mypy still refuses to index a Scalar, or to take its members
Scalar: TypeAlias = float | Any
#: components, or entries in an order that the docstring names: a tuple, the rows of an array, a
#: CasADi vector
Vector: TypeAlias = Sequence[Scalar] | Any

#: vectors of two and of three components; C takes the length from the annotation
Vector2: TypeAlias = Annotated[Vector, 2]
Vector3: TypeAlias = Annotated[Vector, 3]

SMALLEST_DIVISOR = 1e-300  #: smallest divisor

#: isinstance is four times as fast with a tuple as with float | int, and every formula calls it
_NUMBER = float, int


def sqrt(x: Scalar) -> Any:
    """Return the square root."""
    return _library(x).sqrt(x)


def ceil(x: Scalar) -> Any:
    """Return the smallest whole number that is not below ``x``."""
    if isinstance(x, _NUMBER):
        return float(math.ceil(x))
    return _library(x).ceil(x)


def floor(x: Scalar) -> Any:
    """Return the largest whole number that is not above ``x``."""
    if isinstance(x, _NUMBER):
        return float(math.floor(x))
    return _library(x).floor(x)


def nearest_whole(x: Scalar) -> Any:
    """Return the whole number nearest to ``x``, whatever the processor's rounding mode; the larger of two."""
    return floor(x + 0.5)


def exp(x: Scalar) -> Any:
    """Return the exponential."""
    return _library(x).exp(x)


def log(x: Scalar) -> Any:
    """Return the natural logarithm."""
    return _library(x).log(x)


def sin(x: Scalar) -> Any:
    """Return the sine of an angle in rad."""
    return _library(x).sin(x)


def cos(x: Scalar) -> Any:
    """Return the cosine of an angle in rad."""
    return _library(x).cos(x)


def tanh(x: Scalar) -> Any:
    """Return the hyperbolic tangent."""
    return _library(x).tanh(x)


def hypot(x: Scalar, y: Scalar) -> Any:
    """Return the length of the vector (x, y)."""
    return _library(x).hypot(x, y)


def atan2(y: Scalar, x: Scalar) -> Any:
    """Return the angle (rad) of the vector (x, y)."""
    if isinstance(y, np.ndarray):
        return np.arctan2(y, x)
    return _library(y).atan2(y, x)


def maximum(x: Scalar, y: Scalar) -> Any:
    """Return the larger number; ``x`` where they are equal."""
    if isinstance(x, _NUMBER):
        return max(x, y)
    return _library(x).fmax(x, y)


def minimum(x: Scalar, y: Scalar) -> Any:
    """Return the smaller number; ``x`` where they are equal."""
    if isinstance(x, _NUMBER):
        return min(x, y)
    return _library(x).fmin(x, y)


def where(condition: Scalar, x: Scalar, y: Scalar) -> Any:
    """Return ``x`` where the condition holds, else ``y``; both are computed."""
    if isinstance(condition, _NUMBER):
        return x if condition else y
    if isinstance(condition, ca.SX):
        return ca.if_else(condition, x, y)
    if isinstance(condition, np.ndarray):
        return np.where(condition, x, y)
    return x if condition else y


def logical_and(*conditions: Scalar) -> Any:
    """Return whether all of the conditions hold; all are computed."""
    if _symbolic(conditions):
        return reduce(ca.logic_and, map(ca.SX, conditions))
    return all(conditions)


def logical_or(*conditions: Scalar) -> Any:
    """Return whether one of the conditions holds; all are computed."""
    if _symbolic(conditions):
        return reduce(ca.logic_or, map(ca.SX, conditions))
    return any(conditions)


def less(x: Scalar, y: Scalar) -> Any:
    """Return 1 where ``x`` is less than ``y``, else 0."""
    if isinstance(x, float) and isinstance(y, float):
        return float(x < y)
    return x < y


def unit_sign(x: Scalar) -> Any:
    """Return 1 with the sign of ``x``."""
    if isinstance(x, float):
        return math.copysign(1.0, x)
    if isinstance(x, np.ndarray):
        return np.copysign(1.0, x)
    return ca.copysign(1.0, x)


def sum_of(terms: Iterable[Scalar], start: Scalar = 0.0) -> Any:
    """Return the sum of ``start`` and the terms, added from left to right and rounded each time, as in C.

    The builtin ``sum`` of floats compensates for the rounding since Python 3.12: its bits depend on
    the version.
    """
    return reduce(add, terms, start)


def dot(a: Vector3, b: Vector3) -> Any:
    """Return the scalar product of vectors; their three components come first."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> tuple[Any, Any, Any]:
    """Return the vector product of vectors; their three components come first."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _symbolic(conditions: tuple[Scalar, ...]) -> bool:
    return ca.SX in map(type, conditions)


def _library(x: Scalar) -> Any:
    """Return the module whose functions take ``x``."""
    if isinstance(x, _NUMBER):
        return math
    return np if isinstance(x, np.ndarray) else ca
