"""The drive: motor, sheave, head ropes and two conveyances, integrated over one communication step.

Generalised coordinates q = (phi, y_L, y_R): sheave angle (positive lifts the left conveyance) and suspension heights.
The energies are written once and Lagrange's equation gives the motion,

    d/dt dK/dq' - dK/dq + dV/dq + dD/dq' = Q ,      lag * M' = M_command - M ,

    K = 1/2 m_s (R phi')^2 + sum_i [ 1/2 m_i v_i^2 + 1/6 mu l_i (w_i^2 + w_i v_i + v_i^2) ]
    V = sum_i [ 1/2 EA (s_i - l_i)^2 / l_i + 1/2 mu g l_i (y_i - y_s) + m_i g y_i ]
    D = sum_i c_i (w_i - v_i)^2 / 2 ,   c_i = 2 zeta sqrt(m_i EA / l_i)

with s_i = y_s - y_i the stretched and l_i the free length of the head ropes on side i (l_L = l_L0 - R phi,
l_R = l_R0 + R phi), and w_i = +-R phi' the rope's speed on the sheave: no slip, small strain. The ropes' velocity is
linear along them, so that a third of their mass moves with the conveyance. The ropes never slacken: a tension ratio
of infinity tells where real ones would. Losses act at the rim:
F_c tanh(R phi' / v_c) + d R phi'. The tension on the sheave is what a leg's own Lagrange row puts on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.loads import under_changing_load
from hoist_demo.parameters import GRAVITY, Hoist

Vector = NDArray[np.float64]

STATE_NAMES = ("torque", "phi", "y_left", "y_right", "phi_rate", "v_left", "v_right")
WORK_NAMES = ("motor", "losses", "ropes", "left", "right")
FORCES = (1, 2)
"""Places of the two vertical forces in a packed input."""
ACCELERATIONS = (STATE_NAMES.index("v_left"), STATE_NAMES.index("v_right"))
"""Places of the two vertical accelerations in the rates."""


@dataclass(frozen=True)
class PlantState:
    """State x = (M [N m], phi [rad], y_L, y_R [m], phi' [rad/s], v_L, v_R [m/s]), work and free lengths."""

    x: Vector  # shape (7,), in the order of STATE_NAMES
    work: Vector  # J, shape (5,): by the motor, into losses, into rope damping, by the balance rope's left, right end
    free_lengths: tuple[float, float]  # m, head ropes at phi = 0


@dataclass(frozen=True)
class PlantInput:
    """Held over one communication step."""

    torque_command: float  # N m
    force_left: float  # N, of the balance rope on the conveyance, negative is down
    force_right: float  # N


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
    torque: float  # N m
    tension_left: float  # N, all head ropes, at the sheave
    tension_right: float  # N
    energy_kinetic: float  # J
    energy_potential: float  # J

    @property
    def tension_ratio(self) -> float:
        """Larger tension over smaller one (Euler-Eytelwein), infinite when a side is slack [-]."""
        low, high = sorted((self.tension_left, self.tension_right))
        return high / low if low > 0.0 else math.inf


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
        model = _equations(hoist)
        self._outputs: Any = model["outputs"]
        self._rates: Any = model["rates"]
        self._hold: Any = model["hold"]
        self._dae: Any = model["dae"]
        self._under_path: Any = None
        self._options: dict[str, Any] = {
            "reltol": tolerance,
            "abstol": tolerance,
            "quad_err_con": True,
            "max_num_steps": 20000,
            "linear_multistep_method": "bdf",
            "show_eval_warnings": False,
            "disable_internal_warnings": True,
        }
        # time scaled to [0, 1], so that one integrator serves every step length
        self._integrator: Any = ca.integrator("drive", "cvodes", self._dae, 0.0, 1.0, self._options)

    def equilibrium(self, y_left: float, y_right: float, force_left: float, force_right: float) -> PlantState:
        """State at rest with the conveyances at the given heights [m] and the motor holding the imbalance."""
        hoist = self.hoist
        lengths = (
            self._free_length("y_left", y_left, hoist.mass_left, force_left),
            self._free_length("y_right", y_right, hoist.mass_right, force_right),
        )
        x = np.array([0.0, 0.0, y_left, y_right, 0.0, 0.0, 0.0])
        x[0] = float(self._hold(x, *lengths))
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
        work = state.work + np.asarray(result["qf"], dtype=np.float64).ravel()
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(work))):
            return PlantStep(False, "drive: state is not finite: check rope forces and torque command", state)
        new = PlantState(x=x, work=work, free_lengths=state.free_lengths)
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

    def acting(self, state: PlantState, path: PlantInputPath, s: float) -> PlantInput:
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
        """dx/dt, shape (7,)."""
        return np.asarray(self._rates(state.x, _pack(u), *state.free_lengths), dtype=np.float64).ravel()

    def outputs(self, state: PlantState, u: PlantInput) -> PlantOutput:
        """Measured quantities; accelerations and tensions belong to the held input u."""
        values = self._outputs(state.x, _pack(u), *state.free_lengths)
        return PlantOutput(*(float(value) for value in np.asarray(values).ravel()))

    def _along_path(self) -> Any:
        """The integrator for inputs that change within a step, made when the first is met."""
        if self._under_path is None:
            dae = under_changing_load(self._dae, len(fields(PlantInput)), FORCES, ACCELERATIONS)
            self._under_path = ca.integrator("drive_path", "cvodes", dae, 0.0, 1.0, self._options)
        return self._under_path

    def _free_length(self, name: str, y: float, mass: float, force: float) -> float:
        """Positive root of s = l (1 + (m g - F + mu g l / 2) / EA) [m]."""
        s = self.hoist.sheave_height - y
        if not s > 0.0:
            raise ValueError(f"{name} = {y!r} m must be below the sheave at {self.hoist.sheave_height:g} m: lower it")
        b = 1.0 + (mass * GRAVITY - force) / self.hoist.rope_stiffness
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


