"""The drive: motor, sheave, head ropes and two conveyances, integrated over one communication step.

The equations are in `equations.py`. Without further parts of the hoist the state has seven numbers: motor torque,
sheave angle and suspension heights with their rates. Shaft, head rope modes, play and brake append theirs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.end_motion import EndMotion
from hoist_demo.drive.equations import INPUT_NAMES, POWER_NAMES, STATE_NAMES, equations, state_names
from hoist_demo.drive.loads import under_changing_load
from hoist_demo.parameters import GRAVITY, Hoist

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

WORK_NAMES = ("motor", "losses", "ropes", "left", "right")
LOSS_NAMES = ("rim", "guides", "brake", "shaft")
SIDE_FORCES = tuple(f"{side}.{name}" for side in ("left", "right") for name in ("fx", "fz", "my"))
"""The rope's signals that act on conveyances with play."""
FORCES = tuple(INPUT_NAMES.index(name) for name in ("force_left", "force_right"))
"""Places of the two vertical forces in a packed input."""
ACCELERATIONS = (STATE_NAMES.index("v_left"), STATE_NAMES.index("v_right"))
"""Places of the two vertical accelerations in the rates."""


@dataclass(frozen=True)
class PlantState:
    """State x = (M [N m], phi [rad], y_L, y_R [m], phi' [rad/s], v_L, v_R [m/s], ...), work and free lengths."""

    x: Vector  # in the order of HoistPlant.state_names, which begin with STATE_NAMES
    work: Vector  # J, (5,): by the motor, into losses, into rope damping, by all balance ropes' left, right ends
    free_lengths: tuple[float, float]  # m, head ropes at phi = 0
    losses: Vector = field(default_factory=lambda: np.zeros(len(LOSS_NAMES)))  # J, the parts of work[1]


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


@dataclass(frozen=True)
class PlantOutput:
    """What the drive shows at one instant."""

    y_left: float  # m
    y_right: float  # m
    v_left: float  # m/s
    v_right: float  # m/s
    a_left: float  # m/s^2
    a_right: float  # m/s^2
    angle: float  # rad, of the sheave
    rate: float  # rad/s
    torque: float  # N m, of the motor
    tension_left: float  # N, all head ropes, at the sheave
    tension_right: float  # N
    energy_kinetic: float  # J
    energy_potential: float  # J
    motor_rate: float = 0.0  # rad/s
    brake_torque: float = 0.0  # N m, on the sheave, positive against positive rotation
    static_tension_left: float = 0.0  # N, at the sheave, were everything at rest here
    static_tension_right: float = 0.0  # N
    x_left: float = 0.0  # m, of the conveyance from the middle of its guides, in the plane of the loop
    vx_left: float = 0.0  # m/s
    ax_left: float = 0.0  # m/s^2
    z_left: float = 0.0  # m, out of plane
    vz_left: float = 0.0  # m/s
    az_left: float = 0.0  # m/s^2
    yaw_left: float = 0.0  # rad, about the vertical
    yaw_rate_left: float = 0.0  # rad/s
    yaw_acceleration_left: float = 0.0  # rad/s^2
    x_right: float = 0.0
    vx_right: float = 0.0
    ax_right: float = 0.0
    z_right: float = 0.0
    vz_right: float = 0.0
    az_right: float = 0.0
    yaw_right: float = 0.0
    yaw_rate_right: float = 0.0
    yaw_acceleration_right: float = 0.0

    @property
    def tension_ratio(self) -> float:
        """Larger tension over smaller one (Euler-Eytelwein), infinite when a side is slack [-]."""
        return _ratio(self.tension_left, self.tension_right)

    @property
    def static_tension_ratio(self) -> float:
        """The same, were everything at rest here [-]."""
        return _ratio(self.static_tension_left, self.static_tension_right)

    @property
    def power(self) -> float:
        """Mechanical power of the motor [W]."""
        return self.torque * self.motor_rate

    @property
    def ends(self) -> tuple[EndMotion, EndMotion]:
        """Motion of the balance rope's left and right end."""
        return self._end("left"), self._end("right")

    def _end(self, side: str) -> EndMotion:
        names = ("x", "z", "vx", "vz", "ax", "az", "yaw", "yaw_rate")
        lateral = {name: getattr(self, f"{name}_{side}") for name in names}
        upright = {f"{name}y": getattr(self, f"{name or 'y'}_{side}") for name in ("", "v", "a")}
        return EndMotion(**lateral, **upright)


@dataclass(frozen=True)
class PlantStep:
    """New state, or the old one and the cause when the step failed."""

    valid: bool
    message: str
    state: PlantState


