"""The swing mode that a trip leaves behind, measured: x(t) = c + e^(-zeta w t) (a cos w_d t + b sin w_d t).

The frequency and damping are fitted to a record by least squares; a, b and c are linear and follow from them
(variable projection; G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SwingMode:
    """One damped mode of a record."""

    frequency: float  # Hz, damped
    damping: float  # 1, ratio
    amplitude: float  # of the record's unit, at its first instant


def fit_swing(time: Array, x: Array) -> SwingMode | str:
    """Return the strongest mode of an evenly sampled record; else why there is none, in words."""
    from scipy.optimize import least_squares  # as slow to load as all the rest of a demo

    t = time - time[0]
    drift = np.polynomial.Polynomial.fit(t, x, 1)
    rest = x - drift(t)
    if t.size < 16 or float(np.ptp(rest)) < 1e-9:
        return "the record is too short" if t.size < 16 else "nothing swings"
    spectrum = np.abs(np.fft.rfft(rest * np.hanning(t.size), 8 * t.size))
    frequencies = np.fft.rfftfreq(8 * t.size, t[1] - t[0])
    w0 = 2.0 * math.pi * max(float(frequencies[int(np.argmax(spectrum))]), 0.5 / t[-1])

    def basis(p: Array) -> Array:
        decay = np.exp(-p[1] * t)
        return np.stack([np.ones_like(t), t, decay * np.cos(p[0] * t), decay * np.sin(p[0] * t)], axis=1)

    def residual(p: Array) -> Array:
        A = basis(p)
        return np.asarray(A @ np.linalg.lstsq(A, x, rcond=None)[0] - x)

    fit = least_squares(
        residual, [w0, 0.03 * w0], bounds=([0.5 * w0, -0.1 * w0], [1.5 * w0, w0]), x_scale=[w0, 0.03 * w0]
    )
    w_d, decay = (float(value) for value in fit.x)
    # a fit that ends at its bounds has found a drift or a bump, not a mode
    bounded = not 0.51 * w0 < w_d < 1.49 * w0 or decay > 0.99 * w0
    if bounded or np.var(fit.fun) > 0.5 * np.var(rest):
        return "no single damped mode fits what swings"
    c = np.linalg.lstsq(basis(fit.x), x, rcond=None)[0]
    return SwingMode(w_d / (2.0 * math.pi), decay / math.hypot(w_d, decay), math.hypot(c[2], c[3]))
