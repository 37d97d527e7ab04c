"""The drive's functions, compiled where there is a C compiler: one text for all hoists with the same parts.

`advance` does CHUNK steps of a Runge-Kutta method of the length h (s counts from 0 to 1 over a communication step H)

    dx/ds = H rates(x, u(s)) ,   dW/ds = H powers(x, u(s)) ,

and shows the drive at their end: state, work so far, these steps' included, largest error over tolerance
(1 + |y| + |dy/ds|) of any of them (infinite where anything is not finite), input that acts there, outputs. With H = 0
it shows the drive as it is. Inputs change, and forces yield to the drive's acceleration,

    u(s) = u_0 + u_1 s + u_2 s^2 ,   F(s) = F_p(s) - m_a a ,   a = a_0 + B F .

Forces enter the accelerations linearly, so that with the accelerations a_p under the polynomial F_p alone
F = F_p - (1 + m_a B)^-1 m_a a_p.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import casadi as ca

from hoist_demo.drive.equations import (
    ACCELERATIONS,
    FORCES,
    INPUT_NAMES,
    LOSS_NAMES,
    WORK_NAMES,
    Equations,
    equations,
    numbers_of,
    state_names,
)
from hoist_demo.drive.outputs import OUTPUTS
from hoist_demo.parameters import Hoist
from rope_model.numerics.kernels import KernelForm, build_library, cache_folder, prepare

ORDER = 5

#: of the last stage, which is the result
_B = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
_A = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    _B,
)
_C = (1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
#: b - b*
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)


def runge_kutta_step(f: Callable[[Any, Any], Any], t: Any, y: Any, k: Any, h: Any) -> tuple[Any, Any, Any]:
    """State after h, f there, and the error of a step of fifth order; k is f(t, y).

        k_i = f(t + c_i h, y + h sum_j a_ij k_j) ,   y_new = y + h sum_i b_i k_i ,   error = h sum_i (b_i - b*_i) k_i

    The last stage is the first of the next step. Source: J. R. Dormand and P. J. Prince, A family of embedded
    Runge-Kutta formulae, Journal of Computational and Applied Mathematics 6 (1980), RK5(4)7M.
    """
    stages = [k]
    new = y
    for a, c in zip(_A, _C, strict=True):
        new = y + h * _sum(a, stages)
        stages.append(f(t + c * h, new))
    return new, stages[-1], h * _sum(_ERROR, stages)


def _sum(weights: Sequence[float], stages: Sequence[Any]) -> Any:
    """Weighted sum of the stages, without those of no weight."""
    terms = [weight * stage for weight, stage in zip(weights, stages, strict=True) if weight]
    return sum(terms[1:], terms[0])


CHUNK = 3  #: Steps in one call.

TOLERANCE = 1e-9  #: Of a step's error, relative and in SI units.

WORKS = len(WORK_NAMES) + len(LOSS_NAMES)
PATH = 3 * len(INPUT_NAMES)  #: Numbers of a path: u_0, u_1 and u_2.


@dataclass(frozen=True)
class DriveKernels:
    """CasADi functions of hoists with the same parts, and places in the argument and in the result of `advance`."""

    names: tuple[str, ...]  # of the states
    given: dict[str, slice]
    result: dict[str, slice]
    advance: Any
    mobility: Any  # of the equations
    hold: Any  # likewise


@cache
def drive_kernels(parts: Hoist, form: KernelForm = "auto") -> DriveKernels:
    """Return the kernels for all hoists with these parts (`equations.parts_of`)."""
    of, names, numbers = equations(parts), state_names(parts), len(numbers_of(parts))
    held = {"H": 1, "path": PATH, "added_mass": 2, "l0": 2, "p": numbers}
    given = _slices({"x": len(names), "works": WORKS, "s": 1, "h": 1, **held})
    shown = {"error": 1, "acting": len(INPUT_NAMES), "shown": len(OUTPUTS)}
    result = _slices({"x": len(names), "works": WORKS, **shown})
    functions = [_advance(of, given), of.mobility]
    (advance, mobility), _ = prepare(
        functions, partial(build_library, functions, folder=cache_folder(), name="hoist_drive"), form
    )
    return DriveKernels(names, given, result, advance, mobility, of.hold)


def _advance(of: Equations, given: dict[str, slice]) -> Any:
    """(one vector) -> one vector."""
    n, held_from = given["x"].stop, given["H"].start
    numbers = given["p"].stop - held_from
    slope = _slope(of, n, numbers)
    z = ca.MX.sym("z", given["p"].stop)
    held = z[held_from:]
    s, h = z[given["s"]], z[given["h"]]
    y = ca.vertcat(z[given["x"]], ca.MX.zeros(WORKS))
    k = slope(y, s, held)
    step, error = _step(slope, n + WORKS, numbers), ca.MX(0)
    for j in range(CHUNK):
        y, k, missed = step(s + j * h, y, k, h, held)
        error = ca.fmax(error, missed)
    acting, shown = _loads_and_outputs(of, n, numbers)(y[:n], s + CHUNK * h, held)
    # what is not finite anywhere passes as no step; a comparison with NaN is false
    error = ca.if_else(ca.norm_1(ca.vertcat(y, error, acting, shown)) < ca.inf, error, ca.inf)
    return ca.Function("advance", [z], [ca.vertcat(y[:n], z[given["works"]] + y[n:], error, acting, shown)])


def _step(slope: Any, size: int, numbers: int) -> Any:
    """(s, y, dy/ds, h, held) -> y and dy/ds after h, largest error."""
    s, y, k = ca.MX.sym("s"), ca.MX.sym("y", size), ca.MX.sym("k", size)
    h, held = ca.MX.sym("h"), ca.MX.sym("held", numbers)
    new, last, error = runge_kutta_step(lambda t, at: slope(at, t, held), s, y, k, h)
    missed = ca.norm_inf(error / (TOLERANCE * (1 + ca.fabs(y) + ca.fabs(k))))
    return ca.Function("step", [s, y, k, h, held], [new, last, missed])


def _slope(of: Equations, states: int, numbers: int) -> Any:
    """(y, s, held) -> dy/ds."""
    y, s = ca.SX.sym("y", states + WORKS), ca.SX.sym("s")
    x = y[:states]
    held, H, u, l0, p = _symbols(of, numbers, x, s)
    value = H * ca.vertcat(of.rates(x, u, l0, p), of.powers(x, u, l0, p))
    return ca.Function("slope", [y, s, held], [ca.cse(value)])


def _loads_and_outputs(of: Equations, states: int, numbers: int) -> Any:
    """(x, s, held) -> input that acts, outputs."""
    x, s = ca.SX.sym("x", states), ca.SX.sym("s")
    held, _, u, l0, p = _symbols(of, numbers, x, s)
    return ca.Function("loads_and_outputs", [x, s, held], ca.cse([u, of.outputs(x, u, l0, p)]))


def _symbols(of: Equations, numbers: int, x: Any, s: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Symbols of what is held over a communication step, and of it H, the input that acts at s, l0 and p."""
    held = ca.SX.sym("held", numbers)
    H, path, added_mass, l0, p = ca.vertsplit(held, [0, 1, 1 + PATH, 3 + PATH, 5 + PATH, numbers])
    start, rise, bend = ca.vertsplit(path, len(INPUT_NAMES))
    return held, H, _acting(of, x, start + s * (rise + s * bend), added_mass, l0, p), l0, p


def _acting(of: Equations, x: Any, u: Any, added_mass: Any, l0: Any, p: Any) -> Any:
    """The input with its forces less the added masses times the accelerations that come out."""
    a = of.rates(x, u, l0, p)[list(ACCELERATIONS)]
    B = of.mobility(x, u, l0, p)
    given_up = ca.solve(ca.SX.eye(len(FORCES)) + ca.diag(added_mass) @ B, added_mass * a)
    acting = ca.SX(u)
    for k, place in enumerate(FORCES):
        acting[place] -= given_up[k]
    return acting


def _slices(sizes: dict[str, int]) -> dict[str, slice]:
    found, start = {}, 0
    for name, size in sizes.items():
        found[name] = slice(start, start + size)
        start += size
    return found
