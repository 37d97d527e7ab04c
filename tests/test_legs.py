"""Joined elements of the legs on a long trip, where what transformations do to the loop adds up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.kinematic import ends_at, scene_of, wind
from benchmarks.legs import Case, apart, meshes, wind_uncoupled
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model.numerics.kernels import find_compiler
from rope_model.parameters import Mesh
from rope_model.simulation.mesh import fit_mesh
from rope_model.simulation.simulator import RopeSimulator


def rms(x: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(x**2)))


@pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")
@pytest.mark.parametrize("travel", [100.0, pytest.param(400.0, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_joined_elements_of_a_deep_shaft_move_the_loop_by_less_than_the_mesh_may_err(travel: float) -> None:
    scene = scene_of("monopol-1000", "uncoupled")
    asked = 5e-3
    auto = fit_mesh(scene.with_(mesh=Mesh("auto", loop_error=asked)))
    assert auto.grading_length > 0
    trip = Winding(travel=travel, speed=8.0)
    places = []
    for mesh in (auto, replace(auto, grading_length=0.0)):
        run = wind(scene.with_(mesh=mesh), s_curve(trip), trip.travel, settle=0.0, sample=25)
        assert run.status.valid, run.status.message
        places.append(np.array(run.bottom))
    assert np.linalg.norm(places[0] - places[1], axis=1).max() < 0.5 * asked


@pytest.mark.slow
@pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")
def test_joined_elements_follow_an_emergency_stop_as_well_as_the_steps_do() -> None:
    case = Case("monopol-1000", Winding(travel=900.0, speed=16.0, emergency_at=40.0))
    auto = meshes(case, 5e-3)[0]
    plain = wind_uncoupled(case, replace(auto, grading_length=0.0))
    by_the_legs, by_the_steps = (
        apart(wind_uncoupled(case, auto), plain),
        apart(wind_uncoupled(case, auto, 2.5e-3), wind_uncoupled(case, auto)),
    )
    assert 1e-4 < by_the_legs < by_the_steps < 0.05


@pytest.mark.slow
def test_steps_cut_at_transformations_err_several_times_more_than_meshes_that_wait(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = scene_of("rope-120", "uncoupled")
    reference, h, steps = s_curve(Winding(travel=26.0, speed=6.0, start_delay=0.0)), 0.01, 700

    def forces(mesh: Mesh) -> NDArray[np.float64]:
        rope = RopeSimulator(scene.with_(mesh=mesh))
        assert rope.initialize(0.0, *ends_at(reference, 26.0, 0.0)).valid
        found = []
        for k in range(1, steps + 1):
            assert rope.advance_to(k * h, *ends_at(reference, 26.0, k * h)).valid
            found.append(rope.state.motion.reaction[[0, -1], 1])
        assert mesh.kind == "eem" or rope.state.counts.transformations > 5
        return np.array(found)

    exact = forces(Mesh("eem", elements=240))
    waiting = rms(forces(Mesh("auto")) - exact)
    monkeypatch.setattr("rope_model.simulation.stepping.LATEST", 0.0)
    assert rms(forces(Mesh("auto")) - exact) > 3 * waiting
