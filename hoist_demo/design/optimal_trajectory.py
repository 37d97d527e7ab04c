"""The fastest trip that leaves the ropes at rest: optimal control of the low-fidelity model by IPOPT.

    minimise   T + T_s int_hold (v_L^2 + v_R^2) / (2 v_s^2 t_hold) dt + smoothness of the jerk
    subject to |v| <= v_max, |a| <= a_max, |j| <= j_max of the reference, |force| <= limit,
               s(T) = travel, v(T) = a(T) = 0 and the reference at rest over the hold,

with the limits of the winding, over the trip's duration T and a jerk that is constant on each of N equal intervals, by
multiple shooting with the Runge-Kutta method of order 4. v_s is the swing speed that is worth T_s seconds. The solution
is again a chain of constant-jerk segments, which the host samples like any S-curve.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import Trajectory, chain, rest, s_curve
from hoist_demo.design.low_fidelity import STATES, V_LEFT, V_RIGHT, LowFidelityModel, low_fidelity
from hoist_demo.parameters import Hoist, Winding, start_heights
from hoist_demo.parameters.trip_design import TrajectoryOptions

_INSIDE = 0.9  # 1, share of the limits that the first guess uses
_SUBSTEP = 0.05  # s, at most a sixth of the period of the swings that matter
_IPOPT: dict[str, Any] = {
    "print_level": 0,
    "sb": "yes",
    "max_iter": 1000,
    "tol": 1e-5,
    "hessian_approximation": "limited-memory",
}
# s, price of a jerk that jumps by j_max at every interval's end, over all of them
_SMOOTHNESS = 1e-2
#: Units of the reference's variables: 10 m, 10 m/s, 1 m/s^2; all are then of the size of 1.
_SCALE = ca.DM([10.0, 10.0, 1.0])


class _Variables(NamedTuple):
    """Variables of the solver, of N intervals: the reference is a chain of integrators between nodes."""

    T: Any  # s, duration
    J: Any  # (1, N), jerks over the largest
    r: Any  # (3, N + 1), position, speed and acceleration of the reference over _SCALE

    @staticmethod
    def of(opti: Any, intervals: int) -> "_Variables":
        """Return the variables of a problem."""
        return _Variables(
            opti.variable(), opti.variable(1, intervals), opti.variable(3, intervals + 1)
        )

    @property
    def intervals(self) -> int:
        """Number N of intervals."""
        return int(self.J.shape[1])

    @property
    def reference(self) -> tuple[Any, Any, Any]:
        """Position [m], speed [m/s] and acceleration [m/s^2] of the reference at the nodes."""
        s, v, a = (_SCALE[i] * self.r[i, :] for i in range(3))
        return s, v, a


def optimise(
    hoist: Hoist,
    winding: Winding,
    gains: Gains,
    limits: TrajectoryOptions,
    start: float | None = None,
) -> Trajectory:
    """Return the optimised trip; a solver that does not converge is an error with its status.

    ``start`` is the height of the left conveyance before the trip [m]; None: at the landing.
    """
    require_no_creep(winding)
    left = start_heights(hoist, winding)[0] if start is None else start
    model = low_fidelity(hoist, gains, left, hoist.shaft_travel - left)
    N = limits.intervals
    guess = _first_guess(winding)
    N_hold = max(1, round(limits.hold * N / guess.duration))
    swing = _swing(model, N, N_hold, max(1, math.ceil(guess.duration / N / _SUBSTEP)))

    opti = ca.Opti()
    variables = _Variables.of(opti, N)
    _require_path(opti, variables, winding)
    _require_limits(opti, variables, hoist, winding, model)
    opti.subject_to(opti.bounded(0.7 * guess.duration, variables.T, 1.5 * guess.duration))
    price = limits.swing_price / (2.0 * limits.swing_speed**2)
    rough = ca.sumsqr(ca.diff(ca.horzcat(0, variables.J, 0), 1, 1)) / N
    swung = price * swing(variables.T, variables.J * winding.jerk)
    opti.minimize(variables.T + swung + _SMOOTHNESS * rough)
    _start_from(guess, opti, variables, winding)
    return _solve(opti, variables, winding)


def _first_guess(winding: Winding) -> Trajectory:
    """Return an S-curve that keeps off the limits, as an interior-point method likes it."""
    gentle = {name: _INSIDE * getattr(winding, name) for name in ("speed", "acceleration", "jerk")}
    return s_curve(replace(winding, start_delay=0.0, **gentle))


def _require_path(opti: Any, variables: _Variables, winding: Winding) -> None:
    """Require that the reference follows its jerks, from rest to rest over the travel."""
    s, v, a = variables.reference
    h = variables.T / variables.intervals
    j = winding.jerk * variables.J
    ends = (
        s[:-1] + h * (v[:-1] + h * (a[:-1] / 2 + h * j / 6)) - s[1:],
        v[:-1] + h * (a[:-1] + h * j / 2) - v[1:],
        a[:-1] + h * j - a[1:],
    )
    opti.subject_to(ca.vec(ca.vertcat(*(e / _SCALE[i] for i, e in enumerate(ends)))) == 0)
    opti.subject_to(variables.r[:, 0] == 0)
    arrived = ca.DM([winding.travel, 0.0, 0.0]) / _SCALE
    opti.subject_to(variables.r[:, variables.intervals] == arrived)


def _require_limits(
    opti: Any, variables: _Variables, hoist: Hoist, winding: Winding, model: LowFidelityModel
) -> None:
    """Bound the reference by the winding's limits, and what is fed forward by the motor's."""
    s, v, a = variables.reference
    N = variables.intervals
    opti.subject_to(opti.bounded(-1.0, ca.vec(variables.J), 1.0))
    opti.subject_to(opti.bounded(-1.0, ca.vec(v[1:N]) / winding.speed, 1.0))
    opti.subject_to(opti.bounded(-1.0, ca.vec(a[1:N]) / winding.acceleration, 1.0))
    limit = hoist.torque_limit / hoist.sheave_radius
    force = ca.vec(model.feed_forward(s[1:N], v[1:N], a[1:N]))
    opti.subject_to(opti.bounded(-1.0, force / limit, 1.0))


def _start_from(guess: Trajectory, opti: Any, variables: _Variables, winding: Winding) -> None:
    """Let the solver begin with the motion of a trajectory."""
    times = np.linspace(0.0, guess.duration, variables.intervals + 1)
    sampled = guess.sample(times)
    jerks = np.diff(sampled[:, 2]) / np.diff(times)  # means of the intervals
    opti.set_initial(variables.T, guess.duration)
    opti.set_initial(variables.J, jerks / winding.jerk)
    opti.set_initial(variables.r, (sampled[:, :3] / np.array(_SCALE).ravel()).T)


def _solve(opti: Any, variables: _Variables, winding: Winding) -> Trajectory:
    """Return the trip of the solution; RuntimeError with IPOPT's status where there is none."""
    opti.solver("ipopt", {"print_time": False}, _IPOPT)
    try:
        solution = opti.solve()
    except RuntimeError as error:
        status = opti.debug.return_status()
        raise RuntimeError(
            f"trajectory optimisation: IPOPT ended with {status}: change trajectory.intervals or "
            "relax the limits"
        ) from error
    duration = float(solution.value(variables.T))
    jerks = winding.jerk * np.asarray(solution.value(variables.J), dtype=np.float64).ravel()
    N = variables.intervals
    return chain(
        winding.start_delay, rest(0.0), jerks.tolist(), [duration / N] * N, end=winding.travel
    )


