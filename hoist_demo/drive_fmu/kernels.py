"""Plant and control law as C: generated from the host's own equations, with the hoist's numbers as an argument p.

    k = rates(x, u, l0, p)

drive_model.c does the host's Runge-Kutta steps with them, and holds u.  Hoists with the same STRUCTURE have the same
text: a part that a hoist lacks has the numbers with which it does nothing (``complete``).
"""

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.control.controller import Gains
from hoist_demo.control.kernel import ARGUMENTS, law_kernel
from hoist_demo.drive.equations import INPUT_NAMES, equations, state_names
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant, free_lengths, hanging_places
from hoist_demo.drive_fmu.interface import PLANT
from hoist_demo.parameters import GRAVITY, SIDES, Hoist, start_heights
from hoist_demo.parameters.components import DriveShaft, Guides, Play
from hoist_demo.parameters.hoist import with_numbers
from hoist_demo.parameters.suspension import MOVED, moment_at, motion_at

#: Step times the largest eigenvalue: an error of LIMIT^6 / 3600 = 7e-8 of the fastest oscillation; 3 is unstable.
LIMIT = 0.25
#: Factor on a torque limit [rad/s]: a power of two, so that (limit * _FAST) / _FAST is the limit to the bit.
_FAST = 2.0**40
KERNELS = (
    "rates",
    "outputs",
    "control",
    "rest",
    "moment",
    "point",
)  #: Names of the C functions behind "drive_".
#: Highest number of head rope modes of a side with which the installed package brings the drive compiled.
MOST_MODES = 4


def complete(hoist: Hoist) -> Hoist:
    """Return the hoist with all parts but the shaft; those that it lacks do nothing to its results."""
    return replace(
        hoist,
        conveyance_mass_right=hoist.mass_right - hoist.payload_right
        if hoist.conveyance_mass_right is None
        else hoist.conveyance_mass_right,
        power_limit=hoist.torque_limit * _FAST if hoist.power_limit is None else hoist.power_limit,
        guides=hoist.guides or Guides(coulomb=0.0, viscous=0.0),
        play=hoist.play or Play(),
        slack_tension=None,
    )


def structures() -> list[Hoist]:
    """Return the structures of the drives that the installed package brings compiled."""
    hoists = [
        Hoist(head_rope_modes=n, drive_shaft=s)
        for n in range(MOST_MODES + 1)
        for s in (None, DriveShaft())
    ]
    return [complete(hoist).equation_structure for hoist in hoists]


@dataclass(frozen=True)
class Kernels:
    """C text of the kernels, with the sizes that the C code around it needs."""

    c: str
    states: int
    numbers: int  # of a hoist
    work: tuple[int, int, int, int]  # sizes of arg, res, iw and w


_HOST = Path(__file__).resolve().parent.parent


def kernels(structure: Hoist) -> Kernels:
    """Return the C functions of KERNELS for hoists of this structure; the installed package brings some."""
    brought = kernels_file(_HOST, structure)
    if not brought.exists():
        return generate(structure)
    data = json.loads(brought.read_text(encoding="utf-8"))
    return Kernels(**data | {"work": tuple(data["work"])})


def kernels_file(package: Path, structure: Hoist) -> Path:
    """Return the JSON file of the kernels of ``structure`` if the folder ``package`` brings them."""
    digest = hashlib.sha256(repr(structure).encode())
    for path in sorted(package.rglob("*.py")):
        digest.update(
            f"{path.relative_to(package).as_posix()}\0{path.read_text(encoding='utf-8')}\0".encode()
        )
    return package / "drive_fmu" / "prebuilt" / f"kernels-{digest.hexdigest()[:20]}.json"


def generate(structure: Hoist) -> Kernels:
    """Generate the kernels as C."""
    functions = [
        _rates(structure),
        _outputs(structure),
        _control(structure),
        _rest(structure),
        moment_function(),
        point_function(),
    ]
    generator = ca.CodeGenerator(
        "drive_kernels", {"with_header": False, "casadi_int": "int", "indent": 4}
    )
    for function in functions:
        generator.add(function)
    work = tuple(
        max(getattr(f, size)() for f in functions) for size in ("sz_arg", "sz_res", "sz_iw", "sz_w")
    )
    return Kernels(
        c=str(generator.dump()),
        states=len(state_names(structure)),
        numbers=len(structure.numbers),
        work=(int(work[0]), int(work[1]), max(1, int(work[2])), max(1, int(work[3]))),
    )


