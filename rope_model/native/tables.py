"""What the native rope takes from the Python one when it is built."""

from __future__ import annotations

import re

from ..simulation.signals import SHAPE_POINTS, SIGNALS, group_of


def signal_numbers() -> str:
    """The text of signal_numbers.h: the signals' numbers and groups.

    A number is the place in SIGNALS, a group the function of simulation.signals that computes the signal.
    """
    numbers = "".join(f"    {constant(name)},\n" for name in SIGNALS)
    groups = ", \\\n".join(f"    {group_of(name).__name__.upper()}" for name in SIGNALS)
    return (
        "/* Generated from rope_model.simulation.signals by rope_model.native.tables. */\n"
        "#ifndef SIGNAL_NUMBERS_H\n#define SIGNAL_NUMBERS_H\n\n"
        f"enum {{\n{numbers}    SIGNALS,\n    SHAPE_POINTS = {SHAPE_POINTS}\n}};\n\n"
        f"/* of each signal, an enum of signals.h */\n#define SIGNAL_GROUPS \\\n{groups}\n\n#endif\n"
    )


def constant(name: str) -> str:
    """Name of a signal's number in C: SIGNAL_SHAPE_X_1 for ``shape.x[1]``."""
    return "SIGNAL_" + re.sub(r"\W+", "_", name).strip("_").upper()
