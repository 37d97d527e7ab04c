"""Hoist and winding of the published ropes."""

from __future__ import annotations

from dataclasses import dataclass

from hoist_demo.parameters.hoist import Hoist
from hoist_demo.parameters.winding import Winding


@dataclass(frozen=True)
class Setup:
    """Hoist and winding that belong to a scene of the balance rope."""

    hoist: Hoist
    winding: Winding


SETUPS = {
    "rope-120": Setup(Hoist(), Winding()),
    "rope-240": Setup(Hoist(shaft_travel=200.0, tail_rope_length=240.0), Winding(travel=200.0, speed=10.0)),
}
