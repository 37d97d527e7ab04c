"""The drive: motor, sheave, head ropes and two conveyances, integrated over one communication step.

The equations are in `equations.py`. Without further parts of the hoist the state has seven numbers: motor torque,
sheave angle and suspension heights with their rates. Shaft, head rope modes, play and brake append theirs.
The integrator is in `kernels.py`. Its steps are chosen here so that none errs by more than the tolerance,

    h_new = 0.9 h (tolerance / error)^(1/5) ,   from half of h to half as much again ,

and not beyond h after one that was taken back: a step at the bound of stability errs little, and a longer one much.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.equations import (
    INPUT_NAMES,
    LOSS_NAMES,
    SIDES,
    STATE_NAMES,
    WORK_NAMES,
    equations,
    numbers_of,
    parts_of,
    state_names,
)
from hoist_demo.drive.kernels import CHUNK, WORKS, drive_kernels
from hoist_demo.drive.outputs import PlantOutput
from hoist_demo.drive.runge_kutta import ORDER
from hoist_demo.parameters import GRAVITY, Hoist
from rope_model.numerics.kernels import Kernel, KernelForm

__all__ = [
    "LOSS_NAMES",
    "SIDE_FORCES",
    "STATE_NAMES",
    "WORK_NAMES",
    "HoistPlant",
    "PlantInput",
    "PlantInputPath",
    "PlantOutput",
    "PlantState",
    "PlantStep",
    "energy_residual",
    "free_lengths_at",
    "side_forces",
]

Vector = NDArray[np.float64]

SIDE_FORCES = tuple(f"{side}.{name}" for side in SIDES for name in ("fx", "fz", "my"))
"""The rope's signals that act on conveyances with play."""
SHORTEST = 1e-7
"""Step of the integrator [s] below which it gives up."""
SAFETY, SHRINKS, GROWS = 0.9, 0.5, 1.5
"""Of its steps: factor from the error, and its bounds."""


_NO_WORK, _NO_LOSSES = np.zeros(WORKS), np.zeros(len(LOSS_NAMES))


class PlantState(NamedTuple):
    """State x = (M [N m], phi [rad], y_L, y_R [m], phi' [rad/s], v_L, v_R [m/s], ...), work and free lengths."""

    x: Vector  # in the order of HoistPlant.state_names, which begin with STATE_NAMES
    work: Vector  # J, (5,): by the motor, into losses, into rope damping, by all balance ropes' left, right ends
    free_lengths: tuple[float, float]  # m, head ropes at phi = 0
    losses: Vector = _NO_LOSSES  # J, the parts of work[1]
    step_next: float = 0.0  # s, of the integrator; 0: not known yet


@dataclass(frozen=True)
class PlantInput:
    """Held over one communication step; forces are those of one balance rope on the conveyances."""

    torque_command: float  # N m
    force_left: float  # N, of the balance rope on the conveyance, negative is down
    force_right: float  # N
    brake: float = 0.0  # -, fraction of the brake's full torque
    fx_left: float = 0.0  # N, in the plane of the loop; the sides and the moment act where the hoist has play
    fz_left: float = 0.0  # N, out of plane
    my_left: float = 0.0  # N m, about the vertical
    fx_right: float = 0.0
    fz_right: float = 0.0
    my_right: float = 0.0


@dataclass(frozen=True)
class PlantInputPath:
    """Input over one communication step, s = 0 .. 1: start + rise s + bend s^2, and forces less m_a times a."""

    start: PlantInput
    rise: PlantInput
    bend: PlantInput
    added_mass: tuple[float, float] = (0.0, 0.0)  # kg, m_a of the left and the right end


class PlantStep(NamedTuple):
    """New state, or the old one and the cause when the step failed."""

    valid: bool
    message: str
    state: PlantState
    acting: Vector = np.zeros(0)  # input at the step's end, in the order of INPUT_NAMES
    shown: Vector = np.zeros(0)  # what PlantOutput has under it, as numbers


