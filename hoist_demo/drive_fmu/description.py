"""The drive put together for a builder of FMUs: table, words and C sources."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.resources import files

from hoist_demo.cases.case import Case
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.drive.plant import MIN_ROPE
from hoist_demo.drive_fmu.interface import START_PULLS, DriveRope, force_inputs, holding, plant_outputs, variables
from hoist_demo.drive_fmu.kernels import Kernels, kernels
from hoist_demo.drive_fmu.omissions import leave_out, obstacles
from hoist_demo.parameters import ASSUMED_DATA, Winding, require_trip_fits
from hoist_demo.parameters.problems import Problems
from rope_model import Inputs
from rope_model.scene_names import Variable
from rope_model.texts import html_text

NAME = "HoistDrive"
MOST_STEPS = 100_000  #: Internal steps that one communication step may take.


@dataclass(frozen=True)
class DriveModel:
    """Contents of an FMU for its builder: the sources implement the model behind a generic FMI shell."""

    name: str
    description: str
    variables: tuple[Variable, ...]
    sources: dict[str, str]  # file name -> text; those that end in .c are compiled
    attachments: dict[str, bytes]  # path in the FMU -> documentation and picture
    duration: float  # s, of the trip with what waits before and after it
    initial: dict[str, tuple[str, ...]]  # output -> what it follows while the drive is initialised


def duration(winding: Winding, trajectory: Trajectory | None = None) -> float:
    """Return a trip's duration with waits, in whole seconds; ``trajectory``, without waits, replaces the S-curve."""
    reached = s_curve(winding).duration if trajectory is None else winding.start_delay + trajectory.duration
    return float(math.ceil(reached + winding.settle))


def drive_model(case: Case, ropes: Sequence[DriveRope] = (), trajectory: Trajectory | None = None) -> DriveModel:
    """Hoist and trip of ``case`` as C; the trip is part of the export.

    ``ropes`` are its balance ropes where they differ; the hoist of the case has them as one.  ``trajectory`` as for
    duration.  The brake is left out: it is for emergency stops, which an exported trip lacks; ValueError names
    what else an exported drive cannot hold.
    """
    Problems(obstacles(case)).refuse()
    case = leave_out(case, ())
    # the wait before the trip is a parameter of its own
    reference = s_curve(replace(case.winding, start_delay=0.0)) if trajectory is None else trajectory
    require_trip_fits(case.hoist, case.winding)
    generated = kernels(case, ropes)
    table = variables(case, generated.step, ropes)
    trip = f"{abs(case.winding.travel):g} m {'up' if case.winding.travel > 0.0 else 'down'} at up to"
    text = (
        "Drive of a friction hoist with motor, sheave, head ropes and two conveyances, S-curve reference and speed "
        f"controller; left conveyance {trip} {case.winding.speed:g} m/s{_creep(case.winding)}"
    )
    sources = {
        "drive_model.c": files(__package__).joinpath("drive_model.c").read_text(encoding="utf-8"),
        "drive_kernels.c": generated.c,
        "drive_table.h": _table(case, table, generated, ropes, reference),
    }
    lasts = duration(case.winding, trajectory)
    return DriveModel(NAME, text, table, sources, attachments(text, table), lasts, initial(case, ropes))


def initial(case: Case, ropes: Sequence[DriveRope] = ()) -> dict[str, tuple[str, ...]]:
    """Return the inputs, and the parameters in their place, that the outputs follow during initialisation.

    Conveyances and sheave rest at the landings whatever the forces, and the reference waits there.  What holds the
    balance rope follows its vertical forces; those of the sides come with the first step.
    """
    numbers = (v.name for v in variables(case, 1.0, ropes) if v.causality == "output" and v.kind == "Real")
    held = holding(ropes)
    return {name: held.get(name, ()) for name in numbers}


def _creep(winding: Winding) -> str:
    """Return the description's words on the creep; nothing without one."""
    ends = (("first", winding.departure_creep_distance), ("last", winding.creep_distance))
    where = " and ".join(f"the {end} {distance:g} m" for end, distance in ends if distance > 0.0)
    return f", {where} at {winding.creep_speed:g} m/s" if where else ""


