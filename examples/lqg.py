"""A linear-quadratic-Gaussian controller from a linear model, against PI with feed-forward.

Both wind payloads, head ropes and swivels other than those of the design. The feed-forward inverts
the model: the left conveyance follows the trip. Gains and observer are those at the arrival.

python examples/lqg.py "as designed"    # or other cases; all of them without
"""

import sys
from typing import Any

import numpy as np
from scipy.linalg import expm, solve, solve_continuous_are

from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import Command, ControllerFactory, Measurement
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduction import reduced
from hoist_demo.parameters import Hoist
from hoist_demo.run.data import RunData, build
from hoist_demo.run.metrics import measure

DESIGN = build("rope-120", {"winding.jerk": 5.0})
SHOWN = ("swing_left", "tracking_error", "cycle_time", "torque_peak", "slip_safety")
OUTPUTS = ("angle", "rate", "v_left", "v_right", "y_left")
MASS = DESIGN.hoist.moving_mass
R = DESIGN.hoist.sheave_radius
SWING = 50e-3  # m, weight of the left conveyance's height
SPEED = 0.1  # m/s, weight of either conveyance's speed
TORQUE = 0.1 * MASS * R * DESIGN.winding.acceleration  # N m, weight of the torque, and its noise
NOISE = np.diag([1e-3, 5e-3]) ** 2  # variances of travel (m) and speed (m/s)


class Lqg:
    """Torque by an estimate of the state's error and of a constant torque beside the model."""

    def __init__(self, hoist: Hoist, holding: float) -> None:
        self.hoist = hoist
        self.holding = holding
        A = MODEL.A[-1]
        B = MODEL.B[-1]
        C = MODEL.C[-1]
        self.A = A
        self.B = B
        n = len(A)
        # state and torque along a trip by its derivatives: sum of x_k p^(k), u_k p^(k), where the
        # left height is p
        x = np.zeros(n)
        self.along = []
        inverse = np.block([[A, B], [C[4:], np.zeros((1, 1))]])
        for k in range(4):
            found = solve(inverse, np.append(x, float(k == 0)))
            x = found[:n]
            self.along.append(found)
        seen = np.vstack((C[4], R * C[1]))
        self.seen = [seen @ found[:n] for found in self.along]
        scale = [TORQUE]
        cost = C[4:].T @ C[4:] / SWING**2 + C[2:4].T @ C[2:4] / SPEED**2
        self.K = scale[0] ** 2 * B.T @ solve_continuous_are(A, B, cost, np.diag(scale) ** -2.0)
        # observer of the state and of a constant torque
        self.Ae = np.block([[A, B], [np.zeros((1, n + 1))]])
        self.Ce = np.hstack((seen, np.zeros((2, 1))))
        drive = np.append(B * scale, 0.0)
        drive_noise = np.outer(drive, drive) + np.diag(np.append(np.zeros(n), scale[0] ** 2))
        covariance = solve_continuous_are(self.Ae.T, self.Ce.T, drive_noise, NOISE)
        self.L = covariance @ self.Ce.T @ np.linalg.inv(NOISE)

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        """Torque of the step that begins now.

        The state is the estimate and the last torque of the feedback.
        """
        z = np.zeros(len(self.Ae) + 1)
        if state is not None:
            z = np.array(state)
        p = [0.0, reference.speed, reference.acceleration, reference.jerk]
        n = len(self.A)
        hoist = self.hoist
        expected = sum(s * x for s, x in zip(self.seen, p, strict=True))
        error = [measured.travel - reference.position, measured.speed] - expected
        step = expm(h * (self.Ae - self.L @ self.Ce))
        pushed = np.append(self.B[:, 0] * z[-1], 0.0) + self.L @ error
        z[:-1] = step @ z[:-1] + solve(self.Ae - self.L @ self.Ce, (step - np.eye(n + 1)) @ pushed)
        feedback = float(-(self.K @ z[:n])[0] - z[n])
        coulomb = hoist.travel_loss[0] * np.tanh(reference.speed / hoist.loss_speed)
        ahead = self.holding + R * (hoist.imbalance_rate * reference.position + coulomb)
        model_torque = sum(found[-1] * x for found, x in zip(self.along, p, strict=True))
        torque = ahead + model_torque + feedback
        limit = hoist.torque_available(measured.speed / R)
        limited = min(max(torque, -limit), limit)
        z[-1] = feedback + limited - torque
        return Command(float(limited), limited=bool(abs(torque) > limit), state=z.tolist())


def metrics_of(run: RunData, controller: ControllerFactory | None) -> dict[str, float]:
    """Metrics of a trip."""
    rope = InProcessRope(rope_scene(run.rope_values))
    result = Host(rope, run.hoist, run.winding, run.coupling, run.gains, controller).run()
    return measure(result, run.hoist, run.arrival).metrics


def lqg_of_the_design(hoist: Hoist, holding: float) -> Lqg:
    """The controller, which has the data of the design whatever the hoist."""
    return Lqg(DESIGN.hoist, holding)


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
    for law, controller in (("PI", None), ("LQG", lqg_of_the_design)):
        found = metrics_of(build("rope-120", {"winding.jerk": 5.0, **values}), controller)
        print(f"{name:>24}{law:>6}" + "".join(f"{found[key]:16.4g}" for key in SHOWN), flush=True)
