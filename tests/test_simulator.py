"""The rope in time: end paths, meshes that agree, transformations, failures, states, frames."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import hung, recorded, smooth_trip, wound

from rope_model import BalanceRope, Mesh, Rope, RopeSimulator, Scene, Solver, Swivel, balance_rope
from rope_model.simulation.ends.paths import EndMotion

H = 0.01
#: 30 m rope, 12 m of travel, in steps as long as the host's: a winding small enough for every test run
EVEN = Solver(tolerance=1e6)
SHORT = Scene(rope=Rope(length=30.0), mesh=Mesh(coarse_length=1.6, counts=(2, 4, 40, 4, 2)), solver=EVEN)
HIGH = 12.0


def ends_at(t: float) -> tuple[EndMotion, EndMotion]:
    return smooth_trip(t, 8.0, 5.0, HIGH)


def wind(scene: Scene = SHORT, steps: int = 550) -> BalanceRope:
    return wound(balance_rope(scene), ends_at, steps)


def test_tmn_agrees_with_a_fine_equal_length_mesh_through_the_winding() -> None:
    fine = SHORT.with_(mesh=Mesh(kind="eem", elements=120))
    names = ("left.fy", "right.fy", "loop.x", "loop.y", "loop.z", "count.transformations")
    ours, reference = (recorded(balance_rope(scene), ends_at, 600, names) for scene in (SHORT, fine))
    force, loop = (ours - reference)[:, :2], (ours - reference)[:, 2:5]
    # measured 0.008 % of the largest force and 1.1 mm; the acceptance is 0.5 % and 1 cm
    assert np.sqrt(np.mean(force**2)) < 0.0003 * np.abs(reference[:, :2]).max()
    assert np.abs(loop).max() < 0.004
    assert ours[-1, 5] >= 3


def test_transformation_happens_each_coarse_length_of_travel_and_on_the_way_back_and_changes_little_energy() -> None:
    rope = wind(steps=0)
    instants, counts, changes, kinetic = [], [rope.state.partition.counts], [], 0.0
    there = 500
    for k in range(2 * there):
        t = (k + 1) * H
        ends = ends_at(t) if k < there else smooth_trip(t - there * H, -8.0, 5.0, HIGH - 8.0)
        assert rope.advance_to(t, replace(ends[0], y=ends[0].y + 8.0 * (k >= there)), ends[1]).valid
        events = [event for event in rope.state.events if event.what == "transformation"]
        instants += [event.t for event in events]
        counts += [rope.state.partition.counts] * len(events)
        changes += [(event.kinetic, event.potential) for event in events]
        kinetic = max(kinetic, rope.state.energy_balance.kinetic)
    assert {sum(c) for c in counts} == {sum(counts[0])}
    assert {c[1:6] for c in counts} == {counts[0][1:6]}
    travelled = [ends_at(t)[0].y for t in instants if t < there * H]
    # at the end of the step in which it is due
    late = np.array(travelled) - (travelled[0] + rope.state.partition.coarse * np.arange(len(travelled)))
    assert np.ptp(late) < 1.05 * max(ends_at(t)[0].vy for t in instants) * H
    assert_allclose(np.round(np.array(instants) / H) * H, instants, rtol=0, atol=1e-9)
    back = sum(t > there * H for t in instants)
    assert back >= len(travelled) - 1
    # energy of about 500 J of kinetic energy, and of the work of one step
    assert np.abs(changes).max(axis=0)[0] < 1e-5 * kinetic
    assert np.abs(changes).max(axis=0)[1] < 0.05


def test_energy_balance_closes_at_second_order_in_the_step() -> None:
    residuals = []
    for step in (0.01, 0.005):
        scene = SHORT.with_(mesh=Mesh(kind="eem", elements=62), solver=replace(EVEN, step_max=step))
        rope = wind(scene)
        residuals.append(abs(rope.state.energy_balance.residual))
    assert residuals[0] < 0.01 * rope.state.energy_balance.dissipated_material
    assert residuals[1] < 0.35 * residuals[0]


def test_work_of_nonconservative_coupling_is_counted_and_the_energy_balance_closes() -> None:
    rope = wind(SHORT.with_(rope=replace(SHORT.rope, Qb=2.371e5, Qc=2.301e5)))
    assert rope.state.energy_balance.nonconservative != 0.0
    assert abs(rope.state.energy_balance.residual) < 0.2


def test_work_is_bounded() -> None:
    counts = wind().state.counts
    # one step of the host is one step of the rope but for transformations, and Newton needs two corrections
    assert counts.steps <= 550 + 2 * counts.transformations
    assert counts.newton <= 2 * counts.steps
    assert counts.rejections <= 0.02 * counts.steps


@pytest.mark.parametrize(("EI", "height"), [(300.0, 116.0), (1e4, 108.0)])
def test_a_loop_near_an_end_hangs_on_the_fitted_mesh_as_on_short_equal_elements(EI: float, height: float) -> None:
    scene, found = Scene(rope=Rope(EI=EI)), []
    for mesh in (scene.mesh, Mesh("eem", elements=480)):
        found.append(hung(RopeSimulator(scene.with_(mesh=mesh)), right=EndMotion(y=height)).signals())
    # what is asked of the loop, to which the mesh is fitted, and of the end forces over the rope's weight
    assert_allclose(found[0]["loop.y"], found[1]["loop.y"], rtol=0, atol=scene.accuracy.loop)
    weight = scene.rope.mass_per_length * 9.81 * scene.rope.length
    assert_allclose(found[0]["left.fy"], found[1]["left.fy"], rtol=0, atol=scene.accuracy.end_force * weight)


@pytest.mark.parametrize("EI", [3e4, 1e5, 1e6])
def test_a_stiff_rope_hangs_without_being_told_how(EI: float) -> None:
    for height in (0.0, 60.0, 91.0):  # down to 0.12 of its length from an end
        hung(RopeSimulator(Scene(rope=Rope(EI=EI))), right=EndMotion(y=height))


def test_swivel_without_any_friction_turns_freely_and_does_not_chatter() -> None:
    ideal = Swivel(mode="coulomb", mu_static=0.0, mu_kinetic=0.0)
    rope = wind(SHORT.with_(rope=replace(SHORT.rope, Qb=0.0, Qc=0.0), left=ideal, right=ideal), 20)
    assert rope.state.counts.steps <= 22
    assert rope.state.counts.swivel_events == 0
