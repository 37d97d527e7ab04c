"""Data that the hoist has of its balance rope beside the rope itself."""

from __future__ import annotations

import math
from collections.abc import Mapping

from hoist_demo.parameters import Hoist
from hoist_demo.parameters.parameter import Value

SHARED = (("rope.mass_per_length", "tail_rope_mass", "kg/m"), ("rope.length", "tail_rope_length", "m"))
"""Parameters of the rope of which the hoist has a copy for its controller, and their unit."""


def tail_rope(values: Mapping[str, Value]) -> dict[str, Value]:
    """Fields of the hoist by which its drive takes the balance rope for the one with these parameters."""
    return {field: values[name] for name, field, _ in SHARED if name in values}


def contradictions(hoist: Hoist, rope: Mapping[str, Value]) -> str:
    """Return where the drive's copy of the balance rope's data differs from the rope's; "" if they agree."""
    told = []
    for name, field, unit in SHARED:
        computed, assumed = rope.get(name), getattr(hoist, field)
        if isinstance(computed, int | float) and not math.isclose(computed, assumed, rel_tol=1e-3):
            told.append(
                f"{name} = {computed:g} {unit} and hoist.{field} = {assumed:g} {unit} contradict each other: "
                f"the drive holds and accelerates by its own number; set hoist.{field} = {computed:g}, too"
            )
    return "; ".join(told)
