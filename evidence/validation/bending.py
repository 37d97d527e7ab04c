"""Measured bending that remembers: a cable's stiffness while its parts stick, and once they slip.

E. Cadavid Gil and others, Procedia Structural Integrity 77 (2026) 248-255, pages 250 and 253: a submarine power cable
of 164.5 mm on two rollers 3.6 m apart, bent to and fro in its middle without tension, at three stages of one series of
cycles.
"""

from __future__ import annotations

from evidence.tables import Table, table

#: N m^2, by what its parts do: the three published values, and the first and last of a steady fall
PUBLISHED = {"stick": (96.87e3, 100.59e3, 81.39e3), "slip": (9.67e3, 8.89e3)}


def measure() -> Table:
    """The range of either."""
    return table(("parts", "least", "most"), [(parts, min(x), max(x)) for parts, x in PUBLISHED.items()])


def from_constant(least: float, most: float) -> float:
    """By how much the best constant misses them, of itself."""
    return (most - least) / (most + least)
