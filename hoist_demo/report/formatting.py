"""Numbers, units and rows of tables as texts for people."""

import math
import re

Row = tuple[str, ...]  #: Quantity, value and unit as texts, and perhaps what more is known of it.


def number(value: float, digits: int = 5) -> str:
    """Format a number for people, without an exponent where ten places do."""
    text = f"{value:.{digits}g}"
    if "e+" in text:
        return f"{float(text):.10g}"
    return text


_UNITS_WITH_PREFIX = ("J", "N", "W", "Pa")
_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3}


def engineering(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor to a unit in which this magnitude has few digits, and that unit.

    For 9.96e7 J these are 1e-6 and MJ.
    """
    first = re.split(r"[.\s/]", unit)[0]
    if first in _UNITS_WITH_PREFIX:
        for prefix, size in _PREFIXES.items():
            if largest >= 10.0 * size:
                return 1.0 / size, prefix + unit
    return 1.0, unit


def unit_text(unit: str) -> str:
    """Format a unit for people: ``N.m2`` and ``N m^2`` as N m², and nothing for a pure number."""
    text = unit.replace(".", " ").replace("^", "") if unit != "1" else ""
    return re.sub(r"(?<=[A-Za-z])[23]", lambda match: {"2": "²", "3": "³"}[match[0]], text)


def rounded(value: float, error: float) -> str:
    """Return a number with the decimals that its error allows, three at most.

    An unknown error leaves three digits.
    """
    if not error > 0.0:
        return number(value, 3)
    decimals = min(3, max(0, round(-math.log10(error))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
