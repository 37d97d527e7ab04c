"""Trips and emergency stops of the installed hoists with dead weights for their balance ropes.

What the drive has to do, and whether the head ropes would slip; how the balance rope itself moves is the FMU's business
and not computed here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.installed import INSTALLED
from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import s_curve
from hoist_demo.drive.plant import HoistPlant, PlantInput, energy_residual
from hoist_demo.parameters import GRAVITY, EmergencyLaw, Hoist, Winding

STEP = 0.02  # s

COLUMNS = {
    "time": "s",
    "position": "m",
    "speed": "m/s",
    "acceleration": "m/s2",
    "torque": "N.m",
    "power": "W",
    "brake_torque": "N.m",
    "tension_left": "N",
    "tension_right": "N",
    "tension_ratio": "1",
    "static_tension_ratio": "1",
    "slip_safety": "1",
    "static_slip_safety": "1",
    "energy_residual": "J",
}
"""Columns of a run; position and acceleration are those of the left conveyance, the speed is that of the rim."""


@dataclass(frozen=True)
class Run:
    """A trip, one row per step."""

    hoist: Hoist
    table: NDArray[np.float64]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.table[:, list(COLUMNS).index(name)]


def dead_weights(hoist: Hoist, y_left: float, y_right: float, acceleration: float) -> tuple[float, float]:
    """Forces of one balance rope on the conveyances [N]: its legs' weight and inertia at an acceleration [m/s^2]."""
    half, half_difference = hoist.tail_rope_length / 2.0, (y_left - y_right) / 2.0
    return (
        -hoist.tail_rope_mass * (half + half_difference) * (GRAVITY + acceleration),
        -hoist.tail_rope_mass * (half - half_difference) * (GRAVITY - acceleration),
    )


def wind(hoist: Hoist, winding: Winding, gains: Gains, step: float = STEP) -> Run:
    """One trip; the dead weights accelerate as the reference does, so that the coupling has no delay to answer for."""
    plant, reference = HoistPlant(hoist), s_curve(winding)
    start = (0.0, hoist.shaft_travel) if winding.travel > 0.0 else (hoist.shaft_travel, 0.0)
    state = plant.equilibrium(*start, *dead_weights(hoist, *start, 0.0))
    shown = at_rest = plant.outputs(state, PlantInput(float(state.x[0]), *dead_weights(hoist, *start, 0.0)))
    controller, memory = SpeedController(hoist, at_rest.torque, gains), ControllerState()
    rows = []
    for k in range(math.ceil((reference.duration + winding.settle) / step)):
        point = reference.at(k * step)
        measured = Measurement(shown.y_left - start[0], hoist.sheave_radius * shown.rate)
        command = controller.command(point, measured, memory, step)
        rope = dead_weights(hoist, shown.y_left, shown.y_right, point.acceleration)
        u = PlantInput(command.torque, *rope, brake=command.brake)
        moved = plant.step(state, step, u)
        if not moved.valid:
            raise RuntimeError(f"t = {k * step:g} s: {moved.message}")
        state, memory, shown = moved.state, command.state, plant.outputs(moved.state, u)
        rows.append(
            (
                (k + 1) * step,
                shown.y_left - start[0],
                hoist.sheave_radius * shown.rate,
                shown.a_left,
                shown.torque,
                shown.power,
                shown.brake_torque,
                shown.tension_left,
                shown.tension_right,
                shown.tension_ratio,
                shown.static_tension_ratio,
                hoist.slip_safety(shown.tension_ratio),
                hoist.slip_safety(shown.static_tension_ratio),
                energy_residual(at_rest, shown, state.work),
            )
        )
    return Run(hoist, np.array(rows))


def stop(name: str, law: EmergencyLaw, at: float) -> Run:
    """A case's trip, stopped by the brake at a time [s]."""
    case = INSTALLED[name]
    winding = replace(case.winding, emergency_at=at, emergency_law=law)
    return wind(case.hoist, winding, case.gains)
