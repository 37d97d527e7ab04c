"""Library of trip.c for hoists with the same parts: its structures, its numbers, its compilation."""

from ctypes import CDLL
from dataclasses import fields
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any

from hoist_demo.control.kernel import ARGUMENTS, RESULTS, law_kernel
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.drive_signals import OUTPUT_COLUMNS, ROW, WORK_COLUMNS
from hoist_demo.cosimulation.participants.c_structures import (
    CMember,
    SharedStructure,
    definition,
    fields_of,
)
from hoist_demo.cosimulation.participants.fmi_versions import DISCARD, WARNING
from hoist_demo.cosimulation.participants.library_calls import CALLS, FUNCTIONS, Access
from hoist_demo.cosimulation.schemes.interface import HISTORY
from hoist_demo.drive import integrator, plant
from hoist_demo.drive.coordinates import (
    FORCES,
    INPUT_NAMES,
    STATE_NAMES,
    TORQUE_COMMAND,
    WORK_NAMES,
)
from hoist_demo.drive.kernels import generate_c
from hoist_demo.drive.outputs import OUTPUT_INDEX, OUTPUTS
from hoist_demo.parameters import Hoist
from hoist_demo.recording.time_series import TIME
from rope_model import SIDES, EndMotion
from rope_model.codegen.build import sources as rope_sources
from rope_model.compiler import cache_folder, compile_library, find_compiler

#: Files of this folder: the loop, and the calls of the rope.
_WRITTEN = ("trip.c", "rope_calls.h")
#: Headers of the rope that trip.c includes, with those that they include.
_ROPE_HEADERS = ("rope.h", "parameters.h", "interface_structures.h")
#: Ends of a call: well, before a sample that the host must process, or the part that has failed.
STOPS = ("WELL", "LOOK", "DRIVE", *CALLS)
_MOTIONS = tuple(field.name for field in fields(EndMotion))
#: Names of an end's motion in OUTPUTS, where they are others.
_OUTPUT_NAMES = {"vy": "v", "ay": "a"}
_NO_OUTPUT = -1  #: Place of a motion that the hoist does not have, as one that leans.
#: Places in OUTPUTS of the motions of both ends.
_ENDS = [
    OUTPUT_INDEX.get(f"{_OUTPUT_NAMES.get(name, name)}_{side}", _NO_OUTPUT)
    for side, name in product(SIDES, _MOTIONS)
]
_MEMORY = ("arg", "res", "iw", "w")  #: Memory of a function of CasADi.
#: Places of the forces on conveyances with play in an input.
SIDE_INPUTS = slice(INPUT_NAMES.index("fx_left"), len(INPUT_NAMES))
#: Signals at which blocks or single numbers of a row of the record begin, by names in trip.c.
_COLUMNS = {
    "TIME": TIME,
    "REFERENCE": "reference.position",
    "TORQUE_COMMAND": "drive.torque_command",
    "TORQUE_LIMITED": "drive.torque_limited",
    "SLIP": "drive.slip",
    "SLIP_SPEED": "drive.slip_speed",
    "COUPLING_ENERGY": "coupling.energy",
    "EXCHANGES": "coupling.exchanges",
    "OUTPUTS": OUTPUT_COLUMNS[0],
    "WORK_TOTALS": WORK_COLUMNS[0],
}
_INTEGRATOR_CONSTANTS = (
    "MIN_STEP",
    "SAFETY",
    "MIN_FACTOR",
    "MAX_FACTOR",
    "MIN_ERROR",
    "ORDER",
    "STEP_ROUNDING",
)
#: Numbers of trip.c that are those of all hoists, by name.
_NUMBERS: dict[str, float] = {
    **{name: getattr(integrator, name) for name in _INTEGRATOR_CONSTANTS},
    "MIN_ROPE": plant.MIN_ROPE,
    "HISTORY": HISTORY,
    "WARNING": WARNING,
    "DISCARD": DISCARD,
    "INPUTS": len(INPUT_NAMES),
    "TORQUE": TORQUE_COMMAND,
    "FORCE": FORCES[0],
    "SIDES": SIDE_INPUTS.start,
    "PHI": STATE_NAMES.index("phi"),
    "WORK_COUNT": integrator.WORK_COUNT,
    "JERK": TrajectoryPoint._fields.index("jerk"),
    "OUTPUTS": len(OUTPUTS),
    "LAW_RESULTS": len(RESULTS),
    **{f"LAW_{name.upper()}": k for k, name in enumerate(RESULTS)},
    **{f"{name.upper()}_WORK": WORK_NAMES.index(name) for name in SIDES},
    **{name.upper(): OUTPUT_INDEX[name] for name in ("y_left", "a_left", "pull_left", "rate")},
    **{name.upper(): ARGUMENTS.index(name) for name in ("travel", "speed", "integral")},
    **{f"AS_{name}": k for k, name in enumerate(FUNCTIONS)},
    **{f"COLUMN_{name}": ROW.index(signal) for name, signal in _COLUMNS.items()},
}


