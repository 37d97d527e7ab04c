"""The drive's functions, compiled where there is a C compiler: one text for all hoists with the same parts.

`advance` does CHUNK steps of a Runge-Kutta method of the length h (s counts from 0 to 1 over a communication step H)

    dx/ds = H rates(x, u(s)) ,   dW/ds = H powers(x, u(s)) ,

and shows the drive at their end: state, work so far, these steps' included, largest error over tolerance
(1 + |y| + |dy/ds|) of any of them (infinite where anything is not finite), input that acts there, outputs. With H = 0
it shows the drive as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import casadi as ca

from hoist_demo.drive.equations import INPUT_NAMES, LOSS_NAMES, WORK_NAMES, Equations, equations, numbers_of
from hoist_demo.drive.loads import PATH, effective_input, path_at
from hoist_demo.drive.runge_kutta import runge_kutta_step
from hoist_demo.parameters import Hoist
from rope_model.numerics.kernels import KernelForm, build_library, cache_folder, prepare

CHUNK = 3
"""Steps in one call."""

TOLERANCE = 1e-9
"""Of a step's error, relative and in SI units."""

WORKS = len(WORK_NAMES) + len(LOSS_NAMES)


@dataclass(frozen=True)
class Layout:
    """Places of all quantities in the argument and in the result of `advance`, one vector each."""

    states: int
    outputs: int
    numbers: int  # of the hoist

    @property
    def given(self) -> dict[str, slice]:
        """Parts of the argument."""
        held = {"H": 1, "path": PATH, "added_mass": 2, "l0": 2, "p": self.numbers}
        return _slices({"x": self.states, "works": WORKS, "s": 1, "h": 1, **held})

    @property
    def result(self) -> dict[str, slice]:
        """Parts of the result."""
        shown = {"error": 1, "acting": len(INPUT_NAMES), "shown": self.outputs}
        return _slices({"x": self.states, "works": WORKS, **shown})


@dataclass(frozen=True)
class DriveKernels:
    """CasADi functions; `rates` and `mobility` are those of the equations."""

    layout: Layout
    advance: Any
    rates: Any
    mobility: Any


@cache
def drive_kernels(parts: Hoist, form: KernelForm = "auto") -> DriveKernels:
    """Return the kernels for all hoists with these parts (`equations.parts_of`)."""
    of = equations(parts)
    layout = Layout(of.rates.size1_out(0), of.outputs.size1_out(0), len(numbers_of(parts)))
    functions = [_advance(of, layout), of.rates, of.mobility]
    made, _ = prepare(functions, partial(build_library, functions, folder=cache_folder(), name="hoist_drive"), form)
    return DriveKernels(layout, *made)


def _advance(of: Equations, layout: Layout) -> Any:
    """(one vector) -> one vector, see Layout."""
    n, given = layout.states, layout.given
    slope = _slope(of, layout)
    z = ca.MX.sym("z", given["p"].stop)
    held = z[given["H"].start :]
    s, h = z[given["s"]], z[given["h"]]
    y = ca.vertcat(z[given["x"]], ca.MX.zeros(WORKS))
    k = slope(y, s, held)
    step, error = _step(slope, n + WORKS, held.numel()), ca.MX(0)
    for j in range(CHUNK):
        y, k, missed = step(s + j * h, y, k, h, held)
        error = ca.fmax(error, missed)
    acting, shown = _loads_and_outputs(of, layout)(y[:n], s + CHUNK * h, held)
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


def _slope(of: Equations, layout: Layout) -> Any:
    """(y, s, held) -> dy/ds."""
    y, s = ca.SX.sym("y", layout.states + WORKS), ca.SX.sym("s")
    held, H, u, l0, p = _symbols(of, layout, y[: layout.states], s)
    x = y[: layout.states]
    value = H * ca.vertcat(of.rates(x, u, l0, p), of.powers(x, u, l0, p))
    return ca.Function("slope", [y, s, held], [ca.cse(value)])


def _loads_and_outputs(of: Equations, layout: Layout) -> Any:
    """(x, s, held) -> input that acts, outputs."""
    x, s = ca.SX.sym("x", layout.states), ca.SX.sym("s")
    held, _, u, l0, p = _symbols(of, layout, x, s)
    return ca.Function("loads_and_outputs", [x, s, held], ca.cse([u, of.outputs(x, u, l0, p)]))


def _symbols(of: Equations, layout: Layout, x: Any, s: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Symbols of what is held over a communication step, and of it H, the input that acts at s, l0 and p."""
    held = ca.SX.sym("held", layout.given["p"].stop - layout.given["H"].start)
    H, path, added_mass, l0, p = ca.vertsplit(held, [0, 1, 1 + PATH, 3 + PATH, 5 + PATH, held.numel()])
    return held, H, effective_input(of, x, path_at(path, s), added_mass, l0, p), l0, p


def _slices(sizes: dict[str, int]) -> dict[str, slice]:
    found, start = {}, 0
    for name, size in sizes.items():
        found[name] = slice(start, start + size)
        start += size
    return found