def require_no_creep(winding: Winding) -> None:
    """Reject creep: the optimiser chooses the speed along the whole trip."""
    for name in ("departure_creep_distance", "creep_distance"):
        if getattr(winding, name) > 0.0:
            raise ValueError(
                f"{name} = {getattr(winding, name):g} m must be 0 with controller = 'optimised-trajectory', which "
                "chooses the speed itself: leave the creep out, or take another controller"
            )


def _swing(model: LowFidelityModel, N: int, N_hold: int, substeps: int) -> Any:
    """(T, jerks) -> mean over the hold of the squared conveyance speeds [m^2/s^2], from one simulation."""
    x = ca.SX.sym("x", len(STATES))
    j = ca.SX.sym("j")
    h = ca.SX.sym("h")
    z = x
    squares = ca.SX(0)
    dt = h / substeps
    for _ in range(substeps):
        k1 = model.rates(z, j)
        k2 = model.rates(z + dt / 2 * k1, j)
        k3 = model.rates(z + dt / 2 * k2, j)
        k4 = model.rates(z + dt * k3, j)
        z = z + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        squares += (z[V_LEFT] ** 2 + z[V_RIGHT] ** 2) / substeps
    step = ca.Function("step", [x, j, h], [z, squares])
    T = ca.MX.sym("T")
    jerks = ca.MX.sym("jerks", 1, N)
    no_jerk = ca.DM.zeros(1, N_hold)
    _, squared_speeds = step.mapaccum(N + N_hold)(
        model.start, ca.horzcat(jerks, no_jerk), ca.repmat(T / N, 1, N + N_hold)
    )
    return ca.Function("swing", [T, jerks], [ca.sum2(squared_speeds[N:]) / N_hold])
