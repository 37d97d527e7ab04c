"""The controller respects its limits and does not wind up."""

import numpy as np
import pytest

from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.parameters import Hoist

HOIST = Hoist()
REST = TrajectoryPoint(0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("acceleration", "speed", "torque", "integral"),
    [
        pytest.param(0.0, 0.0, 5e4, 0.0, id="at rest: the holding torque"),
        pytest.param(0.75, 0.0, 5e4 + HOIST.sheave_radius * HOIST.moving_mass * 0.75, 0.0, id="fed forward"),
        pytest.param(0.0, -0.1, 5e4 + HOIST.sheave_radius * 1e3, 5.0, id="k_v e; h k_v e / T_i from then on"),
    ],
)
def test_the_command_is_that_of_the_law(acceleration: float, speed: float, torque: float, integral: float) -> None:
    asked, controller = TrajectoryPoint(0.0, 0.0, acceleration, 0.0), SpeedController(HOIST, 5e4, Gains(1e4, 2.0))
    command = controller.command(asked, Measurement(0.0, speed), ControllerState(), 0.01)
    np.testing.assert_allclose([command.torque, command.state.integral], [torque, integral], rtol=1e-14)
    assert not command.limited


def test_torque_never_exceeds_the_limit_and_the_integral_stands_still_there() -> None:
    controller = SpeedController(HOIST, 0.0)
    for sign in (1.0, -1.0):
        state = ControllerState()
        for _ in range(1000):
            command = controller.command(REST, Measurement(0.0, -sign * 50.0), state, 0.01)
            assert command.torque == sign * HOIST.torque_limit
            state = command.state
        assert state == ControllerState()


def test_the_integral_may_leave_the_limit() -> None:
    # at the limit because of the integral, with an error that reduces it
    controller = SpeedController(HOIST, 0.0)
    wound = ControllerState(integral=1e7)
    command = controller.command(REST, Measurement(0.0, 1.0), wound, 0.01)
    assert command.limited
    assert command.state.integral < wound.integral


def test_after_a_blocked_start_the_speed_overshoots_no_more_than_without_integral() -> None:
    # a mass whose brake stays on for 5 s while the controller pushes against its limit, then is free
    def overshoot(integral_time: float) -> float:
        controller = SpeedController(HOIST, 0.0, Gains(speed=1.5e5, integral_time=integral_time))
        asked, v, state, peak = TrajectoryPoint(0.0, 3.0, 0.0, 0.0), 0.0, ControllerState(), 0.0
        for k in range(3000):
            command = controller.command(asked, Measurement(0.0, v), state, 0.01)
            state = command.state
            if k >= 500:
                losses = HOIST.loss_coulomb * np.tanh(v / HOIST.loss_speed) + HOIST.loss_viscous * v
                v += 0.01 * (command.torque / HOIST.sheave_radius - losses) / HOIST.moving_mass
            peak = max(peak, v - 3.0)
        return peak

    # with the integral frozen at the limit only the time spent below it counts: v_err k_v / T_i over the decay m / k_v
    limit_speed = HOIST.torque_limit / HOIST.sheave_radius / 1.5e5
    assert overshoot(1e9) < 1e-3
    assert overshoot(1.0) < 0.35 * limit_speed