class HoistPlant:
    """The drive of one hoist; states are explicit and never changed in place. Not to be shared between threads."""

    def __init__(self, hoist: Hoist, form: KernelForm = "auto") -> None:
        self.hoist = hoist
        self.state_names = state_names(hoist)
        parts, numbers = parts_of(hoist), np.array(numbers_of(hoist))
        self._equations, self._numbers = equations(parts), numbers
        kernels = drive_kernels(parts, form)
        self._layout = kernels.layout
        given, result = kernels.layout.given, kernels.layout.result
        self._given, self._result = given, result
        self._advance = Kernel(kernels.advance, [(result["shown"].stop,)])
        self._z, self._y = self._advance.inputs[0], self._advance.outputs[0]
        self._s, self._h, self._x = given["s"].start, given["h"].start, self._z[given["x"]]
        # over a step: its length, the path and the added masses; then the free lengths
        self._held, self._l0 = self._z[given["H"].start : given["added_mass"].stop], self._z[given["l0"]]
        self._z[given["p"]] = numbers
        self.evaluations = 0  # of `advance`, so far
        self._rates = Kernel(kernels.rates, [(kernels.layout.states,)])
        self._mobility = Kernel(kernels.mobility, [(2, 2)])

    def reload(self, hoist: Hoist) -> None:
        """Go on with the numbers of a hoist of the same parts: with another payload."""
        self.hoist = hoist
        self._numbers[:] = numbers_of(hoist)
        self._z[self._given["p"]] = self._numbers

    def equilibrium(self, y_left: float, y_right: float, force_left: float, force_right: float) -> PlantState:
        """State at rest with the conveyances at the given heights [m] and the motor holding the imbalance.

        The conveyances hang in the middle of their guides, under the vertical forces of one balance rope [N].
        """
        state = self.hanging_state(y_left, y_right, force_left, force_right)
        if not abs(state.x[0]) <= self.hoist.torque_limit:
            raise ValueError(
                f"holding torque = {state.x[0]:.6g} N m must be within torque_limit = {self.hoist.torque_limit:g} N m: "
                "lighten the payload, balance the ropes or take a stronger motor"
            )
        return state

    def hanging_state(self, y_left: float, y_right: float, force_left: float, force_right: float) -> PlantState:
        """As equilibrium, whatever torque that takes."""
        hoist = self.hoist
        lengths = (
            self._free_length("y_left", y_left, hoist.mass_left, force_left),
            self._free_length("y_right", y_right, hoist.mass_right, force_right),
        )
        x = np.zeros(len(self.state_names))
        x[2:4] = y_left, y_right
        # own weight moves the inner points of the head ropes off the straight line: dV/d eta = 0
        for j in range(1, hoist.head_rope_modes + 1):
            k = j * math.pi
            sag = 2.0 * hoist.rope_mass * GRAVITY * (1.0 - (-1.0) ** j) / (hoist.rope_stiffness * k**3)
            for side, length in zip(("left", "right"), lengths, strict=True):
                x[self.state_names.index(f"eta{j}_{side}")] = -sag * length**2
        x[0] = float(self._equations.hold(x, lengths, self._numbers))
        if hoist.shaft is not None:
            x[self.state_names.index("twist")] = x[0] / hoist.shaft.stiffness
        return PlantState(x=x, work=np.zeros(len(WORK_NAMES)), free_lengths=lengths)

    def step(self, state: PlantState, h: float, u: PlantInput | PlantInputPath) -> PlantStep:
        """State h [s] later under the input, held or along its path; a failure is a status."""
        return self.advance(state, h, *_pack_path(u))

    def advance(
        self, state: PlantState, h: float, path: Vector, added_mass: Vector, begin: float = 0.0, end: float = 1.0
    ) -> PlantStep:
        """The same with the path's three inputs, of INPUT_NAMES each, in one vector; from s = begin to end of it."""
        self._give(state, h, path, added_mass)
        if not math.isfinite(self._held.dot(self._held)):
            return PlantStep(False, f"drive: input is not finite: {_not_finite(path)}", state)
        found = self._integrate(h, (state.step_next or h) / h, begin, end)
        if found is None:
            return PlantStep(False, "drive: state is not finite: check rope forces and torque command", state)
        y, work, size = found
        result, n = self._result, len(WORK_NAMES)
        new = PlantState(y[result["x"]], state.work + work[:n], state.free_lengths, state.losses + work[n:], size * h)
        if (free := min(free_lengths_at(self.hoist, new))) <= 0.1:
            return PlantStep(False, f"drive: head rope of {free:.3g} m left at the sheave: overwind", state)
        return PlantStep(True, "", new, y[result["acting"]], y[result["shown"]])

    def _integrate(self, h: float, size: float, s: float, end: float) -> tuple[Vector, Vector, float] | None:
        """What `advance` shows at the end, all work, next step in s; begins with steps of this size. None: no way."""
        z, result, error_at = self._z, self._result, self._result["error"].start
        work, growth = _NO_WORK, GROWS
        while size * h > SHORTEST:
            calls = max(1, math.ceil((end - s) / (CHUNK * size) - 1e-9))
            used = (end - s) / (CHUNK * calls)
            z[self._s], z[self._h] = s, used
            self._advance.evaluate()
            self.evaluations += 1
            y = self._y.copy()
            error = y.item(error_at)
            size = min(used * _change(error), size * growth)
            if error <= 1.0 and math.isfinite(y.dot(y)):
                work = work + y[result["work"]]
                if calls == 1:
                    return y, work, size
                self._x[:] = y[result["x"]]
                s += CHUNK * used
            else:
                growth = 1.0
        return None

    def mobility(self, state: PlantState) -> Vector:
        """Change of (a_left, a_right) per force on either conveyance, shape (2, 2) [1/kg]; exact, they are linear."""
        # symmetric, so that the order of rows and columns does not matter
        return self._at(self._mobility, state, np.zeros(len(INPUT_NAMES)))

    def loads_at(self, state: PlantState, path: PlantInputPath, s: float) -> PlantInput:
        """What acts at s = 0 .. 1 of a path when the drive is in this state there."""
        return unpack(self.loads_and_outputs(state, *_pack_path(path), s)[0])

    def outputs(self, state: PlantState, u: PlantInput) -> PlantOutput:
        """Measured quantities; accelerations and tensions belong to the held input u."""
        return PlantOutput(*self.loads_and_outputs(state, *_pack_path(u), 0.0)[1].tolist())

    def loads_and_outputs(self, state: PlantState, path: Vector, added_mass: Vector, s: float) -> tuple[Vector, Vector]:
        """The input that acts at s, and what PlantOutput has, as numbers."""
        self._give(state, 0.0, path, added_mass)
        result = self._result
        self._z[self._s], self._z[self._h] = s, 0.0
        self._advance.evaluate()
        y = self._y.copy()
        return y[result["acting"]], y[result["shown"]]

    def rates(self, state: PlantState, u: PlantInput) -> Vector:
        """dx/dt, in the order of state_names."""
        return self._at(self._rates, state, np.array(_pack(u)))

    def _give(self, state: PlantState, h: float, path: Vector, added_mass: Vector) -> None:
        held = self._held
        held[0], held[1:-2], held[-2:] = h, path, added_mass
        self._x[:], self._l0[:] = state.x, state.free_lengths

    def _at(self, function: Kernel, state: PlantState, u: Vector) -> Vector:
        (value,) = function(state.x, u, np.array(state.free_lengths), self._numbers)
        return value

    def _free_length(self, name: str, y: float, mass: float, force: float) -> float:
        """Positive root of s = l (1 + (m g - n F + mu g l / 2) / EA) [m]."""
        s = self.hoist.sheave_height - y
        if not s > 0.0:
            raise ValueError(f"{name} = {y!r} m must be below the sheave at {self.hoist.sheave_height:g} m: lower it")
        b = 1.0 + (mass * GRAVITY - self.hoist.tail_rope_number * force) / self.hoist.rope_stiffness
        c = self.hoist.rope_mass * GRAVITY / (2.0 * self.hoist.rope_stiffness)
        if not (math.isfinite(force) and b > 1.0):
            raise ValueError(f"rope force {force!r} N at {name} must leave the head ropes taut: check its sign")
        return 2.0 * s / (b + math.sqrt(b * b + 4.0 * c * s))


