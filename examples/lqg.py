"""A linear-quadratic-Gaussian controller from the linear model of a hoist, against PI with feed-forward.

Both wind payloads, head ropes and swivels that the design does not know. The feed-forward inverts the model: the
left conveyance follows the trip. Gains and observer are those at the arrival.

python examples/lqg.py "as designed"    # or other cases; all of them without
"""

import sys
from typing import Any

import numpy as np
from scipy.linalg import expm, solve, solve_continuous_are

from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import Command, Measurement
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduction import reduced
from hoist_demo.parameters import Hoist
from hoist_demo.study.metrics import measure
from hoist_demo.study.run import RunData, build

DESIGN = build("rope-120", {"winding.jerk": 5.0})
SHOWN = ("swing_left", "tracking_error", "cycle_time", "torque_peak", "slip_safety")
OUTPUTS = ("angle", "rate", "v_left", "v_right", "y_left")
MASS, R = DESIGN.hoist.moving_mass, DESIGN.hoist.sheave_radius


class Lqg:
    """Torque by a state estimate of the error and of a constant torque that the model does not have."""

    def __init__(self, hoist: Hoist, holding: float) -> None:
        self.hoist, self.holding = hoist, holding
        self.A, self.B, C = A, B, C = MODEL.A[-1], MODEL.B[-1], MODEL.C[-1]
        n = len(A)
        # state and torque along a trip by its derivatives: sum of x_k p^(k), u_k p^(k), where the left height is p
        x, self.along = np.zeros(n), []
        for k in range(4):
            found = solve(
                np.block([[A, B], [C[4:], np.zeros((1, 1))]]), np.append(x, float(k == 0))
            )
            x = found[:n]
            self.along.append(found)
        seen = np.vstack((C[4], R * C[1]))
        self.seen = [seen @ found[:n] for found in self.along]
        # weights: 50 mm, 0.1 m/s of either conveyance, a tenth of the acceleration's torque; noise of 1 mm and 5 mm/s
        scale = [0.1 * MASS * R * DESIGN.winding.acceleration]
        cost = C[4:].T @ C[4:] / 50e-3**2 + C[2:4].T @ C[2:4] / 0.1**2
        self.K = scale[0] ** 2 * B.T @ solve_continuous_are(A, B, cost, np.diag(scale) ** -2.0)
        self.Ae = np.block([[A, B], [np.zeros((1, n + 1))]])
        self.Ce = np.hstack((seen, np.zeros((2, 1))))
        noise, drive = np.diag([1e-3, 5e-3]) ** 2, np.append(B * scale, 0.0)
        grown = np.outer(drive, drive) + np.diag(np.append(np.zeros(n), scale[0] ** 2))
        self.L = (
            solve_continuous_are(self.Ae.T, self.Ce.T, grown, noise)
            @ self.Ce.T
            @ np.linalg.inv(noise)
        )

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        """Torque of the step that begins now; the state is the estimate and the last torque of the feedback."""
        z = np.zeros(len(self.Ae) + 1) if state is None else np.array(state)
        p, n, hoist = [0.0, *reference[1:4]], len(self.A), self.hoist
        expected = sum(s * x for s, x in zip(self.seen, p, strict=True))
        error = [measured.travel - reference.position, measured.speed] - expected
        step = expm(h * (self.Ae - self.L @ self.Ce))
        pushed = np.append(self.B[:, 0] * z[-1], 0.0) + self.L @ error
        z[:-1] = step @ z[:-1] + solve(self.Ae - self.L @ self.Ce, (step - np.eye(n + 1)) @ pushed)
        feedback = float(-(self.K @ z[:n])[0] - z[n])
        coulomb = hoist.travel_loss[0] * np.tanh(reference.speed / hoist.loss_speed)
        ahead = self.holding + R * (hoist.imbalance_rate * reference.position + coulomb)
        torque = (
            ahead + sum(found[-1] * x for found, x in zip(self.along, p, strict=True)) + feedback
        )
        limit = hoist.torque_available(measured.speed / R)
        z[-1] = feedback + min(max(torque, -limit), limit) - torque
        return Command(
            float(min(max(torque, -limit), limit)), bool(abs(torque) > limit), z.tolist()
        )


def wound(run: RunData, controller: Any) -> dict[str, float]:
    """Metrics of a trip; the controller has the data of the design."""
    made = None if controller is None else lambda hoist, holding: controller(DESIGN.hoist, holding)
    rope = InProcessRope(rope_scene(run.rope_values))
    result = Host(rope, run.hoist, run.winding, run.coupling, run.gains, made).run()
    return measure(result, run.hoist, run.arrival).metrics


(LINEAR,) = linearise(find_case("rope-120"), [1.0])
MODEL = reduced([LINEAR.selected(("torque_command",), OUTPUTS)], 7)
CASES: dict[str, dict[str, Any]] = {
    "as designed": {},
    "no payload": {"hoist.payload_left": 0.0},
    "head ropes 20 % softer": {"hoist.head_rope_stiffness": 20.8e6},
    "swivels free": {"left.swivel.mode": 1, "right.swivel.mode": 1},
}
print(f"{'':>24}{'':>6}" + "".join(f"{name:>16}" for name in SHOWN))
for name, values in {name: CASES[name] for name in sys.argv[1:] or CASES}.items():
    for law, controller in (("PI", None), ("LQG", Lqg)):
        found = wound(build("rope-120", {"winding.jerk": 5.0, **values}), controller)
        print(f"{name:>24}{law:>6}" + "".join(f"{found[key]:16.4g}" for key in SHOWN), flush=True)