class TripSample(SharedStructure):
    """Forces and motions of the interface at one communication point."""

    members = (
        CMember("t", "double"),
        CMember("force", "double", length=2),
        CMember("mean", "double", length=2),
        CMember("acceleration", "double", length=2),
    )
    _fields_ = fields_of(members)


class Trip(SharedStructure):
    """Arguments and state of a trip in C."""

    members = (
        # the drive
        CMember("drive", "Kernel *", "one substep of the drive"),
        CMember("z", "double *", "its arguments"),
        CMember("y", "double *", "its results"),
        CMember("law_arguments", "double *"),
        # the rope; accesses without a function where it lacks one
        CMember("step", "Access"),
        CMember("motions", "Access"),
        CMember("valid", "Access"),
        CMember("forces", "Access"),
        CMember("sides", "Access"),
        CMember("guard", "Access"),
        CMember("recorded", "const Access *"),
        CMember("warning", "RopeWarning *"),
        CMember("warned", "char *", "1 for each warning that was logged"),
        CMember("text", "char *", "of a warning"),
        CMember("log_warnings", "LogWarnings *"),
        CMember("records", "int", "number of recorded accesses"),
        CMember("warnings", "int", "number of warnings"),
        CMember("watched", "int", "not 0 while the safety circuit is watched"),
        # the trip
        CMember("per_sample", "int", "steps"),
        CMember("per_step", "int", "commands"),
        CMember("start", "double", "s"),
        CMember("H", "double", "s, communication step"),
        CMember("period", "double", "s, of samples"),
        CMember("radius", "double", "m, of the sheave"),
        CMember("start_height", "double", "m, of the left conveyance"),
        CMember("ropes", "double", "number of tail ropes"),
        CMember("slack_tension", "double", "N"),
        CMember("reference", "const Reference *", "of all commands of the trip"),
        # its state
        CMember("samples", "TripSample *", "the last ones, oldest first"),
        CMember("row", "double *", "of the record, where the first sample goes"),
        CMember("columns", "size_t", "of a row"),
        CMember("step_next", "double", "s, of the drive"),
        CMember("torque", "double", "N m, commanded"),
        CMember("integral", "double", "of the controller"),
        CMember("residual", "double", "J, energy that the coupling adds"),
        CMember("exchanges", "double"),
        CMember("drive_time", "double", "s, wall time"),
        CMember("rope_time", "double", "s, wall time"),
        CMember("kept_samples", "int"),
        CMember("steps", "int"),
        CMember("evaluations", "int", "of the drive"),
        CMember("status", "int", "of the rope's latest call"),
    )
    _fields_ = fields_of(members, (Access,))


@cache
def trip_library(structure: Hoist, kernels: integrator.DriveKernels) -> CDLL:
    """Compile and load trip.c for hoists with these parts; RuntimeError without a C compiler."""
    compiler = find_compiler()
    if compiler is None:
        raise RuntimeError("no C compiler found")
    law = law_kernel(structure)
    sources = {
        **{name: files(__package__).joinpath(name).read_text("utf-8") for name in _WRITTEN},
        **{name: rope_sources()[name] for name in _ROPE_HEADERS},
        "numbers.h": _numbers_header(law, kernels),
        "access.h": definition(Access),
        "structures.h": "\n".join(map(definition, (TripSample, Trip))),
        "law.c": generate_c((law,), "law"),
    }
    return CDLL(str(compile_library(sources, compiler, cache_folder(), "hoist_trip")))


def _numbers_header(law: Any, kernels: integrator.DriveKernels) -> str:
    """Return the text of numbers.h: numbers and types of trip.c that follow from Python."""
    argument = kernels.argument_slices
    result = kernels.result
    numbers = _NUMBERS | {
        **{f"AT_{name.upper()}": argument[name].start for name in ("s", "h", "path", "l0")},
        **{
            f"AT_{name.upper()}": result[name].start for name in ("work_totals", "error", "outputs")
        },
        "REACHED": result["work_totals"].stop,
        "SIZE": result["outputs"].stop,
        **{f"SZ_{name.upper()}": _memory_size(name, law, kernels.advance) for name in _MEMORY},
    }
    defines = "".join(f"#define {name} {value!r}\n" for name, value in numbers.items())
    places = ", ".join(map(str, _ENDS))
    return (
        "#ifndef NUMBERS_H\n#define NUMBERS_H\n"
        f"{defines}"
        f"typedef enum {{ {', '.join(STOPS)} }} Stop;\n"
        f"static const int ENDS_OUTPUTS[] = {{{places}}};\n"
        "#endif\n"
    )


def _memory_size(name: str, law: Any, advance: Any) -> int:
    """Return the size of a working array that serves both functions of CasADi."""
    return 1 + max(int(getattr(function, f"sz_{name}")()) for function in (law, advance))
