"""Head ropes that slip on the sheave: the limit in closed form, momentum, energy, when they slip and hold again."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drives import Plant, PlantInput, energy_residual

from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.drive.equations import LOSS_NAMES
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import GRAVITY, Coupling, Hoist, Winding
from hoist_demo.parameters.components import Brake, DriveShaft, Lining, Play
from hoist_demo.recording.incidents import slip

HOISTS = {
    "plain": Hoist(lining=Lining(), brake=Brake(torque=8e5)),
    "everything": Hoist(
        lining=Lining(), brake=Brake(torque=8e5), head_rope_modes=2, drive_shaft=DriveShaft(), play=Play()
    ),
}
PULL = -4e3
LINING = LOSS_NAMES.index("lining")


def running(plant: Plant, speed: float) -> PlantState:
    """In the middle of the shaft, the left conveyance rising."""
    state = plant.equilibrium(45.0, 45.0, PULL, PULL)
    x = state.x.copy()
    x[4:7] = speed / plant.hoist.sheave_radius, speed, -speed
    return state._replace(x=x)


def braked(plant: Plant, state: PlantState, seconds: float, h: float = 0.01) -> list[PlantState]:
    """States at every communication step under the full brake, the first as given."""
    return plant.run(state, h, PlantInput(0.0, PULL, PULL, brake=1.0), round(seconds / h))


@pytest.mark.parametrize("name", ["plain", pytest.param("everything", marks=pytest.mark.slow)])
def test_ropes_that_slide_have_the_tensions_of_euler_and_eytelwein_and_energy_is_kept(name: str) -> None:
    hoist = HOISTS[name]
    plant = Plant(hoist)
    states = braked(plant, running(plant, 8.0), 3.0)
    shown = [plant.outputs(s, PlantInput(0.0, PULL, PULL, brake=1.0)) for s in states]
    assert {s.slide.sense for s in states} >= {0.0, 1.0}
    for state, now in zip(states, shown, strict=True):
        if state.slide.sense != 0.0:
            off = hoist.rope_mass * (hoist.sheave_radius * now.rate + state.slide.speed) ** 2
            ratio = (now.tension_right - off) / (now.tension_left - off)
            np.testing.assert_allclose(math.log(ratio) * state.slide.sense, 0.8 * 0.25 * math.pi, rtol=1e-9)
    taken = np.diff([s.works[5:][LINING] for s in states])
    assert np.all(taken >= 0.0)
    assert np.sum(taken) > 1e5
    # the integrator's 1e-9 on 1e7 J, some thousand steps
    np.testing.assert_allclose(energy_residual(shown[0], shown[-1], states[-1].works[:5]), 0.0, atol=0.5)
    np.testing.assert_allclose(states[-1].works[5:].sum(), states[-1].works[:5][1], rtol=1e-12)


def test_over_a_sheave_that_is_held_two_weights_fall_as_on_a_capstan() -> None:
    hoist = Hoist(
        lining=Lining(), payload_left=15e3, sheave_mass=1e12, torque_limit=1e9, loss_coulomb=0.0, loss_viscous=0.0,
        head_rope_mass=0.01, head_rope_damping=0.7,
    )  # fmt: skip
    plant = Plant(hoist)
    state = plant.hanging_state(45.0, 45.0, 0.0, 0.0)
    u = PlantInput(float(state.x[0]), 0.0, 0.0)
    at = plant.run(state, 0.01, u, 150)
    state = at[-1]
    most = math.exp(0.8 * hoist.friction_coefficient * hoist.wrap_angle)
    heavy, light = hoist.mass_left, hoist.mass_right
    exact = -GRAVITY * (heavy - most * light) / (heavy + most * light)
    # the weight of 5 kg of ropes, more on one side by some m: of the 60 kN that accelerate them
    assert (state.slide.speed - at[100].slide.speed) / 0.5 == pytest.approx(exact, rel=1e-3)
    force = light * (GRAVITY - exact) * (most - 1.0)
    work = state.works[5:][LINING] - at[100].works[5:][LINING]
    assert work == pytest.approx(force * abs(state.slide.way - at[100].slide.way), rel=1e-3)


def test_slip_does_not_depend_on_the_communication_step() -> None:
    plant = Plant(HOISTS["plain"])
    coarse, fine = (braked(plant, running(plant, 8.0), 3.0, h)[-1] for h in (0.02, 0.001))
    assert coarse.slide.way > 1.0
    # both instants are located within 1e-9 s, at up to 10 m/s, in each of some ten slips
    np.testing.assert_allclose(fine.slide.way, coarse.slide.way, atol=1e-6)
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
    assert states[0].slide.way == 0.0
    np.testing.assert_array_equal(states[0].x, states[1].x)
    np.testing.assert_array_equal(states[0].works[:5], states[1].works[:5])


def test_the_mobility_of_ropes_that_slide_is_that_of_differences() -> None:
    plant = Plant(HOISTS["plain"])
    state = next(s for s in braked(plant, running(plant, 8.0), 0.5) if s.slide.sense != 0.0)
    found = np.empty((2, 2))
    for k, change in enumerate(((1e3, 0.0), (0.0, 1e3))):
        up, down = (plant.outputs(state, PlantInput(0.0, s * change[0], s * change[1])) for s in (1.0, -1.0))
        found[:, k] = np.array([up.a_left - down.a_left, up.a_right - down.a_right]) / 2e3
    # linear: rounding of some 1e5 N / 1e4 kg
    np.testing.assert_allclose(plant.mobility(state), found, atol=1e-13)


def test_a_run_goes_on_in_the_middle_of_a_slip_with_the_same_bits(tmp_path: Path) -> None:
    hoist, winding = HOISTS["plain"], Winding(travel=30.0, emergency_at=5.0, emergency_law="torque", settle=1.0)

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
