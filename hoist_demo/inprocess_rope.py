"""The balance rope in this process: the same RopePlant as the FMU, without the FMU.

The only module of the host that knows rope_model; it serves as the FMU's twin and for debugging.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Literal

from hoist_demo.rope_plant import EndMotion, RopeStatus
from rope_model.native.engine import rope_simulator
from rope_model.parameters import PRESETS, Level, Scene
from rope_model.simulation import ends
from rope_model.simulation.signals import SIGNALS, group_of, signals
from rope_model.simulation.state import RopeState


class InProcessRope:
    """A RopePlant around rope_model's simulator."""

    def __init__(self, scene: Scene) -> None:
        self._simulator = rope_simulator(scene)

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """Find the hanging shape at t0 [s]."""
        status = self._simulator.initialize(t0, _motion(left), _motion(right))
        return RopeStatus(bool(status.valid), str(status.message))

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        """Advance to t + h [s]; the motions hold there."""
        status = self._simulator.advance_to(t + h, _motion(left), _motion(right))
        return RopeStatus(bool(status.valid), str(status.message))

    def signals(self) -> dict[str, float]:
        """All outputs by FMI name."""
        return {name: float(value) for name, value in signals(self._simulator).items()}

    def read(self, names: Iterable[str]) -> dict[str, float]:
        """Some outputs; kin are computed together."""
        wanted = [name for name in names if name in SIGNALS]
        values: dict[str, float] = {}
        for name in wanted:
            if name not in values:
                values |= group_of(name)(self._simulator)
        return {name: float(values[name]) for name in wanted}

    def save(self) -> RopeState:
        """The state, which nothing changes."""
        return self._simulator.state

    def restore(self, snapshot: RopeState) -> None:
        """Go on from a state."""
        self._simulator.restore(snapshot)

    def free(self, snapshot: RopeState) -> None:
        """Nothing is held."""

    def to_bytes(self, snapshot: RopeState) -> bytes:
        """The state as bytes."""
        return snapshot.to_bytes()

    def from_bytes(self, data: bytes) -> RopeState:
        """The state that these bytes hold."""
        return RopeState.from_bytes(data)

    def units(self) -> dict[str, str]:
        """Unit of each output."""
        return {name: str(signal.unit) for name, signal in SIGNALS.items()}

    def close(self) -> None:
        """Nothing is held."""


def rope_in_process(
    scene: str, kernels: Literal["auto", "compiled", "portable"] = "auto", level: Level = "standard"
) -> InProcessRope:
    """The rope of a named scene at a level of accuracy."""
    if scene not in PRESETS:
        raise ValueError(f"scene = '{scene}' must be one of {', '.join(PRESETS)}: choose one")
    data = PRESETS[scene](level).scene
    return InProcessRope(data.with_(solver=replace(data.solver, kernels=kernels)))


def _motion(end: EndMotion) -> ends.EndMotion:
    """The same numbers in rope_model's own type."""
    return ends.EndMotion(**asdict(end))
