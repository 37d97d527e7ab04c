"""Joined elements of the legs on a long trip, where what transformations do to the loop adds up."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import ends_at, fixed_steps

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.parameters import Winding
from rope_model import BalanceRope, Mesh, Model, RopeSimulator, Scene, Swivel, balance_rope
from rope_model.numerics.kernels import find_compiler
from rope_model.simulation.mesh.partition import fit_mesh

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")]


def uncoupled(name: str) -> Scene:
    scene = rope_data(find_case(name).rope)
    locked, rope = Swivel(mode="locked"), replace(scene.rope, Qb=0.0, Qc=0.0)
    return scene.with_(rope=rope, left=locked, right=locked, solver=fixed_steps(0.01), model=Model("planar"))


def followed(rope: BalanceRope, trip: Winding, steps: int, every: int) -> np.ndarray:
    reference, found = s_curve(trip), []
    assert rope.initialize(0.0, *ends_at(reference, trip.travel, 0.0)).valid
    for k in range(1, steps + 1):
        assert rope.advance_to(0.01 * k, *ends_at(reference, trip.travel, 0.01 * k)).valid
        if k % every == 0:
            found.append([*rope.signals(("left.fy", "right.fy", "loop.x", "loop.y", "loop.z")).values()])
    return np.array(found)


@pytest.mark.parametrize("travel", [100.0, 400.0])
def test_joined_elements_of_a_deep_shaft_move_the_loop_by_less_than_the_mesh_may_err(travel: float) -> None:
    scene, asked, trip = uncoupled("monopol-1000"), 5e-3, Winding(travel=travel, speed=8.0)
    auto = fit_mesh(scene.with_(mesh=Mesh("auto", loop_error=asked)))
    assert auto.grading_length > 0
    meshes, steps = (auto, replace(auto, grading_length=0.0)), round(s_curve(trip).duration / 0.01)
    one, other = (followed(balance_rope(scene.with_(mesh=mesh)), trip, steps, 25)[:, 2:] for mesh in meshes)
    assert np.linalg.norm(one - other, axis=1).max() < 0.5 * asked


def test_steps_cut_at_transformations_err_much_more_than_meshes_that_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, trip = uncoupled("rope-120"), Winding(travel=26.0, speed=6.0, start_delay=0.0)

    def forces(mesh: Mesh) -> np.ndarray:
        return followed(RopeSimulator(scene.with_(mesh=mesh)), trip, 700, 1)[:, :2]

    exact = forces(Mesh("eem", elements=240))
    waiting = np.linalg.norm(forces(Mesh("auto")) - exact)
    monkeypatch.setattr("rope_model.simulation.stepping.stepping.LATEST", 0.0)
    assert np.linalg.norm(forces(Mesh("auto")) - exact) > 3 * waiting
