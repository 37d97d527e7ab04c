"""The drive's FMI variables: forces of the balance rope in, motions of the conveyances and drive signals out.

Names are those of the balance rope's FMU, so that equal names are connected. A variable's place in the table is its
value reference: parameters, inputs, outputs, status. A hoist whose conveyances have play between their guides also
takes the rope's horizontal forces and its moment about the vertical, and gives the motions that follow. Of several
ropes each has forces of its own, behind its name; the drive adds them up, and gives each the motions of its own place.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.control.controller import Gains
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.parameters import GRAVITY, SIDES, Hoist, start_heights
from hoist_demo.parameters.quantity import leaves
from hoist_demo.parameters.suspension import MOVED, SuspensionOffset
from rope_model import EndMotion
from rope_model.parameter_table import parameters_of
from rope_model.scene_names import Variable

INPUTS = tuple(f"{side}.fy_mean" for side in SIDES)
START_PULLS = tuple(f"{side}.fy_start" for side in SIDES)
_UPRIGHT = {"y": "y", "vy": "v", "ay": "a"}
#: Inputs of the rope's ends, and what they are called in OUTPUTS, but for the side.
_LATERAL = ("x", "vx", "ax", "z", "vz", "az", "yaw", "yaw_rate")
_MOST = 1e9  #: Largest value of a parameter that has no other bound.

#: one of OUTPUTS -> name, unit and description of an output
_DRIVE = {
    "angle": ("drive.angle", "rad", "angle of the sheave, positive lifts the left conveyance"),
    "rate": ("drive.rate", "rad/s", "rate of drive.angle"),
    "torque": ("drive.torque", "N.m", "torque of the motor"),
    "tension_left": ("drive.tension_left", "N", "tension of all head ropes at the sheave, left"),
    "tension_right": ("drive.tension_right", "N", "tension of all head ropes at the sheave, right"),
    "energy_kinetic": ("drive.energy_kinetic", "J", "kinetic energy of drive, head ropes and conveyances"),
    "energy_potential": ("drive.energy_potential", "J", "potential energy of head ropes and conveyances"),
}
#: description of a gain; Gains has the units
_GAINS = {
    "speed": "gain of the speed loop [assumed]",
    "integral_time": "integral time of the speed loop [assumed]",
    "position": "gain of the position loop [assumed]",
    "feed_forward": "share of the feed-forward that is used, 0 to 1",
}
_CONTROL = {
    "reference.position": ("m", "travel of the left conveyance that is asked for"),
    "reference.speed": ("m/s", "its rate"),
    "reference.acceleration": ("m/s2", "its second derivative"),
    "drive.torque_command": ("N.m", "torque that the controller asked for in the last step"),
}
#: units and descriptions of forces, "{side}" stands for the side
_MOTIONS = {name: (p.unit, p.description) for name, p in parameters_of(EndMotion).items()}
_FORCES = {
    "fy_mean": (
        "N",
        "vertical force of the balance rope on the {side} conveyance, mean of a step, negative pulls down",
    ),
    "fx": ("N", "force of the balance rope on the {side} conveyance in the plane of the loop"),
    "fz": ("N", "force of the balance rope on the {side} conveyance out of plane"),
    "my": ("N.m", "moment of the balance rope on the {side} conveyance about the vertical"),
}


class DriveRope(NamedTuple):
    """One of several balance ropes, as the drive takes it."""

    name: str
    mass_per_length: float  # kg/m
    length: float  # m
    suspension: SuspensionOffset = SuspensionOffset()


def force_inputs(ropes: Sequence[DriveRope]) -> tuple[str, ...]:
    """Names of the vertical forces: left and right, of each rope where there are several."""
    return tuple(f"{rope.name}.{force}" for rope in ropes for force in INPUTS) or INPUTS


def holding(ropes: Sequence[DriveRope]) -> dict[str, tuple[str, ...]]:
    """Outputs that hold the balance ropes' weight, and what says how much: inputs, and parameters in their place."""
    names = (*force_inputs(ropes), *START_PULLS)
    return {
        **dict.fromkeys(("drive.torque", "drive.torque_command", "drive.energy_potential"), names),
        **{f"drive.tension_{side}": names[k::2] for k, side in enumerate(SIDES)},
    }


def rest_forces(case: Case, rope: DriveRope | None = None) -> tuple[float, float]:
    """Weight of a balance rope's legs on the conveyances at the start [N], negative: the bend's size neglected."""
    left, right = start_heights(case.hoist, case.winding)
    rope = rope or DriveRope("", case.hoist.tail_rope_mass, case.hoist.tail_rope_length)
    weight = GRAVITY * rope.mass_per_length
    middle = 0.5 * rope.length
    return -weight * (middle + 0.5 * (left - right)), -weight * (middle - 0.5 * (left - right))


