"""The guards of the loop: what they see, when they trip, and that they change nothing."""

import pytest
from guard_scenes import SHORT, guarded
from numpy.testing import assert_allclose, assert_array_equal
from scenes import going_aside, hung, wound

from rope_model import (
    EndMotion,
    Guard,
    Mesh,
    Model,
    Rope,
    Scene,
    Shaft,
    Sump,
    balance_rope,
)
from rope_model.physics.guard import CAUSES, NEVER, GuardState, off_plumb, sideways, watch

LEFT = (-1.0, 20.0, 0.0)
RIGHT = (2.0, 10.0, 4.0)
NOTHING = dict.fromkeys(CAUSES, 0.0) | {"clearance": 1e6}


def test_distances_from_midway_and_from_plumb_are_exact() -> None:
    assert_allclose(sideways((0.5 + 0.3, -5.0, 2.0 - 0.4), LEFT, RIGHT), 0.5, rtol=1e-14)
    # at the height 0 the piece is at X = -0.7, Z = 0.4
    assert_allclose(off_plumb(0.0, (-1.6, -5.0, 0.1), (2.0, 15.0, 1.3), LEFT), 0.5, rtol=1e-14)


def after(guard: Guard, *looks: tuple[float, str, float]) -> GuardState:
    """What the guards remember after having seen, each time, one quantity of this size."""
    state = GuardState()
    for t, what, size in looks:
        state = watch(guard, state, t, tuple((NOTHING | {what: size}).values()))
    return state


@pytest.mark.parametrize("cause", CAUSES)
def test_a_guard_trips_beyond_its_threshold_and_no_other_does(cause: str) -> None:
    guard = Guard(**{cause: 1.0})
    inside = 1.0
    # a clearance trips below its threshold
    outside = dict.fromkeys(CAUSES, 1.01) | {"clearance": 0.99}
    far_outside = dict.fromkeys(CAUSES, 2.0) | {"clearance": 0.5}
    others = [(1.0, other, far_outside[other]) for other in CAUSES if other != cause]
    assert after(guard, (0.0, cause, inside), *others).cause == 0
    assert after(guard, (0.0, cause, inside), (3.0, cause, outside[cause]))[1:3] == (
        CAUSES.index(cause) + 1,
        3.0,
    )


def test_a_guard_waits_for_its_delay_without_a_break() -> None:
    guard = Guard(rise=1.0, rise_delay=0.5)
    broken = (0.0, "rise", 2.0), (0.4, "rise", 1.0), (0.6, "rise", 2.0), (1.0, "rise", 2.0)
    assert after(guard, *broken).cause == 0
    assert after(guard, *broken, (1.1, "rise", 2.0), (1.2, "rise", 2.0))[1:3] == (1.0, 1.1)


def test_the_first_cause_stays() -> None:
    tripped = after(
        Guard(rise=1.0, torque=10.0), (1.0, "torque", 11.0), (2.0, "rise", 2.0), (3.0, "rise", 0.0)
    )
    assert tripped[1:3] == (5.0, 1.0)
    assert tripped.since == (NEVER,) * 5


def test_the_rise_is_nothing_wherever_the_ends_are_at_rest() -> None:
    soft = Scene(Rope(length=60.0, Qa=2e5, Qb=0.0, Qc=0.0, EI=20.0), mesh=Mesh("eem", elements=120))
    rope = balance_rope(soft)
    rests = []
    for left, right in ((0.0, 0.0), (10.0, 30.0), (0.0, 40.0)):
        assert (
            hung(rope, EndMotion(y=left), EndMotion(y=right)).signals(["loop.rise"])["loop.rise"]
            == 0.0
        )
        rests.append(rope.state.guard.rest)
    # the legs stretch by 0.18 m and by 0.45 m in sum; their longer loop, and the bend at the ends,
    # are left out
    assert_allclose(rests, rests[0], atol=0.01)


def test_each_guard_trips_for_its_cause() -> None:
    cases = {
        "window": Guard(window=0.01, window_delay=0.05),
        "clearance": Guard(clearance=1.0, rise=5.0),
    }
    cases |= {"rise": Guard(rise=0.5, rise_y=-14.0), "torque": Guard(torque=0.3)}
    cases |= {"turns": Guard(turns=1e-4, turns_delay=0.1)}
    for cause, guard in cases.items():
        scene = guarded(guard, SHORT.with_(shaft=Shaft(sump=Sump(-11.9))))
        seen = wound(balance_rope(scene), going_aside, 30).state.guard
        assert seen.cause == CAUSES.index(cause) + 1
        assert 0.0 <= seen.time < 0.31


EACH = {
    "rise": Guard(rise=0.5),
    "switched rise": Guard(rise=0.5, rise_y=-14.0),
    "window": Guard(window=0.5, window_y=-6.0),
    "clearance": Guard(clearance=1.0),
    "turns": Guard(turns=0.25),
    "torque": Guard(torque=500.0),
}


@pytest.mark.parametrize(
    ("fidelity", "blind"),
    [
        ("auto", ()),
        ("torsional", ()),
        ("spatial", ("torque",)),
        ("planar", ("turns", "torque")),
        ("rigid", ("rise", "window", "turns", "torque")),
    ],
)
def test_a_guard_that_the_model_leaves_nothing_to_see_is_named_at_the_start(fidelity, blind):
    told = {}
    for name, guard in EACH.items():
        rope = hung(
            balance_rope(guarded(guard).with_(model=Model(fidelity))), right=EndMotion(y=6.0)
        )
        told[name] = rope.warnings().get("blind_guards", "")
    assert tuple(name for name, text in told.items() if text) == blind
    for name in blind:
        assert told[name].startswith(f"guard.{name} = {getattr(EACH[name], name):g} ")
        assert f"the {fidelity} model" in told[name]
        assert "set model.fidelity = auto" in told[name]


def test_guards_change_nothing_in_the_motion() -> None:
    scenes = guarded(Guard(torque=1e-3, rise=1e-6)), SHORT
    watched, alone = (wound(balance_rope(scene, "native"), going_aside, 30) for scene in scenes)
    assert watched.signals(["guard.tripped"]) == {"guard.tripped": 1.0}
    assert alone.signals(["guard.tripped"]) == {"guard.tripped": 0.0}
    assert_array_equal(watched.state.motion.q, alone.state.motion.q)