def free_lengths_at(hoist: Hoist, state: PlantState) -> tuple[float, float]:
    """Free head rope lengths between sheave and conveyances, left and right [m]."""
    wound = hoist.sheave_radius * state.x.item(1)
    return state.free_lengths[0] - wound, state.free_lengths[1] + wound


def energy_residual(start: PlantOutput, now: PlantOutput, work: Vector) -> float:
    """Motor and balance rope work minus losses minus the hoist's energy gained [J]; 0 for an exact integration."""
    gained = now.energy_kinetic + now.energy_potential - start.energy_kinetic - start.energy_potential
    motor, losses, ropes, left, right = work.tolist()
    return float(motor + left + right - losses - ropes - gained)


def side_forces(signals: Mapping[str, float]) -> dict[str, float]:
    """The balance rope's horizontal forces and its moments about the vertical, as keywords of PlantInput."""
    sided = (name.partition(".") for name in SIDE_FORCES)
    return {f"{force}_{side}": signals.get(f"{side}.{force}", 0.0) for side, _, force in sided}


_inputs_of = attrgetter(*INPUT_NAMES)


def _pack(u: PlantInput) -> list[float]:
    return [*_inputs_of(u)]


def _pack_path(u: PlantInput | PlantInputPath) -> tuple[Vector, Vector]:
    """A path as one vector, and its added masses."""
    if isinstance(u, PlantInput):
        return np.array([*_pack(u), *_NO_CHANGE]), np.zeros(2)
    return np.array([*_pack(u.start), *_pack(u.rise), *_pack(u.bend)]), np.array(u.added_mass)


def unpack(u: Vector) -> PlantInput:
    """An input from its numbers in the order of INPUT_NAMES."""
    return PlantInput(**dict(zip(INPUT_NAMES, u.tolist(), strict=True)))


def _not_finite(path: Vector) -> str:
    """Names of the inputs of a path that are no numbers, now or later in the step."""
    numbers = path.reshape(3, -1).T.tolist()
    bad = [name for name, moving in zip(INPUT_NAMES, numbers, strict=True) if not all(map(math.isfinite, moving))]
    return ", ".join(bad) or "step or added mass"


_NO_CHANGE = (0.0,) * (2 * len(INPUT_NAMES))


def _change(error: float) -> float:
    """Factor to the next step of the integrator, after one of this error over the tolerance."""
    if not math.isfinite(error):
        return SHRINKS
    factor: float = SAFETY * max(error, 1e-20) ** (-1.0 / ORDER)
    return max(SHRINKS, factor)
