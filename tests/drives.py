"""A drive under inputs that have names, and what it shows by name."""

from collections import namedtuple
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from hoist_demo.drive.equations import INPUT_NAMES, equations, numbers_of, parts_of
from hoist_demo.drive.outputs import OUTPUTS, tension_ratio
from hoist_demo.drive.plant import HoistPlant, PlantState, PlantStep


@dataclass(frozen=True)
class PlantInput:
    """Held over one communication step, in the order of INPUT_NAMES; forces are those of one balance rope."""

    torque_command: float
    force_left: float
    force_right: float
    brake: float = 0.0
    fx_left: float = 0.0
    fz_left: float = 0.0
    my_left: float = 0.0
    fx_right: float = 0.0
    fz_right: float = 0.0
    my_right: float = 0.0


@dataclass(frozen=True)
class PlantInputPath:
    """Input over one communication step, s = 0 .. 1: start + rise s + bend s^2, and forces less m_a times a."""

    start: PlantInput
    rise: PlantInput
    bend: PlantInput
    added_mass: tuple[float, float] = (0.0, 0.0)


class PlantOutput(namedtuple("Shown", OUTPUTS)):
    @property
    def tension_ratio(self) -> float:
        return tension_ratio(self.tension_left, self.tension_right)

    @property
    def static_tension_ratio(self) -> float:
        return tension_ratio(self.static_tension_left, self.static_tension_right)

    @property
    def power(self) -> float:
        return self.torque * self.motor_rate


class Plant(HoistPlant):
    def step(self, state: PlantState, h: float, u: PlantInput | PlantInputPath) -> PlantStep:
        return self.advance(state, h, *_packed(u))

    def outputs(self, state: PlantState, u: PlantInput) -> PlantOutput:
        return PlantOutput(*self.loads_and_outputs(state, *_packed(u), 0.0)[1].tolist())

    def loads_at(self, state: PlantState, path: PlantInputPath, s: float) -> PlantInput:
        return PlantInput(*self.loads_and_outputs(state, *_packed(path), s)[0].tolist())

    def run(self, state: PlantState, h: float, u: PlantInput, steps: int) -> list[PlantState]:
        """States at every communication step, the first as given."""
        states = [state]
        for _ in range(steps):
            step = self.step(states[-1], h, u)
            assert step.valid, step.message
            states.append(step.state)
        return states

    def rates(self, state: PlantState, u: PlantInput) -> np.ndarray:
        """dx/dt of head ropes that hold."""
        hoist = replace(self.hoist, lining=None)
        found = equations(parts_of(hoist)).rates(state.x, astuple(u), state.free_lengths, numbers_of(hoist))
        return np.asarray(found).ravel()


def energy_residual(start: PlantOutput, now: PlantOutput, work: Sequence[float]) -> float:
    """Motor and balance rope work minus losses minus the hoist's energy gained [J]; 0 for an exact integration."""
    motor, losses, ropes, left, right = work
    gained = now.energy_kinetic + now.energy_potential - start.energy_kinetic - start.energy_potential
    return float(motor + left + right - losses - ropes - gained)


def _packed(u: PlantInput | PlantInputPath) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(u, PlantInput):
        return np.array([*astuple(u), *(0.0,) * (2 * len(INPUT_NAMES))]), np.zeros(2)
    return np.array([*astuple(u.start), *astuple(u.rise), *astuple(u.bend)]), np.array(u.added_mass)
