"""The drive's equations compiled where there is a C compiler, and integrated by steps of their own choice.

`advance`, one text for all hoists with the same parts, does a step of a Runge-Kutta method of the length h (s counts
from 0 to 1 over a communication step H)

    dx/ds = H rates(x, u(s)) ,   dW/ds = H powers(x, u(s)) ,

and shows the drive at its end: state, work so far, this step's included, its largest error over tolerance
(1 + |y| + |dy/ds|) (infinite where anything is not finite), input that acts there, outputs. With H = 0
it shows the drive as it is. Inputs change, and forces yield to the drive's acceleration,

    u(s) = u_0 + u_1 s + u_2 s^2 ,   F(s) = F_p(s) - m_a a ,   a = a_0 + B F .

Forces enter the accelerations linearly, so that with the accelerations a_p under the polynomial F_p alone
F = F_p - (1 + m_a B)^-1 m_a a_p.

Steps are chosen so that none errs by more than the tolerance,

    h_new = 0.9 h (tolerance / error)^(1/5) ,   from half of h to half as much again ,

and not beyond h after one that was taken back: a step at the bound of stability errs little, and a longer one much.
What is watched ends them: the last one is then shortened by bisection until what is watched has just become positive.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive import equations as drive
from hoist_demo.drive.kernels import Kernel, KernelForm, build_library, prepare
from hoist_demo.drive.outputs import OUTPUTS
from hoist_demo.parameters import Hoist
from rope_model.compiler import cache_folder

Vector = NDArray[np.float64]
Watch = Callable[
    [Vector], float
]  #: Of a state and OUTPUTS there, as one vector; positive once the steps are to end.
#: Where steps have ended: all that `advance` gives there, size of the next one, s.
StepEnd = tuple[Vector, float, float]
MIN_STEP = 1e-7  #: Step of the integrator [s] below which it gives up.
SAFETY = 0.9  #: Factor on the step that the error allows.
SHRINKS = 0.5  #: Smallest factor from one step to the next.
GROWS = 1.5  #: Largest factor from one step to the next.
LOCATED = (
    1e-9  #: How long before the end of the steps what is watched may have become positive [s].
)
TOLERANCE = 1e-8  #: Of a step's error, relative and in SI units.
WORK_COUNT = len(drive.WORK_NAMES) + len(drive.LOSS_NAMES)
PATH = 3 * len(drive.INPUT_NAMES)  #: Numbers of a path: u_0, u_1 and u_2.
ORDER = 5
_B = (
    35 / 384,
    0.0,
    500 / 1113,
    125 / 192,
    -2187 / 6784,
    11 / 84,
)  #: Weights b of the result, the last stage.
WEIGHTS = (  #: Weights a of the stages; the last ones are b.
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    _B,
)
_C = (1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_ERROR = (
    71 / 57600,
    0.0,
    -71 / 16695,
    71 / 1920,
    -17253 / 339200,
    22 / 525,
    -1 / 40,
)  #: Weights b - b*.


def runge_kutta_step(
    f: Callable[[Any, Any], Any], t: Any, y: Any, k: Any, h: Any
) -> tuple[Any, Any, Any]:
    """State after h, f there, and the error of a step of fifth order; k is f(t, y).

        k_i = f(t + c_i h, y + h sum_j a_ij k_j) ,   y_new = y + h sum_i b_i k_i ,   error = h sum_i (b_i - b*_i) k_i

    The last stage is the first of the next step. Source: J. R. Dormand and P. J. Prince, A family of embedded
    Runge-Kutta formulae, Journal of Computational and Applied Mathematics 6 (1980), RK5(4)7M.
    """
    stages = [k]
    new = y
    for a, c in zip(WEIGHTS, _C, strict=True):
        new = y + h * _sum(a, stages)
        stages.append(f(t + c * h, new))
    return new, stages[-1], h * _sum(_ERROR, stages)


def _sum(weights: Sequence[float], stages: Sequence[Any]) -> Any:
    """Return the weighted sum of the stages, without those of no weight."""
    terms = [weight * stage for weight, stage in zip(weights, stages, strict=True) if weight]
    return sum(terms[1:], terms[0])


@dataclass(frozen=True, eq=False)
class DriveKernels:
    """CasADi functions of hoists with the same parts, and places in the argument and in the result of `advance`."""

    names: tuple[str, ...]  # names of the states
    argument_slices: dict[str, slice]
    result: dict[str, slice]
    advance: Any
    accelerance: Any  # function of the equations
    hold: Any  # function of the equations
    library: Path | None  # that has `advance` compiled


@cache
def drive_kernels(structure: Hoist, form: KernelForm = "auto") -> DriveKernels:
    """Return the kernels for all hoists of this `Hoist.equation_structure`."""
    eqs, names = drive.equations(structure), drive.state_names(structure)
    step_params = {"H": 1, "path": PATH, "added_mass": 2, "l0": 2, "p": len(structure.numbers)}
    argument_slices = _slices(
        {"x": len(names), "work_totals": WORK_COUNT, "s": 1, "h": 1, **step_params}
    )
    outputs = {"error": 1, "applied_input": len(drive.INPUT_NAMES), "outputs": len(OUTPUTS)}
    result = _slices({"x": len(names), "work_totals": WORK_COUNT, **outputs})
    functions = [_advance(eqs, argument_slices), eqs.accelerance]
    made: list[Path] = []

    def build(compiler: Sequence[str]) -> Path:
        made.append(build_library(functions, compiler, cache_folder(), "hoist_drive"))
        return made[0]

    (advance, accelerance), kind = prepare(functions, build, form)
    library = made[0] if kind == "compiled" else None
    return DriveKernels(names, argument_slices, result, advance, accelerance, eqs.hold, library)


def _advance(eqs: drive.Equations, argument_slices: dict[str, slice]) -> Any:
    """Return `advance` as a CasADi function of one vector that gives one vector."""
    n, step_params_from = argument_slices["x"].stop, argument_slices["H"].start
    numbers = argument_slices["p"].stop - step_params_from
    slope = _slope(eqs, n, numbers)
    z = ca.MX.sym("z", argument_slices["p"].stop)
    step_params = z[step_params_from:]
    s, h = z[argument_slices["s"]], z[argument_slices["h"]]
    y = ca.vertcat(z[argument_slices["x"]], ca.MX.zeros(WORK_COUNT))
    k = slope(y, s, step_params)
    new, _, error = runge_kutta_step(lambda at, x: slope(x, at, step_params), s, y, k, h)
    error = ca.norm_inf(error / (TOLERANCE * (1 + ca.fabs(y) + ca.fabs(k))))
    applied_input, outputs = _loads_and_outputs(eqs, n, numbers)(new[:n], s + h, step_params)
    # a step with any value that is not finite fails; a comparison with NaN is false
    error = ca.if_else(
        ca.sumsqr(ca.vertcat(new, error, applied_input, outputs)) < ca.inf, error, ca.inf
    )
    work_totals = z[argument_slices["work_totals"]] + new[n:]
    return ca.Function(
        "advance", [z], [ca.vertcat(new[:n], work_totals, error, applied_input, outputs)]
    )


def _slope(eqs: drive.Equations, states: int, numbers: int) -> Any:
    """Return the CasADi function (y, s, step_params) -> dy/ds."""
    y, s = ca.SX.sym("y", states + WORK_COUNT), ca.SX.sym("s")
    x = y[:states]
    step_params, H, u, l0, p = _symbols(eqs, numbers, x, s)
    value = H * ca.vertcat(eqs.rates(x, u, l0, p), eqs.powers(x, u, l0, p))
    return ca.Function("slope", [y, s, step_params], [ca.cse(value)])


def _loads_and_outputs(eqs: drive.Equations, states: int, numbers: int) -> Any:
    """Return the CasADi function (x, s, step_params) -> input that acts, outputs."""
    x, s = ca.SX.sym("x", states), ca.SX.sym("s")
    step_params, _, u, l0, p = _symbols(eqs, numbers, x, s)
    return ca.Function(
        "loads_and_outputs", [x, s, step_params], ca.cse([u, eqs.outputs(x, u, l0, p)])
    )


def _symbols(eqs: drive.Equations, numbers: int, x: Any, s: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Symbols of what is held over a communication step, and of it H, the input that acts at s, l0 and p."""
    step_params = ca.SX.sym("step_params", numbers)
    H, path, added_mass, l0, p = ca.vertsplit(
        step_params, [0, 1, 1 + PATH, 3 + PATH, 5 + PATH, numbers]
    )
    start, linear, quadratic = ca.vertsplit(path, len(drive.INPUT_NAMES))
    return (
        step_params,
        H,
        _applied_input(eqs, x, start + s * (linear + s * quadratic), added_mass, l0, p),
        l0,
        p,
    )


