"""A clamped rod under tension T and torque M buckles: ours against the linear theory of the rod.

With w = y + i z, EI w'''' - i M w''' - T w'' = 0 has w = a + b s + exp(i m s) (c exp(i l s) + d exp(-i l s)), where
m = M/(2 EI) and l^2 = m^2 - T/EI; w and w' vanish at both clamps.

Source: van der Heijden, Neukirch, Goss and Thompson, Int. J. Mech. Sci. 45 (2003) 161-196, its equation 33, as
CableDyn's VALIDATION.md prints its values: M/(2 sqrt(EI T)) = 1.0124 at T L^2/EI = 400 and 1.0031 at 1600.
"""

import math

import numpy as np
from scipy.optimize import brentq

from evidence.statics import clamped, matrix, rod
from evidence.tables import Array, Table, table
from rope_model.analysis.modes import ZERO_STIFFNESS, softest
from rope_model.parameters import Rope
from rope_model.physics.node import ANGLE, arc_lengths
from rope_model.reference.equations import Equations

BEND = 1.0  # N m^2
TWIST_STIFFNESS = 0.7  # N m^2
AXIAL = 1e3  # N
TENSION = 1.0  # N

#: M/(2 sqrt(EI T)) by T L^2/EI, as printed there
PRINTED = {400.0: 1.0124, 1600.0: 1.0031}
#: 2 sqrt(EI T), N m: where the rod of any length buckles at last
INFINITE = 2.0 * math.sqrt(BEND * TENSION)
#: of the model's rod, which the theory leaves out
STRETCH = TENSION / AXIAL


def straight_rod(elements: int, length: float) -> tuple[Equations, Array]:
    """Clamped at both ends, under TENSION, without weight; ``length`` in m."""
    rope = Rope(length, 1.0, AXIAL, 0.0, 0.0, TWIST_STIFFNESS, EI=BEND, rhoJ=0.1)
    s = np.linspace(0.0, length, elements + 1)
    q = np.zeros((s.size, 7))
    q[:, 0] = s * (1 + TENSION / AXIAL)
    q[:, 3] = 1 + TENSION / AXIAL
    return rod(rope, 0.0, q, clamped(q)), q


def is_stable(equations: Equations, q: Array, torque: float) -> bool:
    """Whether no small motion lowers the straight rod's energy, its end turned until it carries ``torque`` (N m)."""
    q = q.copy()
    q[:, ANGLE] = torque / TWIST_STIFFNESS * arc_lengths(equations.lengths)
    stiffness = matrix(equations, q, (1.0, 0.0, 0.0))
    return softest(stiffness, ~equations.held) > -ZERO_STIFFNESS


def theory(slenderness: float) -> float:
    """The smallest M/(2 sqrt(EI T)) at which a rod of T L^2/EI = ``slenderness`` buckles."""
    half = 0.5 * math.sqrt(slenderness)  # L/2, over sqrt(EI/T)

    def condition(m: float) -> float:
        """Zero where w(-s) = conj(w(s)) satisfies the clamps; divided by l, which is no solution."""
        l = math.sqrt(m * m - 1.0)
        cm = math.cos(m * half)
        sm = math.sin(m * half)
        cl = math.cos(l * half)
        sl = math.sin(l * half)
        # of the two waves, c = cos(l s) exp(i m s) and d = i sin(l s) exp(i m s): real part's slope, imaginary part
        slope = (-m * sm * cl - l * cm * sl, -m * cm * sl - l * sm * cl)
        value = (sm * cl, cm * sl)
        rate = (m * cm * cl - l * sm * sl, -m * sm * sl + l * cm * cl)
        line = tuple(v - half * r for v, r in zip(value, rate, strict=True))
        return (slope[0] * line[1] - slope[1] * line[0]) / l

    l = np.linspace(1e-3, 4.0 * math.pi, 2001) / half
    tries = np.sqrt(1.0 + l * l)
    signs = np.sign([condition(m) for m in tries])
    first = int(np.flatnonzero(signs[1:] != signs[:-1])[0])
    return float(brentq(condition, tries[first], tries[first + 1], xtol=1e-12))


def ours(slenderness: float, elements: int = 80) -> float:
    """The same by the stability of the model's straight rod."""
    equations, q = straight_rod(elements, math.sqrt(slenderness * BEND / TENSION))
    low = 0.9 * INFINITE
    high = 1.5 * INFINITE
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(equations, q, middle) else (low, middle)
    return 0.5 * (low + high) / INFINITE


def measure() -> Table:
    """Printed, by the theory and the model's."""
    found = [(size, printed, theory(size), ours(size)) for size, printed in PRINTED.items()]
    return table(("slenderness", "printed", "theory", "ours"), found)
