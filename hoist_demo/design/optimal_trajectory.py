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
from typing import Any

import casadi as ca
import numpy as np

from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import Trajectory, chain, rest, s_curve
from hoist_demo.design.low_fidelity import STATES, LowFidelityModel, low_fidelity
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


def optimise(
    hoist: Hoist,
    winding: Winding,
    gains: Gains,
    limits: TrajectoryOptions,
    start: float | None = None,
) -> Trajectory:
    """Return the optimised trip; a solver that does not converge is an error with its status.

    `start` is the height of the left conveyance before the trip [m]; None: at the landing.
    """
    require_no_creep(winding)
    left = start_heights(hoist, winding)[0] if start is None else start
    model = low_fidelity(hoist, gains, left, hoist.shaft_travel - left)
    N = limits.intervals
    # start from an S-curve that keeps off the limits, as an interior-point method likes it
    gentle = {name: _INSIDE * getattr(winding, name) for name in ("speed", "acceleration", "jerk")}
    first_guess = s_curve(replace(winding, start_delay=0.0, **gentle))
    times = np.linspace(0.0, first_guess.duration, N + 1)
    jerks = np.diff(first_guess.sample(times)[:, 2]) / np.diff(times)  # means of the intervals
    N_hold = max(1, round(limits.hold * N / first_guess.duration))
    swing = _swing(model, N, N_hold, max(1, math.ceil(first_guess.duration / N / _SUBSTEP)))

    # the reference is a chain of integrators between nodes; the hoist follows it from the start to the hold's end
    opti = ca.Opti()
    T = opti.variable()
    J = opti.variable(1, N)
    r = opti.variable(3, N + 1)  # s [10 m], v [10 m/s], a [m/s^2]
    scale = ca.DM([10.0, 10.0, 1.0])
    h = T / N
    j = winding.jerk * J
    s, v, a = (scale[i] * r[i, :] for i in range(3))
    ends = (
        s[:-1] + h * (v[:-1] + h * (a[:-1] / 2 + h * j / 6)) - s[1:],
        v[:-1] + h * (a[:-1] + h * j / 2) - v[1:],
        a[:-1] + h * j - a[1:],
    )
    opti.subject_to(ca.vec(ca.vertcat(*(e / scale[i] for i, e in enumerate(ends)))) == 0)
    opti.subject_to(r[:, 0] == 0)
    opti.subject_to(r[:, N] == ca.DM([winding.travel, 0.0, 0.0]) / scale)

    # limits of the reference, and of the motor by what is fed forward
    opti.subject_to(opti.bounded(-1.0, ca.vec(J), 1.0))
    opti.subject_to(opti.bounded(-1.0, ca.vec(v[1:N]) / winding.speed, 1.0))
    opti.subject_to(opti.bounded(-1.0, ca.vec(a[1:N]) / winding.acceleration, 1.0))
    limit = hoist.torque_limit / hoist.sheave_radius
    opti.subject_to(
        opti.bounded(-1.0, ca.vec(model.feed_forward(s[1:N], v[1:N], a[1:N])) / limit, 1.0)
    )
    opti.subject_to(opti.bounded(0.7 * first_guess.duration, T, 1.5 * first_guess.duration))

    price = limits.swing_price / (2.0 * limits.swing_speed**2)
    rough = ca.sumsqr(ca.diff(ca.horzcat(0, J, 0), 1, 1)) / N
    opti.minimize(T + price * swing(T, J * winding.jerk) + _SMOOTHNESS * rough)

    opti.set_initial(T, first_guess.duration)
    opti.set_initial(J, jerks / winding.jerk)
    opti.set_initial(r, (first_guess.sample(times)[:, :3] / np.array([10.0, 10.0, 1.0])).T)
    opti.solver("ipopt", {"print_time": False}, _IPOPT)
    try:
        solution = opti.solve()
    except RuntimeError as error:
        status = opti.debug.return_status()
        raise RuntimeError(
            f"trajectory optimisation: IPOPT ended with {status}: change trajectory.intervals or relax the limits"
        ) from error
    duration = float(solution.value(T))
    optimal_jerks = winding.jerk * np.asarray(solution.value(J), dtype=np.float64).ravel()
    return chain(
        winding.start_delay,
        rest(0.0),
        optimal_jerks.tolist(),
        [duration / N] * N,
        end=winding.travel,
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
    x = ca.SX.sym("x", STATES)
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
        squares += (z[7] ** 2 + z[8] ** 2) / substeps
    step = ca.Function("step", [x, j, h], [z, squares])
    T = ca.MX.sym("T")
    jerks = ca.MX.sym("jerks", 1, N)
    no_jerk = ca.DM.zeros(1, N_hold)
    _, squared_speeds = step.mapaccum(N + N_hold)(
        model.start, ca.horzcat(jerks, no_jerk), ca.repmat(T / N, 1, N + N_hold)
    )
    return ca.Function("swing", [T, jerks], [ca.sum2(squared_speeds[N:]) / N_hold])
