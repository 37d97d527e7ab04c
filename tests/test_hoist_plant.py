"""The drive conserves energy, stays at rest in equilibrium, and CVODES agrees with another integrator."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hoist_demo.drive.plant import HoistPlant, PlantInput, PlantState, energy_residual
from hoist_demo.parameters import GRAVITY, Hoist

TAIL = 8.0 * GRAVITY
RELAXED = (-TAIL * 15.0, -TAIL * 105.0)


@pytest.fixture(scope="module")
def plant() -> HoistPlant:
    return HoistPlant(Hoist())


def _move(plant: HoistPlant) -> PlantState:
    """Mid-shaft, moving at 5 m/s, with the ropes slightly out of balance."""
    state = plant.equilibrium(40.0, 50.0, -TAIL * 55.0, -TAIL * 65.0)
    x = state.x + np.array([2e4, 0.0, 0.01, -0.02, 5.0 / 1.25, 5.1, -4.9])
    return replace(state, x=x)


@pytest.mark.parametrize("heights", [(0.0, 90.0), (90.0, 0.0), (45.0, 45.0)])
def test_equilibrium_stays_at_rest(plant: HoistPlant, heights: tuple[float, float]) -> None:
    state = plant.equilibrium(*heights, *RELAXED)
    u = PlantInput(float(state.x[0]), *RELAXED)
    # forces of 1e5 N on 1e4 kg, rounded at 1e-16, stretches of 0.1 m in lengths of 100 m: 1e5 * 1e3 * 1e-16 / 1e4
    np.testing.assert_allclose(plant.rates(state, u), 0.0, atol=1e-11)
    for _ in range(100):
        step = plant.step(state, 0.01, u)
        assert step.valid
        state = step.state
    # the tolerance of CVODES, 1e-9, on heights of 90 m for 100 steps
    np.testing.assert_allclose(state.x[2:4], heights, rtol=0, atol=1e-7)
    np.testing.assert_allclose(state.x[4:], 0.0, atol=1e-7)


def test_motor_holds_the_difference_of_the_tensions(plant: HoistPlant) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    shown = plant.outputs(state, PlantInput(float(state.x[0]), *RELAXED))
    difference = shown.tension_left - shown.tension_right
    np.testing.assert_allclose(shown.torque, 1.25 * difference, rtol=1e-12)
    # all of a side's weight hangs on the sheave, up to the strain of its ropes, T / EA = 1.5e-3
    weight = GRAVITY * (15e3 + 8.0 * 105.0) + TAIL * 15.0
    np.testing.assert_allclose(shown.tension_left, weight, rtol=1.5e-3)
    assert shown.tension_ratio == shown.tension_left / shown.tension_right


def test_the_tensions_shown_are_those_that_turn_the_sheave(plant: HoistPlant) -> None:
    state, u = _move(plant), PlantInput(9e4, -4e3, -5e3)
    shown, hoist = plant.outputs(state, u), plant.hoist
    speed = hoist.sheave_radius * shown.rate
    rim = hoist.loss_coulomb * math.tanh(speed / hoist.loss_speed) + hoist.loss_viscous * speed
    moment = shown.torque - hoist.sheave_radius * (rim + shown.tension_left - shown.tension_right)
    angular = plant.rates(state, u)[4]
    np.testing.assert_allclose(hoist.sheave_mass * hoist.sheave_radius**2 * angular, moment, rtol=1e-10)


def test_one_step_agrees_with_scipy_for_any_step_length(plant: HoistPlant) -> None:
    state, u = _move(plant), PlantInput(9e4, -4e3, -5e3)

    def rates(_: float, x: np.ndarray) -> np.ndarray:
        return plant.rates(replace(state, x=x), u)

    for h in (1e-3, 0.01, 0.05):
        step = plant.step(state, h, u)
        assert step.valid
        exact = solve_ivp(rates, (0.0, h), state.x, method="DOP853", rtol=1e-12, atol=1e-10).y[:, -1]
        # CVODES with rtol = atol = 1e-9 per internal step, some hundred of them
        np.testing.assert_allclose(step.state.x, exact, rtol=1e-7, atol=1e-7)


def test_two_half_steps_equal_one_step(plant: HoistPlant) -> None:
    state, u = _move(plant), PlantInput(9e4, -4e3, -5e3)
    whole = plant.step(state, 0.02, u).state
    half = plant.step(plant.step(state, 0.01, u).state, 0.01, u).state
    np.testing.assert_allclose(half.x, whole.x, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(half.work, whole.work, rtol=1e-7, atol=1e-4)


def test_energy_gained_is_work_done_less_losses(plant: HoistPlant) -> None:
    state, u = _move(plant), PlantInput(9e4, -4e3, -5e3)
    start, first = plant.outputs(state, u), state.work
    for k in range(200):
        u = PlantInput(9e4 + 4e4 * math.sin(0.05 * k), -4e3 - 10.0 * k, -5e3 + 10.0 * k)
        step = plant.step(state, 0.01, u)
        assert step.valid
        state = step.state
    work = state.work - first
    assert min(work[1], work[2]) > 0.0
    # CVODES' 1e-9 on the 1e7 J of the hoist's energy, over 200 steps that partly cancel
    np.testing.assert_allclose(energy_residual(start, plant.outputs(state, u), work), 0.0, atol=0.05)
    assert abs(work[0]) > 1e5


def test_the_hoist_without_losses_and_motor_keeps_its_energy() -> None:
    plant = HoistPlant(Hoist(head_rope_damping=0.0, loss_coulomb=0.0, loss_viscous=0.0))
    state = replace(_move(plant), x=_move(plant).x * np.array([0, 1, 1, 1, 1, 1, 1]))
    u = PlantInput(0.0, 0.0, 0.0)
    start = plant.outputs(state, u)
    for _ in range(100):
        state = plant.step(state, 0.01, u).state
    end = plant.outputs(state, u)
    gained = end.energy_kinetic + end.energy_potential - start.energy_kinetic - start.energy_potential
    # 1e-9 of 1e7 J, 100 steps
    np.testing.assert_allclose(gained, 0.0, atol=0.05)


def test_a_conveyance_swings_at_its_rope_s_frequency() -> None:
    # heavy sheave, massless ropes: m y'' = -EA/l (y - y0), off by the strain (1 + e)^3, e = 1.5e-3
    hoist = Hoist(sheave_mass=1e9, head_rope_mass=1e-9, head_rope_damping=0.0, loss_coulomb=0.0, loss_viscous=0.0)
    plant = HoistPlant(hoist)
    rest = plant.equilibrium(0.0, 90.0, 0.0, 0.0)
    u = PlantInput(float(rest.x[0]), 0.0, 0.0)
    pushed = replace(rest, x=rest.x + np.array([0, 0, 1e-3, 0, 0, 0, 0]))
    omega = math.sqrt(hoist.rope_stiffness / rest.free_lengths[0] / hoist.mass_left)
    quarter = plant.step(pushed, math.pi / 2 / omega, u).state
    # a quarter period later the conveyance passes its rest position at full speed
    np.testing.assert_allclose(quarter.x[2], 0.0, atol=1e-3 * 1e-3)
    np.testing.assert_allclose(quarter.x[5], -1e-3 * omega, rtol=1e-3)


def test_torque_follows_its_command_with_the_lag(plant: HoistPlant) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    M0 = float(state.x[0])
    after = plant.step(state, 0.05, PlantInput(M0 + 1e4, *RELAXED)).state
    np.testing.assert_allclose(after.x[0], M0 + 1e4 * (1.0 - math.exp(-1.0)), rtol=1e-8)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_an_input_that_is_not_finite_is_a_status_and_keeps_the_state(plant: HoistPlant, bad: float) -> None:
    state = plant.equilibrium(0.0, 90.0, *RELAXED)
    step = plant.step(state, 0.01, PlantInput(bad, *RELAXED))
    assert not step.valid
    assert "not finite" in step.message
    assert step.state is state


def test_overwinding_is_a_status() -> None:
    # one metre of rope left, 8 m/s upwards: the rope is used up after an eighth of a second
    plant = HoistPlant(Hoist(head_rope_length_up=1.0))
    state = plant.equilibrium(90.0, 0.0, *RELAXED)
    u = PlantInput(float(state.x[0]), *RELAXED)
    state = replace(state, x=state.x + np.array([0, 0, 0, 0, 6.4, 8.0, -8.0]))
    steps = 0
    while (step := plant.step(state, 0.01, u)).valid and steps < 20:
        state, steps = step.state, steps + 1
    assert "overwind" in step.message
    assert step.state is state
    assert 10 <= steps <= 13


@pytest.mark.parametrize(("field", "value"), [("conveyance_mass", 0.0), ("torque_limit", math.nan)])
def test_bad_data_is_named(field: str, value: Any) -> None:
    with pytest.raises(ValueError, match=rf"{field} = .* must be .*: "):
        Hoist(**{field: value})
