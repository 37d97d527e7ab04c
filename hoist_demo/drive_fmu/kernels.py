"""Plant and control law as C, generated from the host's own equations.

    k = rates(x, u, l0, p)

with the hoist's numbers p. drive_model.c does steps of equal length with them, by the Runge-Kutta
method of the host, and holds u.
Hoists with the same structure have the same text: a part that a hoist lacks has the numbers with
which it does nothing (``complete``).
"""

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.control.controller import Gains
from hoist_demo.control.kernel import ARGUMENTS, law_kernel
from hoist_demo.drive.coordinates import (
    FORCES,
    INPUT_NAMES,
    TORQUE,
    TORQUE_COMMAND,
    state_names,
)
from hoist_demo.drive.equations import equations
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant, free_lengths, hanging_places
from hoist_demo.drive_fmu.interface import PLANT
from hoist_demo.parameters import GRAVITY, SIDES, Hoist, start_heights
from hoist_demo.parameters.components import DriveShaft, Guides, Play
from hoist_demo.parameters.hoist import with_numbers
from hoist_demo.parameters.suspension import MOVED, moment_at, motion_at

#: Step times the largest eigenvalue: an error of LIMIT^6 / 3600 = 7e-8 of the fastest oscillation;
#: 3 is unstable.
LIMIT = 0.25
#: Rate at which a motor without a power limit reaches it [rad/s]: a power of two, so that
#: (limit * _FAST) / _FAST is the torque limit to the bit.
_FAST = 2.0**40
#: Names of the C functions behind "drive_".
KERNELS = ("rates", "outputs", "control", "rest", "moment", "point")
#: Head rope modes of a side up to which the installed package has the drive compiled.
MAX_MODES = 4


def complete(hoist: Hoist) -> Hoist:
    """Return the hoist with all parts but the shaft; added parts do not change its results."""
    conveyance_mass_right = hoist.conveyance_mass_right
    if conveyance_mass_right is None:
        conveyance_mass_right = hoist.mass_right - hoist.payload_right
    power_limit = hoist.power_limit
    if power_limit is None:
        power_limit = hoist.torque_limit * _FAST
    return replace(
        hoist,
        conveyance_mass_right=conveyance_mass_right,
        power_limit=power_limit,
        guides=hoist.guides or Guides(coulomb=0.0, viscous=0.0),
        play=hoist.play or Play(),
        slack_tension=None,
    )


