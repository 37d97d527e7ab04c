"""The drive's FMI variables: forces of the balance rope in, motions of the conveyances and drive signals out.

Names are those of the balance rope's FMU, so that equal names are connected. A variable's place in the table is its
value reference: parameters, inputs, outputs, status.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Literal, NamedTuple

from hoist_demo.controller import Gains
from hoist_demo.parameters import GRAVITY, Setup
from hoist_demo.plant import PlantOutput

INPUTS = ("left.fy_mean", "right.fy_mean")
MOTIONS = {"left.y": "y_left", "left.vy": "v_left", "left.ay": "a_left"}
MOTIONS |= {"right.y": "y_right", "right.vy": "v_right", "right.ay": "a_right"}
"""Outputs that a balance rope takes in, and their fields of PlantOutput."""

#: field of PlantOutput -> name, unit and description of an output
_DRIVE = {
    "angle": ("drive.angle", "rad", "angle of the sheave, positive lifts the left conveyance"),
    "rate": ("drive.rate", "rad/s", "rate of drive.angle"),
    "torque": ("drive.torque", "N.m", "torque of the motor"),
    "tension_left": ("drive.tension_left", "N", "tension of all head ropes at the sheave, left"),
    "tension_right": ("drive.tension_right", "N", "tension of all head ropes at the sheave, right"),
    "energy_kinetic": ("drive.energy_kinetic", "J", "kinetic energy of drive, head ropes and conveyances"),
    "energy_potential": ("drive.energy_potential", "J", "potential energy of head ropes and conveyances"),
}
_GAINS = {
    "speed": ("N.s/m", "gain of the speed loop [assumed]"),
    "integral_time": ("s", "integral time of the speed loop [assumed]"),
    "position": ("1/s", "gain of the position loop [assumed]"),
    "feed_forward": ("1", "share of the feed-forward that is used, 0 to 1"),
}
_CONTROL = {
    "reference.position": ("m", "travel of the left conveyance that is asked for"),
    "reference.speed": ("m/s", "its rate"),
    "reference.acceleration": ("m/s2", "its second derivative"),
    "drive.torque_command": ("N.m", "torque that the controller asked for in the last step"),
}


class Variable(NamedTuple):
    """One FMI variable; ``start`` is None for outputs, ``unit`` empty where there is none."""

    name: str
    causality: Literal["parameter", "input", "output"]
    variability: Literal["fixed", "tunable", "continuous", "discrete"]
    kind: Literal["Real", "Boolean", "String"]
    unit: str
    start: float | None
    description: str
    minimum: float | None = None
    maximum: float | None = None


def start_heights(setup: Setup) -> tuple[float, float]:
    """Of left and right conveyance [m]: the landings, left below when it is to rise."""
    low, high = 0.0, setup.hoist.shaft_travel
    return (low, high) if setup.winding.travel > 0.0 else (high, low)


def rest_forces(setup: Setup) -> tuple[float, float]:
    """Weight of the balance rope's legs on the conveyances at the start [N], negative: the bend's size neglected."""
    left, right = start_heights(setup)
    weight = GRAVITY * setup.hoist.tail_rope_mass
    middle = 0.5 * setup.hoist.tail_rope_length
    return -weight * (middle + 0.5 * (left - right)), -weight * (middle - 0.5 * (left - right))


def plant_outputs() -> tuple[str, ...]:
    """Fields of PlantOutput that are shown, in the order of the table."""
    return (*MOTIONS.values(), *_DRIVE)


def variables(setup: Setup, step: float) -> tuple[Variable, ...]:
    """The table; ``step`` is the largest internal step [s]."""
    start = setup.winding.start_delay
    table = [
        Variable("trip.start", "parameter", "fixed", "Real", "s", start, "wait before the trip begins", 0.0),
        Variable(
            "solver.step_max",
            "parameter",
            "tunable",
            "Real",
            "s",
            step,
            "largest internal step, no longer than that of the export",
            1e-6,
            step,
        ),
    ]
    gains = Gains()
    for field in fields(Gains):
        unit, text = _GAINS[field.name]
        name = f"controller.{field.name}"
        table.append(Variable(name, "parameter", "tunable", "Real", unit, getattr(gains, field.name), text, 0.0))
    for side, force in zip(("left", "right"), rest_forces(setup), strict=True):
        text = f"vertical force of the balance rope on the {side} conveyance, mean of a step, negative pulls down"
        table.append(Variable(f"{side}.fy_mean", "input", "continuous", "Real", "N", force, text))
    units = {"y": ("m", "height"), "v": ("m/s", "speed"), "a": ("m/s2", "acceleration")}
    for name, field_name in MOTIONS.items():
        unit, what = units[field_name[0]]
        text = f"{what} of the {name.partition('.')[0]} conveyance's rope suspension, up"
        table.append(Variable(name, "output", "continuous", "Real", unit, None, text))
    for name, unit, text in _DRIVE.values():
        table.append(Variable(name, "output", "continuous", "Real", unit, None, text))
    for name, (unit, text) in _CONTROL.items():
        table.append(Variable(name, "output", "continuous", "Real", unit, None, text))
    table += [
        Variable("status.valid", "output", "discrete", "Boolean", "", None, "whether the last step succeeded"),
        Variable("status.message", "output", "discrete", "String", "", None, "why not, and what to do; else empty"),
    ]
    assert {f.name for f in fields(PlantOutput)} >= set(plant_outputs())
    return tuple(table)
