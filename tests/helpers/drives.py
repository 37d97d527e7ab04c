"""A drive under inputs that have names, at rest and on a trip with dead weights for its balance ropes."""

import math
from collections import namedtuple
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import s_curve
from hoist_demo.drive.coordinates import INPUT_NAMES
from hoist_demo.drive.equations import equations
from hoist_demo.drive.outputs import OUTPUTS, tension_ratio
from hoist_demo.drive.plant import HoistPlant, PlantState, PlantStep
from hoist_demo.parameters import GRAVITY, Hoist, Winding


class PlantInput(namedtuple("PlantInput", INPUT_NAMES, defaults=(0.0,) * (len(INPUT_NAMES) - 3))):
    """Held over one communication step; forces are those of one balance rope."""


class PlantInputPath(
    namedtuple("Path", ("start", "rise", "bend", "added_mass"), defaults=((0.0, 0.0),))
):
    """Input over one communication step, s = 0 .. 1: start + rise s + bend s^2, and forces less m_a times a."""


class PlantOutput(namedtuple("Shown", OUTPUTS)):
    @property
    def tension_ratio(self) -> float:
        return float(tension_ratio(self.tension_left, self.tension_right))

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
        found = equations(hoist.equation_structure).rates(
            state.x, np.array(u), state.free_lengths, hoist.numbers
        )
        return np.asarray(found).ravel()


def energy_residual(start: PlantOutput, now: PlantOutput, work: Sequence[float]) -> float:
    """Motor and balance rope work minus losses minus the hoist's energy gained [J]; 0 for an exact integration."""
    motor, losses, ropes, left, right = work
    gained = (
        now.energy_kinetic + now.energy_potential - start.energy_kinetic - start.energy_potential
    )
    return float(motor + left + right - losses - ropes - gained)


def _packed(u: PlantInput | PlantInputPath) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(u, PlantInput):
        return np.array([*u, *(0.0,) * (2 * len(INPUT_NAMES))]), np.zeros(2)
    return np.array([*u.start, *u.rise, *u.bend]), np.array(u.added_mass)


def dead_weights(
    hoist: Hoist, y_left: float, y_right: float, acceleration: float
) -> tuple[float, float]:
    """Forces of one balance rope on the conveyances [N]: weight and inertia of its legs."""
    half = hoist.tail_rope_length / 2.0
    high = (y_left - y_right) / 2.0
    mass = hoist.tail_rope_mass
    left = -mass * (half + high) * (GRAVITY + acceleration)
    right = -mass * (half - high) * (GRAVITY - acceleration)
    return left, right


def rest_at(plant: Plant, heights: tuple[float, float]) -> tuple[PlantState, PlantInput]:
    forces = dead_weights(plant.hoist, *heights, 0.0)
    state = plant.equilibrium(*heights, *forces)
    return state, PlantInput(float(state.x[0]), *forces)


def state_with(plant: Plant, state: PlantState, **values: float) -> PlantState:
    x = state.x.copy()
    for name, value in values.items():
        x[plant.state_names.index(name)] = value
    return state._replace(x=x)


def wind(hoist: Hoist, winding: Winding, gains: Gains, step: float = 0.02) -> dict[str, np.ndarray]:
    """One trip by columns; the dead weights accelerate as the reference, so that the coupling has no delay."""
    plant = Plant(hoist)
    reference = s_curve(winding)
    heights = (0.0, hoist.shaft_travel)
    if winding.travel <= 0.0:
        heights = (hoist.shaft_travel, 0.0)
    state, u = rest_at(plant, heights)
    shown = at_rest = plant.outputs(state, u)
    controller = SpeedController(hoist, at_rest.torque, gains)
    memory = ControllerState()
    rows = []
    for k in range(math.ceil((reference.duration + winding.settle) / step)):
        point = reference.at(k * step)
        measured = Measurement(shown.y_left - heights[0], hoist.sheave_radius * shown.rate)
        command = controller.command(point, measured, memory, step)
        ropes = dead_weights(hoist, shown.y_left, shown.y_right, point.acceleration)
        u = PlantInput(command.torque, *ropes, brake=command.brake)
        moved = plant.step(state, step, u)
        assert moved.valid, moved.message
        state = moved.state
        memory = command.state
        shown = plant.outputs(moved.state, u)
        rows.append(
            {
                "time": (k + 1) * step,
                "position": shown.y_left - heights[0],
                "speed": hoist.sheave_radius * shown.rate,
                "torque": shown.torque,
                "power": shown.power,
                "slip_safety": hoist.slip_safety(shown.tension_ratio),
                "static_slip_safety": hoist.slip_safety(
                    tension_ratio(shown.static_tension_left, shown.static_tension_right)
                ),
                "energy_residual": energy_residual(at_rest, shown, state.work_totals[:5]),
            }
        )
    trip = {}
    for name in rows[0]:
        trip[name] = np.array([row[name] for row in rows])
    return trip
