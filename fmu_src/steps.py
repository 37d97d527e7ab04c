"""A communication step of the rope, by either reading of the inputs."""

from __future__ import annotations

from rope_model.simulation.ends import SHORTEST_AIM, EndMotion
from rope_model.simulation.simulator import RopeSimulator, Status


def step(rope: RopeSimulator, t: float, h: float, left: EndMotion, right: EndMotion, at_step_end: bool) -> Status:
    """From ``t`` to ``t + h``; the motions are those of its end, or of its start and extrapolated."""
    if at_step_end:
        return rope.advance_to(t + h, left, right)
    before = rope.state.last_interval if rope.state.counts.steps else 0.0
    return rope.advance_to(t + h, left.extrapolated(h), right.extrapolated(h), max(SHORTEST_AIM, before))
