"""The fastest trip within a swing, by linear programs on the reduced model at the landing.

    minimise   w + price of jerk
    subject to |v| <= v_max, |a| <= a_max, |j| <= j_max,
               s(T) = travel, v(T) = a(T) = 0 of the reference,
               |swing of either conveyance less its place at rest| <= w over the hold after arrival,

for a jerk that is constant on each of N equal intervals; the shortest T with w below the largest
swing is found by halving. The model is hoist, rope and speed loop at the landing. Trips are judged
in the nonlinear co-simulation.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import linprog

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import Trajectory, chain, rest, s_curve
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduction import reduced
from hoist_demo.run.data import build
from hoist_demo.run.metrics import measure

Array = NDArray[np.float64]
N = 220  # intervals of the trip
HOLD = 30  # intervals of the hold
JERK = 5.0  # m/s^3
SWING = 1.5e-3  # m, peak to peak, of the optimal trip
PRICE = 1e-5  # s^2, of the change of acceleration
RUN = build("rope-120", {"winding.jerk": JERK})
HOIST = RUN.hoist
WINDING = RUN.winding
GAINS = RUN.gains
R = HOIST.sheave_radius
DURATION_ERROR = 0.01  # s, of the shortest trip


@cache
def closed_loop() -> tuple[Array, Array]:
    """Matrices of the rates and of the swings (left, right).

    They multiply the states of the model, the integral, s, v, a; that of the rates also the jerk.
    """
    (model,) = linearise(find_case("rope-120"), [1.0])
    outputs = ("rate", "y_left", "angle", "y_right")
    small = reduced([model.selected(("torque_command",), outputs)], 9)
    A = small.A[0]
    B = small.B[0]
    C = small.C[0]
    n = len(A)
    whole = np.zeros((n + 5, n + 5))
    integral, s, v, a, jerk = np.eye(n + 5)[n:]
    error = v + GAINS.position * s - np.append(GAINS.position * C[1] + R * C[0], np.zeros(5))
    command = R * (HOIST.moving_mass * a + GAINS.speed * error + integral)
    whole[:n, :n] = A
    whole[:n] += B * command
    whole[n] = GAINS.speed / GAINS.integral_time * error
    whole[n + 1 : n + 4] = v, a, jerk
    swings = np.vstack((C[1] - R * C[2], C[3] + R * C[2]))
    return whole, np.hstack((swings, np.zeros((2, 4))))


class Plan(NamedTuple):
    """Trip of least swing for a duration."""

    swing: float  # m, either way; infinite where there is no such trip
    jerks: Array  # m/s^3, (N,)


def plan_trip(T: float) -> Plan:
    """The trip of this duration [s] that leaves the least swing."""
    rates, C = closed_loop()
    h = T / N
    step = expm(h * rates)
    g = []
    x = step[:-1, -1]
    for _ in range(N + HOLD):
        g.append(np.append(C @ x, x[-3:]))  # of a jerk that many intervals ago: swings, s, v, a
        x = step[:-1, :-1] @ x
    ago = np.subtract.outer(np.arange(1, N + HOLD + 1), np.arange(N)) - 1
    # (instants, jerks, quantities)
    effect = np.where((ago >= 0)[..., None], np.array(g)[np.maximum(ago, 0)], 0.0)
    swing = np.concatenate((effect[N:, :, 0], effect[N:, :, 1]))
    end = effect[N - 1, :, 2:].T
    place = np.kron(np.eye(2), np.ones((HOLD, 1)))
    one = np.ones((2 * HOLD, 1))
    # unknowns: jerks up, jerks down, places at rest, w
    rows = [np.hstack((sign * swing, -sign * swing, -sign * place, -one)) for sign in (1, -1)]
    bounds = [np.zeros(4 * HOLD)]
    for k, limit in ((3, WINDING.speed), (4, WINDING.acceleration)):
        rows += [
            np.hstack((sign * effect[:N, :, k], -sign * effect[:N, :, k], np.zeros((N, 3))))
            for sign in (1, -1)
        ]
        bounds.append(np.full(2 * N, limit))
    found = linprog(
        c=np.concatenate((np.full(2 * N, PRICE * h), [0.0, 0.0, 1.0])),
        A_ub=np.vstack(rows),
        b_ub=np.concatenate(bounds),
        A_eq=np.hstack((end, -end, np.zeros((3, 3)))),
        b_eq=[WINDING.travel, 0.0, 0.0],
        bounds=[(0.0, JERK)] * (2 * N) + [(None, None)] * 2 + [(0.0, None)],
    )
    if not found.success:
        return Plan(np.inf, np.zeros(N))
    return Plan(found.x[-1], found.x[:N] - found.x[N : 2 * N])


def fastest() -> Trajectory:
    """The shortest trip that leaves no more than SWING."""
    low = WINDING.travel / WINDING.speed + WINDING.speed / WINDING.acceleration
    high = 2.0 + low
    while high - low > DURATION_ERROR:
        T = (low + high) / 2
        if plan_trip(T).swing <= SWING / 2:
            high = T
        else:
            low = T
    jerks = plan_trip(high).jerks.tolist()
    return chain(WINDING.start_delay, rest(0.0), jerks, [high / N] * N, end=WINDING.travel)


def metrics_of(trip: Trajectory) -> dict[str, float]:
    """Metrics of a trip in the co-simulation."""
    rope = InProcessRope(rope_scene(RUN.rope_values))
    result = Host(rope, HOIST, WINDING, RUN.coupling, GAINS, trajectory=trip).run()
    return measure(result, HOIST, RUN.arrival).metrics


SHOWN = ("trajectory_time", "cycle_time", "swing_left", "swing_right", "torque_peak", "slip_safety")
print(f"{'trip':>20}" + "".join(f"{name:>17}" for name in SHOWN))
trips = {
    f"S-curve, {jerk:g} m/s^3": s_curve(replace(WINDING, jerk=jerk))
    for jerk in (1.0, 1.25, 1.5, JERK)
}
trips["optimal"] = fastest()
for name, trip in trips.items():
    found = metrics_of(trip)
    print(f"{name:>20}" + "".join(f"{found[key]:17.4g}" for key in SHOWN), flush=True)
