"""Head ropes that slacken and conveyances that jam: closed forms, energy, what pulls and what holds."""

from dataclasses import replace

import numpy as np
import pytest
from drives import Plant, PlantInput, PlantOutput, energy_residual

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, Coupling, Hoist
from hoist_demo.parameters.components import Brake, Jam
from hoist_demo.recording.incidents import Jam as Jammed
from hoist_demo.recording.incidents import jams, told_of_jams
from hoist_demo.recording.time_series import Recording

FIXED_SHEAVE = Hoist(
    loss_coulomb=0.0, loss_viscous=0.0, head_rope_damping=0.0, torque_limit=1e9, sheave_mass=1e12, head_rope_mass=1e-9
)
"""No losses, ropes without mass, and a sheave too heavy to move."""

H = 1e-3


def thrown(hoist: Hoist, speed: float, seconds: float) -> tuple[list[PlantOutput], list[PlantState]]:
    """The left conveyance thrown up from rest in the middle of the shaft, without balance ropes."""
    plant = Plant(hoist)
    state = plant.equilibrium(45.0, 45.0, 0.0, 0.0)
    u = PlantInput(float(state.x[0]), 0.0, 0.0)
    x = state.x.copy()
    x[plant.state_names.index("v_left")] = speed
    states = plant.run(state._replace(x=x), H, u, round(seconds / H))
    return [plant.outputs(s, u) for s in states], states


def test_a_thrown_conveyance_rises_as_a_stone_above_its_slack_ropes() -> None:
    shown, states = thrown(FIXED_SHEAVE, 5.0, 2.0)
    stiffness = FIXED_SHEAVE.rope_stiffness / states[0].free_lengths[0]
    stretch = FIXED_SHEAVE.mass_left * GRAVITY / stiffness
    # the ropes give their energy until they are slack: v^2 - g e is left of v^2
    highest = 5.0**2 / (2.0 * GRAVITY) - stretch / 2.0
    # sampled: g H^2 / 8 below the top
    np.testing.assert_allclose(max(s.slack_left for s in shown), highest, rtol=0, atol=2e-6)
    slack = [s for s in shown if s.slack_left > 0.0]
    assert {s.pull_left for s in slack} == {0.0}
    np.testing.assert_allclose([s.a_left for s in slack], -GRAVITY, rtol=1e-9)
    # and falls back into its ropes as fast as it was thrown; sampled: (omega H)^2 / 8 below the peak
    peak = FIXED_SHEAVE.mass_left * GRAVITY + 5.0 * np.sqrt(stiffness * FIXED_SHEAVE.mass_left)
    np.testing.assert_allclose(max(s.pull_left for s in shown), peak, rtol=1e-4)
    energy = np.array([s.energy_kinetic + s.energy_potential for s in shown])
    # the integrator's 1e-9 on 1e7 J, some thousand steps
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=0.5)


@pytest.mark.parametrize("damping", [0.03, 0.5])
def test_damped_ropes_never_push_and_never_give_energy(damping: float) -> None:
    hoist = Hoist(head_rope_damping=damping)
    shown, states = thrown(hoist, 6.0, 3.0)
    assert min(s.pull_left for s in shown) == 0.0
    assert max(s.slack_left for s in shown) > 0.5
    assert np.all(np.diff([s.works[:5][2] for s in states]) >= 0.0)
    # the integrator's 1e-9 on 1e7 J, some thousand steps
    np.testing.assert_allclose(energy_residual(shown[0], shown[-1], states[-1].works[:5]), 0.0, atol=0.5)


def test_a_narrow_place_takes_the_work_of_its_force_from_what_passes() -> None:
    jam = Jam(height=50.0, distance=1.0, force=5e4)
    _, states = thrown(replace(FIXED_SHEAVE, jam_left=jam), 20.0, 0.5)
    assert states[-1].x[2] > 51.0
    # F d int_-1^1 (1 - u^2)^2 du; the guides' deflection has long reached its full value
    np.testing.assert_allclose(states[-1].works[5:][1], 5e4 * 16.0 / 15.0, rtol=1e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_jam_holds_a_conveyance_against_the_motor(sign: float) -> None:
    moved = {}
    for jam in (None, Jam()):
        plant = Plant(Hoist(jam_left=jam))
        state = plant.equilibrium(45.0, 45.0, -4e3, -4e3)
        u = PlantInput(sign * plant.hoist.torque_limit, -4e3, -4e3)
        moved[jam is None] = sign * (plant.run(state, 0.01, u, 100)[-1].x[2] - 45.0)
    assert moved[True] > 1.0
    # less than the deflection at the full force
    assert abs(moved[False]) < Jam().travel


def test_a_rising_conveyance_that_jams_stalls_the_drive() -> None:
    case = find_case("jammed-conveyance")
    hoist = replace(case.hoist, jam_right=None, jam_left=Jam())
    rope = rope_in_process("jammed-conveyance", level="draft", parameters={"model.fidelity": 1})
    run = Host(rope, hoist, replace(case.winding, settle=5.0), Coupling(), case.gains).run().recording
    (jam,) = jams(run)
    assert (jam.side, jam.way is not None) == ("left", True)
    # what its head ropes pull in the end is no more than motor or brake and the other side's tension give
    behind = run.time > jam.t + 5.0
    pulls = run["drive.tension_left"][behind] - run["drive.tension_right"][behind]
    assert np.max(pulls) < (hoist.torque_limit + Brake().torque) / hoist.sheave_radius
    assert np.ptp(run["conveyance.left.y"][behind]) < Jam().travel


def test_a_conveyance_that_is_carried_through_is_not_called_jammed() -> None:
    time = np.arange(5.0)
    signals = {"time": time, "drive.jam_left": np.array([0.0, 3.0, 5.0, 0.0, 0.0])}
    signals |= {f"conveyance.left.{name}": values for name, values in (("y", 4.0 * time), ("vy", 4.0 + 0.0 * time))}
    recording = Recording(signals | {"conveyance.left.ay": -time}, {})
    assert jams(recording) == [Jammed("left", 1.0, 4.0, None, 2.0)]
    assert "went through" in told_of_jams(recording)