def _applied_input(eqs: drive.Equations, x: Any, u: Any, added_mass: Any, l0: Any, p: Any) -> Any:
    """Return the input with its forces less the added masses times the accelerations that come out."""
    a = eqs.rates(x, u, l0, p)[list(drive.ACCELERATIONS)]
    B = eqs.accelerance(x, u, l0, p)
    given_up = ca.solve(ca.SX.eye(len(drive.FORCES)) + ca.diag(added_mass) @ B, added_mass * a)
    applied_input = ca.SX(u)
    for k, index in enumerate(drive.FORCES):
        applied_input[index] -= given_up[k]
    return applied_input


def _slices(sizes: dict[str, int]) -> dict[str, slice]:
    slices, start = {}, 0
    for name, size in sizes.items():
        slices[name] = slice(start, start + size)
        start += size
    return slices


class Integrator:
    """Integrator for all hoists with the same parts; not to be shared between threads."""

    def __init__(self, hoist: Hoist, form: KernelForm) -> None:
        self.kernels = kernels = drive_kernels(hoist.equation_structure, form)
        self.names, self.result = kernels.names, kernels.result
        self._error, self._reached = (
            self.result["error"].start,
            slice(0, self.result["work_totals"].stop),
        )
        self._advance = Kernel(kernels.advance, [(self.result["outputs"].stop,)])
        self.z, self.y = self._advance.inputs[0], self._advance.outputs[0]
        self.arguments = {name: self.z[index] for name, index in kernels.argument_slices.items()}
        self._hold, self._accelerance = kernels.hold, Kernel(kernels.accelerance, [(2, 2)])
        self.evaluations = 0  # calls of `advance` with a step, so far
        self.give(p=hoist.numbers)

    def give(self, **values: Any) -> None:
        """Give what `advance` takes, by name: x, work_totals, s, h, H, path, added_mass, l0, p (numbers)."""
        for name, value in values.items():
            self.arguments[name][...] = value

    def holding_torque(self, x: Vector, lengths: tuple[float, float]) -> float:
        """Return the motor's torque that holds the state at rest [N m]."""
        return float(self._hold(x, lengths, self.arguments["p"]))

    def accelerance(self, x: Vector, u: Vector, lengths: tuple[float, float]) -> Vector:
        """Return the change of (a_left, a_right) per force on either conveyance, shape (2, 2) [1/kg]."""
        (columns,) = self._accelerance(x, u, np.array(lengths), self.arguments["p"])
        return columns.T

    def integrate(
        self, h: float, size: float, s: float, end: float, watch: Watch | None = None
    ) -> StepEnd | None:
        """Integrate in steps of `size` [parts of h] at first, to the end or where `watch` turns positive; else None."""
        largest_factor = GROWS
        while size * h > MIN_STEP:
            steps = max(1, math.ceil((end - s) / size - 1e-9))
            used = (end - s) / steps
            y = self.evaluate(s, used)
            error = y.item(self._error)
            size = min(used * _change(error), size * largest_factor)
            if error <= 1.0:
                if watch is not None and watch(y) > 0.0:
                    y, used = self._first(y, s, used, h, watch)
                    return y, size, s + used
                if steps == 1:
                    return y, size, end
                self.z[self._reached] = y[self._reached]
                s += used
            else:
                largest_factor = 1.0
        return None

    def evaluate(self, s: float, used: float = 0.0) -> Vector:
        """Return all that `advance` gives after a step of the size `used` from s; 0: in the state given."""
        self.give(s=s, h=used)
        self._advance.evaluate()
        self.evaluations += 1 if used > 0.0 else 0
        return self.y.copy()

    def _first(
        self, y: Vector, s: float, used: float, h: float, watch: Watch
    ) -> tuple[Vector, float]:
        """Locate where what is watched has just become positive; return the result there and the size of the step."""
        low = 0.0
        while (used - low) * h > LOCATED:
            middle = (low + used) / 2.0
            there = self.evaluate(s, middle)
            if watch(there) > 0.0:
                y, used = there, middle
            else:
                low = middle
        return y, used


def _change(error: float) -> float:
    """Factor to the next step of the integrator, after one of this error over the tolerance."""
    if not math.isfinite(error):
        return SHRINKS
    return max(SHRINKS, float(SAFETY * max(error, 1e-20) ** (-1.0 / ORDER)))
