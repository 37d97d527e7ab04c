"""The laws behind the lengths of the mesh, fitted to the tables.

With w = (EI / rho g)^(1/3), over which weight and bending balance, and x = fine / w:

    loop      too low by   A w x^4
    cover     off by       C w x^p exp(-b (cover / w)^(3/2))
    ends      relative error of the clamp moment  D (end element / layer)^q,  layer = sqrt(EI / T)
    legs      off by       E grading_length L

Loop: the fourth order of cubics that bend and keep their length.  The axial stiffness has no part in it: elements with
the strain of their Gauss points would lock (docs/stability.md).
Cover: near a vertical leg the angle obeys EI psi'' = rho g s psi, Airy's equation, whose solution decays as
exp(-2/3 (s/w)^(3/2)).  Ends: a beam under tension T bends within sqrt(EI / T) of its clamp.  Legs: elements as long as
sqrt(grading_length x) have all waves of one frequency lag by the same angle, and what they lag adds up along the leg.
"""

from typing import NamedTuple

import numpy as np

from evidence.tables import Array, Table, Tables

#: what the fits use: loop elements below this many w, and above those with errors near rounding; covers above this many
#: w, and above errors near rounding; end elements up to this many layers
SHORT = 0.65
RESOLVABLE = 0.25
ABOVE = 1.25
TREMBLES = 1e-7
RESOLVED = 4.0


class Fit(NamedTuple):
    """Coefficients, and the root mean square and the largest of the logarithm that they leave."""

    values: tuple[float, ...]
    spread: float
    worst: float


class Laws(NamedTuple):
    """All fits: A; C, p, b; D, q; E, of smooth trips and of emergency stops."""

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


def loop_error(values: tuple[float, ...], fine: Array, w: Array) -> Array:
    """How much too low the loop hangs, m."""
    (A,) = values
    return np.asarray(A * w * (fine / w) ** 4)


def cover_error(values: tuple[float, ...], fine: Array, cover: Array, w: Array) -> Array:
    """How far the loop is off, m, by fine elements that end ``cover`` (m) above its lowest point."""
    C, p, b = values
    return np.asarray(C * w * (fine / w) ** p * np.exp(-b * (cover / w) ** 1.5))


def moment_error(values: tuple[float, ...], end: Array, layer: Array) -> Array:
    """Relative."""
    D, q = values
    return np.asarray(D * (end / layer) ** q)


def _loop(t: Table) -> Fit:
    x = t["fine [m]"] / t["w [m]"]
    used = (x > RESOLVABLE) & (x < SHORT)
    ratio = np.log(t["too low [m]"][used] / (t["w [m]"][used] * x[used] ** 4))
    return _fit((float(np.exp(np.median(ratio))),), ratio - np.median(ratio))


def _cover(t: Table) -> Fit:
    w = t["w [m]"]
    used = (t["cover [m]"] > ABOVE * w) & (t["off [m]"] > TREMBLES * w)
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
