"""Joined elements of the legs on a long trip, where what transformations do to the loop adds up."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scenes import ends_at, fixed_steps, recorded

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.parameters import Winding
from rope_model import Mesh, Model, RopeSimulator, Scene, Swivel, balance_rope
from rope_model.numerics.kernels import find_compiler
from rope_model.simulation.mesh.partition import fit_mesh

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")]


def uncoupled(name: str) -> Scene:
    scene = rope_data(find_case(name).rope)
    locked, rope = Swivel(mode="locked"), replace(scene.rope, Qb=0.0, Qc=0.0)
    return scene.with_(rope=rope, left=locked, right=locked, solver=fixed_steps(0.01), model=Model("planar"))


@pytest.mark.parametrize("travel", [100.0, 400.0])
def test_joined_elements_of_a_deep_shaft_move_the_loop_by_less_than_the_mesh_may_err(travel: float) -> None:
    scene, asked, reference = uncoupled("monopol-1000"), 5e-3, s_curve(Winding(travel=travel, speed=8.0))
    auto = fit_mesh(scene.with_(mesh=Mesh("auto", loop_error=asked)))
    assert auto.grading_length > 0
    ropes = [balance_rope(scene.with_(mesh=mesh)) for mesh in (auto, replace(auto, grading_length=0.0))]
    motion, steps = partial(ends_at, reference, travel), round(reference.duration / 0.01)
    one, other = (recorded(rope, motion, steps, ("loop.x", "loop.y", "loop.z")) for rope in ropes)
    assert np.linalg.norm(one - other, axis=1)[24::25].max() < 0.5 * asked


def test_steps_cut_at_transformations_err_much_more_than_meshes_that_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, trip = uncoupled("rope-120"), Winding(travel=26.0, speed=6.0, start_delay=0.0)

    def forces(mesh: Mesh) -> np.ndarray:
        motion = partial(ends_at, s_curve(trip), trip.travel)
        return recorded(RopeSimulator(scene.with_(mesh=mesh)), motion, 700, ("left.fy", "right.fy"))

    exact = forces(Mesh("eem", elements=240))
    waiting = np.linalg.norm(forces(Mesh("auto")) - exact)
    monkeypatch.setattr("rope_model.simulation.stepping.stepping.LATEST", 0.0)
    assert np.linalg.norm(forces(Mesh("auto")) - exact) > 3 * waiting
