"""One case: all that a run needs besides the coupling."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hoist_demo.control.controller import Gains
from hoist_demo.parameters import Hoist, Winding

LOCKED, COULOMB = 0, 2  #: Codes of swivel.mode, docs/reference/variables.md.

#: What the source of the published rope states of it.
PUBLISHED_ROPE = ("rope.length", "rope.Qb", "rope.Qc", "hoist.tail_rope_length")


def swivels(mode: int, **data: float) -> dict[str, float]:
    """Parameters by FMI name of two equal swivels."""
    values: dict[str, float] = {"mode": mode, **data}
    return {f"{side}.swivel.{name}": value for name, value in values.items() for side in ("left", "right")}


@dataclass(frozen=True)
class Case:
    """A hoist, its trip, its controller's gains, and one of its balance ropes."""

    hoist: Hoist
    winding: Winding
    gains: Gains = field(default_factory=Gains)
    rope: Mapping[str, float | int | str] = field(
        default_factory=dict
    )  # parameters by FMI name; the rest is the rope's own
    published: str = ""  # what the source of an installed hoist states
    stated: tuple[str, ...] = ()  # the parameters that its source states, by the names of a study
    source: str = ""  # "" for a case of ours
