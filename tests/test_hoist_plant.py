"""The drive conserves energy, stays at rest in equilibrium, and its integrator agrees with two others."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from drives import Plant, PlantInput, PlantInputPath
from scipy.integrate import solve_ivp

from hoist_demo.drive.equations import equations, numbers_of, parts_of
from hoist_demo.drive.integrator import CHUNK
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, Hoist
from hoist_demo.parameters.components import Brake, DriveShaft, Guides, Play

TAIL = 8.0 * GRAVITY
RELAXED = (-TAIL * 15.0, -TAIL * 105.0)


@pytest.fixture(scope="module")
def plant() -> Plant:
    return Plant(Hoist())


def _move(plant: Plant) -> PlantState:
    """Mid-shaft, moving at 5 m/s, with the ropes slightly out of balance."""
    state = plant.equilibrium(40.0, 50.0, -TAIL * 55.0, -TAIL * 65.0)
    x = state.x + np.array([2e4, 0.0, 0.01, -0.02, 5.0 / 1.25, 5.1, -4.9])
    return state._replace(x=x)


def test_the_tensions_shown_are_those_that_turn_the_sheave(plant: Plant) -> None:
    state, u = _move(plant), PlantInput(9e4, -4e3, -5e3)
    shown, hoist = plant.outputs(state, u), plant.hoist
    speed = hoist.sheave_radius * shown.rate
    rim = hoist.loss_coulomb * math.tanh(speed / hoist.loss_speed) + hoist.loss_viscous * speed
    moment = shown.torque - hoist.sheave_radius * (rim + shown.tension_left - shown.tension_right)
    angular = plant.rates(state, u)[4]
    np.testing.assert_allclose(hoist.sheave_mass * hoist.sheave_radius**2 * angular, moment, rtol=1e-10)


HOISTS = {
    "default": Hoist(),
    "modes": Hoist(head_rope_modes=2),
    "shaft and brake": Hoist(drive_shaft=DriveShaft(), brake=Brake(), power_limit=1.2e6),
    "everything": Hoist(
        head_rope_modes=1, drive_shaft=DriveShaft(), brake=Brake(), guides=Guides(), play=Play(), tail_rope_number=2
    ),
}


def _swinging(name: str) -> tuple[Plant, PlantState]:
    """Near the upper landing at 2 m/s, out of balance, leaning on the guides with the brake closing."""
    plant = Plant(HOISTS[name])
    state = plant.equilibrium(80.0, 10.0, -TAIL * 95.0, -TAIL * 25.0)
    x = state.x.copy()
    changes = {"phi_rate": 1.6, "v_left": 2.05, "v_right": -1.95, "y_left": 0.01, "eta1_left": 1e-3, "twist": 1e-3}
    changes |= {"x_left": 6e-3, "z_right_rate": 0.1, "brake_pressure": 0.3, "brake_deflection": 1e-3}
    for of, change in changes.items():
        if of in plant.state_names:
            x[plant.state_names.index(of)] += change
    return plant, state._replace(x=x)


PATH = PlantInputPath(
    PlantInput(9e4, -8e3, -3e3, 0.5, fx_left=50.0), PlantInput(0.0, -400.0, 300.0), PlantInput(0.0, 200.0, 90.0)
)


@pytest.mark.parametrize("added_mass", [(0.0, 0.0), (900.0, 300.0)])
@pytest.mark.parametrize("name", HOISTS)
def test_steps_of_any_length_agree_with_an_integrator_of_order_eight(name, added_mass):
    plant, state = _swinging(name)
    path = replace(PATH, added_mass=added_mass)
    for h in (1e-3, 0.01, 0.04):

        def rates(t: float, x: np.ndarray, h: float = h) -> np.ndarray:
            here = state._replace(x=x)
            return plant.rates(here, plant.loads_at(here, path, t / h))

        step = plant.step(state, h, path)
        assert step.valid
        exact = solve_ivp(rates, (0.0, h), state.x, method="DOP853", rtol=1e-12, atol=1e-12, max_step=h / 20)
        # 1e-9 for each of some ten steps
        np.testing.assert_allclose(step.state.x, exact.y[:, -1], rtol=1e-8, atol=1e-8)
        # the input that acts at the end belongs to the state there
        np.testing.assert_allclose(step.acting[1], plant.loads_at(step.state, path, 1.0).force_left, rtol=1e-12)


@pytest.mark.parametrize("name", HOISTS)
def test_state_and_work_of_a_step_agree_with_cvodes(name: str) -> None:
    plant, state = _swinging(name)
    of, p = equations(parts_of(plant.hoist)), numbers_of(plant.hoist)
    x, u = ca.SX.sym("x", state.x.size), ca.DM([*vars(PATH.start).values()])
    arguments = (x, u, ca.DM(list(state.free_lengths)), p)
    dae = {"x": x, "ode": of.rates(*arguments), "quad": of.powers(*arguments)}
    options = {"reltol": 1e-11, "abstol": 1e-11, "quad_err_con": True, "max_num_steps": 100000}
    exact = ca.integrator("drive", "cvodes", dae, 0.0, 0.02, options)(x0=state.x)
    step = plant.step(state, 0.02, PATH.start)
    np.testing.assert_allclose(step.state.x, np.asarray(exact["xf"]).ravel(), rtol=1e-7, atol=1e-7)
    # of some kJ in this step
    np.testing.assert_allclose(step.state.works, np.asarray(exact["qf"]).ravel(), rtol=1e-7, atol=1e-4)


def test_without_a_compiler_the_drive_takes_the_same_steps() -> None:
    plant, state = _swinging("everything")
    portable = Plant(plant.hoist, form="portable")
    ours, theirs = (p.step(state, 0.01, PATH) for p in (plant, portable))
    # the same operations, contracted or ordered otherwise by a compiler: rounding, in some ten steps
    np.testing.assert_allclose(ours.state.x, theirs.state.x, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(ours.shown, theirs.shown, rtol=1e-9, atol=1e-6)
    assert ours.state.step_next == pytest.approx(theirs.state.step_next, rel=1e-3)


def test_modes_of_the_head_ropes_cost_a_bounded_number_of_steps() -> None:
    # the second mode of 15 m of rope is overdamped, 6006/s: an explicit method is stable up to 3.3 / 6006 s
    plant = Plant(Hoist(head_rope_modes=2))
    state = plant.equilibrium(*(90.0, 0.0), *RELAXED[::-1])
    u, begin = PlantInput(float(state.x[0]) + 2e4, *RELAXED[::-1]), plant.evaluations
    plant.run(state, 0.01, u, 100)
    steps = 100 * 0.01 * 6006 / 3.3
    assert plant.evaluations - begin < 2.0 * steps / CHUNK


def test_torque_follows_its_command_with_the_lag(plant: Plant) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    M0 = float(state.x[0])
    after = plant.step(state, 0.05, PlantInput(M0 + 1e4, *RELAXED)).state
    np.testing.assert_allclose(after.x[0], M0 + 1e4 * (1.0 - math.exp(-1.0)), rtol=1e-8)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_an_input_that_is_not_finite_is_a_status_and_keeps_the_state(plant: Plant, bad: float) -> None:
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
        state, steps = step.state, steps + 1
    assert "overwind" in step.message
    assert step.state is state
    assert 10 <= steps <= 13
