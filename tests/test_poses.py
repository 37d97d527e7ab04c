"""Ropes in any pose find their rest: the one that slow turning leads to, and stable."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose
from random_poses import KINDS, NO_REASON, Pose, hang, poses

from rope_model import BalanceRope, EndMotion, RopeSimulator, balance_rope, rope_120
from rope_model.public import Form
from rope_model.simulation.outputs.modal import natural_modes

SEED = 7
DRAWN, QUICK = list(poses(SEED, 5 * len(KINDS))), len(KINDS)


@pytest.mark.parametrize(
    "pose",
    [
        pytest.param(pose, marks=[pytest.mark.slow] if k >= QUICK else [], id=f"{k}, {pose.kind}")
        for k, pose in enumerate(DRAWN)
    ],
)
def test_every_pose_finds_rest_or_is_refused_for_a_reason(pose: Pose) -> None:
    rest = hang(pose)
    assert NO_REASON not in rest.refusal
    # rounding of the height L in the strain of the shortest elements, l = .1 m: eps Qa L / l is 4.5e-9 of the weight
    # where Qa per mass is largest
    assert rest.weight_error < 1e-8


#: of 118 m, soft against twist: past 6.46875 rad, and again past 17.7 rad, nothing is left of the way it was on
SOFT = replace(rope_120().scene.rope, length=118.0, Qd=2000.0, Qb=2.0e5, Qc=1.6e5)


def at_rest(form: Form, twist: float) -> BalanceRope:
    rope = balance_rope(rope_120().scene.with_(rope=replace(SOFT, installed_twist=twist)), form)
    assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
    return rope


@pytest.mark.parametrize("twist", [5.0, pytest.param(7.0, marks=pytest.mark.slow)])
def test_the_rest_of_a_twisted_rope_is_stable_and_does_not_depend_on_the_step(
    twist: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rope = at_rest("auto", twist)
    monkeypatch.setattr("rope_model.simulation.stepping.hang.TWIST_STEP", 0.5)
    half = at_rest("python", twist)
    assert isinstance(half, RopeSimulator)
    assert natural_modes(half.system, half.state.motion.q, 1).frequencies[0] > 0  # stable, or it raises
    # convergence at 1e-11 of the length, times what the softest mode makes of it
    assert_allclose(half.state.loop_yaw, rope.state.loop_yaw, rtol=0, atol=1e-5)
    assert (rope.state.snapped_at != 0) == (twist > 6.5)


def test_a_rope_that_snapped_over_says_so_while_it_rests() -> None:
    assert "other_rests" not in at_rest("auto", 6.0).warnings()
    assert "snapped over at 6.47 rad" in at_rest("auto", 7.0).warnings()["other_rests"]


@pytest.mark.parametrize("unequal", [-0.6, 0.4, 0.8])
def test_any_difference_of_Qb_and_Qc_finds_rest(unequal: float) -> None:
    data = rope_120().scene.rope
    rope = balance_rope(
        rope_120().scene.with_(rope=replace(data, Qb=(1 + unequal) * data.Qs, Qc=(1 - unequal) * data.Qs))
    )
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    assert status.valid, status.message
