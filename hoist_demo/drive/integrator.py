"""The drive's equations, compiled where there is a C compiler, and their adaptive integration.

``advance``, one text for all hoists with the same parts, does a step of a Runge-Kutta method of the
length h (s counts from 0 to 1 over a communication step H)

    dx/ds = H rates(x, u(s)) ,   dW/ds = H powers(x, u(s)) ,

and shows the drive at its end: state, work so far, this step's included, its largest error over
tolerance (1 + |y| + |dy/ds|) (infinite where anything is not finite), input that acts there,
outputs. With H = 0 it shows the drive as it is. Inputs change, and forces yield to the drive's
acceleration,

    u(s) = u_0 + u_1 s + u_2 s^2 ,   F(s) = F_p(s) - m_a a ,   a = a_0 + B F .

Forces enter the accelerations linearly, so that with the accelerations a_p under the polynomial F_p
alone F = F_p - (1 + m_a B)^-1 m_a a_p.

Steps are chosen so that the error of each stays within the tolerance,

    h_new = 0.9 h (tolerance / error)^(1/5) ,   from half of h to half as much again ,

and not beyond h after one that was taken back: a step at the bound of stability has a small error,
and a longer one a large error. An event, a function of the state that becomes positive, ends the
steps: bisection shortens the last one until the function has just become positive.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.coordinates import (
    ACCELERATIONS,
    FORCES,
    INPUT_NAMES,
    LOSS_NAMES,
    WORK_NAMES,
    state_names,
)
from hoist_demo.drive.equations import HoistEquations, equations
from hoist_demo.drive.kernels import Kernel, KernelForm, build_library, prepare
from hoist_demo.drive.outputs import OUTPUTS
from hoist_demo.parameters import Hoist
from rope_model.compiler import cache_folder

Vector = NDArray[np.float64]
EventFunction = Callable[
    [Vector], float
]  #: Function of the result of ``advance``; positive ends the steps.
MIN_STEP = 1e-7  #: Step of the integrator [s] below which it gives up.
SAFETY = 0.9  #: Factor on the step that the error allows.
MIN_FACTOR = 0.5  #: Smallest factor from one step to the next.
MAX_FACTOR = 1.5  #: Largest factor from one step to the next.
MIN_ERROR = 1e-20  #: Errors over the tolerance count as no smaller, so that their root is finite.
STEP_ROUNDING = 1e-9  #: Part of a step by which the rest may exceed it through rounding alone.
#: Largest time from the event, where the watched value becomes positive, to the end of the steps
#: [s].
EVENT_TOLERANCE = 1e-9
TOLERANCE = 1e-8  #: Bound of a step's error, relative and in SI units.
WORK_COUNT = len(WORK_NAMES) + len(LOSS_NAMES)
PATH_SIZE = 3 * len(INPUT_NAMES)  #: Numbers of a path: u_0, u_1 and u_2.
ORDER = 5
#: Weights b of the result, the last stage.
_B = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
#: Weights a of the stages; the last ones are b.
WEIGHTS = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    _B,
)
_C = (1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
#: Weights b - b*.
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)


class Span(NamedTuple):
    """Part of a communication step, in s from 0 to 1."""

    begin: float
    end: float


class StepsEnd(NamedTuple):
    """End of the steps of an integration."""

    y: Vector  # result of `advance`
    next_size: float  # of the next step, part of the communication step
    s: float


class RungeKuttaStep(NamedTuple):
    """Result of a step."""

    y: Any
    k: Any  # f there
    error: Any


def runge_kutta_step(
    f: Callable[[Any, Any], Any], t: Any, y: Any, k: Any, h: Any
) -> RungeKuttaStep:
    """Return a step of fifth order of the length h; k is f(t, y).

        k_i = f(t + c_i h, y + h sum_j a_ij k_j) ,
        y_new = y + h sum_i b_i k_i ,   error = h sum_i (b_i - b*_i) k_i .

    The last stage is the first of the next step. Source: J. R. Dormand and P. J. Prince, A family
    of embedded Runge-Kutta formulae, Journal of Computational and Applied Mathematics 6 (1980),
    RK5(4)7M.
    """
    stages = [k]
    new = y
    for a, c in zip(WEIGHTS, _C, strict=True):
        new = y + h * _sum(a, stages)
        stages.append(f(t + c * h, new))
    return RungeKuttaStep(new, stages[-1], h * _sum(_ERROR, stages))


def _sum(weights: Sequence[float], stages: Sequence[Any]) -> Any:
    """Return the weighted sum of the stages, without those of no weight."""
    terms = [weight * stage for weight, stage in zip(weights, stages, strict=True) if weight]
    return sum(terms[1:], terms[0])


@dataclass(frozen=True, eq=False)
class DriveKernels:
    """CasADi functions of hoists with the same parts, and places in the vectors of ``advance``."""

    names: tuple[str, ...]  # names of the states
    argument_slices: dict[str, slice]
    result: dict[str, slice]
    advance: Any
    accelerance: Any  # function of the equations
    hold: Any  # function of the equations
    library: Path | None  # that has `advance` compiled


@cache
def drive_kernels(structure: Hoist, form: KernelForm = "auto") -> DriveKernels:
    """Return the kernels for all hoists of this ``Hoist.equation_structure``."""
    eqs = equations(structure)
    names = state_names(structure)
    argument_slices = _slices(
        x=len(names), work_totals=WORK_COUNT, s=1, h=1, **_step_parameter_sizes(structure)
    )
    result = _slices(
        x=len(names),
        work_totals=WORK_COUNT,
        error=1,
        applied_input=len(INPUT_NAMES),
        outputs=len(OUTPUTS),
    )
    functions = [_advance(eqs, argument_slices), eqs.accelerance]
    libraries: list[Path] = []

    def build(compiler: Sequence[str]) -> Path:
        library = build_library(functions, compiler, cache_folder(), "hoist_drive")
        libraries.append(library)
        return library

    (advance, accelerance), kind = prepare(functions, build, form)
    return DriveKernels(
        names=names,
        argument_slices=argument_slices,
        result=result,
        advance=advance,
        accelerance=accelerance,
        hold=eqs.hold,
        library=libraries[0] if kind == "compiled" else None,
    )


def _step_parameter_sizes(structure: Hoist) -> dict[str, int]:
    """Return the sizes of the arguments of ``advance`` that are held over a communication step."""
    return {"H": 1, "path": PATH_SIZE, "added_mass": 2, "l0": 2, "p": len(structure.numbers)}


def _advance(eqs: HoistEquations, argument_slices: dict[str, slice]) -> Any:
    """Return ``advance`` as a CasADi function of one vector that gives one vector."""
    n = argument_slices["x"].stop
    first_step_param = argument_slices["H"].start
    numbers = argument_slices["p"].stop - first_step_param
    slope = _slope(eqs, n, numbers)
    z = ca.MX.sym("z", argument_slices["p"].stop)
    step_params = z[first_step_param:]
    s = z[argument_slices["s"]]
    h = z[argument_slices["h"]]
    y = ca.vertcat(z[argument_slices["x"]], ca.MX.zeros(WORK_COUNT))
    k = slope(y, s, step_params)
    step = runge_kutta_step(lambda at, x: slope(x, at, step_params), s, y, k, h)
    error = ca.norm_inf(step.error / (TOLERANCE * (1 + ca.fabs(y) + ca.fabs(k))))
    applied_input, outputs = _loads_and_outputs(eqs, n, numbers)(step.y[:n], s + h, step_params)
    # a step with any value that is not finite fails; a comparison with NaN is false
    is_finite = ca.sumsqr(ca.vertcat(step.y, error, applied_input, outputs)) < ca.inf
    error = ca.if_else(is_finite, error, ca.inf)
    work_totals = z[argument_slices["work_totals"]] + step.y[n:]
    result = ca.vertcat(step.y[:n], work_totals, error, applied_input, outputs)
    return ca.Function("advance", [z], [result])


def _slope(eqs: HoistEquations, states: int, numbers: int) -> Any:
    """Return the CasADi function (y, s, step_params) -> dy/ds."""
    y = ca.SX.sym("y", states + WORK_COUNT)
    s = ca.SX.sym("s")
    x = y[:states]
    symbols = _step_symbols(eqs, numbers, x, s)
    arguments = (x, symbols.u, symbols.l0, symbols.p)
    value = symbols.H * ca.vertcat(eqs.rates(*arguments), eqs.powers(*arguments))
    return ca.Function("slope", [y, s, symbols.step_params], [ca.cse(value)])


def _loads_and_outputs(eqs: HoistEquations, states: int, numbers: int) -> Any:
    """Return the CasADi function (x, s, step_params) -> input that acts, outputs."""
    x = ca.SX.sym("x", states)
    s = ca.SX.sym("s")
    symbols = _step_symbols(eqs, numbers, x, s)
    outputs = eqs.outputs(x, symbols.u, symbols.l0, symbols.p)
    return ca.Function(
        "loads_and_outputs", [x, s, symbols.step_params], ca.cse([symbols.u, outputs])
    )


class _StepSymbols(NamedTuple):
    """Symbols of the arguments that are held over a communication step."""

    step_params: Any  # all in one vector
    H: Any
    u: Any  # input that acts at s
    l0: Any
    p: Any


def _step_symbols(eqs: HoistEquations, numbers: int, x: Any, s: Any) -> _StepSymbols:
    """Return the symbols of a communication step, with the input at s in the state x."""
    step_params = ca.SX.sym("step_params", numbers)
    H, path, added_mass, l0, p = ca.vertsplit(
        step_params, [0, 1, 1 + PATH_SIZE, 3 + PATH_SIZE, 5 + PATH_SIZE, numbers]
    )
    start, linear, quadratic = ca.vertsplit(path, len(INPUT_NAMES))
    polynomial = start + s * (linear + s * quadratic)
    u = _applied_input(eqs, x, polynomial, added_mass, l0, p)
    return _StepSymbols(step_params, H, u, l0, p)


def _applied_input(eqs: HoistEquations, x: Any, u: Any, added_mass: Any, l0: Any, p: Any) -> Any:
    """Return the input with its forces less the added masses times the accelerations."""
    a = eqs.rates(x, u, l0, p)[list(ACCELERATIONS)]
    B = eqs.accelerance(x, u, l0, p)
    given_up = ca.solve(ca.SX.eye(len(FORCES)) + ca.diag(added_mass) @ B, added_mass * a)
    applied_input = ca.SX(u)
    for k, index in enumerate(FORCES):
        applied_input[index] -= given_up[k]
    return applied_input


def _slices(**sizes: int) -> dict[str, slice]:
    """Return the places of parts of these sizes in one vector, by name."""
    slices: dict[str, slice] = {}
    start = 0
    for name, size in sizes.items():
        slices[name] = slice(start, start + size)
        start += size
    return slices


class Integrator:
    """Integrator for all hoists with the same parts; not to be shared between threads."""

    def __init__(self, hoist: Hoist, form: KernelForm) -> None:
        kernels = drive_kernels(hoist.equation_structure, form)
        self.kernels = kernels
        self.names = kernels.names
        self.result = kernels.result
        self._error = self.result["error"].start
        self._state = slice(0, self.result["work_totals"].stop)  # states and works
        self._advance = Kernel(kernels.advance, [(self.result["outputs"].stop,)])
        self.z = self._advance.inputs[0]
        self.y = self._advance.outputs[0]
        self.arguments = {name: self.z[index] for name, index in kernels.argument_slices.items()}
        self._hold = kernels.hold
        self._accelerance = Kernel(kernels.accelerance, [(2, 2)])
        self.evaluations = 0  # calls of `advance` with a step, so far
        self.set_arguments(p=hoist.numbers)

    def set_arguments(self, **values: Any) -> None:
        """Set arguments of ``advance``: x, work_totals, s, h, H, path, added_mass, l0, p."""
        for name, value in values.items():
            self.arguments[name][...] = value

    def holding_torque(self, x: Vector, lengths: tuple[float, float]) -> float:
        """Return the motor's torque that holds the state at rest [N m]."""
        return float(self._hold(x, lengths, self.arguments["p"]))

    def accelerance(self, x: Vector, u: Vector, lengths: tuple[float, float]) -> Vector:
        """Return the change of (a_left, a_right) per force on either conveyance, (2, 2) [1/kg]."""
        (columns,) = self._accelerance(x, u, np.array(lengths), self.arguments["p"])
        return columns.T

    def integrate(
        self, h: float, size: float, span: Span, event: EventFunction | None = None
    ) -> StepsEnd | None:
        """Integrate over a span of a communication step of h [s], or until an event.

        The first step is ``size`` long, a part of h. Returns None where no step keeps to the
        tolerance.
        """
        s, end = span
        largest_factor = MAX_FACTOR
        while size * h > MIN_STEP:
            steps = max(1, math.ceil((end - s) / size - STEP_ROUNDING))
            used = (end - s) / steps
            y = self.evaluate(s, used)
            error = y.item(self._error)
            size = min(used * _step_factor(error), size * largest_factor)
            if not error <= 1.0:
                largest_factor = 1.0
                continue
            if event is not None and event(y) > 0.0:
                y, used = self._locate(event, y, s, used, h)
                return StepsEnd(y, size, s + used)
            if steps == 1:
                return StepsEnd(y, size, end)
            self.z[self._state] = y[self._state]
            s += used
        return None

    def evaluate(self, s: float, used: float = 0.0) -> Vector:
        """Return the result of ``advance`` after a step of ``used`` from s, which may be 0."""
        self.set_arguments(s=s, h=used)
        self._advance.evaluate()
        if used > 0.0:
            self.evaluations += 1
        return self.y.copy()

    def _locate(
        self, event: EventFunction, y: Vector, s: float, used: float, h: float
    ) -> tuple[Vector, float]:
        """Return the result just behind an event within a step, and the size of the step to there.

        ``y`` is the result of the whole step, of the size ``used``.
        """
        before = 0.0
        while (used - before) * h > EVENT_TOLERANCE:
            middle = (before + used) / 2.0
            result = self.evaluate(s, middle)
            if event(result) > 0.0:
                y = result
                used = middle
            else:
                before = middle
        return y, used


def _step_factor(error: float) -> float:
    """Return the factor to the next step, after one with this error over the tolerance."""
    if not math.isfinite(error):
        return MIN_FACTOR
    return max(MIN_FACTOR, float(SAFETY * max(error, MIN_ERROR) ** (-1.0 / ORDER)))
