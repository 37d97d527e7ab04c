"""The drive conserves energy and rests; its integrator, controller and brake agree with others and closed forms."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from drives import Plant, PlantInput, PlantInputPath, PlantOutput, dead_weights, rest_at, state_with
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import Braking, TrajectoryPoint, s_curve
from hoist_demo.drive.equations import equations
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, EmergencyLaw, Hoist, Winding
from hoist_demo.parameters.components import Brake, DriveShaft, Guides, Play

TAIL = 8.0 * GRAVITY
RELAXED = (-TAIL * 15.0, -TAIL * 105.0)


@pytest.fixture(scope="module")
def plant() -> Plant:
    return Plant(Hoist())


def test_the_tensions_shown_are_those_that_turn_the_sheave(plant: Plant) -> None:
    rest = plant.equilibrium(40.0, 50.0, -TAIL * 55.0, -TAIL * 65.0)
    u = PlantInput(9e4, -4e3, -5e3)
    # mid-shaft, moving at 5 m/s, with the ropes slightly out of balance
    state = rest._replace(x=rest.x + np.array([2e4, 0.0, 0.01, -0.02, 5.0 / 1.25, 5.1, -4.9]))
    shown = plant.outputs(state, u)
    hoist = plant.hoist
    speed = hoist.sheave_radius * shown.rate
    rim = hoist.loss_coulomb * math.tanh(speed / hoist.loss_speed) + hoist.loss_viscous * speed
    moment = shown.torque - hoist.sheave_radius * (rim + shown.tension_left - shown.tension_right)
    angular = plant.rates(state, u)[4]
    np.testing.assert_allclose(
        hoist.sheave_mass * hoist.sheave_radius**2 * angular, moment, rtol=1e-10
    )


HOISTS = {
    "default": Hoist(),
    "modes": Hoist(head_rope_modes=2),
    "shaft and brake": Hoist(drive_shaft=DriveShaft(), brake=Brake(), power_limit=1.2e6),
    "everything": Hoist(
        head_rope_modes=1,
        drive_shaft=DriveShaft(),
        brake=Brake(),
        guides=Guides(),
        play=Play(),
        tail_rope_number=2,
    ),
}


def _swinging(name: str) -> tuple[Plant, PlantState]:
    """Near the upper landing at 2 m/s, out of balance, leaning on the guides with the brake closing."""
    plant = Plant(HOISTS[name])
    state = plant.equilibrium(80.0, 10.0, -TAIL * 95.0, -TAIL * 25.0)
    x = state.x.copy()
    changes = {
        "phi_rate": 1.6,
        "v_left": 2.05,
        "v_right": -1.95,
        "y_left": 0.01,
        "eta1_left": 1e-3,
        "twist": 1e-3,
    }
    changes |= {
        "x_left": 6e-3,
        "z_right_rate": 0.1,
        "brake_pressure": 0.3,
        "brake_deflection": 1e-3,
    }
    for of, change in changes.items():
        if of in plant.state_names:
            x[plant.state_names.index(of)] += change
    return plant, state._replace(x=x)


PATH = PlantInputPath(
    PlantInput(9e4, -8e3, -3e3, 0.5, fx_left=50.0),
    PlantInput(0.0, -400.0, 300.0),
    PlantInput(0.0, 200.0, 90.0),
)


@pytest.mark.parametrize(
    "added_mass", [pytest.param((0.0, 0.0), marks=pytest.mark.slow), (900.0, 300.0)]
)
@pytest.mark.parametrize("name", HOISTS)
def test_steps_of_any_length_agree_with_an_integrator_of_order_eight(name, added_mass):
    plant, state = _swinging(name)
    path = PATH._replace(added_mass=added_mass)
    for h in (1e-3, 0.01, 0.04):

        def rates(t: float, x: np.ndarray, h: float = h) -> np.ndarray:
            here = state._replace(x=x)
            return plant.rates(here, plant.loads_at(here, path, t / h))

        step = plant.step(state, h, path)
        assert step.valid
        exact = solve_ivp(
            rates, (0.0, h), state.x, method="DOP853", rtol=1e-12, atol=1e-12, max_step=h / 20
        )
        # steps mostly err by far less than their bound of 1e-8
        np.testing.assert_allclose(step.state.x, exact.y[:, -1], rtol=1e-8, atol=1e-8)
        # the input that acts at the end belongs to the state there
        np.testing.assert_allclose(
            step.applied_input[1], plant.loads_at(step.state, path, 1.0).force_left, rtol=1e-12
        )


@pytest.mark.parametrize("name", HOISTS)
def test_state_and_work_of_a_step_agree_with_cvodes(name: str) -> None:
    plant, state = _swinging(name)
    of = equations(plant.hoist.equation_structure)
    p = plant.hoist.numbers
    x = ca.SX.sym("x", state.x.size)
    u = ca.DM([*PATH.start])
    arguments = (x, u, ca.DM(list(state.free_lengths)), p)
    dae = {"x": x, "ode": of.rates(*arguments), "quad": of.powers(*arguments)}
    options = {"reltol": 1e-11, "abstol": 1e-11, "quad_err_con": True, "max_num_steps": 100000}
    exact = ca.integrator("drive", "cvodes", dae, 0.0, 0.02, options)(x0=state.x)
    step = plant.step(state, 0.02, PATH.start)
    np.testing.assert_allclose(step.state.x, np.asarray(exact["xf"]).ravel(), rtol=1e-7, atol=1e-7)
    # of some kJ in this step
    np.testing.assert_allclose(
        step.state.work_totals, np.asarray(exact["qf"]).ravel(), rtol=1e-7, atol=1e-4
    )


def test_without_a_compiler_the_drive_takes_the_same_steps() -> None:
    plant, state = _swinging("everything")
    portable = Plant(plant.hoist, form="portable")
    ours, theirs = (p.step(state, 0.01, PATH) for p in (plant, portable))
    # the same operations, contracted or ordered otherwise by a compiler: rounding, in some ten steps
    np.testing.assert_allclose(ours.state.x, theirs.state.x, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(ours.outputs, theirs.outputs, rtol=1e-9, atol=1e-6)
    assert ours.state.step_next == pytest.approx(theirs.state.step_next, rel=1e-3)


def test_modes_of_the_head_ropes_cost_a_bounded_number_of_steps() -> None:
    # the second mode of 15 m of rope is overdamped, 6006/s: an explicit method is stable up to 3.3 / 6006 s
    plant = Plant(Hoist(head_rope_modes=2))
    state = plant.equilibrium(*(90.0, 0.0), *RELAXED[::-1])
    u = PlantInput(float(state.x[0]) + 2e4, *RELAXED[::-1])
    begin = plant.evaluations
    plant.run(state, 0.01, u, 100)
    steps = 100 * 0.01 * 6006 / 3.3
    assert plant.evaluations - begin < 2.0 * steps


def test_torque_follows_its_command_with_the_lag(plant: Plant) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    M0 = float(state.x[0])
    after = plant.step(state, 0.05, PlantInput(M0 + 1e4, *RELAXED)).state
    np.testing.assert_allclose(after.x[0], M0 + 1e4 * (1.0 - math.exp(-1.0)), rtol=1e-8)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_an_input_that_is_not_finite_is_a_status_and_keeps_the_state(
    plant: Plant, bad: float
) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    step = plant.step(state, 0.01, PlantInput(bad, *RELAXED))
    assert not step.valid
    assert "not finite" in step.message
    assert step.state is state


def test_overwinding_is_a_status() -> None:
    # one metre of rope left, 8 m/s upwards: the rope is used up after an eighth of a second
    plant = Plant(Hoist(head_rope_length_up=1.0))
    state = plant.equilibrium(90.0, 0.0, *RELAXED)
    u = PlantInput(float(state.x[0]), *RELAXED)
    state = state._replace(x=state.x + np.array([0, 0, 0, 0, 6.4, 8.0, -8.0]))
    steps = 0
    while (step := plant.step(state, 0.01, u)).valid and steps < 20:
        state = step.state
        steps += 1
    assert "overwind" in step.message
    assert step.state is state
    assert 10 <= steps <= 13


BALANCED = Hoist(
    payload_left=0.0,
    head_rope_mass=1e-6,
    tail_rope_mass=0.0,
    head_rope_stiffness=1e9,
    head_rope_damping=0.3,
    loss_coulomb=0.0,
    loss_viscous=0.0,
    brake=Brake(torque=7.0e4, delay=0.2, lag=0.1),
)
"""Stiff, without losses and imbalance: 28 t that the brake stops at 2 m/s^2."""


def _stop(hoist: Hoist, law: EmergencyLaw, speed: float, seconds: float) -> list[PlantOutput]:
    """Motion after a trip at mid-shaft, one output per 10 ms."""
    plant = Plant(hoist)
    h = 0.01
    state, u = rest_at(plant, (45.0, 45.0))
    controller = SpeedController(
        hoist, float(state.x[0]), Gains(speed=4.0 * hoist.moving_mass, integral_time=1.0)
    )
    state = state_with(
        plant, state, phi_rate=speed / hoist.sheave_radius, v_left=speed, v_right=-speed, torque=0.0
    )
    memory = ControllerState()
    shown = [plant.outputs(state, u)]
    for k in range(round(seconds / h)):
        point = TrajectoryPoint(0.0, 0.0, 0.0, 0.0, Braking(law, k * h, 1.5))
        measured = Measurement(shown[-1].y_left - 45.0, hoist.sheave_radius * shown[-1].rate)
        command = controller.command(point, measured, memory, h)
        forces = dead_weights(hoist, shown[-1].y_left, shown[-1].y_right, 0.0)
        held = PlantInput(command.torque, *forces, brake=command.brake)
        state = plant.step(state, h, held).state
        memory = command.state
        shown.append(plant.outputs(state, held))
    return shown


@pytest.mark.parametrize("speed", [6.0, -6.0])
def test_constant_torque_stops_within_the_distance_of_the_closed_form(speed: float) -> None:
    shown = _stop(BALANCED, "torque", speed, 5.0)
    a = 7.0e4 / 1.25 / 28e3
    d = 0.2
    tau = 0.1
    v = abs(speed)
    # v(t) = v - a (t - tau (1 - exp(-t / tau))) after the dead time d
    t = brentq(lambda t: v - a * (t - tau * (1.0 - math.exp(-t / tau))), 0.0, 10.0)
    distance = v * (d + t) - a * (t * t / 2.0 - tau * t + tau**2 * (1.0 - math.exp(-t / tau)))
    # the linings' deflection of 2 mm comes first, and the stop ends within it
    np.testing.assert_allclose(abs(shown[-1].y_left - 45.0), distance, rtol=0, atol=4e-3)


@pytest.mark.parametrize(("payload", "speed"), [(0.0, 6.0), (4.0e3, 6.0), (4.0e3, -6.0)])
def test_a_regulated_stop_keeps_its_deceleration_with_any_load(
    payload: float, speed: float
) -> None:
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
    torque = np.array(
        [s.brake_torque for s in _stop(replace(BALANCED, brake=brake), "two-stage", 6.0, 2.5)]
    )
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
    reference = s_curve(winding)
    hoist = Hoist(brake=Brake())
    before = reference.at(7.99)
    after = reference.at(8.5)
    assert before.braking is None
    assert after.braking is not None
    np.testing.assert_allclose(after.braking.elapsed, 0.5, rtol=1e-12)
    command = SpeedController(hoist, 5e4).command(
        after, Measurement(20.0, 6.0), ControllerState(integral=1e4), 0.01
    )
    assert (command.torque, command.brake) == (0.0, 1.0)


HOIST = Hoist()
REST = TrajectoryPoint(0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("acceleration", "speed", "torque", "integral"),
    [
        pytest.param(0.0, 0.0, 5e4, 0.0, id="at rest: the holding torque"),
        pytest.param(
            0.75, 0.0, 5e4 + HOIST.sheave_radius * HOIST.moving_mass * 0.75, 0.0, id="fed forward"
        ),
        pytest.param(
            0.0, -0.1, 5e4 + HOIST.sheave_radius * 1e3, 5.0, id="k_v e; h k_v e / T_i from then on"
        ),
    ],
)
def test_the_command_is_that_of_the_law(
    acceleration: float, speed: float, torque: float, integral: float
) -> None:
    asked = TrajectoryPoint(0.0, 0.0, acceleration, 0.0)
    controller = SpeedController(HOIST, 5e4, Gains(1e4, 2.0))
    command = controller.command(asked, Measurement(0.0, speed), ControllerState(), 0.01)
    np.testing.assert_allclose(
        [command.torque, command.state.integral], [torque, integral], rtol=1e-14
    )
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
        asked = TrajectoryPoint(0.0, 3.0, 0.0, 0.0)
        v = 0.0
        state = ControllerState()
        peak = 0.0
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
