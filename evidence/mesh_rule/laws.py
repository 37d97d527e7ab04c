"""The laws behind the lengths of the mesh, fitted to the tables.

With w = (EI / rho g)^(1/3), over which weight and bending balance, x = fine / w and S = EA w^2 / EI:

    loop      too high by  A w x^2 N / (1 + N),  N = B S x^4
    cover     off by       C w x^p exp(-b (cover / w)^(3/2))
    ends      relative error of the clamp moment  D (end element / layer)^q,  layer = sqrt(EI / T)
    legs      off by       E grading_length L

Loop: a cubic of length l bends without stretching as far as its curvature is even; what is left of curvature times its
change, k k' l^3, is strain.  Where EA that^2 is much larger than EI k^2, N >> 1, elements do not stretch, each has one
shape left, its angle, and the chain converges with l^2 (membrane locking); where it is much smaller, with EA / EI l^6.
Cover: near a vertical leg the angle obeys EI psi'' = rho g s psi, Airy's equation, whose solution decays as
exp(-2/3 (s/w)^(3/2)).  Ends: a beam under tension T bends within sqrt(EI / T) of its clamp.  Legs: elements as long as
sqrt(grading_length x) have all waves of one frequency lag by the same angle, and what they lag adds up along the leg.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from evidence.tables import Array, Table, Tables

#: what the fits use: loop elements below this many w, further down the leg than this, end elements up to this many
#: layers
SHORT = 0.6
ABOVE = 1.25
RESOLVED = 4.0


class Fit(NamedTuple):
    """Coefficients, and the root mean square and the largest of the logarithm that they leave."""

    values: tuple[float, ...]
    spread: float
    worst: float


class Laws(NamedTuple):
    """All fits: A, B; C, p, b; D, q; E, of smooth trips and of emergency stops."""

    loop: Fit
    cover: Fit
    ends: Fit
    legs: Fit
    legs_stopped: Fit


def fit(tables: Tables) -> Laws:
    """To the tables of statics and trips."""
    return Laws(
        _loop(tables["loop"]),
        _cover(tables["cover"]),
        _ends(tables["ends"]),
        _legs(tables["parts"], "smooth"),
        _legs(tables["parts"], "emergency stop"),
    )


def stiffness(EA: Array, EI: Array, w: Array) -> Array:
    """S."""
    return EA * w**2 / EI


def loop_error(values: tuple[float, ...], fine: Array, w: Array, S: Array) -> Array:
    """How much too high the loop hangs, m."""
    A, B = values
    x = fine / w
    locked = B * S * x**4
    return np.asarray(A * w * x**2 * locked / (1 + locked))


def cover_error(values: tuple[float, ...], fine: Array, cover: Array, w: Array) -> Array:
    """How far the loop is off, m, by fine elements that end ``cover`` (m) above its lowest point."""
    C, p, b = values
    return np.asarray(C * w * (fine / w) ** p * np.exp(-b * (cover / w) ** 1.5))


def moment_error(values: tuple[float, ...], end: Array, layer: Array) -> Array:
    """Relative."""
    D, q = values
    return np.asarray(D * (end / layer) ** q)


def _loop(t: Table) -> Fit:
    w = t["w [m]"]
    S = stiffness(t["EA [N]"], t["EI [N m2]"], t["w [m]"])
    used = t["fine [m]"] < SHORT * w
    measured = np.log(t["too high [m]"][used])

    def residual(logarithms: Array) -> Array:
        values = tuple(np.exp(logarithms))
        return np.asarray(
            np.log(loop_error(values, t["fine [m]"][used], w[used], S[used])) - measured
        )

    found = least_squares(residual, np.log([0.02, 3e-3]))
    return _fit(tuple(np.exp(found.x)), residual(found.x))


def _cover(t: Table) -> Fit:
    w = t["w [m]"]
    used = t["cover [m]"] > ABOVE * w
    x, up, off = (t[name][used] / w[used] for name in ("fine [m]", "cover [m]", "off [m]"))
    (a, p, b), left = _linear(
        np.stack([np.ones_like(x), np.log(x), -(up**1.5)], axis=1), np.log(off)
    )
    return _fit((float(np.exp(a)), p, b), left)


def _ends(t: Table) -> Fit:
    y = t["end element [m]"] / t["layer [m]"]
    used = y < RESOLVED
    (a, q), left = _linear(
        np.stack([np.ones(used.sum()), np.log(y[used])], axis=1), np.log(t["moment error"][used])
    )
    return _fit((float(np.exp(a)), q), left)


def _legs(t: Table, trip: str) -> Fit:
    used = (
        (t["what"] == "legs") & (t["trip"] == trip) & (t["off [m]"] > 0)
    )  # short legs may have no longer elements
    ratio = np.log(t["off [m]"][used] / (t["grading_length [m]"][used] * t["length [m]"][used]))
    return _fit((float(np.exp(np.median(ratio))),), ratio - np.median(ratio))


def _linear(columns: Array, measured: Array) -> tuple[tuple[float, ...], Array]:
    """Coefficients of least squares, and what they leave."""
    found = np.linalg.lstsq(columns, measured, rcond=None)[0]
    return tuple(float(x) for x in found), columns @ found - measured


def _fit(values: tuple[float, ...], left: Array) -> Fit:
    return Fit(
        tuple(float(x) for x in values), float(np.sqrt(np.mean(left**2))), float(np.abs(left).max())
    )
