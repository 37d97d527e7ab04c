"""The drive's FMI variables: forces of the balance rope in, motions of the conveyances and drive signals out.

Names are those of the balance rope's FMU, so that equal names are connected. A variable's place in the table is its
value reference: parameters, inputs, outputs, status. A hoist whose conveyances have play between their guides also
takes the rope's horizontal forces and its moment about the vertical, and gives the motions that follow. Of several
ropes each has forces of its own, behind its name; the drive adds them up, and gives each the motions of its own place.

One compiled drive serves all hoists. So its table has the variables of a hoist with play and of MOST_ROPES ropes, by
their number, and a hoist's FMU describes those that it has, a rope's by the rope's name.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.control.controller import Gains
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
MOST_ROPES = 8  #: Balance ropes that one drive takes.
PERIOD = "controller.period"
LONGEST_PERIOD = 0.1  #: Longest sample time of the controller [s], that of `Coupling.step`.
#: outputs of the drive that a rope at the centre of a conveyance without play takes in, and their names in OUTPUTS
UPRIGHT = {
    f"{side}.{name}": f"{field}_{side}" for side in SIDES for name, field in _UPRIGHT.items()
}
#: the same with play
MOTIONS = UPRIGHT | {f"{side}.{name}": f"{name}_{side}" for side in SIDES for name in _LATERAL}

#: one of OUTPUTS -> name, unit and description of an output
_DRIVE = {
    "angle": ("drive.angle", "rad", "angle of the sheave, positive lifts the left conveyance"),
    "rate": ("drive.rate", "rad/s", "rate of drive.angle"),
    "torque": ("drive.torque", "N.m", "torque of the motor"),
    "tension_left": ("drive.tension_left", "N", "tension of all head ropes at the sheave, left"),
    "tension_right": ("drive.tension_right", "N", "tension of all head ropes at the sheave, right"),
    "energy_kinetic": (
        "drive.energy_kinetic",
        "J",
        "kinetic energy of drive, head ropes and conveyances",
    ),
    "energy_potential": (
        "drive.energy_potential",
        "J",
        "potential energy of head ropes and conveyances",
    ),
}
#: OUTPUTS that the compiled drive computes, in the order of its table but for the ropes' places
PLANT = (*MOTIONS.values(), *(f"yaw_acceleration_{side}" for side in SIDES), *_DRIVE)
#: name, kind and description of an output of the shell
_STATUS: tuple[tuple[str, Literal["Boolean", "String"], str], ...] = (
    ("valid", "Boolean", "whether the last step succeeded"),
    ("message", "String", "cause and cure of a failure; else empty"),
    ("warning", "String", "warnings about valid results; else empty"),
)
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
    "drive.torque_command": ("N.m", "torque that the controller asked for at its last sample"),
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
    return MOTIONS if hoist.play is not None else UPRIGHT


def offset_ropes(hoist: Hoist, ropes: Sequence[DriveRope]) -> list[DriveRope]:
    """Ropes beside the centres of conveyances that may yaw."""
    return [
        rope for rope in ropes if hoist.play is not None and rope.suspension != SuspensionOffset()
    ]


class DriveTable(NamedTuple):
    """Variables of the compiled drive by value reference, and those of them that a hoist's FMU describes."""

    whole: tuple[Variable, ...]
    described: dict[int, Variable]


