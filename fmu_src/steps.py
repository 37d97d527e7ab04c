"""FMI's reading of the inputs: the motion at the start of a communication step."""

from __future__ import annotations

from rope_model.simulation.balance_rope import Status
from rope_model.simulation.paths import SHORTEST_AIM, EndMotion
from rope_model.simulation.simulator import RopeSimulator


def advance_with_extrapolation(rope: RopeSimulator, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
    """From ``t`` to ``t + h``, with motions of the time ``t``.

    What the step before missed is made good within at most as long as that step took.
    """
    before = rope.state.last_interval if rope.state.counts.steps else 0.0
    return rope.advance_to(t + h, left.extrapolate(h), right.extrapolate(h), max(SHORTEST_AIM, before))