def structures() -> list[Hoist]:
    """Return the structures of the drives that the installed package has compiled."""
    shafts = (None, DriveShaft())
    hoists = [
        Hoist(head_rope_modes=modes, drive_shaft=shaft)
        for modes, shaft in product(range(MAX_MODES + 1), shafts)
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
    """Return the C functions of KERNELS for hoists of this structure, generated or installed."""
    installed = kernels_file(_HOST, structure)
    if not installed.exists():
        return generate(structure)
    data = json.loads(installed.read_text(encoding="utf-8"))
    return Kernels(**data | {"work": tuple(data["work"])})


def kernels_file(package: Path, structure: Hoist) -> Path:
    """Return the JSON file for the kernels of ``structure`` in the folder ``package``."""
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
    return Kernels(
        c=str(generator.dump()),
        states=len(state_names(structure)),
        numbers=len(structure.numbers),
        work=(
            max(int(function.sz_arg()) for function in functions),
            max(int(function.sz_res()) for function in functions),
            max(1, *(int(function.sz_iw()) for function in functions)),
            max(1, *(int(function.sz_w()) for function in functions)),
        ),
    )


class _Arguments(NamedTuple):
    """Symbols of state, input, free lengths and the hoist's numbers."""

    x: Any
    u: Any
    l0: Any
    p: Any


def _arguments(structure: Hoist) -> _Arguments:
    return _Arguments(
        x=ca.SX.sym("x", len(state_names(structure))),
        u=ca.SX.sym("u", len(INPUT_NAMES)),
        l0=ca.SX.sym("l0", 2),
        p=ca.SX.sym("p", len(structure.numbers)),
    )


def _rates(structure: Hoist) -> Any:
    """Return the function (x, u, l0, p) -> dx/dt."""
    arguments = _arguments(structure)
    return ca.Function("drive_rates", arguments, [equations(structure).rates(*arguments)])


def _outputs(structure: Hoist) -> Any:
    """Return the function (x, u, l0, p) -> PLANT."""
    arguments = _arguments(structure)
    outputs = equations(structure).outputs(*arguments)
    plant = ca.vertcat(*(outputs[OUTPUT_INDEX[name]] for name in PLANT))
    return ca.Function("drive_outputs", arguments, [plant])


def _control(structure: Hoist) -> Any:
    """Return the control law (its ARGUMENTS, gains, p) -> (M_c, I)."""
    sample = ca.SX.sym("sample", len(ARGUMENTS))
    gains = ca.SX.sym("gains", len(fields(Gains)))
    p = ca.SX.sym("p", len(structure.numbers))
    torque, _, integral = ca.vertsplit(law_kernel(structure)(ca.vertcat(sample, gains, p)))
    return ca.Function("drive_control", [sample, gains, p], [torque, integral])


def _rest(structure: Hoist) -> Any:
    """Return the function (heights, forces, p) -> x, l0 at rest, as HoistPlant.hanging_state."""
    heights = ca.SX.sym("y", 2)
    forces = ca.SX.sym("F", 2)
    p = ca.SX.sym("p", len(structure.numbers))
    hoist = with_numbers(structure, ca.vertsplit(p))
    names = state_names(structure)
    lengths = free_lengths(hoist, ca.vertsplit(heights), ca.vertsplit(forces))
    places = hanging_places(hoist, ca.vertsplit(heights), lengths)
    x = ca.vertcat(*(places.get(name, 0.0) for name in names))
    l0 = ca.vertcat(*lengths)
    torque = equations(structure).hold(x, l0, p)
    x[TORQUE] = torque
    if hoist.drive_shaft is not None:
        x[names.index("twist")] = torque / hoist.drive_shaft.stiffness
    return ca.Function("drive_rest", [heights, forces, p], [x, l0])


def moment_function() -> Any:
    """Return the function (x and z of a point, yaw, force there) -> moment about the vertical."""
    offset = ca.SX.sym("p", 2)
    yaw = ca.SX.sym("yaw")
    force = ca.SX.sym("F", 3)
    x, z = ca.vertsplit(offset)
    _, about_vertical, _ = moment_at((x, z), yaw, ca.vertsplit(force))
    return ca.Function("drive_moment", [offset, yaw, force], [about_vertical])


def point_function() -> Any:
    """Return the function (offset, centre, yaw) -> MOVED of a point of a conveyance.

    ``offset`` are x and z of the point, ``centre`` has MOVED of the centre, ``yaw`` the angle with
    its rate and second derivative.
    """
    offset = ca.SX.sym("p", 2)
    centre = ca.SX.sym("c", len(MOVED))
    yaw = ca.SX.sym("yaw", 3)
    x, z = ca.vertsplit(offset)
    moved = motion_at((x, z), ca.vertsplit(centre), *ca.vertsplit(yaw))
    return ca.Function("drive_point", [offset, centre, yaw], [ca.vertcat(*moved)])


def largest_step(case: Case) -> float:
    """Return the largest step in two digits [s].

    The fastest oscillation sets it: that of the shortest head rope, at a landing.
    """
    hoist = case.hoist
    plant = HoistPlant(hoist, "portable")
    structure = hoist.equation_structure
    arguments = _arguments(structure)
    rates = equations(structure).rates(*arguments)
    jacobian = ca.Function("J", arguments, [ca.jacobian(rates, arguments.x)])
    low = start_heights(hoist, case.winding)
    high = low[::-1]
    fastest = 0.0
    for force in (0.0, -GRAVITY * hoist.tail_rope_mass * hoist.tail_rope_length):
        for heights in (low, high):
            state = plant.hanging_state(*heights, force, force)
            u = np.zeros(len(INPUT_NAMES))
            u[TORQUE_COMMAND] = state.x[TORQUE]
            u[list(FORCES)] = force
            matrix = np.asarray(jacobian(state.x, u, list(state.free_lengths), hoist.numbers))
            fastest = max(fastest, float(np.abs(np.linalg.eigvals(matrix)).max()))
    step = LIMIT / fastest
    unit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return float(f"{math.floor(step / unit) * unit:.1e}")


def places_of_yaw(structure: Hoist) -> Sequence[int]:
    """Return the places of both conveyances' yaw in the state."""
    return [state_names(structure).index(f"yaw_{side}") for side in SIDES]
