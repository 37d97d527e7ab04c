"""The drive put together for a builder of FMUs: table, texts, C sources, numbers of the hoist."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from itertools import chain

import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.drive import integrator
from hoist_demo.drive.coordinates import INPUT_NAMES
from hoist_demo.drive.plant import MIN_ROPE, SIDE_FORCES
from hoist_demo.drive_fmu.interface import (
    FORCE_INPUTS,
    MAX_ROPES,
    MOTIONS,
    PERIOD,
    PLANT,
    START_PULLS,
    DriveRope,
    drive_table,
    weight_dependencies,
)
from hoist_demo.drive_fmu.kernels import (
    KERNELS,
    Kernels,
    complete,
    kernels,
    largest_step,
    places_of_yaw,
)
from hoist_demo.drive_fmu.omissions import leave_out, obstacles
from hoist_demo.parameters import (
    ASSUMED_DATA,
    GRAVITY,
    SIDES,
    Hoist,
    Winding,
    require_trip_fits,
    start_heights,
)
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.suspension import MOVED
from rope_model import Inputs
from rope_model.scene_names import Variable
from rope_model.texts import html_text

NAME = "HoistDrive"
MAX_STEPS = 100_000  #: Internal steps that one communication step may take.
#: Segments of a trip: an S-curve has 8, one with creep 14, a shaped one several times as many.
MAX_SEGMENTS = 256
SAMPLE_PERIOD = 0.01  #: Sample time of the controller where an export gives none [s].
#: Communication step [s] beyond which a force that changes is warned of: the rope extrapolates no
#: longer ones.
LONGEST_HOLD = 0.02


@dataclass(frozen=True)
class DriveModel:
    """Contents of an FMU for its builder; the sources implement the model behind an FMI shell."""

    name: str
    description: str
    variables: tuple[Variable, ...]  # of the compiled drive, by value reference
    described: dict[int, Variable]  # those that this hoist has
    sources: dict[str, str]  # file name -> text; those that end in .c are compiled
    data: tuple[float, ...]  # numbers of hoist and trip, in C behind the start values
    attachments: dict[str, bytes]  # path in the FMU -> documentation and picture
    duration: float  # s, of the trip with the waits before and after it
    initial: dict[str, tuple[str, ...]]  # output -> variables that it follows in initialisation


def duration(winding: Winding, trajectory: Trajectory | None = None) -> float:
    """Return a trip's duration with waits, in whole seconds [s].

    ``trajectory``, without waits, replaces the S-curve.
    """
    return float(math.ceil(_arrival(winding, trajectory) + winding.settle))


def _arrival(winding: Winding, trajectory: Trajectory | None) -> float:
    """Return the time from the start of a run to the end of its motion [s]."""
    if trajectory is None:
        return s_curve(winding).duration
    return winding.start_delay + trajectory.duration


def drive_model(
    case: Case,
    ropes: Sequence[DriveRope] = (),
    trajectory: Trajectory | None = None,
    period: float = SAMPLE_PERIOD,
) -> DriveModel:
    """Hoist and trip of ``case`` in C; the trip is part of the export.

    ``ropes`` are its balance ropes where they differ; the hoist of the case has them as one.
    ``trajectory`` as for duration; ``period`` is the controller's sample time [s].  The brake is
    left out: it is for emergency stops, which an exported trip lacks; ValueError names other parts
    that an exported drive cannot hold.
    """
    Problems(obstacles(case)).refuse()
    if len(ropes) > MAX_ROPES:
        raise ValueError(
            f"{len(ropes)} balance ropes must be at most {MAX_ROPES} in an exported drive: "
            "join equal ones"
        )
    case = leave_out(case, ())
    reference = trajectory
    if reference is None:
        # the wait before the trip is a parameter of its own
        reference = s_curve(replace(case.winding, start_delay=0.0))
    require_trip_fits(case.hoist, case.winding)
    table = drive_table(case, largest_step(case), period, ropes)
    text = (
        "Drive of a friction hoist with motor, sheave, head ropes and two conveyances, S-curve "
        f"reference and speed controller; left conveyance {_trip(case.winding)}"
    )
    shown = list(table.described.values())
    return DriveModel(
        name=NAME,
        description=text,
        variables=table.compiled,
        described=table.described,
        sources=sources(complete(case.hoist).equation_structure),
        data=_packed(_data(case, ropes, reference)),
        attachments=attachments(text, shown),
        duration=duration(case.winding, trajectory),
        initial=initial(shown, ropes),
    )


def sources(structure: Hoist) -> dict[str, str]:
    """Return the C files of all hoists of this structure, see ``kernels.complete``."""
    generated = kernels(structure)
    return {
        "drive_model.c": files(__package__).joinpath("drive_model.c").read_text(encoding="utf-8"),
        "drive_kernels.c": generated.c,
        "drive_table.h": _table(structure, generated),
    }


def initial(
    described: Sequence[Variable], ropes: Sequence[DriveRope] = ()
) -> dict[str, tuple[str, ...]]:
    """Return the inputs, and the parameters in their place, that the outputs follow at first.

    That is during initialisation: conveyances and sheave rest at the landings whatever the forces,
    and the reference waits there.  The forces that hold the balance rope follow its vertical
    forces; those of the sides come with the first step.
    """
    numbers = (v.name for v in described if v.causality == "output" and v.kind == "Real")
    dependencies = weight_dependencies(ropes)
    return {name: dependencies.get(name, ()) for name in numbers}


def _trip(winding: Winding) -> str:
    """Return the description's words on the trip."""
    direction = "up" if winding.travel > 0.0 else "down"
    text = f"{abs(winding.travel):g} m {direction} at up to {winding.speed:g} m/s"
    ends = (("first", winding.departure_creep_distance), ("last", winding.creep_distance))
    where = " and ".join(f"the {end} {distance:g} m" for end, distance in ends if distance > 0.0)
    if not where:
        return text
    return f"{text}, {where} at {winding.creep_speed:g} m/s"


