"""The methods, and the coefficients of those with stages: stiffly accurate, diagonally implicit Runge-Kutta methods.

A row has the weights of the derivatives at the step's start and at the stages before, and last that of the stage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Method:
    """What a step is made by, its order, and its stages by rows."""

    kind: Literal["generalized-alpha", "stages", "backward"]
    name: str
    order: int
    rows: tuple[tuple[float, ...], ...] = ()


ALPHA, BDF2 = Method("generalized-alpha", "generalized-alpha", 2), Method("backward", "BDF2", 2)


def bathe(rho: float) -> Method:
    """The rho_inf-Bathe method, two substeps; Noh and Bathe, Computers and Structures 212 (2019)."""
    g = (2 - math.sqrt(2 + 2 * rho)) / (1 - rho)
    q1 = (rho + 1) / (2 * g * (rho - 1) + 4)
    q2 = 0.5 - g * q1
    return Method("stages", f"Bathe, rho {rho:g}", 2, ((g / 2, g / 2), (1 - q1 - q2, q1, q2)))


#: Alexander, SIAM J. Numer. Anal. 14 (1977); its stages are of first order, those of the others of second
_G2 = 1 - math.sqrt(0.5)
SDIRK2 = Method("stages", "SDIRK 2", 2, ((0.0, _G2), (0.0, 1 - _G2, _G2)))
#: implicit part of ARK3(2)4L[2]SA; Kennedy and Carpenter, Appl. Numer. Math. 44 (2003)
_G3 = 1767732205903 / 4055673282236
ESDIRK3 = Method(
    "stages",
    "ESDIRK 3",
    3,
    (
        (_G3, _G3),
        (2746238789719 / 10658868560708, -640167445237 / 6845629431997, _G3),
        (1471266399579 / 7840856788654, -4482444167858 / 7529755066697, 11266239266428 / 11593286722821, _G3),
    ),
)
#: implicit part of ARK4(3)6L[2]SA, the same source
ESDIRK4 = Method(
    "stages",
    "ESDIRK 4",
    4,
    (
        (1 / 4, 1 / 4),
        (8611 / 62500, -1743 / 31250, 1 / 4),
        (5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4),
        (15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912, 1 / 4),
        (82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4),
    ),
)
