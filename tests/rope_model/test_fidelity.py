"""The fidelities of the model: what equals what, what cannot follow, and what 'auto' makes of it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from end_paths import led
from fidelity_choice import choose_fidelity, lowest_sufficient
from fidelity_scenes import EVEN, HIGH, SHORT, UNCOUPLED, ends_at
from native_parts import RigidRope, rigid_rope
from numpy.testing import assert_allclose
from scenes import CHOICES, Choice, wound

from rope_model import BalanceRope, Model, Rope, Scene, Swivel, balance_rope
from rope_model.boundary.end_paths import EndMotion, EndPath
from rope_model.fidelity.choice import FIDELITIES
from rope_model.fidelity.fidelity_rules import expected_travel, force_error

H = 0.01
FREE = Swivel(mode="free")


def start(scene: Scene, **model: object) -> BalanceRope:
    """The native rope, where it is to be had; test_native holds the Python one against it."""
    return wound(balance_rope(scene.with_(model=Model(**model))), ends_at, 0)  # type: ignore[arg-type]


def together(ropes: Sequence[BalanceRope], steps: int, **motion: float) -> Iterator[int]:
    """Numbers of the steps, each done by all ropes."""
    for k in range(1, steps + 1):
        for rope in ropes:
            assert rope.advance_to(k * H, *ends_at(k * H, **motion)).valid
        yield k


def end_force(rope: BalanceRope) -> np.ndarray:
    """Vertical, N."""
    return np.array([*rope.signals(("left.fy", "right.fy")).values()])


def test_spatial_and_torsional_without_inertia_are_the_same() -> None:
    """Undamped: the damping of bending is seen from the section, whose spin a spatial rope has not."""
    swivel = replace(FREE, inertia=0.05 * 0.01)
    rope = replace(UNCOUPLED, rhoJ=UNCOUPLED.rhoJ * 0.01, beta_K=0.0)
    scene = EVEN.with_(rope=rope, left=swivel, right=swivel)
    ropes = [start(scene, fidelity="torsional"), start(scene, fidelity="spatial")]
    for _ in together(ropes, 400, z=0.2):
        one, other = ([*each.signals(("loop.x", "loop.y", "loop.z")).values()] for each in ropes)
        # a hundredth of the inertia leaves a hundredth of the 2e-5 m
        assert np.linalg.norm(np.subtract(one, other)) < 1e-6
        # measured below 1e-5 with the rope's own inertia; the loop's place is the sharper measure
        assert_allclose(end_force(ropes[1]), end_force(ropes[0]), rtol=1e-4)


def test_planar_equals_torsional_without_torque_through_transformations() -> None:
    full = start(SHORT, fidelity="torsional")
    planar = start(SHORT, fidelity="planar")
    for _ in together((full, planar), 399):
        # the same equations, apart from rounding, which Newton's method and the stiff axial
        # direction amplify
        assert_allclose(end_force(planar), end_force(full), rtol=1e-9)
        assert_allclose(
            planar.state.motion.q, full.state.motion.q, rtol=0, atol=1e-9 * SHORT.rope.length
        )
    assert planar.state.counts.transformations >= 3


def rigid_at(t: float) -> RigidRope:
    """The rigid rope on many nodes, in the middle of a host step; both ends accelerate, and differently."""
    left = led(EndPath.at_rest(0.0, EndMotion()), 4.0, EndMotion(y=3.0, vy=1.5, ay=0.7))
    right = led(
        EndPath.at_rest(0.0, EndMotion(y=HIGH)), 4.0, EndMotion(y=HIGH + 1.0, vy=-0.5, ay=0.2)
    )
    return rigid_rope(
        SHORT, (left.at(t), right.at(t)), t, np.linspace(0.0, SHORT.rope.length, 20001)
    )


def integral(rope: RigidRope, values: np.ndarray) -> float:
    s = np.linspace(0.0, SHORT.rope.length, values.size)
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(s)))


def test_total_force_of_the_rigid_rope_is_weight_and_rate_of_momentum() -> None:
    def momentum(t: float) -> float:
        rope = rigid_at(t)
        return SHORT.rope.mass_per_length * integral(rope, rope.v[:, 1])

    weight = SHORT.rope.mass_per_length * SHORT.layout.gravity * SHORT.rope.length
    d = 1e-3
    rates = []
    for t in (1.0, 2.0, 3.5):
        rates.append((momentum(t + d) - momentum(t - d)) / (2 * d))
        # the quadrature's error (1.5 mm intervals) over 2 d
        assert_allclose(sum(rigid_at(t).tensions), weight + rates[-1], rtol=1e-5)
    assert np.abs(rates).max() > 0.02 * weight


def test_energies_of_the_rigid_rope_are_those_of_its_shape_and_flow_and_change_by_the_work_of_the_ends() -> (
    None
):
    rho = SHORT.rope.mass_per_length
    g = SHORT.layout.gravity
    d = 1e-3
    for t in (1.0, 2.0, 3.5):
        rope = rigid_at(t)
        before = rigid_at(t - d)
        after = rigid_at(t + d)
        assert_allclose(
            0.5 * rho * integral(rope, np.sum(rope.v[:, :3] ** 2, axis=1)), rope.kinetic, rtol=1e-5
        )
        assert_allclose(rho * g * integral(rope, rope.q[:, 1]), rope.gravity, rtol=1e-5)
        power = (after.kinetic + after.gravity - before.kinetic - before.gravity) / (2 * d)
        assert_allclose(
            power, rope.tensions[0] * rope.v[0, 1] + rope.tensions[1] * rope.v[-1, 1], rtol=1e-5
        )


def test_energy_balance_of_the_rigid_rope_closes_at_second_order_in_the_step() -> None:
    residuals = []
    for h in (0.04, 0.02, 0.01):
        rope = wound(balance_rope(EVEN.with_(model=Model("rigid"))), ends_at, round(2.0 / h), h)
        residuals.append(abs(rope.state.energy_balance.residual))
    assert rope.signals(["status.end_force_error"])["status.end_force_error"] < 1e-6
    assert_allclose(np.divide(residuals[:-1], residuals[1:]), 4.0, rtol=0.05)
    assert residuals[-1] < 1e-4 * abs(rope.state.energy_balance.work_ends)


def test_rigid_and_planar_rope_err_less_than_estimated_at_gentle_motion() -> None:
    coupled = EVEN.with_(rope=Rope(length=30.0))
    for scene, fidelities in ((coupled, ("torsional", "planar")), (EVEN, ("planar", "rigid"))):
        ropes = [start(scene, fidelity=fidelity) for fidelity in fidelities]
        forces = []
        for _ in together(ropes, 1000, duration=10.0):
            forces.append([end_force(rope) for rope in ropes])
        full, lower = np.moveaxis(np.array(forces), 1, 0)
        error = math.sqrt(np.mean((lower - full) ** 2)) / np.abs(full).max()
        assert error < force_error(scene, ropes[1].state.fidelity, expected_travel(ends_at(0.0)))


@pytest.mark.parametrize(
    ("fidelity", "motion", "name"),
    [
        ("planar", {"z": 0.2}, "left.z"),
        ("planar", {"yaw": 0.1}, "left.yaw"),
        ("spatial", {"yaw": 0.1}, "left.yaw"),
        ("rigid", {"z": 0.2}, "left.z"),
    ],
)
def test_fidelity_by_name_says_what_it_cannot_follow_and_changes_nothing(fidelity, motion, name):
    rope = wound(balance_rope(EVEN.with_(model=Model(fidelity))), ends_at, 1)
    before = rope.save()
    status = rope.advance_to(2.0, *ends_at(2.0, **motion))
    assert not status.valid
    assert f"{fidelity} model cannot follow {name}" in status.message
    assert "model.fidelity = auto" in status.message
    assert rope.save() == before


@pytest.mark.parametrize(
    ("swivel", "motion", "fidelity"),
    [
        pytest.param(FREE, {"z": 0.2}, "spatial", id="out of plane, swivels free"),
        pytest.param(Swivel(), {"z": 0.2}, "torsional", id="out of plane"),
        pytest.param(Swivel(), {"yaw": 0.1}, "torsional", id="turned"),
    ],
)
def test_auto_switches_up_without_a_jump(
    swivel: Swivel, motion: dict[str, float], fidelity: str
) -> None:
    scene = EVEN.with_(left=swivel, right=swivel)
    rope = start(scene)
    whole = start(scene, fidelity=fidelity)
    assert rope.state.fidelity == "planar"
    # a restart does not know how the acceleration changed over the last step, jerk times step (the
    # jerk is 0.15 m/s^3 at 1 s): as much force on half the rope, and jerk times step^2 in the
    # speeds
    blow = 120.0 * 0.16 * H
    drift = 0.16 * H**2
    for k in together((rope, whole), 200, **motion):
        allowed = float(k > 100)
        assert_allclose(end_force(rope), end_force(whole), rtol=1e-9, atol=allowed * blow)
        q = whole.state.motion.q[:, :3]
        assert_allclose(
            rope.state.motion.q[:, :3], q, rtol=0, atol=1e-9 + allowed * drift * (k - 100) * H
        )
        switched = [event.what for event in rope.state.events if "model" in event.what]
        assert switched == [f"model {fidelity}"] * (k == 101)
    assert rope.state.fidelity == fidelity
    assert "planar model cannot follow left." in rope.state.fidelity_reason


@pytest.mark.parametrize(
    ("tolerance", "why"), [(0.1, "its estimated error is"), (0.9, "goes slack")]
)
def test_rigid_rope_becomes_flexible_when_it_errs_too_much_or_would_go_slack(
    tolerance: float, why: str
) -> None:
    rope = start(EVEN, force_tolerance=tolerance)
    planar = start(EVEN, fidelity="planar")
    assert rope.state.fidelity == "rigid"
    forces = []
    for _ in together((rope, planar), 100, duration=2.0):  # up to 11 m/s^2
        forces.append((end_force(rope), end_force(planar)))
    assert rope.state.fidelity == "planar"
    assert "rigid model cannot follow" in rope.state.fidelity_reason
    assert why in rope.state.fidelity_reason
    ours, reference = np.moveaxis(np.array(forces), 1, 0)
    # the tolerance is of the root mean square; 10 % for either, because nothing allows more after
    # the switch
    assert math.sqrt(np.mean((ours - reference) ** 2)) < 0.1 * np.abs(reference).max()
    # the energy of the shape that it takes on is in the balance
    assert abs(rope.state.energy_balance.residual) < 0.01 * rope.state.energy_balance.kinetic


@pytest.mark.parametrize("case", CHOICES, ids=[case.title for case in CHOICES])
def test_auto_takes_the_fidelity_that_the_scene_needs(case: Choice) -> None:
    choice = choose_fidelity(case.scene, case.ends(0.0))
    assert choice.fidelity == case.fidelity
    assert choice.reason
    times = np.arange(0.0, case.until, 0.05)
    needed = [FIDELITIES.index(lowest_sufficient(case.scene, case.ends(t))) for t in times]
    if choice.fidelity != "torsional":
        assert FIDELITIES[max(max(needed), FIDELITIES.index(choice.fidelity))] == (
            case.last or case.fidelity
        )


@pytest.mark.parametrize("start_time", [-5.0, -0.5])
def test_a_free_swivel_that_waits_for_the_instant_0_holds_in_a_run_that_starts_before(
    start_time: float,
) -> None:
    """It twists the rope out of plane until then, so that the model without torsion does not serve."""
    waits = Swivel(mode="free", release_time=0.0)
    aside = EndMotion(z=1e-6, vz=2e-4, az=0.02)
    found = []
    for swivel in (waits, FREE):
        rope = balance_rope(EVEN.with_(left=swivel, right=swivel, model=Model("auto")), "native")
        assert rope.initialize(start_time, EndMotion(), EndMotion()).valid
        assert rope.advance_to(start_time + H, aside, EndMotion()).valid
        found.append(rope.state.fidelity)
    assert found == ["torsional", "spatial"]
