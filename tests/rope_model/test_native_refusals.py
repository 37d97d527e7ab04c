"""The rope refuses what it cannot do, in a sentence, and keeps its state."""

import math
import re
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from scenes import hung

from rope_model import (
    Contact,
    EndMotion,
    Layout,
    Lining,
    Mesh,
    Model,
    PointForces,
    Rope,
    Scene,
    Shaft,
    Solver,
)
from rope_model.engine import NativeRope


@pytest.mark.parametrize(
    ("scene", "left", "words"),
    [
        (Scene(), EndMotion(vy=1.0), "moves at the start"),
        (Scene(), EndMotion(y=math.nan), "left.y = nan is not finite"),
        (Scene(), EndMotion(y=200.0), "cannot hang"),
        (Scene(model=Model("planar")), EndMotion(z=0.1), "z = 0.1"),
        (Scene(), EndMotion(x=2.0, y=1.5), "exactly above each other, 1.5 m apart"),
    ],
)
def test_a_start_that_fails_says_why(scene: Scene, left: EndMotion, words: str) -> None:
    status = NativeRope(scene).initialize(0.0, left, EndMotion())
    assert not status.valid
    assert words in status.message


def test_an_advance_that_takes_too_many_steps_is_refused() -> None:
    """At once when step_max alone tells; else when as many steps are done."""
    rope = hung(
        NativeRope(Scene(rope=Rope(length=60.0), solver=Solver(step_min=1e-12, tolerance=1e-14)))
    )
    assert (
        "more than 20000 steps of step_max = 0.02 s; communicate every 400 s"
        in rope.advance_to(1e6, EndMotion(), EndMotion()).message
    )
    moved = EndMotion(y=0.02, vy=0.2, ay=1.0), EndMotion()
    assert (
        "20000 steps did not lead from t = 0 s to 0.2 s; communicate more often"
        in rope.advance_to(0.2, *moved).message
    )
    assert rope.state.motion.t == 0.0


#: after the step, or longer before it than a sample may be held; rounding is none
ANOTHER_TIME = (math.nan, -math.inf, math.inf, -1.01, 0.0200001)
LATE = "the ends' motions are of t = {:.9g} s: they must be of -1 s (inputs.hold_max before the step) to 0.02 s"