def drive_table(
    case: Case, step: float, period: float, ropes: Sequence[DriveRope] = ()
) -> DriveTable:
    """Return the FMI variables; ``step`` is the largest internal step, ``period`` the controller's [s]."""
    parameters = list(_parameters(case, step, period, ropes))
    rows = [_Row(variable) for variable in parameters]
    attached = ropes or (None,)
    for k in range(MOST_ROPES):
        rope = attached[k] if k < len(attached) else None
        prefix = f"rope[{k + 1}]." if k else ""
        pulls = dict(zip(INPUTS, rest_forces(case, rope), strict=True))
        for name in (*INPUTS, *SIDE_FORCES):
            there = k < len(attached) and (name in INPUTS or case.hoist.play is not None)
            unit, text = _texts(_FORCES, name)
            start = pulls.get(name, 0.0) if there else 0.0
            variable = Variable(f"{prefix}{name}", "input", "continuous", "Real", unit, start, text)
            rows.append(_Row(variable, there, rope.name if rope and there else ""))
    beside = offset_ropes(case.hoist, ropes)
    shown = motions(case.hoist)
    rows += [_Row(_output(name, *_texts(_MOTIONS, name)), name in shown) for name in MOTIONS]
    for k in range(MOST_ROPES):
        rope = ropes[k] if k < len(ropes) and ropes[k] in beside else None
        for name in (f"{side}.{moved}" for side in SIDES for moved in MOVED):
            variable = _output(f"rope[{k + 1}].{name}", *_texts(_MOTIONS, name))
            rows.append(_Row(variable, rope is not None, rope.name if rope else ""))
    rows += [_Row(_output(*texts)) for texts in _DRIVE.values()]
    rows += [_Row(_output(name, *texts)) for name, texts in _CONTROL.items()]
    rows += [
        _Row(Variable(f"status.{name}", "output", "discrete", kind, "", None, text))
        for name, kind, text in _STATUS
    ]
    whole = tuple(row.variable for row in rows)
    return DriveTable(whole, {k: row.described() for k, row in enumerate(rows) if row.there})


class _Row(NamedTuple):
    """A variable of the compiled drive, and what a hoist's FMU shows of it."""

    variable: Variable
    there: bool = True  # False: the hoist lacks it
    rope: str = ""  # name of one of several ropes whose variable it is

    def described(self) -> Variable:
        """Return the variable as the FMU describes it."""
        if not self.rope:
            return self.variable
        *_, side, last = self.variable.name.split(".")
        text = f"{self.variable.description}, rope {self.rope}"
        return self.variable._replace(name=f"{self.rope}.{side}.{last}", description=text)


def _output(name: str, unit: str, description: str) -> Variable:
    return Variable(name, "output", "continuous", "Real", unit, None, description)


def _parameters(
    case: Case, step: float, period: float, ropes: Sequence[DriveRope]
) -> Iterator[Variable]:
    text = "wait before the trip begins"
    yield Variable(
        "trip.start", "parameter", "fixed", "Real", "s", case.winding.start_delay, text, 0.0, _MOST
    )
    pulls = np.sum([rest_forces(case, rope) for rope in ropes or (None,)], axis=0)
    for side, name, pull in zip(SIDES, START_PULLS, pulls, strict=True):
        text = f"pull of all balance ropes on the {side} conveyance at the start, where no input gives one (0 N)"
        yield Variable(name, "parameter", "fixed", "Real", "N", float(pull), text, -_MOST, 0.0)
    text = "largest internal step, no longer than that of the export"
    yield Variable("solver.step_max", "parameter", "tunable", "Real", "s", step, text, 1e-6, step)
    text = "sample time of the controller, whatever the communication step"
    yield Variable(PERIOD, "parameter", "fixed", "Real", "s", period, text, 1e-4, LONGEST_PERIOD)
    for p in leaves(Gains):
        low, high = 1e-6 if p.bounds.opens else p.bounds.low, p.bounds.high or _MOST
        value, description = getattr(case.gains, p.name), _GAINS[p.name]
        yield Variable(
            f"controller.{p.name}",
            "parameter",
            "tunable",
            "Real",
            p.unit,
            value,
            description,
            low,
            high,
        )


def _texts(table: Mapping[str, tuple[str, str]], name: str) -> tuple[str, str]:
    """Unit and description of an end's variable."""
    side, last = name.split(".")
    unit, text = table[last]
    return unit, text.format(side=side)