def _arguments(structure: Hoist) -> tuple[Any, Any, Any, Any]:
    """Return symbols of state, input, free lengths and the hoist's numbers."""
    states, numbers = len(state_names(structure)), len(structure.numbers)
    return (
        ca.SX.sym("x", states),
        ca.SX.sym("u", len(INPUT_NAMES)),
        ca.SX.sym("l0", 2),
        ca.SX.sym("p", numbers),
    )


def _rates(structure: Hoist) -> Any:
    """Return the function (x, u, l0, p) -> dx/dt."""
    arguments = _arguments(structure)
    return ca.Function("drive_rates", arguments, [equations(structure).rates(*arguments)])


def _outputs(structure: Hoist) -> Any:
    """Return the function (x, u, l0, p) -> PLANT."""
    arguments = _arguments(structure)
    outputs = equations(structure).outputs(*arguments)
    return ca.Function(
        "drive_outputs", arguments, [ca.vertcat(*(outputs[OUTPUT_INDEX[name]] for name in PLANT))]
    )


def _control(structure: Hoist) -> Any:
    """Return the control law (its ARGUMENTS, gains, p) -> (M_c, I)."""
    sample, gains = ca.SX.sym("sample", len(ARGUMENTS)), ca.SX.sym("gains", len(fields(Gains)))
    p = ca.SX.sym("p", len(structure.numbers))
    torque, _, grown = ca.vertsplit(law_kernel(structure)(ca.vertcat(sample, gains, p)))
    return ca.Function("drive_control", [sample, gains, p], [torque, grown])


def _rest(structure: Hoist) -> Any:
    """Return the function (heights, forces, p) -> x, l0 at rest, as HoistPlant.hanging_state finds them."""
    heights, forces, p = (
        ca.SX.sym("y", 2),
        ca.SX.sym("F", 2),
        ca.SX.sym("p", len(structure.numbers)),
    )
    hoist, names = with_numbers(structure, ca.vertsplit(p)), state_names(structure)
    lengths = free_lengths(hoist, ca.vertsplit(heights), ca.vertsplit(forces))
    places = hanging_places(hoist, ca.vertsplit(heights), lengths)
    x = ca.vertcat(*(places.get(name, 0.0) for name in names))
    l0 = ca.vertcat(*lengths)
    x[0] = torque = equations(structure).hold(x, l0, p)
    if hoist.drive_shaft is not None:
        x[names.index("twist")] = torque / hoist.drive_shaft.stiffness
    return ca.Function("drive_rest", [heights, forces, p], [x, l0])


def moment_function() -> Any:
    """Return the function (x and z of a point, yaw, force there) -> moment about the vertical."""
    offset, yaw, force = ca.SX.sym("p", 2), ca.SX.sym("yaw"), ca.SX.sym("F", 3)
    x, z = ca.vertsplit(offset)
    return ca.Function(
        "drive_moment", [offset, yaw, force], [moment_at((x, z), yaw, ca.vertsplit(force))[1]]
    )


def point_function() -> Any:
    """Return the function (x and z of a point, MOVED of the centre, yaw with rate and second derivative) -> MOVED."""
    offset, centre, yaw = ca.SX.sym("p", 2), ca.SX.sym("c", len(MOVED)), ca.SX.sym("yaw", 3)
    x, z = ca.vertsplit(offset)
    moved = motion_at((x, z), ca.vertsplit(centre), *ca.vertsplit(yaw))
    return ca.Function("drive_point", [offset, centre, yaw], [ca.vertcat(*moved)])


def largest_step(case: Case) -> float:
    """Return the largest step in two digits [s], of the fastest oscillation: the shortest head rope, at a landing."""
    plant = HoistPlant(case.hoist, "portable")
    x, u, l0, p = _arguments(structure := case.hoist.equation_structure)
    jacobian = ca.Function(
        "J", [x, u, l0, p], [ca.jacobian(equations(structure).rates(x, u, l0, p), x)]
    )
    fastest = 0.0
    for force in (0.0, -GRAVITY * case.hoist.tail_rope_mass * case.hoist.tail_rope_length):
        for heights in ((low := start_heights(case.hoist, case.winding)), low[::-1]):
            state = plant.hanging_state(*heights, force, force)
            held = np.zeros(u.size1())
            held[:3] = state.x[0], force, force
            matrix = np.asarray(
                jacobian(state.x, held, list(state.free_lengths), case.hoist.numbers)
            )
            fastest = max(fastest, float(np.abs(np.linalg.eigvals(matrix)).max()))
    step = LIMIT / fastest
    unit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return float(f"{math.floor(step / unit) * unit:.1e}")


def places_of_yaw(structure: Hoist) -> Sequence[int]:
    """Return the places of both conveyances' yaw in the state."""
    return [state_names(structure).index(f"yaw_{side}") for side in SIDES]