def motions(hoist: Hoist) -> dict[str, str]:
    """Outputs that a balance rope at the conveyances' centres takes in, and their names in OUTPUTS."""
    names = {f"{side}.{name}": f"{field}_{side}" for side in SIDES for name, field in _UPRIGHT.items()}
    if hoist.play is not None:
        names |= {f"{side}.{name}": f"{name}_{side}" for side in SIDES for name in _LATERAL}
    return names


def side_forces(hoist: Hoist, ropes: Sequence[DriveRope]) -> tuple[str, ...]:
    """Inputs beyond the vertical forces: of each rope, in the order of the plant's."""
    if hoist.play is None:
        return ()
    return tuple(f"{rope.name}.{force}" for rope in ropes for force in SIDE_FORCES) or SIDE_FORCES


def offset_motions(hoist: Hoist, ropes: Sequence[DriveRope]) -> list[str]:
    """Outputs that the ropes beside the centres take in, by rope and end MOVED: there a conveyance's yaw counts."""
    return [f"{rope.name}.{side}.{name}" for rope in offset_ropes(hoist, ropes) for side in SIDES for name in MOVED]


def offset_ropes(hoist: Hoist, ropes: Sequence[DriveRope]) -> list[DriveRope]:
    """Ropes beside the centres of conveyances that may yaw."""
    return [rope for rope in ropes if hoist.play is not None and rope.suspension != SuspensionOffset()]


def plant_outputs(hoist: Hoist, ropes: Sequence[DriveRope]) -> tuple[str, ...]:
    """Names of the plant's outputs, in the order of the table."""
    return (*motions(hoist), *offset_motions(hoist, ropes), *(name for name, _, _ in _DRIVE.values()))


def output_names(hoist: Hoist) -> dict[str, str]:
    """Outputs of the plant that are OUTPUTS, and their names there."""
    return motions(hoist) | {name: output for output, (name, _, _) in _DRIVE.items()}


def variables(case: Case, step: float, ropes: Sequence[DriveRope] = ()) -> tuple[Variable, ...]:
    """Return the table of FMI variables; ``step`` is the largest internal step [s], ``ropes`` are several."""
    outputs = [(name, *_texts(_MOTIONS, name)) for name in (*motions(case.hoist), *offset_motions(case.hoist, ropes))]
    outputs += [*_DRIVE.values(), *((name, *texts) for name, texts in _CONTROL.items())]
    assert {*output_names(case.hoist).values()} <= OUTPUT_INDEX.keys()
    return (
        *_parameters(case, step, ropes),
        *_inputs(case, ropes),
        *(Variable(name, "output", "continuous", "Real", unit, None, text) for name, unit, text in outputs),
        Variable("status.valid", "output", "discrete", "Boolean", "", None, "whether the last step succeeded"),
        Variable("status.message", "output", "discrete", "String", "", None, "cause and cure of a failure; else empty"),
    )


def _parameters(case: Case, step: float, ropes: Sequence[DriveRope]) -> Iterator[Variable]:
    text = "wait before the trip begins"
    yield Variable("trip.start", "parameter", "fixed", "Real", "s", case.winding.start_delay, text, 0.0, _MOST)
    pulls = np.sum([rest_forces(case, rope) for rope in ropes or (None,)], axis=0)
    for side, name, pull in zip(SIDES, START_PULLS, pulls, strict=True):
        text = f"pull of all balance ropes on the {side} conveyance at the start, where no input gives one (0 N)"
        yield Variable(name, "parameter", "fixed", "Real", "N", float(pull), text, -_MOST, 0.0)
    text = "largest internal step, no longer than that of the export"
    yield Variable("solver.step_max", "parameter", "tunable", "Real", "s", step, text, 1e-6, step)
    for p in leaves(Gains):
        low, high = 1e-6 if p.bounds.opens else p.bounds.low, p.bounds.high or _MOST
        value, description = getattr(case.gains, p.name), _GAINS[p.name]
        yield Variable(f"controller.{p.name}", "parameter", "tunable", "Real", p.unit, value, description, low, high)


def _inputs(case: Case, ropes: Sequence[DriveRope]) -> Iterator[Variable]:
    upright, sides = force_inputs(ropes), side_forces(case.hoist, ropes)
    forces = [force for rope in ropes or (None,) for force in rest_forces(case, rope)] + [0.0] * len(sides)
    for name, force in zip((*upright, *sides), forces, strict=True):
        unit, text = _texts(_FORCES, name)
        yield Variable(name, "input", "continuous", "Real", unit, force, text)


def _texts(table: Mapping[str, tuple[str, str]], name: str) -> tuple[str, str]:
    """Unit and description of an end's variable, that of one of several ropes or of all."""
    *rope, side, last = name.split(".")
    unit, text = table[last]
    return unit, text.format(side=side) + "".join(f", rope {one}" for one in rope)
