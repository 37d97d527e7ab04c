"""Data of the exchange between drive and rope."""

from dataclasses import dataclass
from functools import cached_property

from hoist_demo.parameters.components import require
from hoist_demo.parameters.quantity import UNBOUNDED, NumberRange, ValidatedData, parameter

#: Part of a sample time that rounding may leave between it and whole steps.
SAMPLE_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Coupling(ValidatedData):
    """Exchange of data between drive and rope."""

    step: float = parameter(
        0.01, "s", "communication step H", NumberRange(0.0, 0.1, True, "take 0.005 to 0.02 s")
    )
    start: float = parameter(0.0, "s", "simulated time at the start", UNBOUNDED)
    #: one of hoist_demo.cosimulation.schemes.catalogue
    scheme: str = parameter(
        "gauss-seidel-1", "-", "coupling scheme, listed by wind --help", UNBOUNDED
    )
    sample: float | None = parameter(
        None,
        "s",
        "sample time of the controller, a multiple of step or a whole part of it; left out: the "
        "step",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        sample = self.sample_time
        step = f"the communication step {self.step:g} s"
        remainder = abs(self.per_sample * self.step - self.per_step * sample)
        require(
            sample,
            remainder <= SAMPLE_TOLERANCE * sample,
            name="sample",
            bound=f"a multiple of {step}, or a whole part of it",
            cure="take the step itself, twice or half of it",
        )
        require(
            sample,
            self.per_step == 1 or self.scheme != "energy-controlled",
            name="sample",
            bound=f"at least {step} with the scheme energy-controlled, which divides it",
            cure="take the step itself, or another scheme",
        )

    @cached_property
    def sample_time(self) -> float:
        """Sample time of the controller [s]."""
        if self.sample is None:
            return self.step
        return self.sample

    @cached_property
    def per_sample(self) -> int:
        """Communication steps from one sample to the next; 1 where a step has several samples."""
        return max(1, round(self.sample_time / self.step))

    @cached_property
    def per_step(self) -> int:
        """Samples in a communication step; 1 where it has fewer."""
        return max(1, round(self.step / self.sample_time))

    @cached_property
    def period(self) -> float:
        """Time from one recorded instant to the next, all of them ends of steps and samples [s]."""
        return max(self.step, self.sample_time)
