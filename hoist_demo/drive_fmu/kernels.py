"""Plant and control law as C: generated from what HoistPlant holds, whatever parts its hoist has.

    x_{k+1} = RK5(rates; x_k, u, h) ,   h <= LIMIT / largest |eigenvalue| of d rates / d x

with the host's own equations and Runge-Kutta step, and u held over a communication step. The state at rest depends on
the two forces of the balance rope; it is interpolated in them between what HoistPlant.equilibrium finds at Chebyshev's
points, to rounding: the forces are small against the stiffness EA of the head ropes, and DEGREE is chosen for
(force / EA)^(DEGREE + 1).
"""

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from hoist_demo.cases.case import Case
from hoist_demo.control.controller import Gains
from hoist_demo.control.kernel import ARGUMENTS, law_kernel
from hoist_demo.drive.equations import INPUT_NAMES, equations
from hoist_demo.drive.integrator import runge_kutta_step
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant
from hoist_demo.drive_fmu.interface import DriveRope, offset_ropes, output_names, plant_outputs, side_forces
from hoist_demo.parameters import GRAVITY, SIDES, Hoist, start_heights
from hoist_demo.parameters.suspension import MOVED, SuspensionOffset, moment_at, motion_at

#: Step times the largest eigenvalue: an error of LIMIT^6 / 3600 = 7e-8 of the fastest oscillation; 3 is unstable.
LIMIT = 0.25
DEGREE = 4
_ONE = DriveRope("", 0.0, 0.0)  #: The rope of a hoist with one, or with equal ones.


@dataclass(frozen=True)
class Kernels:
    """C text of the kernels, with the sizes that the C code around it needs."""

    c: str
    states: int
    inputs: int  # number of the plant's inputs; torque command and the two forces come first
    step: float  # s, largest stable and accurate
    lowest_force: float  # N, the state at rest is known from here to 0
    work: tuple[int, int, int, int]  # sizes of arg, res, iw and w


_HOST = Path(__file__).resolve().parent.parent


def kernels(case: Case, ropes: Sequence[DriveRope] = ()) -> Kernels:
    """C functions drive_rest, _input, _step, _outputs and _control; the installed package brings some."""
    brought = kernels_file(_HOST, case)
    if ropes or not brought.exists():
        return generate(case, ropes)
    data = json.loads(brought.read_text(encoding="utf-8"))
    return Kernels(**data | {"work": tuple(data["work"])})


def kernels_file(package: Path, case: Case) -> Path:
    """Return the JSON file of the kernels of ``case`` if the folder ``package`` brings them for its Python text."""
    digest = hashlib.sha256(repr((case.hoist, case.winding)).encode())
    for path in sorted(package.rglob("*.py")):
        digest.update(f"{path.relative_to(package).as_posix()}\0{path.read_text(encoding='utf-8')}\0".encode())
    return package / "drive_fmu" / "prebuilt" / f"kernels-{digest.hexdigest()[:20]}.json"


def generate(case: Case, ropes: Sequence[DriveRope] = ()) -> Kernels:
    """Generate the kernels as C."""
    plant = HoistPlant(case.hoist)
    lowest = -2.0 * GRAVITY * case.hoist.tail_rope_mass * case.hoist.tail_rope_length
    rest = _rest(plant, case, lowest)
    functions = [rest, _input(plant, ropes), _step(plant), _outputs(plant, ropes), _control(case.hoist)]
    generator = ca.CodeGenerator("drive_kernels", {"with_header": False, "casadi_int": "int", "indent": 4})
    for function in functions:
        generator.add(function)
    work = tuple(max(getattr(f, size)() for f in functions) for size in ("sz_arg", "sz_res", "sz_iw", "sz_w"))
    return Kernels(
        c=str(generator.dump()),
        states=len(plant.state_names),
        inputs=len(INPUT_NAMES),
        step=_largest_step(plant, case, rest),
        lowest_force=lowest,
        work=(int(work[0]), int(work[1]), max(1, int(work[2])), max(1, int(work[3]))),
    )


def _rest(plant: HoistPlant, case: Case, lowest: float) -> Any:
    """(F_left, F_right) -> x, l0 (2), at the start heights."""
    nodes = 0.5 * lowest * (1.0 - np.cos(math.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1)))
    heights = start_heights(case.hoist, case.winding)
    states = [[plant.hanging_state(*heights, float(f), float(g)) for g in nodes] for f in nodes]
    values = np.array([[[*s.x, *s.free_lengths] for s in row] for row in states])
    force = ca.SX.sym("F", 2)
    # polynomials that are 1 at one node and 0 at the others
    weights = [[math.prod((f - b) / (a - b) for b in nodes if b != a) for a in nodes] for f in ca.vertsplit(force)]
    # the mean first and the small rest by interpolation: rounding is that of the small part
    mean = values.mean(axis=(0, 1))
    sum_ = ca.SX(mean)
    for i, j in np.ndindex(values.shape[:2]):
        sum_ += weights[0][i] * weights[1][j] * (values[i, j] - mean)
    n = values.shape[2] - 2
    return ca.Function("drive_rest", [force], [sum_[:n], sum_[n:]])


