"""The swing mode that a trip leaves behind, measured: x(t) = c + e^(-zeta w t) (a cos w_d t + b sin w_d t).

All of these, and a drift, are fitted to a record by least squares.
"""

import math
import warnings
from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array

_NO_MODE = "no single damped mode fits what swings"


@dataclass(frozen=True)
class SwingMode:
    """Damped mode that was fitted to a record."""

    frequency: float  # Hz, damped
    damping: float  # 1, ratio
    amplitude: float  # unit of the record, at its first instant


def fit_swing(time: Array, x: Array) -> SwingMode | str:
    """Return the strongest mode of an evenly sampled record; else why there is none, in words."""
    # as slow to load as all the rest of a demo
    from scipy.optimize import (
        OptimizeWarning,
        curve_fit,
    )

    t = time - time[0]
    rest = x - np.polynomial.Polynomial.fit(t, x, 1)(t)
    if t.size < 16 or float(np.ptp(rest)) < 1e-9:
        return "the record is too short" if t.size < 16 else "nothing swings"
    spectrum = np.abs(np.fft.rfft(rest * np.hanning(t.size), 8 * t.size))
    frequencies = np.fft.rfftfreq(8 * t.size, t[1] - t[0])
    w0 = 2.0 * math.pi * max(float(frequencies[int(np.argmax(spectrum))]), 0.5 / t[-1])

    def columns(t: Array, w: float, decay: float) -> Array:
        wave = np.exp((1j * w - decay) * t)
        return np.stack([np.ones_like(t), t, wave.real, wave.imag], axis=1)

    def swing(t: Array, w: float, decay: float, *c: float) -> Array:
        return np.asarray(columns(t, w, decay) @ c)

    def derivatives(t: Array, w: float, decay: float, *c: float) -> Array:
        _, _, cosine, sine = (A := columns(t, w, decay)).T
        return np.column_stack(
            [t * (c[3] * cosine - c[2] * sine), -t * (c[2] * cosine + c[3] * sine), A]
        )

    start = w0, 0.03 * w0
    linear = np.linalg.lstsq(columns(t, *start), x, rcond=None)[0]
    with (
        np.errstate(all="ignore"),
        warnings.catch_warnings(action="ignore", category=OptimizeWarning),
    ):
        try:  # a mode takes ten evaluations
            w_d, decay, *c = curve_fit(swing, t, x, [*start, *linear], jac=derivatives, maxfev=25)[
                0
            ].tolist()
        except RuntimeError:
            return _NO_MODE
    # a fit that ends far from where it began has found a drift or a bump, not a mode
    far = not (0.51 * w0 < w_d < 1.49 * w0 and -0.1 * w0 < decay < 0.99 * w0)
    if far or np.var(swing(t, w_d, decay, *c) - x) > 0.5 * np.var(rest):
        return _NO_MODE
    return SwingMode(w_d / (2.0 * math.pi), decay / math.hypot(w_d, decay), math.hypot(c[2], c[3]))