def _pack(u: PlantInput) -> list[float]:
    return [u.torque_command, u.force_left, u.force_right]


def _equations(hoist: Hoist) -> dict[str, Any]:
    """CasADi functions of the drive: DAE for the integrator, rates, outputs and holding torque."""
    R, EA, mu, g = hoist.sheave_radius, hoist.rope_stiffness, hoist.rope_mass, GRAVITY
    torque, command = ca.SX.sym("M"), ca.SX.sym("M_command")
    q, v, force = ca.SX.sym("q", 3), ca.SX.sym("v", 3), ca.SX.sym("F", 2)
    l0 = ca.SX.sym("l0", 2)
    H = ca.SX.sym("H")

    # energies of the two legs, and of what turns with the sheave
    kinetic, potential, damping = [], [], []
    for i, (sign, mass) in enumerate(((1.0, hoist.mass_left), (-1.0, hoist.mass_right))):
        y, vy, w = q[1 + i], v[1 + i], sign * R * v[0]
        length, s = l0[i] - sign * R * q[0], hoist.sheave_height - q[1 + i]
        c = 2.0 * hoist.head_rope_damping * ca.sqrt(mass * EA / length)
        kinetic.append(mass * vy**2 / 2 + mu * length * (w**2 + w * vy + vy**2) / 6)
        potential.append(EA * (s - length) ** 2 / (2 * length) - mu * g * length * s / 2 + mass * g * y)
        damping.append(c * (w - vy) ** 2 / 2)
    sheave = hoist.sheave_mass * (R * v[0]) ** 2 / 2
    K, V, D = sheave + sum(kinetic), sum(potential), sum(damping)
    rim = hoist.loss_coulomb * ca.tanh(R * v[0] / hoist.loss_speed) + hoist.loss_viscous * R * v[0]

    # Lagrange's equation: mass matrix times acceleration = everything else
    Q = ca.vertcat(torque - R * rim, force[0], force[1])
    momentum = ca.gradient(K, v)
    mass_matrix = ca.jacobian(momentum, v)
    carried = ca.jtimes(momentum, q, v)
    a = ca.solve(mass_matrix, Q - carried + ca.gradient(K, q) - ca.gradient(V, q) - ca.gradient(D, v))
    x = ca.vertcat(torque, q, v)
    rates = ca.vertcat((command - torque) / hoist.torque_lag, v, a)
    powers = ca.vertcat(torque * v[0], rim * R * v[0], 2 * D, force[0] * v[1], force[1] * v[2])

    # a leg's row of Lagrange's equation is its moment on the sheave
    tensions = []
    for sign, k, p, d in zip((1.0, -1.0), kinetic, potential, damping, strict=True):
        leg = ca.gradient(k, v[0])
        change = ca.jtimes(leg, q, v) + ca.jtimes(leg, v, a) - ca.gradient(k, q[0])
        tensions.append(sign * (change + ca.gradient(p, q[0]) + ca.gradient(d, v[0])) / R)

    u = ca.vertcat(command, force)
    shown = ca.vertcat(q[1], q[2], v[1], v[2], a[1], a[2], q[0], v[0], torque, *tensions, K, V)
    arguments = [x, u, l0[0], l0[1]]
    return {
        "dae": {"x": x, "p": ca.vertcat(H, u, l0), "ode": H * rates, "quad": H * powers},
        "rates": ca.Function("rates", arguments, [rates]),
        "outputs": ca.Function("outputs", arguments, [shown]),
        "hold": ca.Function("hold", [x, l0[0], l0[1]], [ca.gradient(V, q)[0]]),
    }
