"""The drive's FMI variables: forces of the balance rope in, motions and drive signals out.

Names are those of the balance rope's FMU, so that equal names are connected. A variable's place in
the table is its value reference: parameters, inputs, outputs, status. A hoist whose conveyances
have play between their guides also takes the rope's horizontal forces and its moment about the
vertical, and gives the motions that follow. Of several ropes each has forces of its own, behind its
name; the drive adds them up, and gives each the motions of its own place.

One compiled drive serves all hoists. So its table has the variables of a hoist with play and of
MOST_ROPES ropes, by their number, and a hoist's FMU describes those that it has, a rope's by the
rope's name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
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

FORCE_INPUTS = tuple(f"{side}.fy_mean" for side in SIDES)
START_PULLS = tuple(f"{side}.fy_start" for side in SIDES)
#: Vertical inputs of a rope's end, and their names in OUTPUTS without the side.
_UPRIGHT = {"y": "y", "vy": "v", "ay": "a"}
#: Other inputs of a rope's end, which have the same names in OUTPUTS.
_LATERAL = ("x", "vx", "ax", "z", "vz", "az", "yaw", "yaw_rate")
_LARGEST = 1e9  #: Largest value of a parameter that has no other bound.
_SHORTEST_STEP = 1e-6  #: Shortest internal step that may be asked for [s].
_SHORTEST_PERIOD = 1e-4  #: Shortest sample time of the controller [s].
_SMALLEST_GAIN = 1e-6  #: Smallest value of a gain that must be positive.
MAX_ROPES = 8  #: Balance ropes that one drive takes.
PERIOD = "controller.period"
LONGEST_PERIOD = 0.1  #: Longest sample time of the controller [s], that of ``Coupling.step``.
#: Outputs of a drive without play that are inputs of a rope at a conveyance's centre, and their
#: names in OUTPUTS.
UPRIGHT = {f"{side}.{name}": f"{_UPRIGHT[name]}_{side}" for side, name in product(SIDES, _UPRIGHT)}
#: Outputs of a drive with play that are inputs of a rope, and their names in OUTPUTS.
MOTIONS = UPRIGHT | {f"{side}.{name}": f"{name}_{side}" for side, name in product(SIDES, _LATERAL)}

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
        "vertical force of the balance rope on the {side} conveyance, mean of a step, "
        "negative pulls down",
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
    if not ropes:
        return FORCE_INPUTS
    return tuple(f"{rope.name}.{force}" for rope, force in product(ropes, FORCE_INPUTS))


def weight_dependencies(ropes: Sequence[DriveRope]) -> dict[str, tuple[str, ...]]:
    """Outputs that follow the balance ropes' weight at rest, each with the variables that give it.

    These are inputs, and parameters in their place.
    """
    names = (*force_inputs(ropes), *START_PULLS)
    return {
        **dict.fromkeys(("drive.torque", "drive.torque_command", "drive.energy_potential"), names),
        **{f"drive.tension_{side}": names[k::2] for k, side in enumerate(SIDES)},
    }


def rest_forces(case: Case, rope: DriveRope | None = None) -> tuple[float, float]:
    """Weight of a balance rope's legs on the conveyances at the start [N], negative.

    The size of the bend is neglected.
    """
    left, right = start_heights(case.hoist, case.winding)
    rope = rope or DriveRope("", case.hoist.tail_rope_mass, case.hoist.tail_rope_length)
    weight = GRAVITY * rope.mass_per_length
    middle = 0.5 * rope.length
    return -weight * (middle + 0.5 * (left - right)), -weight * (middle - 0.5 * (left - right))


def motions(hoist: Hoist) -> dict[str, str]:
    """Outputs that are inputs of a rope at the conveyances' centres, and their names in OUTPUTS."""
    if hoist.play is None:
        return UPRIGHT
    return MOTIONS


def offset_ropes(hoist: Hoist, ropes: Sequence[DriveRope]) -> list[DriveRope]:
    """Ropes beside the centres of conveyances that may yaw."""
    if hoist.play is None:
        return []
    return [rope for rope in ropes if rope.suspension != SuspensionOffset()]


class DriveTable(NamedTuple):
    """Variables of the compiled drive, and of a hoist's FMU, by value reference."""

    compiled: tuple[Variable, ...]
    described: dict[int, Variable]  # variables that the hoist has