def _arguments(plant: HoistPlant) -> tuple[Any, Any, Any]:
    rates = equations(plant.hoist.equation_structure).rates
    return ca.SX.sym("x", rates.size1_in(0)), ca.SX.sym("u", rates.size1_in(1)), ca.SX.sym("l0", 2)


def _rates(plant: HoistPlant, x: Any, u: Any, l0: Any) -> Any:
    """dx/dt with the numbers of this hoist."""
    return equations(plant.hoist.equation_structure).rates(x, u, l0, plant.hoist.numbers)


def _step(plant: HoistPlant) -> Any:
    """Return the step (x, u, l0, h) -> x after h."""
    x, u, l0 = _arguments(plant)
    h = ca.SX.sym("h")
    new, _, _ = runge_kutta_step(lambda _, at: _rates(plant, at, u, l0), 0.0, x, _rates(plant, x, u, l0), h)
    return ca.Function("drive_step", [x, u, l0, h], [new])


def _input(plant: HoistPlant, ropes: Sequence[DriveRope]) -> Any:
    """(x, forces of the ropes in the order of the table) -> the plant's input but for the torque."""
    x = ca.SX.sym("x", len(plant.state_names))
    attached = ropes or (_ONE,)
    forces = ca.SX.sym("F", 2 * len(attached) + len(side_forces(plant.hoist, ropes)))
    total = dict.fromkeys(INPUT_NAMES[1:], ca.SX(0.0))
    upright, sides = forces[: 2 * len(attached)], forces[2 * len(attached) :]
    for k, rope in enumerate(attached):
        for i, side in enumerate(SIDES):
            fy = upright[2 * k + i]
            total[f"force_{side}"] += fy
            if plant.hoist.play is None:
                continue
            fx, fz, my = ca.vertsplit(sides[6 * k + 3 * i : 6 * k + 3 * i + 3])
            if rope.suspension != SuspensionOffset():
                yaw = x[plant.state_names.index(f"yaw_{side}")]
                my += moment_at(rope.suspension.at(side), yaw, (fx, fy, fz))[1]
            for name, value in (("fx", fx), ("fz", fz), ("my", my)):
                total[f"{name}_{side}"] += value
    return ca.Function("drive_input", [x, forces], [ca.vertcat(*total.values())])


def _outputs(plant: HoistPlant, ropes: Sequence[DriveRope]) -> Any:
    """Return the function (x, u, l0) -> outputs of the interface."""
    x, u, l0 = _arguments(plant)
    outputs = equations(plant.hoist.equation_structure).outputs(x, u, l0, plant.hoist.numbers)
    signals = {name: outputs[OUTPUT_INDEX[field]] for name, field in output_names(plant.hoist).items()}
    for rope in offset_ropes(plant.hoist, ropes):
        for side in SIDES:
            centre, yaw = [signals[f"{side}.{name}"] for name in MOVED], signals[f"{side}.yaw"]
            yaw_acceleration = outputs[OUTPUT_INDEX[f"yaw_acceleration_{side}"]]
            moved = motion_at(rope.suspension.at(side), centre, yaw, signals[f"{side}.yaw_rate"], yaw_acceleration)
            signals |= {f"{rope.name}.{side}.{name}": value for name, value in zip(MOVED, moved, strict=True)}
    names = plant_outputs(plant.hoist, ropes)
    return ca.Function("drive_outputs", [x, u, l0], [ca.vertcat(*(signals[name] for name in names))])


def _control(hoist: Hoist) -> Any:
    """Return the control law (its ARGUMENTS, gains) -> (M_c, I)."""
    sample, gains = ca.SX.sym("sample", len(ARGUMENTS)), ca.SX.sym("gains", len(fields(Gains)))
    law = law_kernel(hoist.equation_structure)
    torque, _, grown = ca.vertsplit(law(ca.vertcat(sample, gains, ca.DM(hoist.numbers))))
    return ca.Function("drive_control", [sample, gains], [torque, grown])


def _largest_step(plant: HoistPlant, case: Case, rest: Any) -> float:
    """Return the largest step in two digits [s], of the fastest oscillation: the shortest head rope, at a landing."""
    x, u, l0 = _arguments(plant)
    jacobian = ca.Function("J", [x, u, l0], [ca.jacobian(_rates(plant, x, u, l0), x)])
    fastest = 0.0
    for force in (0.0, -GRAVITY * case.hoist.tail_rope_mass * case.hoist.tail_rope_length):
        for heights in ((low := start_heights(case.hoist, case.winding)), low[::-1]):
            state = plant.hanging_state(*heights, force, force)
            held = np.zeros(u.size1())
            held[:3] = state.x[0], force, force
            matrix = np.asarray(jacobian(state.x, held, list(state.free_lengths)))
            fastest = max(fastest, float(np.abs(np.linalg.eigvals(matrix)).max()))
    step = LIMIT / fastest
    unit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return float(f"{math.floor(step / unit) * unit:.1e}")