def _data(case: Case, ropes: Sequence[DriveRope], reference: Trajectory) -> dict[str, list[float]]:
    """Return the numbers of hoist and trip that the C code reads, by their names there."""
    hoist = case.hoist
    segments = len(reference.starts)
    if segments > MAX_SEGMENTS:
        raise ValueError(
            f"the trip has {segments} segments of constant jerk: it must have at most "
            f"{MAX_SEGMENTS} in an exported drive; shape it less"
        )
    trip = np.zeros((MAX_SEGMENTS, 5))  # start and s, v, a, j of each segment
    trip[:segments, 0] = reference.starts
    trip[:segments, 1:] = [point[:4] for point in reference.points]
    places = np.zeros((MAX_ROPES, len(SIDES), 2))  # x, z of each rope's end
    for k, rope in enumerate(ropes):
        places[k] = [rope.suspension.at(side) for side in SIDES]
    return {
        "RADIUS": [hoist.sheave_radius],
        "TORQUE_LIMIT": [hoist.torque_limit],
        "LOWEST_FORCE": [-2.0 * GRAVITY * hoist.tail_rope_mass * hoist.tail_rope_length],
        "HEIGHTS": list(start_heights(hoist, case.winding)),
        "ROPES": [float(max(1, len(ropes)))],
        "PLACES": places.ravel().tolist(),
        "SEGMENTS": [float(segments)],
        "TRIP": trip.ravel().tolist(),
        "NUMBERS": complete(hoist).numbers,
    }


def _packed(data: dict[str, list[float]]) -> tuple[float, ...]:
    return tuple(chain.from_iterable(data.values()))


_TABLE = """\
/* Generated: the drive's sizes, its places in the table of variables, and those of a hoist's numbers. */
#ifndef DRIVE_TABLE_H
#define DRIVE_TABLE_H

enum {{
{sizes}
}};

#define DRIVE_MIN_ROPE {min_rope!r} /* m, of a head rope between sheave and conveyance */
#define DRIVE_HARDEST {hardest!r} /* m/s2: a rope refuses ends that accelerate more */
#define DRIVE_LONGEST_HOLD {hold!r} /* s: a step beyond which changing forces are warned of */
static const int DRIVE_ACCELERATION[] = {{{accelerations}}}; /* places in the outputs of all ropes' ends */
static const int DRIVE_YAW[] = {{{yaw}}}; /* of both conveyances, in the state */
static const int DRIVE_CENTRE[2][{moved}] = {centre}; /* motion of a centre in the outputs, as drive_point takes it */
static const int DRIVE_TURN[2][3] = {turn}; /* yaw, rate, acceleration in what drive_outputs gives */

/* lowest and highest value of each parameter; that of solver.step_max is its start value */
static const double DRIVE_BOUNDS[][2] = {bounds};

/* weights of the Runge-Kutta method's stages, the last row those of the result */
static const double DRIVE_WEIGHTS[DRIVE_STAGES][DRIVE_STAGES] = {weights};

/* drive_kernels.c */
{kernels}

#endif
"""


def _table(structure: Hoist, generated: Kernels) -> str:
    """Return the text of drive_table.h."""
    kernel = "int drive_{}(const double **arg, double **res, int *iw, double *w, int mem);"
    table = drive_table(_any_case(), step=1.0, period=SAMPLE_PERIOD).compiled
    bounds = [(v.minimum, v.maximum) for v in table if v.causality == "parameter"]
    stages = len(integrator.WEIGHTS)
    sizes = _sizes(structure, generated)
    return _TABLE.format(
        sizes="\n".join(f"    DRIVE_{name} = {value}," for name, value in sizes.items()),
        min_rope=MIN_ROPE,
        hardest=Inputs().acceleration_max,
        hold=LONGEST_HOLD,
        accelerations=", ".join(map(str, _accelerations(table))),
        yaw=", ".join(map(str, places_of_yaw(structure))),
        moved=len(MOVED),
        centre=_rows([_centre_places(side) for side in SIDES]),
        turn=_rows([_turn_places(side) for side in SIDES]),
        bounds=_rows([(float(low or 0.0), float(high or 0.0)) for low, high in bounds]),
        weights=_rows([[*row, *[0.0] * (stages - len(row))] for row in integrator.WEIGHTS]),
        kernels="\n".join(map(kernel.format, KERNELS)),
    )


