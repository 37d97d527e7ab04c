"""The loop turned about the vertical by a full turn; the frame that does not survive 90 degrees is in the suite."""

import math
from dataclasses import replace

import pytest
from numpy.testing import assert_allclose
from scenes import fixed_steps, turn, wound

from rope_model import balance_rope
from rope_model.parameters import Mesh, Rope, Scene, rope_120
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.outputs.modal import natural_modes
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.stepping.statics import find_equilibrium

SCENE = Scene(
    rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=40), solver=replace(fixed_steps(0.02), kernels="portable")
)
STILL = dict.fromkeys(("vx", "vy", "vz", "ax", "ay", "az", "yaw_rate"), 0.0)


def test_loop_yaws_through_90_degrees_and_on_to_a_full_turn() -> None:
    rope = RopeSimulator(SCENE)
    rope.restore(wound(balance_rope(SCENE, "native"), lambda t: turn(2 * math.pi, 20.0, t), 1000, 0.02).state)
    assert rope.state.loop_yaw > 1.5 * math.pi
    # the ends are back where they were, and so are shape and torque at rest: theta counts on as the frame is carried
    # along.  What is left is the quadrature of the frame's turn, on elements of 0.75 m
    first = RopeSimulator(SCENE)
    assert first.initialize(0.0, EndMotion(), EndMotion()).valid
    motion = rope.state.motion
    rest = find_equilibrium(rope.system, motion.q, motion.t)
    before = first.ends.moment(0, first.state.motion.reaction)
    assert_allclose(rope.ends.moment(0, rest.reaction), before, rtol=1e-4)
    assert_allclose(rest.q[:, :3], first.state.motion.q[:, :3], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_installed_twist_turns_the_loop_over_on_any_mesh() -> None:
    yaws = []
    for mesh in (Mesh("auto"), Mesh(coarse_length=1.0)):
        rope = RopeSimulator(Scene(rope=Rope(length=60.0, installed_twist=7.0), mesh=mesh))
        assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
        assert natural_modes(rope.system, rope.state.motion.q, 2).frequencies[0] > 0  # stable, or it raises
        yaws.append(rope.state.loop_yaw)
    assert min(yaws) > math.pi  # past the plane again, legs crossed
    assert_allclose(yaws[0], yaws[1], rtol=1e-3)  # the coarser mesh is made for 5 mm of 1 m


@pytest.mark.parametrize("angle", [1.0, 0.5 * math.pi, math.pi])
def test_rope_hung_between_ends_turned_as_a_whole_is_the_same_rope(angle: float) -> None:
    loads = [at_rest(*turn(angle if x else 0.0, 1.0, 1.0)) for x in (0, 1)]
    c, s = math.cos(angle), math.sin(angle)
    for side in ("left", "right"):
        for kind in "fm":
            x, y, z = (loads[0][f"{side}.{kind}{axis}"] for axis in "xyz")
            there = [loads[1][f"{side}.{kind}{axis}"] for axis in "xyz"]
            # a residual of 1e-6 N is left at the nodes
            assert_allclose(there, [c * x + s * z, y, c * z - s * x], rtol=0, atol=1e-5)


def test_moments_on_a_rope_at_rest_balance_about_the_vertical() -> None:
    loads, spacing = at_rest(EndMotion(y=30.0), EndMotion(yaw=1.5)), rope_120().scene.layout.spacing
    assert abs(loads["right.my"]) > 10.0
    # the forces out of plane act at both ends, half the spacing to either side
    about_y = loads["left.my"] + loads["right.my"] + 0.5 * spacing * (loads["left.fz"] - loads["right.fz"])
    assert_allclose(about_y, 0.0, atol=1e-5)


def test_turns_put_in_at_once_turn_the_loop_and_leave_the_torque() -> None:
    # four turns of one end are two of the loop, by which the rope gets rid of the twist
    loads, turned_in = at_rest(EndMotion(), EndMotion()), at_rest(EndMotion(), EndMotion(yaw=8 * math.pi))
    assert_allclose(turned_in["loop.yaw"] - loads["loop.yaw"], 4 * math.pi, rtol=1e-6)
    assert_allclose(turned_in["left.my"], loads["left.my"], rtol=1e-4)


def at_rest(left: EndMotion, right: EndMotion) -> dict[str, float]:
    rope = balance_rope(rope_120().scene)
    status = rope.initialize(0.0, replace(left, **STILL), replace(right, **STILL))
    assert status.valid, status.message
    return rope.signals()