@pytest.mark.parametrize(
    ("left", "given_at", "words"),
    [
        (EndMotion(y=-0.01, vy=-1.0, ay=-50.0), 0.02, "local error"),
        (EndMotion(y=5.0), 0.02, "inputs.misfit_max"),
        (EndMotion(vx=math.inf), 0.02, "not finite"),
        *((EndMotion(), t, LATE.format(t)) for t in ANOTHER_TIME),
    ],
)
def test_a_step_that_fails_says_why_and_leaves_the_state(
    left: EndMotion, given_at: float, words: str
) -> None:
    rope = hung(
        NativeRope(Scene(rope=Rope(length=60.0), solver=Solver(step_min=5e-3, tolerance=1e-2)))
    )
    before = rope.state.motion.q.tobytes()
    status = rope.advance_to(0.02, left, EndMotion(), given_at)
    assert not status.valid
    assert words in status.message
    assert rope.state.motion.q.tobytes() == before
    for fits in (-1.0, math.nextafter(0.02, 1.0)):
        assert rope.advance_to(0.02, EndMotion(), EndMotion(), fits).valid


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (
            Scene(mesh=Mesh("tmn", counts=(2, 4, 80000, 4, 2), coarse_length=0.01)),
            "counts make 82012 elements, more",
        ),
        (
            Scene(mesh=Mesh("tmn", counts=(2, 4, 160000, 4, 2), coarse_length=0.01)),
            "leave nothing for I and VII",
        ),
        (
            Scene(layout=Layout(gravity=1e6), rope=Rope(EI=1e-6)),
            "mesh.kind = auto takes them from EI",
        ),
    ],
)
def test_a_mesh_of_too_many_elements_is_refused(scene: Scene, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        NativeRope(scene)


def test_native_rope_refuses_a_state_that_is_none_of_its_own() -> None:
    rope = hung(NativeRope(Scene(rope=Rope(length=60.0))))
    state = rope.state
    cells = state.partition
    for wrong in (
        state._replace(last_interval=0.0),
        state._replace(step_next=math.nan),
        state._replace(motion=replace(state.motion, t=5.0)),
        state._replace(partition=replace(cells, coarse=1e-300)),
        *(
            state._replace(partition=replace(cells, lengths=x * cells.lengths))
            for x in (1.0 + 1e-6, -1.0, math.nan)
        ),
        state._replace(partition=replace(cells, counts=(1, *cells.counts[1:6], 10**6))),
        state._replace(counts=state.counts._replace(steps=2**62)),
    ):
        with pytest.raises(ValueError, match="not a state of this rope"):
            rope.restore(wrong)
    rope.restore(state)
    assert rope.advance_to(0.01, EndMotion(), EndMotion()).valid
    for scene in (
        Scene(rope=Rope(length=59.99)),
        Scene(rope=Rope(length=60.0), model=Model("rigid")),
    ):
        other = hung(NativeRope(scene))
        with pytest.raises(ValueError, match="not a state of this rope"):
            other.restore(state)


def test_a_refused_state_changes_nothing_and_there_is_none_before_the_start() -> None:
    scene = Scene(rope=Rope(length=60.0))
    rope = NativeRope(scene)
    other = NativeRope(scene.with_(model=Model("planar")))
    still = EndMotion(), EndMotion()
    for call in (
        lambda: rope.state,
        rope.save,
        rope.native_state,
        lambda: rope.advance_to(1.0, *still),
    ):
        with pytest.raises(RuntimeError, match="no state yet"):
            call()
    for r in (rope, other):
        hung(r, right=EndMotion(y=10.0))
    before = other.native_state()
    with pytest.raises(ValueError, match="not a state"):
        other.restore(rope.state._replace(step_next=math.nan))
    assert other.native_state() == before
    assert other.state.fidelity == "planar"


@pytest.mark.parametrize("fidelity", ["rigid", "auto"])
def test_a_rigid_rope_has_no_displacement_by_forces(fidelity: Literal["rigid", "auto"]) -> None:
    """Neither where the model is rigid by choice, nor where 'auto' takes it."""
    rope = hung(NativeRope(Scene(Rope(length=40.0, Qb=0.0, Qc=0.0), model=Model(fidelity, 1.0))))
    assert rope.fidelity == "rigid"
    push = np.ones((1, 3))
    with pytest.raises(ValueError, match=r"forces do not move .* rigid model; set model\.fidelity"):
        rope.displacement(PointForces(np.array([10.0]), push, push, 0.0, 1.0))


@pytest.mark.slow
def test_a_rope_that_is_turned_in_for_too_long_is_refused() -> None:
    rope = Rope(length=11.0, EI=88.0, installed_twist=99.0)
    shaft = Shaft(lining=Lining(width=2.4, depth=0.08))
    said = (
        NativeRope(Scene(rope, shaft=shaft)).initialize(0.0, EndMotion(), EndMotion(y=1.0)).message
    )
    assert re.match(
        r"at \S+ of 99 rad of twist \(last increment \S+ rad, \d+ iterations in all\): no equil",
        said,
    )


@pytest.mark.parametrize("kind", ["tmn", "eem"])
def test_an_accuracy_that_a_kind_of_mesh_does_not_read_is_refused(
    kind: Literal["tmn", "eem"],
) -> None:
    with pytest.raises(
        ValueError, match=r"loop_error = 0\.01 .* unless mesh\.kind = auto; .* set kind = auto"
    ):
        Mesh(kind, loop_error=0.01)


@pytest.mark.slow
def test_a_long_rope_that_goes_on_winding_about_itself_is_refused_with_the_cure() -> None:
    """Without contact of the rope with itself it hangs."""
    rope = Rope(
        length=900.0,
        mass_per_length=4.67,
        Qa=5e7,
        Qb=-1.83e5,
        Qc=-1.83e5,
        Qd=1380.0,
        EI=364.0,
        EI_stick=1557.0,
        slip_moment=9.2,
        diameter=0.0356,
    )
    scene = Scene(rope, Layout(spacing=2.0), shaft=Shaft(contact=Contact(rope_stiffness=4.6e6)))
    said = NativeRope(scene).initialize(0.0, EndMotion(), EndMotion()).message
    assert "winding about itself" in said
    assert "contact.rope_stiffness = 0" in said
    assert hung(NativeRope(scene.with_(shaft=Shaft()))).state.motion.t == 0.0
