"""The rope in Exudyn is the rope here; skipped where Exudyn is not installed (``pip install balance-rope[peer]``)."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("exudyn")

from evidence.peer.exudyn_rope import Method, PeerRope
from evidence.peer.runs import REFERENCE, TRAVEL, UNCOUPLED, hanging_shape
from rope_model.parameters import Mesh
from rope_model.simulation.outputs.diagnostics import loop_bottom
from rope_model.simulation.outputs.modal import natural_modes
from rope_model.simulation.simulator import EndMotion, RopeSimulator

HEIGHTS = (80.0, 0.0)


@pytest.fixture(scope="module")
def theirs() -> PeerRope:
    rope = PeerRope(UNCOUPLED, "beam-quadratic", 120, hanging_shape(UNCOUPLED, HEIGHTS), HEIGHTS)
    rope.rest()
    return rope


@pytest.fixture(scope="module")
def ours() -> RopeSimulator:
    rope = RopeSimulator(UNCOUPLED.with_(mesh=Mesh("auto", loop_error=2e-4)))
    assert rope.initialize(0.0, EndMotion(y=HEIGHTS[0]), EndMotion(y=HEIGHTS[1])).valid
    return rope


def test_an_independent_code_hangs_the_loop_at_the_same_place(theirs: PeerRope, ours: RopeSimulator) -> None:
    q = theirs.configuration()
    # 1 m elements around a loop 3.4 m wide: some 0.1 mm
    np.testing.assert_allclose(loop_bottom(q, theirs.lengths).position[1], ours.loop.position[1], atol=1e-3)
    np.testing.assert_allclose(theirs.end_forces(), -ours.state.motion.reaction[[0, -1], 1], rtol=1e-5)


def test_an_independent_code_finds_the_same_in_plane_frequencies(theirs: PeerRope, ours: RopeSimulator) -> None:
    modes = natural_modes(ours.system, ours.state.motion.q, 10)
    # 0.2 % is asked for
    np.testing.assert_allclose(theirs.frequencies(4), modes.frequencies[modes.out_of_plane < 0.5][:4], rtol=2e-3)


def test_its_ends_follow_the_s_curve() -> None:
    heights = (0.0, TRAVEL)
    rope = PeerRope(UNCOUPLED, "beam", 60, hanging_shape(UNCOUPLED, heights), heights, REFERENCE)
    rope.rest()
    record = rope.run(4.0, 0.04, Method(0.02, "full"))
    climbed = REFERENCE.at(4.0).position
    assert climbed > 1.0
    np.testing.assert_allclose(record.q[-1, [0, -1], 1], [climbed, TRAVEL - climbed], atol=1e-9)