def drive_table(
    case: Case, step: float, period: float, ropes: Sequence[DriveRope] = ()
) -> DriveTable:
    """Return the FMI variables.

    ``step`` is the largest internal step, ``period`` the controller's [s].
    """
    rows = [_Row(variable) for variable in _parameters(case, step, period, ropes)]
    for k in range(MAX_ROPES):
        rows += _force_rows(case, ropes, k)
    shown = motions(case.hoist)
    rows += [_Row(_output(name, *_texts(_MOTIONS, name)), name in shown) for name in MOTIONS]
    for k in range(MAX_ROPES):
        rows += _place_rows(case.hoist, ropes, k)
    rows += [_Row(_output(*texts)) for texts in _DRIVE.values()]
    rows += [_Row(_output(name, *texts)) for name, texts in _CONTROL.items()]
    rows += [
        _Row(Variable(f"status.{name}", "output", "discrete", kind, "", None, text))
        for name, kind, text in _STATUS
    ]
    described = {k: row.described() for k, row in enumerate(rows) if row.exists}
    return DriveTable(tuple(row.variable for row in rows), described)


def _force_rows(case: Case, ropes: Sequence[DriveRope], k: int) -> Iterator[_Row]:
    """Yield the forces of the rope number k, from 0 on; one rope needs no name."""
    rope = ropes[k] if k < len(ropes) else None
    exists = k < max(len(ropes), 1)
    prefix = ""
    if k > 0:
        prefix = f"rope[{k + 1}]."
    pulls = dict(zip(FORCE_INPUTS, rest_forces(case, rope), strict=True))
    for name in (*FORCE_INPUTS, *SIDE_FORCES):
        unit, text = _texts(_FORCES, name)
        row = _Row(
            Variable(f"{prefix}{name}", "input", "continuous", "Real", unit, 0.0, text),
            exists=exists and (name in FORCE_INPUTS or case.hoist.play is not None),
        )
        if row.exists:
            row = row._replace(
                variable=row.variable._replace(start=pulls.get(name, 0.0)),
                rope=rope.name if rope else "",
            )
        yield row


def _place_rows(hoist: Hoist, ropes: Sequence[DriveRope], k: int) -> Iterator[_Row]:
    """Yield the motions of the rope number k, from 0 on, beside the conveyances' centres."""
    exists = k < len(ropes) and ropes[k] in offset_ropes(hoist, ropes)
    rope = ropes[k].name if exists else ""
    for side, moved in product(SIDES, MOVED):
        name = f"{side}.{moved}"
        variable = _output(f"rope[{k + 1}].{name}", *_texts(_MOTIONS, name))
        yield _Row(variable, exists, rope)


class _Row(NamedTuple):
    """A variable of the compiled drive, and of a hoist's FMU if the hoist has it."""

    variable: Variable
    exists: bool = True  # False: the hoist lacks it
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
    delay = case.winding.start_delay
    yield Variable(
        "trip.start", "parameter", "fixed", "Real", "s", delay, text, minimum=0.0, maximum=_LARGEST
    )
    pulls = np.sum([rest_forces(case, rope) for rope in ropes or (None,)], axis=0)
    for side, name, pull in zip(SIDES, START_PULLS, pulls, strict=True):
        text = (
            f"pull of all balance ropes on the {side} conveyance at the start, "
            "where no input gives one (0 N)"
        )
        yield Variable(
            name, "parameter", "fixed", "Real", "N", float(pull), text, -_LARGEST, maximum=0.0
        )
    yield Variable(
        name="solver.step_max",
        causality="parameter",
        variability="tunable",
        kind="Real",
        unit="s",
        start=step,
        description="largest internal step, no longer than that of the export",
        minimum=_SHORTEST_STEP,
        maximum=step,
    )
    yield Variable(
        name=PERIOD,
        causality="parameter",
        variability="fixed",
        kind="Real",
        unit="s",
        start=period,
        description="sample time of the controller, whatever the communication step",
        minimum=_SHORTEST_PERIOD,
        maximum=LONGEST_PERIOD,
    )
    for p in leaves(Gains):
        yield Variable(
            name=f"controller.{p.name}",
            causality="parameter",
            variability="tunable",
            kind="Real",
            unit=p.unit,
            start=getattr(case.gains, p.name),
            description=f"{p.meaning} [assumed]",
            minimum=_SMALLEST_GAIN if p.bounds.opens else p.bounds.lower,
            maximum=_LARGEST if p.bounds.upper is None else p.bounds.upper,
        )


def _texts(table: Mapping[str, tuple[str, str]], name: str) -> tuple[str, str]:
    """Unit and description of an end's variable."""
    side, last = name.split(".")
    unit, text = table[last]
    return unit, text.format(side=side)