def _centre_places(side: str) -> list[int]:
    """Return the places in MOTIONS of the motion of a conveyance's centre."""
    motions = list(MOTIONS)
    return [motions.index(f"{side}.{name}") for name in MOVED]


def _turn_places(side: str) -> list[int]:
    """Return the places in PLANT of a conveyance's yaw, its rate and second derivative."""
    return [PLANT.index(f"{name}_{side}") for name in ("yaw", "yaw_rate", "yaw_acceleration")]


def _accelerations(table: Sequence[Variable]) -> list[int]:
    """Return the places of the ropes' ends' accelerations in the outputs."""
    outputs = [v.name for v in table if v.causality == "output"]
    return [k for k, name in enumerate(outputs) if name.endswith((".ax", ".ay", ".az"))]


def _sizes(structure: Hoist, generated: Kernels) -> dict[str, int]:
    """Return sizes of kernels and data, and places in variables, outputs and data."""
    case = _any_case()
    table = drive_table(case, step=1.0, period=SAMPLE_PERIOD).compiled
    names = [v.name for v in table]
    outputs = [v.name for v in table if v.causality == "output" and v.kind == "Real"]
    data = _data(case, (), s_curve(case.winding)) | {"NUMBERS": structure.numbers}
    places: dict[str, int] = {}
    size = 0
    for name, values in data.items():
        places[f"DATA_{name}"] = size
        size += len(values)
    return {
        "STATES": generated.states,
        "INPUTS": len(INPUT_NAMES),
        "STAGES": len(integrator.WEIGHTS),
        "PARAMETERS": sum(v.causality == "parameter" for v in table),
        "FORCE": names.index(FORCE_INPUTS[0]),
        "FORCES_OF_ROPE": len(FORCE_INPUTS) + len(SIDE_FORCES),
        "MOST_ROPES": MAX_ROPES,
        "FIRST_OUTPUT": names.index(outputs[0]),
        "OUTPUTS": len(outputs),
        "PLANT_OUTPUTS": len(PLANT),
        "MOTIONS": len(MOTIONS),
        "MOVED": len(MOVED),
        "DRIVE_OUTPUTS": outputs.index("drive.angle"),
        "DRIVE_SIGNALS": outputs.index("reference.position") - outputs.index("drive.angle"),
        "DRIVE_IN_PLANT": PLANT.index("angle"),
        "CONTROL": outputs.index("reference.position"),
        "LEFT_Y": outputs.index("left.y"),
        "RATE": outputs.index("drive.rate"),
        "ACCELERATIONS": len(_accelerations(table)),
        "WARNING": names.index("status.warning"),
        "TRIP_START": names.index("trip.start"),
        "FY_START": names.index(START_PULLS[0]),
        "STEP_MAX": names.index("solver.step_max"),
        "PERIOD": names.index(PERIOD),
        "GAINS": names.index("controller.speed"),
        "MOST_STEPS": MAX_STEPS,
        **places,
        "DATA": size,
        **dict(zip(("ARG", "RES", "IW", "W"), generated.work, strict=True)),
    }


@cache
def _any_case() -> Case:
    """Return a case for values that do not depend on its numbers."""
    return find_case("rope-120")


def _rows(rows: Sequence[Sequence[float]]) -> str:
    """Return the initializer of an array of arrays in C."""
    texts = ["{" + ", ".join(map(repr, row)) + "}" for row in rows]
    return "{" + ", ".join(texts) + "}"


def _html_row(variable: Variable) -> str:
    """Return the row of the documentation's table for a variable."""
    start = "" if variable.start is None else f"{variable.start:g}"
    return (
        f"<tr><td><code>{html_text(variable.name)}</code></td><td>{variable.causality}</td>"
        f"<td>{html_text(variable.unit)}</td><td>{start}</td>"
        f"<td>{html_text(variable.description)}</td></tr>"
    )


def attachments(description: str, table: Sequence[Variable]) -> dict[str, bytes]:
    """Return documentation and picture by their paths in the FMU."""
    rows = "\n".join(map(_html_row, table))
    page = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
    page = page.format(
        description=html_text(description), assumed=html_text(ASSUMED_DATA), rows=rows
    )
    return {
        "documentation/index.html": page.encode(),
        "model.png": files(__package__).joinpath("icon.png").read_bytes(),
    }
