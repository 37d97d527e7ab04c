"""Controller and brake: limits, wind-up, stopping distances in closed form, regulated stops, two stages, standstill."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drives import Plant, PlantInput, PlantOutput, dead_weights, rest_at, state_with
from scipy.optimize import brentq

from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import Braking, TrajectoryPoint, s_curve
from hoist_demo.parameters import GRAVITY, EmergencyLaw, Hoist, Winding
from hoist_demo.parameters.components import Brake

BALANCED = Hoist(
    payload_left=0.0, head_rope_mass=1e-6, tail_rope_mass=0.0, head_rope_stiffness=1e9, head_rope_damping=0.3,
    loss_coulomb=0.0, loss_viscous=0.0, brake=Brake(torque=7.0e4, delay=0.2, lag=0.1),
)  # fmt: skip
"""Stiff, without losses and imbalance: 28 t that the brake stops at 2 m/s^2."""


def _stop(hoist: Hoist, law: EmergencyLaw, speed: float, seconds: float) -> list[PlantOutput]:
    """Motion after a trip at mid-shaft, one output per 10 ms."""
    plant, h = Plant(hoist), 0.01
    state, u = rest_at(plant, (45.0, 45.0))
    controller = SpeedController(hoist, float(state.x[0]), Gains(speed=4.0 * hoist.moving_mass, integral_time=1.0))
    state = state_with(plant, state, phi_rate=speed / hoist.sheave_radius, v_left=speed, v_right=-speed, torque=0.0)
    memory, shown = ControllerState(), [plant.outputs(state, u)]
    for k in range(round(seconds / h)):
        point = TrajectoryPoint(0.0, 0.0, 0.0, 0.0, Braking(law, k * h, 1.5))
        measured = Measurement(shown[-1].y_left - 45.0, hoist.sheave_radius * shown[-1].rate)
        command = controller.command(point, measured, memory, h)
        forces = dead_weights(hoist, shown[-1].y_left, shown[-1].y_right, 0.0)
        held = PlantInput(command.torque, *forces, brake=command.brake)
        state, memory = plant.step(state, h, held).state, command.state
        shown.append(plant.outputs(state, held))
    return shown


@pytest.mark.parametrize("speed", [6.0, -6.0])
def test_constant_torque_stops_within_the_distance_of_the_closed_form(speed: float) -> None:
    shown = _stop(BALANCED, "torque", speed, 5.0)
    a, d, tau, v = 7.0e4 / 1.25 / 28e3, 0.2, 0.1, abs(speed)
    # v(t) = v - a (t - tau (1 - exp(-t / tau))) after the dead time d
    t = brentq(lambda t: v - a * (t - tau * (1.0 - math.exp(-t / tau))), 0.0, 10.0)
    distance = v * (d + t) - a * (t * t / 2.0 - tau * t + tau**2 * (1.0 - math.exp(-t / tau)))
    # the linings' deflection of 2 mm comes first, and the stop ends within it
    np.testing.assert_allclose(abs(shown[-1].y_left - 45.0), distance, rtol=0, atol=4e-3)


@pytest.mark.parametrize(("payload", "speed"), [(0.0, 6.0), (4.0e3, 6.0), (4.0e3, -6.0)])
def test_a_regulated_stop_keeps_its_deceleration_with_any_load(payload: float, speed: float) -> None:
    hoist = replace(BALANCED, payload_left=payload, brake=Brake(torque=2.0e5, delay=0.2, lag=0.05))
    shown = _stop(hoist, "deceleration", speed, 6.0)
    rim = np.abs([hoist.sheave_radius * s.rate for s in shown])
    # between 1.2 s and 3.2 s, the lag's transient over; k_v / m = 4 1/s
    np.testing.assert_allclose((rim[120] - rim[320]) / 2.0, 1.5, rtol=0.02)
    # v_b^2 / (2 a) from the speed at the bite, which the imbalance changes during the dead time
    bitten = rim[20] ** 2 / 3.0 + abs(shown[20].y_left - 45.0)
    np.testing.assert_allclose(abs(shown[-1].y_left - 45.0), bitten, rtol=0.03)


def test_two_stages_brake_with_a_part_of_the_torque_and_then_with_all_of_it() -> None:
    brake = Brake(torque=7.0e4, delay=0.2, lag=0.02, first_stage=0.4, first_stage_time=1.2)
    torque = np.array([s.brake_torque for s in _stop(replace(BALANCED, brake=brake), "two-stage", 6.0, 2.5)])
    np.testing.assert_allclose(torque[:20], 0.0, atol=1e-9)
    np.testing.assert_allclose(torque[60:120], 0.4 * 7.0e4, rtol=1e-3)
    np.testing.assert_allclose(torque[150:], 7.0e4, rtol=1e-3)


def test_the_brake_holds_the_imbalance_without_creeping() -> None:
    hoist = replace(BALANCED, payload_left=4.0e3, loss_viscous=200.0, brake=Brake(torque=2.0e5))
    shown = _stop(hoist, "torque", 2.0, 12.0)
    # the motor is off: the brake carries the payload
    np.testing.assert_allclose(shown[-1].brake_torque, -1.25 * 4.0e3 * GRAVITY, rtol=1e-3)
    assert abs(shown[-1].y_left - shown[-400].y_left) < 1e-5


def test_the_motor_is_off_while_the_brake_stops_the_hoist() -> None:
    winding = Winding(emergency_at=8.0, emergency_law="torque")
    reference, hoist = s_curve(winding), Hoist(brake=Brake())
    before, after = reference.at(7.99), reference.at(8.5)
    assert before.braking is None
    assert after.braking is not None
    np.testing.assert_allclose(after.braking.elapsed, 0.5, rtol=1e-12)
    command = SpeedController(hoist, 5e4).command(after, Measurement(20.0, 6.0), ControllerState(integral=1e4), 0.01)
    assert (command.torque, command.brake) == (0.0, 1.0)


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
