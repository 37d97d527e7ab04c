"""Numbers drawn from a seed, and the ropes and trips that they are drawn from: the published case is none of them."""

import numpy as np

LENGTH = (60.0, 1200.0)  # m
MASS = (3.0, 15.0)  # kg/m
BENDING = (50.0, 3000.0)  # N m^2
SPACING = (1.2, 3.0)  # m
#: EA (N) per mass per length (kg/m) of steel wire ropes, that of the published case's assumed data in the middle
STIFFNESS = (1.1e7, 2.0e7)
SPEED = (4.0, 20.0)  # m/s
ACCELERATION = (0.5, 1.5)  # m/s^2
JERK = (0.3, 3.0)  # m/s^3
#: how near an end the loop hangs when the trip begins, in rope lengths
NEAR = (0.13, 0.3)


class Draws:
    """Numbers one after the other; the same seed gives the same."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)

    def evenly(self, bounds: tuple[float, float] = (0.0, 1.0)) -> float:
        """A number between the bounds."""
        return float(self._rng.uniform(*bounds))

    def in_logarithms(self, bounds: tuple[float, float]) -> float:
        """One whose logarithm is spread evenly."""
        return float(np.exp(self._rng.uniform(*np.log(bounds))))

    def one_of(self, number: int) -> int:
        """A place among so many."""
        return int(self._rng.integers(number))