_TABLE = """\
/* Generated: the drive's sizes, its places in the table of variables, and the trip. */
#ifndef DRIVE_TABLE_H
#define DRIVE_TABLE_H

enum {{
{sizes}
}};

#define DRIVE_RADIUS {radius!r}
#define DRIVE_MIN_ROPE {min_rope!r} /* m, of a head rope between sheave and conveyance */
#define DRIVE_LOWEST_FORCE ({lowest!r})
#define DRIVE_TORQUE_LIMIT {limit!r}
#define DRIVE_HARDEST {hardest!r} /* m/s2: a rope refuses ends that accelerate more */
static const int DRIVE_ACCELERATION[] = {{{accelerations}}}; /* places in the outputs */

/* lowest and highest value of each parameter */
static const double DRIVE_BOUNDS[][2] = {bounds};

/* s: begin of each segment; m, m/s, m/s2, m/s3: its first position, speed, acceleration, and its jerk */
static const double DRIVE_TRIP[][5] = {trip};

/* drive_kernels.c */
{kernels}

#endif
"""


def _table(
    case: Case, table: Sequence[Variable], generated: Kernels, ropes: Sequence[DriveRope], reference: Trajectory
) -> str:
    """Return the text of drive_table.h: sizes, places in the table and the trip."""
    trip = [(start, *point[:4]) for start, point in zip(reference.starts, reference.points, strict=True)]
    hardest = [i for i, name in enumerate(plant_outputs(case.hoist, ropes)) if name.endswith((".ax", ".ay", ".az"))]
    integers = _sizes(case, table, generated, ropes) | {"SEGMENTS": len(trip), "ACCELERATIONS": len(hardest)}
    parameters = (v for v in table if v.causality == "parameter")
    bounds = [(v.minimum, v.maximum) for v in parameters if v.minimum is not None and v.maximum is not None]
    kernel = "int drive_{}(const double **arg, double **res, int *iw, double *w, int mem);"
    return _TABLE.format(
        sizes="\n".join(f"    DRIVE_{name} = {value}," for name, value in integers.items()),
        radius=case.hoist.sheave_radius,
        min_rope=MIN_ROPE,
        lowest=generated.lowest_force,
        limit=case.hoist.torque_limit,
        hardest=Inputs().acceleration_max,
        accelerations=", ".join(map(str, hardest)),
        bounds=_rows(bounds),
        trip=_rows(trip),
        kernels="\n".join(map(kernel.format, ("rest", "input", "step", "outputs", "control"))),
    )


def _sizes(case: Case, table: Sequence[Variable], generated: Kernels, ropes: Sequence[DriveRope]) -> dict[str, int]:
    """Sizes of kernels and trip, and places in the table of variables."""
    names, shown = [v.name for v in table], plant_outputs(case.hoist, ropes)
    forces = force_inputs(ropes)
    controls = sum(v.causality == "output" and v.kind == "Real" for v in table) - len(shown)
    return {
        "STATES": generated.states,
        "INPUTS": generated.inputs,
        "PARAMETERS": sum(v.causality == "parameter" for v in table),
        "FORCE": names.index(forces[0]),
        "FORCES": len(forces),
        "FIRST_OUTPUT": names.index(next(v.name for v in table if v.causality == "output")),
        "PLANT_OUTPUTS": len(shown),
        "OUTPUTS": len(shown) + controls,
        "LEFT_Y": shown.index("left.y"),
        "RATE": shown.index("drive.rate"),
        "TRIP_START": names.index("trip.start"),
        "FY_START": names.index(START_PULLS[0]),
        "STEP_MAX": names.index("solver.step_max"),
        "GAINS": names.index("controller.speed"),
        "MOST_STEPS": MOST_STEPS,
        **dict(zip(("ARG", "RES", "IW", "W"), generated.work, strict=True)),
    }


def _rows(rows: Sequence[Sequence[float]]) -> str:
    return "{" + ", ".join("{" + ", ".join(repr(float(x)) for x in row) + "}" for row in rows) + "}"


def attachments(description: str, table: Sequence[Variable]) -> dict[str, bytes]:
    """Return documentation and picture by their paths in the FMU."""
    rows = "\n".join(
        f"<tr><td><code>{html_text(v.name)}</code></td><td>{v.causality}</td><td>{html_text(v.unit)}</td>"
        f"<td>{'' if v.start is None else f'{v.start:g}'}</td><td>{html_text(v.description)}</td></tr>"
        for v in table
    )
    page = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
    page = page.format(description=html_text(description), assumed=html_text(ASSUMED_DATA), rows=rows)
    return {
        "documentation/index.html": page.encode(),
        "model.png": files(__package__).joinpath("icon.png").read_bytes(),
    }
