"""Every part that a hoist may have: analytic frequencies, hand numbers, closed forms, energy balances that close."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drives import Plant, PlantInput, energy_residual, rest_at, state_with
from scipy.optimize import brentq

from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.schemes.interface import DriveLoad, Stopwatch
from hoist_demo.design.statics import pulls
from hoist_demo.drive.coordinates import LOSS_NAMES
from hoist_demo.drive.plant import PlantState
from hoist_demo.drive_fmu.description import drive_model
from hoist_demo.parameters import (
    GRAVITY,
    Arrival,
    Coupling,
    Hoist,
    Winding,
    quantity,
    require_jams_on_the_way,
    require_trip_fits,
)
from hoist_demo.parameters.components import Brake, DriveShaft, Guides, Jam, Play, SheaveLining
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.parameters.trip_design import Shaper, TrajectoryOptions
from rope_model import EndMotion, parameter_table

FULL = Hoist(
    head_rope_modes=2,
    tail_rope_number=2,
    tail_rope_mass=4.0,
    conveyance_mass_right=9.0e3,
    power_limit=8.0e5,
    drive_shaft=DriveShaft(),
    brake=Brake(torque=1.5e5),
    guides=Guides(),
    play=Play(),
)
"""A hoist with everything."""

LOSSLESS = Hoist(loss_coulomb=0.0, loss_viscous=0.0, head_rope_damping=0.0)
SMOOTH = replace(LOSSLESS, torque_limit=1e9, sheave_mass=1e12, tail_rope_mass=0.0)
"""No losses, and a sheave too heavy to move: each leg is a system of its own."""


def _frequencies(plant: Plant, heights: tuple[float, float]) -> np.ndarray:
    """Circular frequencies of small motion about rest [rad/s], ascending."""
    state, u = rest_at(plant, heights)
    jacobian = np.empty((state.x.size, state.x.size))
    for k in range(state.x.size):
        d = np.zeros(state.x.size)
        d[k] = 1e-4
        up, down = (plant.rates(state._replace(x=state.x + s * d), u) for s in (1, -1))
        jacobian[:, k] = (up - down) / 2e-4
    values = np.linalg.eigvals(jacobian).imag
    return np.sort(values[values > 1e-6])


@pytest.mark.parametrize("modes", [1, 3])
def test_head_ropes_swing_as_a_rod_with_the_conveyance_at_its_end(modes: int) -> None:
    hoist = replace(
        SMOOTH, head_rope_mass=10.0, shaft_travel=500.0, head_rope_modes=modes, payload_left=0.0
    )
    plant = Plant(hoist)
    state, _ = rest_at(plant, (250.0, 250.0))
    length = state.free_lengths[0]
    ratio = hoist.rope_mass * length / hoist.mass_left
    # k l tan(k l) = rope's mass over conveyance's, in each branch of the tangent
    branches = [(n * math.pi, (n + 0.5) * math.pi) for n in range(modes)]
    roots = [brentq(lambda b: b * math.sin(b) - ratio * math.cos(b), *ends) for ends in branches]
    exact = np.array(roots) * math.sqrt(hoist.rope_stiffness / hoist.rope_mass) / length
    found = _frequencies(plant, (250.0, 250.0))[::2][:modes]  # both sides are alike
    # a mode left out would add its participating mass 2 mu l / (j pi)^2, by the square of the ratio of the frequencies
    fixed = math.pi * math.sqrt(hoist.rope_stiffness / hoist.rope_mass) / length
    left_out = sum(
        ratio / (j * math.pi) ** 2 * (exact[0] / (j * fixed)) ** 2 for j in range(modes + 1, 100)
    )
    np.testing.assert_allclose(found[0], exact[0], rtol=left_out)
    # of higher ones the highest, next to what is left out, errs most: 1e-3
    np.testing.assert_allclose(found, exact, rtol=2e-3)


def test_between_its_guides_a_conveyance_is_a_pendulum_of_several_ropes() -> None:
    play = Play(clearance=0.05, damping=0.0, contact_damping=0.0)
    plant = Plant(replace(SMOOTH, head_rope_mass=1e-9, play=play))
    found = _frequencies(plant, (0.0, 0.0))
    pendulum = math.sqrt(GRAVITY / plant.hoist.sheave_height)
    # x and z of both sides, then yaw on ropes at the radius b: b / r times the pendulum's
    np.testing.assert_allclose(found[2:6], pendulum, rtol=1e-4)
    np.testing.assert_allclose(found[:2], pendulum * play.rope_spread / play.gyration, rtol=1e-4)


def test_a_pushed_conveyance_leans_on_its_guides() -> None:
    plant = Plant(replace(SMOOTH, play=Play()))
    state, u = rest_at(plant, (45.0, 45.0))
    tension = (
        plant.hoist.mass_left * GRAVITY
        + plant.hoist.rope_mass * GRAVITY * state.free_lengths[0] / 2
    )
    pendulum = tension / (plant.hoist.sheave_height - 45.0)
    k = 2.0e6
    c = 5.0e-3
    place = (1.0e4 + k * c) / (k + pendulum)
    rates = plant.rates(state_with(plant, state, x_left=place), u._replace(fx_left=1.0e4))
    # 1e4 N on 15 t, the shortening of the pendulum (x / H)^2 = 3e-8 left out
    np.testing.assert_allclose(rates[plant.state_names.index("x_left_rate")], 0.0, atol=1e-6)


def test_a_conveyance_that_leans_on_its_guides_is_braked_by_its_shoes() -> None:
    rates = []
    for friction in (0.1, 0.0):
        plant = Plant(
            replace(SMOOTH, head_rope_mass=1e-9, play=Play(friction=friction, contact_damping=0.0))
        )
        state, u = rest_at(plant, (45.0, 45.0))
        rates.append(
            plant.rates(state_with(plant, state, x_left=8e-3, z_left=-7e-3, v_left=1.0), u)[5]
        )
    # springs of 2e6 N/m pressed by 3 and 2 mm hold 15 t back
    np.testing.assert_allclose(rates[0] - rates[1], -0.1 * 2.0e6 * (3e-3 + 2e-3) / 15e3, rtol=1e-6)


def test_the_shaft_s_swinging_dies_with_its_damping_ratio() -> None:
    plant = Plant(replace(LOSSLESS, drive_shaft=DriveShaft(damping=0.03), head_rope_mass=1e-9))
    state, u = rest_at(plant, (45.0, 45.0))
    twisted = state_with(plant, state, twist=state.x[7] + 1e-3)
    at_place = plant.rates(twisted, u)[8]
    turning = plant.rates(state_with(plant, state, twist_rate=1.0), u)[8]
    # delta'' = -w^2 delta - 2 D w delta'
    np.testing.assert_allclose(-turning / (2.0 * math.sqrt(-at_place / 1e-3)), 0.03, rtol=1e-6)


def test_motor_and_sheave_swing_on_their_shaft() -> None:
    hoist = replace(
        LOSSLESS, drive_shaft=DriveShaft(damping=0.0), head_rope_mass=1e-9, head_rope_stiffness=1e6
    )
    motor = 3.0e3 * 1.25**2
    sheave = 5.0e3 * 1.25**2
    exact = math.sqrt(2.0e8 * (1.0 / motor + 1.0 / sheave))
    # soft ropes add less than half the square of the ratio of the frequencies, 3 / 330
    np.testing.assert_allclose(_frequencies(Plant(hoist), (45.0, 45.0))[-1], exact, rtol=1e-4)


@pytest.mark.parametrize("modes", [0, 2])
def test_a_hoist_at_constant_speed_hangs_as_one_at_rest(modes: int) -> None:
    hoist = replace(SMOOTH, head_rope_mass=10.0, shaft_travel=500.0, head_rope_modes=modes)
    plant = Plant(hoist)
    state, u = rest_at(plant, (100.0, 400.0))
    moving = state_with(plant, state, phi_rate=18.0 / 1.25, v_left=18.0, v_right=-18.0)
    rest = plant.outputs(state, u)
    wound = plant.outputs(moving, u)
    # of mu w^2 = 13 kN only the part of the strain, 3e-3, may remain
    tensions = [(shown.tension_left, shown.tension_right) for shown in (wound, rest)]
    np.testing.assert_allclose(*tensions, rtol=0, atol=40.0)
    np.testing.assert_allclose([wound.a_left, wound.a_right], 0.0, atol=40.0 / 10e3)


@pytest.mark.parametrize("heights", [(0.0, 90.0), (90.0, 0.0), (30.0, 60.0)])
def test_with_every_part_equilibrium_is_at_rest_to_rounding(heights: tuple[float, float]) -> None:
    plant = Plant(FULL)
    # forces of 1e5 N rounded at 1e-16 of energies over 0.1 m, on 1e4 kg
    np.testing.assert_allclose(plant.rates(*rest_at(plant, heights)), 0.0, atol=1e-10)


def test_with_every_part_the_energy_balance_closes() -> None:
    plant = Plant(FULL)
    state, u = rest_at(plant, (40.0, 50.0))
    moving = {"phi_rate": 4.0, "v_left": 5.0, "v_right": -5.0, "brake_pressure": 0.1}
    state = state_with(plant, state, **moving, x_left=4e-3, eta1_left=2e-3, twist=3e-3)
    start = plant.outputs(state, u)
    for k in range(150):
        wave = math.sin(0.1 * k)
        u = u._replace(
            torque_command=7e4 + 3e4 * wave,
            brake=0.6 * (k > 60),
            fx_left=8e3 * wave,
            fz_left=-2e3,
            my_left=5e3 * wave,
            fx_right=-9e3 * wave,
            fz_right=1e4,
            my_right=-3e3,
        )
        step = plant.step(state, 0.01, u)
        assert step.valid
        state = step.state
    # steps mostly err by far less than their bound of 1e-8, here of 1e7 J
    np.testing.assert_allclose(
        energy_residual(start, plant.outputs(state, u), state.work_totals[:5]), 0.0, atol=0.05
    )
    np.testing.assert_allclose(state.work_totals[5:].sum(), state.work_totals[:5][1], rtol=1e-12)
    # every loss has taken something, or this test says nothing of it; head ropes that slip are in test_head_ropes
    taken = dict(zip(LOSS_NAMES, state.work_totals[5:], strict=True))
    assert taken.pop("lining") == 0.0
    assert min(taken.values()) > 1.0, taken
    assert np.all(np.abs(state.work_totals[:5]) > 10.0)


def test_a_hoist_with_its_sides_exchanged_does_the_same_mirrored() -> None:
    left = replace(FULL, payload_left=5e3, payload_right=0.0, conveyance_mass_right=None)
    right = replace(left, payload_left=0.0, payload_right=5e3)
    shown = []
    for hoist, sign, heights in ((left, 1.0, (20.0, 70.0)), (right, -1.0, (70.0, 20.0))):
        plant = Plant(hoist)
        state, u = rest_at(plant, heights)
        pushed = u._replace(torque_command=u.torque_command + sign * 2e4)
        shown.append(plant.outputs(plant.run(state, 0.01, pushed, 20)[-1], u))
    one, other = shown
    np.testing.assert_allclose(other.tension_right, one.tension_left, rtol=1e-7)
    np.testing.assert_allclose([other.v_right, other.rate], [one.v_left, -one.rate], rtol=1e-6)


def test_static_tensions_and_slip_safety_are_those_of_a_hand_calculation() -> None:
    hoist = Hoist()
    plant = Plant(hoist)
    shown = plant.outputs(*rest_at(plant, (0.0, 90.0)))
    # 15 t and 10 t; head ropes 8 kg/m, 105 m and 15 m; balance rope 8 kg/m, legs of 15 m and 105 m
    left = 15e3 + 8 * 105 + 8 * 15
    right = 10e3 + 8 * 15 + 8 * 105
    # head ropes are a strain of 1.5e-3 shorter than they hang, on 840 of 15960 kg
    np.testing.assert_allclose(shown.static_tension_left, GRAVITY * left, rtol=1e-4)
    np.testing.assert_allclose(shown.static_tension_right, GRAVITY * right, rtol=1e-4)
    # all of a side's weight hangs on the sheave, up to the strain of its ropes, T / EA = 1.5e-3
    np.testing.assert_allclose(shown.tension_ratio, left / right, rtol=1.5e-3)
    # e^(0.25 pi) = 2.19328: 1.19328 / 0.456204
    np.testing.assert_allclose(hoist.slip_safety(left / right), 2.61567, rtol=1e-5)
    assert hoist.slip_safety(1.0) == math.inf
    uneven = replace(hoist, tail_rope_mass=3.0)
    apart = []
    for y in (0.0, 30.0, 60.0, 90.0):
        one, other = pulls(uneven, y)
        apart.append(abs(one - other))
    np.testing.assert_allclose(
        [uneven.imbalance(), uneven.imbalance(30.0)], [max(apart), max(apart[1:3])]
    )


def test_the_motor_keeps_its_limits_of_torque_and_power() -> None:
    plant = Plant(replace(FULL, power_limit=3.0e5))
    state, u = rest_at(plant, (0.0, 90.0))
    greedy = u._replace(torque_command=1e7)
    shown = [plant.outputs(s, greedy) for s in plant.run(state, 0.01, greedy, 150)]
    assert 0.99 * 2.2e5 < max(s.torque for s in shown) <= 2.2e5 * (1 + 1e-12)
    assert max(s.power for s in shown) <= 3.0e5 * (1 + 1e-12)
    assert shown[-1].power > 0.999 * 3.0e5


def ends(plant: Plant, state: PlantState, u: PlantInput) -> tuple[EndMotion, EndMotion]:
    drive = HoistPartner(plant, state, np.array(u), Stopwatch())
    return drive.ends(
        drive.motion(DriveLoad.constant(np.array([u.force_left, u.force_right])), 0.0)
    )


def test_the_ends_of_the_balance_rope_follow_the_conveyances() -> None:
    plant = Plant(FULL)
    state, u = rest_at(plant, (30.0, 60.0))
    aside = {
        "x_left": 1e-3,
        "x_left_rate": 0.3,
        "z_right": -2e-3,
        "yaw_right": 1e-3,
        "yaw_right_rate": 0.1,
    }
    left, right = ends(plant, state_with(plant, state, v_left=2.0, **aside), u)
    assert (left.x, left.y, left.vx, left.vy) == (1e-3, 30.0, 0.3, 2.0)
    assert (right.z, right.y, right.yaw, right.yaw_rate) == (-2e-3, 60.0, 1e-3, 0.1)
    plain = Plant(Hoist())
    assert ends(plain, *rest_at(plain, (0.0, 90.0)))[0] == EndMotion(
        y=0.0, ay=pytest.approx(0.0, abs=1e-10)
    )


REGULATED = Winding(emergency_at=5.0, emergency_law="deceleration")
BAD = {
    "conveyance_mass": lambda: Hoist(conveyance_mass=0.0),
    "torque_limit": lambda: Hoist(torque_limit=math.nan),
    "slack_tension": lambda: Hoist(slack_tension=1e5),
    "jam_right.height": lambda: Hoist(jam_right=Jam(height=91.0)),
    r"jam_right\.height": lambda: require_jams_on_the_way(
        Hoist(jam_right=Jam(height=53.0)), Winding(travel=10.0)
    ),
    "lining.sliding": lambda: SheaveLining(sliding=1.2),
    "lining": lambda: drive_model(
        replace(find_case("rope-120"), hoist=Hoist(lining=SheaveLining()))
    ),
    "jam_right": lambda: drive_model(find_case("jammed-conveyance")),
    "emergency_law": lambda: require_trip_fits(
        Hoist(), Winding(emergency_at=5.0, emergency_law="torque")
    ),
    "emergency_deceleration": lambda: require_trip_fits(Hoist(brake=Brake(torque=5e4)), REGULATED),
    "gain speed": lambda: Gains(speed=0.0),
    "gain feed_forward": lambda: Gains(feed_forward=1.1),
    "wrap_angle": lambda: Hoist(wrap_angle=180.0),
    "head_rope_stiffness": lambda: Hoist(head_rope_stiffness=3.2e4),
    "jerk": lambda: Winding(jerk=math.nan),
    "emergency_at": lambda: s_curve(Winding(emergency_at=30.0)),
    "creep_speed": lambda: s_curve(Winding(creep_speed=9.0, creep_distance=3.0)),
    "creep_distance": lambda: s_curve(Winding(creep_distance=0.4)),
    "drive_shaft.motor_mass": lambda: Hoist(drive_shaft=DriveShaft(motor_mass=8.0e3)),
    "head_rope_modes": lambda: Hoist(head_rope_modes=-1),
    "tail_rope_number": lambda: Hoist(tail_rope_number=1.5),  # type: ignore[arg-type]
    "power_limit": lambda: Hoist(power_limit=0.0),
    "brake.first_stage": lambda: Brake(first_stage=2.0),
    "brake.torque": lambda: Brake(torque=math.nan),
    "play.arm": lambda: Play(arm=0.0),
    "guides.viscous": lambda: Guides(viscous=-1.0),
    "emergency_la.": lambda: Winding(emergency_law="anchor"),  # type: ignore[arg-type]
    "holding torque": lambda: Plant(Hoist(torque_limit=1e4)).equilibrium(0.0, 90.0, -1e3, -8e3),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_data_is_named_with_its_bound_and_a_cure(name: str) -> None:
    with pytest.raises(ValueError, match=rf"^{name} = .* must be .*: .*"):
        BAD[name]()


def test_bounds_of_host_and_rope_have_the_same_names() -> None:
    shared = {"lower", "upper", "cure"}
    assert shared <= {*quantity.NumberRange._fields}
    assert shared <= {*parameter_table.Bounds._fields}


@pytest.mark.parametrize(
    "data", [Hoist, Winding, Coupling, Arrival, Gains, Shaper, TrajectoryOptions, SuspensionOffset]
)
def test_each_number_of_the_host_has_a_description_that_stands_alone(data: type) -> None:
    # a first word that leans on the name of the key or on the row above
    leaning = ("at", "by", "for", "from", "in", "its", "likewise", "none", "of", "that", "to")
    for one in quantity.leaves(data):
        if one.choices:
            continue
        words = one.meaning.split()
        assert len(words) > 1, one
        assert words[0] not in leaning, one
        assert not one.meaning.startswith("the same"), one
