"""Data of the exchange between drive and rope."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hoist_demo.parameters.components import require
from hoist_demo.parameters.quantity import quantity


@dataclass(frozen=True)
class Coupling:
    """How drive and rope exchange their data."""

    step: float = quantity(0.01, "s", "communication step H")
    start: float = quantity(0.0, "s")
    scheme: str = "gauss-seidel-1"  # one of hoist_demo.cosimulation.schemes.catalogue
    sample: float | None = quantity(
        None, "s", "sample time of controller and recording, a multiple of step; None: the step"
    )

    def __post_init__(self) -> None:
        require(self.step, 0.0 < self.step <= 0.1, "step", "above 0 and at most 0.1 s", "take 0.005 to 0.02 s")
        require(self.start, True, "start", "finite", "give a time in s")
        require(
            self.sample_time,
            self.per_sample >= 1 and abs(self.per_sample * self.step - self.sample_time) <= 1e-9 * self.sample_time,
            "sample",
            f"a multiple of the communication step {self.step:g} s",
            "take the step itself, or twice or thrice",
        )

    @cached_property
    def sample_time(self) -> float:
        """Sample time of controller and recording [s]."""
        return self.step if self.sample is None else self.sample

    @cached_property
    def per_sample(self) -> int:
        """Communication steps from one sample to the next."""
        return round(self.sample_time / self.step)
