"""Coefficients and weights of the extended generalized-alpha method."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.physics.elementary import Scalar

#: growth of the step above which the acceleration's rate over the shorter step is mostly noise, and
#: used neither for extrapolation nor for re-centring
MAX_GROWTH = 5.0


@dataclass(frozen=True)
class Motion:
    """Complete state of the method; arrays have the shape (nodes, degrees of freedom per node).

    ``a_rate`` is (a_n - a_{n-1}) / h; ``h`` is the step that led here, 0 after a restart.
    ``reaction`` is the residual: zero where free, the force of the surroundings where prescribed.
    """

    t: float
    q: Array
    v: Array
    a: Array
    b: Array
    a_rate: Array
    h: float
    reaction: Array


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of the method for the spectral radius ``rho`` in [0, 1] at infinite frequency."""

    rho: float

    @cached_property
    def alpha_m(self) -> float:
        return (2 * self.rho - 1) / (self.rho + 1)

    @cached_property
    def alpha_f(self) -> float:
        return self.rho / (self.rho + 1)

    @cached_property
    def gamma(self) -> float:
        return 0.5 + self.alpha_f - self.alpha_m

    @cached_property
    def beta(self) -> float:
        return 0.25 * ((1 + self.alpha_f - self.alpha_m) * (1 + self.alpha_f - self.alpha_m))

    @cached_property
    def shift(self) -> float:
        """Instant of b, in steps from t_n."""
        return self.alpha_m - self.alpha_f

    def newton(self, h: float) -> Array:
        """Return the derivatives (3,) of q, v and a at the end of a step ``h`` with respect to q there."""
        return np.array(newton_coefficients(self, h))

    def prediction(self, h: float, recentring: float, horizon: float) -> Array:
        """Return q, v, a at the end of a step ``h`` as weights (3, 5) of q, v, a, b, a_rate; see prediction_weights."""
        q_a, v_a, q_b, v_b, q_rate, v_rate = prediction_weights(self, h, recentring, horizon)
        return np.array(
            [
                [1.0, h, q_a, q_b, q_rate],
                [0.0, 1.0, v_a, v_b, v_rate],
                [0.0, 0.0, 1.0, 0.0, horizon],
            ]
        )


class TangentCoefficients(NamedTuple):
    """Coefficients of dR/dq, dR/dv and dR/da in the tangent of Newton's method: motion per correction."""

    q: Scalar
    v: Scalar
    a: Scalar


def recentring_time(method: Coefficients, h: Scalar, before: Scalar) -> Scalar:
    """Return the time (s) by which b moves when a step ``h`` follows one of length ``before``."""
    return method.shift * (h - before)


def newton_coefficients(method: Coefficients, h: Scalar) -> TangentCoefficients:
    """Return the derivatives of q, v and a at the end of a step ``h`` with respect to q there."""
    m = method.alpha_m
    f = method.alpha_f
    return TangentCoefficients(
        q=1.0,
        v=method.gamma / (method.beta * h),
        a=(1 - m) / (method.beta * h * h * (1 - f)),
    )


class PredictionWeights(NamedTuple):
    """Weights of a, b and a_rate at the start of a step in q and in v at its end."""

    q_a: Scalar
    v_a: Scalar
    q_b: Scalar
    v_b: Scalar
    q_rate: Scalar
    v_rate: Scalar


class AuxiliaryWeights(NamedTuple):
    """Weights of a, b and a_rate at the start of a step, and of a at its end, in b at its end."""

    a: Scalar
    b: Scalar
    a_rate: Scalar
    a_end: Scalar


def prediction_weights(
    method: Coefficients, h: Scalar, recentring: Scalar, horizon: Scalar
) -> PredictionWeights:
    """Return the weights of the prediction over a step ``h``.

    b is moved by ``recentring``; the acceleration continues at its rate for the time ``horizon``.
    """
    m = method.alpha_m
    gamma = method.gamma
    beta = method.beta
    q_a = h * h * beta / (1 - m)
    v_a = h * gamma / (1 - m)
    q_b = h * h * (0.5 - beta) - m * q_a
    v_b = h * (1 - gamma) - m * v_a
    weight = (1 - method.alpha_f) * horizon
    return PredictionWeights(
        q_a=q_a,
        v_a=v_a,
        q_b=q_b,
        v_b=v_b,
        q_rate=q_b * recentring + q_a * weight,
        v_rate=v_b * recentring + v_a * weight,
    )


def auxiliary_weights(method: Coefficients, recentring: Scalar) -> AuxiliaryWeights:
    """Return the weights of the auxiliary acceleration at the end of a step."""
    m = method.alpha_m
    f = method.alpha_f
    return AuxiliaryWeights(
        a=f / (1 - m),
        b=-m / (1 - m),
        a_rate=-m * recentring / (1 - m),
        a_end=(1 - f) / (1 - m),
    )


def local_error(method: Coefficients, h: Scalar, change: Scalar) -> Scalar:
    """Return the local error of q in a step ``h`` over which the acceleration changes by ``change``."""
    return abs(method.beta + 0.5 * method.shift - 1 / 6) * h * h * change
