"""The fastest trip that leaves no more swing than asked for, by linear programs on the reduced model at the landing.

    minimise   w + price of jerk
    subject to |v| <= v_max, |a| <= a_max, |j| <= j_max, s(T) = travel, v(T) = a(T) = 0 of the reference,
               |swing of either conveyance less its place at rest| <= w over the hold after arrival,

for a jerk that is constant on each of N equal intervals; the shortest T with w below the swing asked for is found by
halving. The model is hoist, rope and speed loop at the landing. Trips are judged in the nonlinear co-simulation.
"""

from dataclasses import replace
from functools import cache

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
from hoist_demo.study.metrics import measure
from hoist_demo.study.run import build

Array = NDArray[np.float64]
N, HOLD, JERK = 220, 30, 5.0  # intervals of the trip and of the hold; m/s^3
SWING = 1.5e-3  # m, peak to peak, of the optimal trip
PRICE = 1e-5  # s^2, of the change of acceleration
RUN = build("rope-120", {"winding.jerk": JERK})
HOIST, WINDING, GAINS, R = RUN.hoist, RUN.winding, RUN.gains, RUN.hoist.sheave_radius


@cache
def closed_loop() -> tuple[Array, Array]:
    """Rates and swings (left, right) by states of the model, integral, s, v, a; of the rates also by the jerk."""
    (model,) = linearise(find_case("rope-120"), [1.0])
    small = reduced(
        [model.selected(("torque_command",), ("rate", "y_left", "angle", "y_right"))], 9
    )
    A, B, C, n = small.A[0], small.B[0], small.C[0], len(small.A[0])
    whole, (integral, s, v, a, jerk) = np.zeros((n + 5, n + 5)), np.eye(n + 5)[n:]
    error = v + GAINS.position * s - np.append(GAINS.position * C[1] + R * C[0], np.zeros(5))
    command = R * (HOIST.moving_mass * a + GAINS.speed * error + integral)
    whole[:n, :n] = A
    whole[:n] += B * command
    whole[n] = GAINS.speed / GAINS.integral_time * error
    whole[n + 1 : n + 4] = v, a, jerk
    swings = np.vstack((C[1] - R * C[2], C[3] + R * C[2]))
    return whole, np.hstack((swings, np.zeros((2, 4))))


def planned(T: float) -> tuple[float, Array]:
    """Least swing [m] that a trip of this duration leaves, and its jerks."""
    (whole, C), h = closed_loop(), T / N
    step, g = expm(h * whole), []
    x = step[:-1, -1]
    for _ in range(N + HOLD):
        g.append(np.append(C @ x, x[-3:]))  # of a jerk that many intervals ago: swings, s, v, a
        x = step[:-1, :-1] @ x
    ago = np.subtract.outer(np.arange(1, N + HOLD + 1), np.arange(N)) - 1
    effect = np.where(
        (ago >= 0)[..., None], np.array(g)[np.maximum(ago, 0)], 0.0
    )  # (instants, jerks, quantities)
    swing, end = np.concatenate((effect[N:, :, 0], effect[N:, :, 1])), effect[N - 1, :, 2:].T
    place, one = np.kron(np.eye(2), np.ones((HOLD, 1))), np.ones((2 * HOLD, 1))
    # unknowns: jerks up, jerks down, places at rest, w
    rows = [np.hstack((sign * swing, -sign * swing, -sign * place, -one)) for sign in (1, -1)]
    bounds = [np.zeros(4 * HOLD)]
    for k, most in ((3, WINDING.speed), (4, WINDING.acceleration)):
        rows += [
            np.hstack((sign * effect[:N, :, k], -sign * effect[:N, :, k], np.zeros((N, 3))))
            for sign in (1, -1)
        ]
        bounds.append(np.full(2 * N, most))
    cost = np.concatenate((np.full(2 * N, PRICE * h), [0.0, 0.0, 1.0]))
    found = linprog(
        cost,
        np.vstack(rows),
        np.concatenate(bounds),
        np.hstack((end, -end, np.zeros((3, 3)))),
        [WINDING.travel, 0.0, 0.0],
        [(0.0, JERK)] * (2 * N) + [(None, None)] * 2 + [(0.0, None)],
    )
    return (
        (found.x[-1], found.x[:N] - found.x[N : 2 * N]) if found.success else (np.inf, np.zeros(N))
    )


def fastest() -> Trajectory:
    """The shortest trip that leaves no more than SWING."""
    high = 2.0 + (low := WINDING.travel / WINDING.speed + WINDING.speed / WINDING.acceleration)
    while high - low > 0.01:
        T = (low + high) / 2
        low, high = (low, T) if planned(T)[0] <= SWING / 2 else (T, high)
    return chain(
        WINDING.start_delay,
        rest(0.0),
        planned(high)[1].tolist(),
        [high / N] * N,
        end=WINDING.travel,
    )


def wound(trip: Trajectory) -> dict[str, float]:
    """Metrics of a trip in the co-simulation."""
    rope = InProcessRope(rope_scene(RUN.rope_values))
    result = Host(rope, HOIST, WINDING, RUN.coupling, GAINS, trajectory=trip).run()
    return measure(result, HOIST, RUN.arrival).metrics


SHOWN = ("trajectory_time", "cycle_time", "swing_left", "swing_right", "torque_peak", "slip_safety")
print(f"{'trip':>20}" + "".join(f"{name:>17}" for name in SHOWN))
plain = {
    f"S-curve, {jerk:g} m/s^3": s_curve(replace(WINDING, jerk=jerk))
    for jerk in (1.0, 1.25, 1.5, JERK)
}
for name, trip in (plain | {"optimal": fastest()}).items():
    found = wound(trip)
    print(f"{name:>20}" + "".join(f"{found[key]:17.4g}" for key in SHOWN), flush=True)
