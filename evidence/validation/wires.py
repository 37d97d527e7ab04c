"""A hanging ring of wire is turned at one end until it throws a loop.

Measured: the twist at which wires of 1.5 m did, each five times; github.com/qj25/adapteddlo_muj (Chen, Bretl, Pham,
arXiv:2310.00911), scripts/real2sim_paramiden.py.  Both ends point away from each other, horizontally, so that the wire
hangs below its holder as a ring.

The stiffnesses are published fits: EI to the shape without twist, GJ to these very angles, each by two models of the
authors' and, for GJ, in two versions of the file.  They disagree; all of them go through ours.
"""

import math
from dataclasses import dataclass

import numpy as np

from evidence.statics import clamped, rod, turned
from evidence.tables import Array, Table, rows, table
from rope_model.parameters import Rope
from rope_model.physics.node import ANGLE, SLOPE
from rope_model.reference.equations import Equations
from rope_model.reference.statics import find_equilibrium

LENGTH = 1.5  # m, of the published set-up
GRAVITY = 9.81  # m/s^2
#: m between the ends, as we read it from the authors' model of their holder; and what we could have misread
GAP = 0.09
GAPS = (0.06, GAP, 0.12)
#: N, assumed: it stretches the wires by less than 1e-3 of their length
QA = 1e3
#: deg: the end's turn between two shapes at rest, and the largest that is tried
STEP = 10.0
MOST = 3000.0


@dataclass(frozen=True)
class Wire:
    """Mass (kg/m), twists measured (deg), and pairs of EI and GJ (N m^2) that were fitted."""

    name: str
    mass: float
    twists: tuple[float, ...]
    stiffness: tuple[tuple[float, float], ...]

    def rope(self, length: float, EI: float, GJ: float) -> Rope:
        """Return ``length`` (m) of it."""
        # rho J takes no part in statics, but must not be zero
        return Rope(length, self.mass, QA, 0.0, 0.0, GJ, EI=EI, rhoJ=1e-6)


def _pairs(
    EI: float, ratios: tuple[float, ...], other: tuple[float, float]
) -> tuple[tuple[float, float], ...]:
    """``ratios`` of GJ to EI by the authors' own model; ``other`` EI and ratio, by MuJoCo's cable."""
    return *((EI, ratio * EI) for ratio in ratios), (other[0], other[1] * other[0])


WIRES = (
    Wire(
        "white",
        0.087 / 5.0,
        (970.0, 970.0, 980.0, 975.0, 980.0),
        _pairs(
            5.644018525809911e-05, (0.68, 0.8232421875, 0.8291015625), (7.256595247469885e-05, 0.71)
        ),
    ),
    Wire(
        "black",
        0.081 / 2.98,
        (470.0, 500.0, 480.0, 470.0, 490.0),
        _pairs(
            0.0009997975674291843, (1.10, 1.3857421875, 1.5205078125), (0.0010643006362955833, 1.05)
        ),
    ),
    Wire(
        "red",
        0.043 / 2.0,
        (430.0, 470.0, 445.0, 445.0, 460.0),
        _pairs(
            0.00063696780505569, (1.5263671875, 1.7724609375, 1.89), (0.0006732507812930395, 1.80)
        ),
    ),
)


def ring(wire: Wire, EI: float, GJ: float, gap: float, elements: int) -> tuple[Equations, Array]:
    """The wire without twist and a circle to find its shape from."""
    s = np.linspace(0.0, 1.0, elements + 1)
    turn = 2 * np.pi * s
    radius = LENGTH / (2 * np.pi)
    q = np.zeros((s.size, 7))
    q[:, 0] = gap * (s - 0.5) - radius * np.sin(turn)
    q[:, 1] = -radius * (1 - np.cos(turn))
    q[:, SLOPE] = np.column_stack((-np.cos(turn), -np.sin(turn), np.zeros(s.size)))
    return rod(wire.rope(LENGTH, EI, GJ), GRAVITY, q, clamped(q)), q


def thrown(wire: Wire, EI: float, GJ: float, gap: float, elements: int = 80) -> float:
    """Turn (deg) of one end, to half a STEP, at which the wire throws a loop: its twist falls as it is turned on.

    Infinite where it does not up to MOST.
    """
    equations, q = ring(wire, EI, GJ, gap, elements)
    q = find_equilibrium(equations, q).q
    for turn in np.arange(0.0, MOST, STEP):
        following = turned(equations, q, math.radians(STEP)).q
        if following[-1, ANGLE] < q[-1, ANGLE]:
            return float(turn) + 0.5 * STEP
        q = following
    return math.inf


def measure() -> Table:
    """What each wire does with each pair of stiffnesses and each gap."""
    cases = [(w, EI, GJ, gap) for w in WIRES for EI, GJ in w.stiffness for gap in GAPS]
    return table(
        ("wire", "EI", "GJ", "gap", "least", "most", "found"),
        [
            (w.name, EI, GJ, gap, min(w.twists), max(w.twists), thrown(w, EI, GJ, gap))
            for w, EI, GJ, gap in cases
        ],
    )


def outside(t: Table, wire: str, gaps: tuple[float, ...]) -> float:
    """By how many degrees the measured range sticks out of that of all stiffnesses at ``gaps``."""
    chosen = rows(t, wire=wire, gap=gaps)
    return float(
        max(
            0.0,
            np.min(chosen["found"]) - chosen["least"][0],
            chosen["most"][0] - np.max(chosen["found"]),
        )
    )
