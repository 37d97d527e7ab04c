"""The loop turned about the vertical by a full turn; the frame that does not survive 90 degrees is in the suite."""

from __future__ import annotations

import math

from numpy.testing import assert_allclose

from evidence.stability.frames import TURNED, turn_through
from rope_model.parameters import Mesh, Rope, Scene
from rope_model.simulation.ends import EndMotion
from rope_model.simulation.modal import natural_modes
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.statics import find_equilibrium


def test_loop_yaws_through_90_degrees_and_on_to_a_full_turn() -> None:
    rope, stopped = turn_through(TURNED, 2 * math.pi, 20.0)
    assert stopped == ""
    assert rope.state.loop_yaw > 1.5 * math.pi
    # the ends are back where they were, and so are shape and torque at rest: theta counts on as the frame is carried
    # along.  What is left is the quadrature of the frame's turn, on elements of 0.75 m
    first = RopeSimulator(TURNED)
    assert first.initialize(0.0, EndMotion(), EndMotion()).valid
    motion = rope.state.motion
    rest = find_equilibrium(rope.system, motion.q, motion.t)
    before = first.ends.moment(0, first.state.motion.reaction)
    assert_allclose(rope.ends.moment(0, rest.reaction), before, rtol=1e-4)
    assert_allclose(rest.q[:, :3], first.state.motion.q[:, :3], rtol=0, atol=1e-6)


def test_installed_twist_turns_the_loop_over_on_any_mesh() -> None:
    yaws = []
    for mesh in (Mesh("auto"), Mesh(coarse_length=1.0)):
        rope = RopeSimulator(Scene(rope=Rope(length=60.0, installed_twist=7.0), mesh=mesh))
        assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
        assert natural_modes(rope.system, rope.state.motion.q, 2).frequencies[0] > 0  # stable, or it raises
        yaws.append(rope.state.loop_yaw)
    assert min(yaws) > math.pi  # past the plane again, legs crossed
    assert_allclose(yaws[0], yaws[1], rtol=1e-3)  # the coarser mesh is made for 5 mm of 1 m
