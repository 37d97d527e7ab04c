"""Head ropes that slacken or slip, conveyances that jam: closed forms, energy, what pulls and what holds."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drives import Plant, PlantInput, PlantOutput, energy_residual, state_with
from rope_groups import rope_in_process

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.design.statics import static_slip_safeties
from hoist_demo.drive.coordinates import LOSS_NAMES
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, Coupling, Hoist, Winding
from hoist_demo.parameters.components import Brake, DriveShaft, Jam, Play, SheaveLining
from hoist_demo.recording.incidents import JamEvent, incidents, jams, slip
from hoist_demo.recording.time_series import Recording

FIXED_SHEAVE = Hoist(
    loss_coulomb=0.0,
    loss_viscous=0.0,
    head_rope_damping=0.0,
    torque_limit=1e9,
    sheave_mass=1e12,
    head_rope_mass=1e-9,
)
"""No losses, ropes without mass, and a sheave too heavy to move."""

H = 1e-3


def thrown(
    hoist: Hoist, speed: float, seconds: float
) -> tuple[list[PlantOutput], list[PlantState]]:
    """The left conveyance thrown up from rest in the middle of the shaft, without balance ropes."""
    plant = Plant(hoist)
    state = plant.equilibrium(45.0, 45.0, 0.0, 0.0)
    u = PlantInput(float(state.x[0]), 0.0, 0.0)
    states = plant.run(state_with(plant, state, v_left=speed), H, u, round(seconds / H))
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
    # steps mostly err by far less than their bound of 1e-8, here of 1e7 J
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=0.5)


@pytest.mark.parametrize("damping", [0.03, 0.5])
def test_damped_ropes_never_push_and_never_give_energy(damping: float) -> None:
    hoist = Hoist(head_rope_damping=damping)
    shown, states = thrown(hoist, 6.0, 3.0)
    assert min(s.pull_left for s in shown) == 0.0
    assert max(s.slack_left for s in shown) > 0.5
    assert np.all(np.diff([s.work_totals[:5][2] for s in states]) >= 0.0)
    # steps mostly err by far less than their bound of 1e-8, here of 1e7 J
    np.testing.assert_allclose(
        energy_residual(shown[0], shown[-1], states[-1].work_totals[:5]), 0.0, atol=0.5
    )


def test_a_narrow_place_takes_the_work_of_its_force_from_what_passes() -> None:
    jam = Jam(height=50.0, distance=1.0, force=5e4)
    _, states = thrown(replace(FIXED_SHEAVE, jam_left=jam), 20.0, 0.5)
    assert states[-1].x[2] > 51.0
    # F d int_-1^1 (1 - u^2)^2 du; the guides' deflection has long reached its full value
    np.testing.assert_allclose(states[-1].work_totals[5:][1], 5e4 * 16.0 / 15.0, rtol=1e-7)


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
    rope = rope_in_process("jammed-conveyance", level="draft", parameters={"model.fidelity": 3})
    run = (
        Host(rope, hoist, replace(case.winding, settle=5.0), Coupling(step=0.02), case.gains)
        .run()
        .recording
    )
    (jam,) = jams(run)
    assert (jam.side, jam.stopping_distance is not None) == ("left", True)
    # what its head ropes pull in the end is no more than motor or brake and the other side's tension give
    behind = run.time > jam.t + 5.0
    pulls = run["drive.tension_left"][behind] - run["drive.tension_right"][behind]
    assert np.max(pulls) < (hoist.torque_limit + Brake().torque) / hoist.sheave_radius
    assert np.ptp(run["conveyance.left.y"][behind]) < Jam().travel


def test_a_conveyance_that_is_carried_through_is_not_called_jammed() -> None:
    time = np.arange(5.0)
    signals = {"time": time, "drive.jam_left": np.array([0.0, 3.0, 5.0, 0.0, 0.0])}
    signals |= {
        f"conveyance.left.{name}": values
        for name, values in (("y", 4.0 * time), ("vy", 4.0 + 0.0 * time))
    }
    recording = Recording(signals | {"conveyance.left.ay": -time}, {})
    assert jams(recording) == [JamEvent("left", 1.0, 4.0, None, 2.0)]
    assert "went through" in incidents(recording)


PLAIN = Hoist(lining=SheaveLining(), brake=Brake(torque=8e5))
HOISTS = {
    "plain": PLAIN,
    "everything": replace(PLAIN, head_rope_modes=2, drive_shaft=DriveShaft(), play=Play()),
}
PULL = -4e3
LINING = LOSS_NAMES.index("lining")


def running(plant: Plant, speed: float) -> PlantState:
    """In the middle of the shaft, the left conveyance rising."""
    state = plant.equilibrium(45.0, 45.0, PULL, PULL)
    return state_with(
        plant, state, phi_rate=speed / plant.hoist.sheave_radius, v_left=speed, v_right=-speed
    )


def braked(plant: Plant, state: PlantState, seconds: float, h: float = 0.01) -> list[PlantState]:
    """States at every communication step under the full brake, the first as given."""
    return plant.run(state, h, PlantInput(0.0, PULL, PULL, brake=1.0), round(seconds / h))


@pytest.mark.parametrize("name", ["plain", pytest.param("everything", marks=pytest.mark.slow)])
def test_ropes_that_slide_have_the_tensions_of_euler_and_eytelwein_and_energy_is_kept(
    name: str,
) -> None:
    hoist = HOISTS[name]
    plant = Plant(hoist)
    states = braked(plant, running(plant, 8.0), 3.0)
    shown = [plant.outputs(s, PlantInput(0.0, PULL, PULL, brake=1.0)) for s in states]
    assert {s.slip_state.sense for s in states} >= {0.0, 1.0}
    for state, now in zip(states, shown, strict=True):
        if state.slip_state.sense != 0.0:
            off = hoist.rope_mass * (hoist.sheave_radius * now.rate + state.slip_state.speed) ** 2
            ratio = (now.tension_right - off) / (now.tension_left - off)
            np.testing.assert_allclose(
                math.log(ratio) * state.slip_state.sense, 0.8 * 0.25 * math.pi, rtol=1e-9
            )
    taken = np.diff([s.work_totals[5:][LINING] for s in states])
    assert np.all(taken >= 0.0)
    assert np.sum(taken) > 1e5
    # steps mostly err by far less than their bound of 1e-8, here of 1e7 J
    np.testing.assert_allclose(
        energy_residual(shown[0], shown[-1], states[-1].work_totals[:5]), 0.0, atol=0.5
    )
    np.testing.assert_allclose(
        states[-1].work_totals[5:].sum(), states[-1].work_totals[:5][1], rtol=1e-12
    )


def test_over_a_sheave_that_is_held_two_weights_fall_as_on_a_capstan() -> None:
    hoist = Hoist(
        lining=SheaveLining(),
        payload_left=15e3,
        sheave_mass=1e12,
        torque_limit=1e9,
        loss_coulomb=0.0,
        loss_viscous=0.0,
        head_rope_mass=0.01,
        head_rope_damping=0.7,
    )
    plant = Plant(hoist)
    state = plant.hanging_state(45.0, 45.0, 0.0, 0.0)
    u = PlantInput(float(state.x[0]), 0.0, 0.0)
    at = plant.run(state, 0.01, u, 120)
    before = at[100]
    state = at[-1]
    most = math.exp(0.8 * hoist.friction_coefficient * hoist.wrap_angle)
    heavy = hoist.mass_left
    light = hoist.mass_right
    exact = -GRAVITY * (heavy - most * light) / (heavy + most * light)
    # the weight of 5 kg of ropes, more on one side by some m: of the 60 kN that accelerate them
    gained = state.slip_state.speed - before.slip_state.speed
    assert gained / 0.2 == pytest.approx(exact, rel=1e-3)
    force = light * (GRAVITY - exact) * (most - 1.0)
    work = state.work_totals[5:][LINING] - before.work_totals[5:][LINING]
    slid = abs(state.slip_state.slid_distance - before.slip_state.slid_distance)
    assert work == pytest.approx(force * slid, rel=1e-3)


@pytest.mark.parametrize(("speed", "when"), [(8.0, "of this trip"), (-8.0, "of a trip back")])
def test_statics_foresee_the_hold_under_the_full_brake(speed: float, when: str) -> None:
    # heavily damped ropes without mass, as the statics have them
    light = {
        "head_rope_mass": 1e-9,
        "head_rope_damping": 0.7,
        "tail_rope_mass": 0.0,
        "loss_coulomb": 0.0,
    }
    plant = Plant(Hoist(brake=Brake(torque=2e5), loss_viscous=0.0, **light))
    u = PlantInput(0.0, 0.0, 0.0, brake=1.0)
    found = plant.outputs(plant.run(running(plant, speed), 0.01, u, 100)[-1], u).tension_ratio
    holding = {
        one.when: one.ratio
        for one in static_slip_safeties(plant.hoist, Winding(emergency_law="torque"))
    }
    assert found == pytest.approx(
        next(ratio for key, ratio in holding.items() if when in key), rel=1e-3
    )


def test_slip_does_not_depend_on_the_communication_step() -> None:
    plant = Plant(HOISTS["plain"])
    coarse, fine = (braked(plant, running(plant, 8.0), 3.0, h)[-1] for h in (0.02, 0.001))
    assert coarse.slip_state.slid_distance > 1.0
    # both instants are located within 1e-9 s, at up to 10 m/s, in each of some ten slips
    np.testing.assert_allclose(
        fine.slip_state.slid_distance, coarse.slip_state.slid_distance, atol=1e-6
    )
    np.testing.assert_allclose(fine.x, coarse.x, rtol=1e-5, atol=1e-4)


def test_ropes_that_hold_have_the_bits_of_a_hoist_without_a_lining() -> None:
    states = []
    for hoist in (HOISTS["plain"], replace(HOISTS["plain"], lining=None)):
        plant = Plant(hoist)
        state = running(plant, 8.0)
        torque = float(state.x[0])
        for k in range(200):
            state = plant.step(state, 0.01, PlantInput(torque + 100.0 * k, PULL, PULL)).state
        states.append(state)
    assert states[0].slip_state.slid_distance == 0.0
    np.testing.assert_array_equal(states[0].x, states[1].x)
    np.testing.assert_array_equal(states[0].work_totals[:5], states[1].work_totals[:5])


def test_the_accelerance_of_ropes_that_slide_is_that_of_differences() -> None:
    plant = Plant(HOISTS["plain"])
    state = next(s for s in braked(plant, running(plant, 8.0), 0.5) if s.slip_state.sense != 0.0)
    found = np.empty((2, 2))
    for k, change in enumerate(((1e3, 0.0), (0.0, 1e3))):
        up, down = (
            plant.outputs(state, PlantInput(0.0, s * change[0], s * change[1])) for s in (1.0, -1.0)
        )
        found[:, k] = np.array([up.a_left - down.a_left, up.a_right - down.a_right]) / 2e3
    # linear: rounding of some 1e5 N / 1e4 kg
    np.testing.assert_allclose(plant.accelerance(state), found, atol=1e-13)


def test_a_run_goes_on_in_the_middle_of_a_slip_with_the_same_bits(tmp_path: Path) -> None:
    hoist = HOISTS["plain"]
    winding = Winding(travel=30.0, emergency_at=5.0, emergency_law="torque", settle=1.0)

    def host() -> Host:
        rope = rope_in_process("rope-120", level="draft", parameters={"model.fidelity": 1})
        return Host(rope, hoist, winding, Coupling())

    whole = host().run().recording
    (slid,) = [slip(whole)]
    file = tmp_path / "last_good.npz"
    host().run(progress=lambda _, t: t < slid.t + 0.3, save_to=file)
    kept = Checkpoint.read(file)
    resumed = host().run(resume=kept).recording
    for name in ("drive.slip", "drive.tension_ratio", "conveyance.left.y", "left.fy"):
        np.testing.assert_array_equal(resumed[name], whole[name])
