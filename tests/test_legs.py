"""Joined elements of the legs on a long trip, where what transformations do to the loop adds up."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.chart.depth import scene_of
from benchmarks.kinematic import wind
from hoist_demo.parameters import Winding
from hoist_demo.reference import s_curve
from rope_model.numerics.kernels import find_compiler
from rope_model.parameters import Mesh
from rope_model.simulation.mesh import suited


@pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")
def test_joined_elements_of_a_deep_shaft_move_the_loop_by_less_than_the_mesh_may_err() -> None:
    scene = scene_of("monopol-1000", "uncoupled")
    auto = suited(Mesh("auto"), scene.rope, scene.layout)
    assert auto.leg_levels > 0
    trip = Winding(travel=400.0, speed=8.0)
    places = []
    for levels in (auto.leg_levels, 0):
        mesh = Mesh("tmn", coarse_length=auto.coarse_length, counts=auto.counts, end_levels=auto.end_levels)
        run = wind(
            scene.with_(mesh=mesh if levels == 0 else auto), s_curve(trip), trip.travel, settle=0.0, interval=0.01
        )
        assert run.status.valid, run.status.message
        places.append(np.array(run.bottom))
    assert np.linalg.norm(places[0] - places[1], axis=1).max() < 0.5 * auto.loop_error