class HoistPlant:
    """Symbolic model and its integrator, built once; states are explicit and never changed in place."""

    def __init__(self, hoist: Hoist, tolerance: float = 1e-9) -> None:
        self.hoist = hoist
        self.state_names = state_names(hoist)
        self.equations = equations(hoist)
        self._under_path: Any = None
        self._options: dict[str, Any] = {
            "reltol": tolerance,
            "abstol": tolerance,
            "quad_err_con": True,
            "max_num_steps": 20000,
            # oscillations, hardly damped, that are to be resolved: no need of Newton's method and its Jacobians
            "linear_multistep_method": "adams",
            "nonlinear_solver_iteration": "functional",
            "show_eval_warnings": False,
            "disable_internal_warnings": True,
        }
        # time scaled to [0, 1], so that one integrator serves every step length
        self._integrator: Any = ca.integrator("drive", "cvodes", self.equations.dae, 0.0, 1.0, self._options)

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
        x[0] = float(self.equations.hold(x, *lengths))
        if hoist.shaft is not None:
            x[self.state_names.index("twist")] = x[0] / hoist.shaft.stiffness
        return PlantState(x=x, work=np.zeros(len(WORK_NAMES)), free_lengths=lengths)

    def step(self, state: PlantState, h: float, u: PlantInput | PlantInputPath) -> PlantStep:
        """State h [s] later under the input, held or along its path; a failure of CVODES is a status."""
        if isinstance(u, PlantInput):
            integrator, given = self._integrator, _pack(u)
        else:
            integrator, given = self._along_path(), [*_pack(u.start), *_pack(u.rise), *_pack(u.bend), *u.added_mass]
        parameters = [h, *given, *state.free_lengths]
        if not np.all(np.isfinite(parameters)):
            return PlantStep(False, f"drive: input is not finite: {u}", state)
        try:
            result = integrator(x0=state.x, p=parameters)
        except RuntimeError as error:
            cause = str(error).strip().splitlines()[-1]
            return PlantStep(False, f"drive: CVODES failed ({cause}): shorten the communication step", state)
        x = np.asarray(result["xf"], dtype=np.float64).ravel()
        done = dict(zip(POWER_NAMES, np.asarray(result["qf"], dtype=np.float64).ravel(), strict=True))
        lost = np.array([done[name] for name in LOSS_NAMES])
        done["losses"] = lost.sum()
        work = state.work + np.array([done[name] for name in WORK_NAMES])
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(work))):
            return PlantStep(False, "drive: state is not finite: check rope forces and torque command", state)
        new = PlantState(x=x, work=work, free_lengths=state.free_lengths, losses=state.losses + lost)
        free = free_lengths_at(self.hoist, new)
        if min(free) <= 0.1:
            return PlantStep(False, f"drive: head rope of {min(free):.3g} m left at the sheave: overwind", state)
        return PlantStep(True, "", new)

    def mobility(self, state: PlantState) -> Vector:
        """Change of (a_left, a_right) per force on either conveyance, shape (2, 2) [1/kg]; exact, they are linear."""
        rows = list(ACCELERATIONS)
        at_rest = self.rates(state, PlantInput(0.0, 0.0, 0.0))[rows]
        unit = 1.0e4  # N
        columns = [self.rates(state, PlantInput(0.0, *forces))[rows] for forces in ((unit, 0.0), (0.0, unit))]
        return np.array([column - at_rest for column in columns]).T / unit

    def loads_at(self, state: PlantState, path: PlantInputPath, s: float) -> PlantInput:
        """What acts at s = 0 .. 1 of a path when the drive is in this state there."""
        values = [a + s * (b + s * c) for a, b, c in zip(*map(_pack, (path.start, path.rise, path.bend)), strict=True)]
        added = np.array(path.added_mass)
        if added.any():
            a = self.rates(state, PlantInput(*values))[list(ACCELERATIONS)]
            matrix = np.eye(2) + added[:, None] * self.mobility(state)
            for place, force in zip(FORCES, np.linalg.solve(matrix, added * a), strict=True):
                values[place] -= float(force)
        return PlantInput(*values)

    def rates(self, state: PlantState, u: PlantInput) -> Vector:
        """dx/dt, in the order of state_names."""
        return np.asarray(self.equations.rates(state.x, _pack(u), *state.free_lengths), dtype=np.float64).ravel()

    def outputs(self, state: PlantState, u: PlantInput) -> PlantOutput:
        """Measured quantities; accelerations and tensions belong to the held input u."""
        values = self.equations.outputs(state.x, _pack(u), *state.free_lengths)
        return PlantOutput(*np.asarray(values).ravel().tolist())

    def _along_path(self) -> Any:
        """The integrator for inputs that change within a step, made when the first is met."""
        if self._under_path is None:
            dae = under_changing_load(self.equations.dae, len(INPUT_NAMES), FORCES, ACCELERATIONS)
            self._under_path = ca.integrator("drive_path", "cvodes", dae, 0.0, 1.0, self._options)
        return self._under_path

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
    wound = hoist.sheave_radius * float(state.x[1])
    return state.free_lengths[0] - wound, state.free_lengths[1] + wound


def energy_residual(start: PlantOutput, now: PlantOutput, work: Vector) -> float:
    """Motor and balance rope work minus losses minus the hoist's energy gained [J]; 0 for an exact integration."""
    gained = now.energy_kinetic + now.energy_potential - start.energy_kinetic - start.energy_potential
    motor, losses, ropes, left, right = (float(value) for value in work)
    return motor + left + right - losses - ropes - gained


def side_forces(signals: Mapping[str, float]) -> dict[str, float]:
    """The balance rope's horizontal forces and its moments about the vertical, as keywords of PlantInput."""
    sided = (name.partition(".") for name in SIDE_FORCES)
    return {f"{force}_{side}": signals.get(f"{side}.{force}", 0.0) for side, _, force in sided}


def _ratio(one: float, other: float) -> float:
    low, high = sorted((one, other))
    return high / low if low > 0.0 else math.inf


_inputs_of = attrgetter(*INPUT_NAMES)


def _pack(u: PlantInput) -> list[float]:
    return [*_inputs_of(u)]
