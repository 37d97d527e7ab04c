"""A hoist at rest, and one on a trip, with dead weights for its balance ropes."""

import math

import numpy as np
from drives import Plant, PlantInput, energy_residual

from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import s_curve
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, Hoist, Winding


def dead_weights(hoist: Hoist, y_left: float, y_right: float, acceleration: float) -> tuple[float, float]:
    """Forces of one balance rope on the conveyances [N]: weight and inertia of its legs."""
    half, high, mass = hoist.tail_rope_length / 2.0, (y_left - y_right) / 2.0, hoist.tail_rope_mass
    return -mass * (half + high) * (GRAVITY + acceleration), -mass * (half - high) * (GRAVITY - acceleration)


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
    plant, reference = Plant(hoist), s_curve(winding)
    heights = (0.0, hoist.shaft_travel) if winding.travel > 0.0 else (hoist.shaft_travel, 0.0)
    state, u = rest_at(plant, heights)
    shown = at_rest = plant.outputs(state, u)
    controller, memory, rows = SpeedController(hoist, at_rest.torque, gains), ControllerState(), []
    for k in range(math.ceil((reference.duration + winding.settle) / step)):
        point = reference.at(k * step)
        measured = Measurement(shown.y_left - heights[0], hoist.sheave_radius * shown.rate)
        command = controller.command(point, measured, memory, step)
        ropes = dead_weights(hoist, shown.y_left, shown.y_right, point.acceleration)
        u = PlantInput(command.torque, *ropes, brake=command.brake)
        moved = plant.step(state, step, u)
        assert moved.valid, moved.message
        state, memory, shown = moved.state, command.state, plant.outputs(moved.state, u)
        rows.append({
            "time": (k + 1) * step, "position": shown.y_left - heights[0], "speed": hoist.sheave_radius * shown.rate,
            "torque": shown.torque, "power": shown.power, "slip_safety": hoist.slip_safety(shown.tension_ratio),
            "static_slip_safety": hoist.slip_safety(shown.static_tension_ratio),
            "energy_residual": energy_residual(at_rest, shown, state.works[:5]),
        })  # fmt: skip
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
