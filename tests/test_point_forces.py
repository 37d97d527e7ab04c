"""Forces that a host puts on places of the rope: what they do, in both forms."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import hung

from rope_model import BalanceRope, EndMotion, Layout, Mesh, Model, PointForces, Rope, Scene, Solver, balance_rope

LENGTH, STEP, FORMS = 6.0, 0.01, ("python", "native")


def short_rope(form: Any, **parts: Any) -> BalanceRope:
    solver = Solver(step_max=STEP, tolerance=1e3)
    scene = Scene(Rope(length=LENGTH, EI=100.0), Layout(0.6), mesh=Mesh("eem", elements=10), solver=solver)
    return hung(balance_rope(scene.with_(**parts), form))


def pushing(t: float, h: float) -> PointForces:
    s = np.array([1.0, 1.3, 3.0, 4.7])
    way = np.array([[0.0, 0.0, 9.0], [3.0, 1.0, 2.0], [0.0, 20.0, 5.0], [-4.0, 0.0, 6.0]])
    return PointForces(s, way * math.sin(3.0 * t), way * math.sin(3.0 * (t + h)), t, t + h)


def push(rope: BalanceRope, steps: int, start: int = 0) -> BalanceRope:
    for k in range(start, start + steps):
        rope.apply(pushing(k * STEP, STEP))
        assert rope.advance_to((k + 1) * STEP, EndMotion(), EndMotion()).valid
    return rope


def test_a_rope_at_rest_under_a_force_pulls_with_it_at_its_ends() -> None:
    rope, force = short_rope("native"), np.array([[2.0, -30.0, 4.0]])
    before = rope.signals(["left.fx", "right.fx", "left.fy", "right.fy", "left.fz", "right.fz"])
    ramp, held = PointForces(np.array([2.0]), 0 * force, force, 0.0, 2.0), None
    rope.apply(ramp)
    for k in range(1500):
        assert rope.advance_to((k + 1) * STEP, EndMotion(), EndMotion()).valid
        mean = rope.signals([*before]) if k > 500 else None
        held = mean if held is None or mean is None else {n: x + 0.01 * (mean[n] - x) for n, x in held.items()}
    assert held is not None
    gained = {name: held[name] - before[name] for name in before}
    # swings about the new rest, with hardly any damping, are averaged
    for axis, of in zip("xyz", force[0], strict=True):
        assert gained[f"left.f{axis}"] + gained[f"right.f{axis}"] == pytest.approx(of, abs=0.5)


@pytest.mark.parametrize("form", FORMS)
def test_their_work_and_their_impulse_are_in_the_balances(form: Any) -> None:
    rope = push(short_rope(form), 100)
    energy, audit = rope.state.energy_balance, rope.state.audit
    assert energy.work_ends > 0.5
    # what the integrator dissipates at 10 ms
    assert abs(energy.residual) < 1e-3 * energy.work_ends
    # of some 30 N
    assert audit.missing_force < 0.03


def test_both_forms_answer_alike() -> None:
    python, native = (push(short_rope(form), 60) for form in FORMS)
    # rounding, grown over 60 steps
    assert_allclose(native.state.motion.q, python.state.motion.q, rtol=0.0, atol=1e-9)
    assert_allclose(native.rows(), python.rows(), rtol=0.0, atol=1e-7)
    assert_allclose(native.state.energy_balance, python.state.energy_balance, rtol=0.0, atol=1e-7)
    given = pushing(0.2, STEP)
    assert_allclose(native.displacement(given), python.displacement(given), rtol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_the_displacement_is_what_the_next_step_moves_its_places_by(form: Any) -> None:
    rope = push(short_rope(form), 20)
    t, size, saved = 20 * STEP, 1e-3, rope.snapshot()
    given = pushing(t, STEP)
    ends = []
    for part in (0.0, 1.0):
        rope.restore(saved)
        rope.apply(PointForces(given.s, given.at_start, given.at_stop + part * size * given.at_start, t, t + STEP))
        assert rope.advance_to(t + STEP, EndMotion(), EndMotion()).valid
        ends.append(rope.rows())
    moved = rope.displacement(given)
    # the loop's place is a node: the fifth of ten elements ends there
    assert_allclose((ends[1] - ends[0])[5, 1:4] / size, moved[2], rtol=2e-2, atol=1e-3 * np.abs(moved).max())


@pytest.mark.parametrize("form", FORMS)
def test_no_forces_change_no_bit_and_given_again_after_restoring_they_go_on_bit_by_bit(form: Any) -> None:
    rope, alone = short_rope(form), short_rope(form)
    nothing = pushing(0.0, STEP)
    rope.apply(PointForces(nothing.s[:0], nothing.at_start[:0], nothing.at_stop[:0], 0.0, STEP))
    for one in (rope, alone):
        assert one.advance_to(STEP, EndMotion(y=1e-3, vy=0.1), EndMotion()).valid
    assert_array_equal(rope.state.motion.q, alone.state.motion.q)
    one = push(short_rope(form), 10)
    saved = one.save()
    other = short_rope(form)
    other.restore(saved)
    assert_array_equal(push(other, 5, 10).state.motion.q, push(one, 5, 10).state.motion.q)


@pytest.mark.parametrize("form", FORMS)
def test_a_rope_that_chooses_its_model_takes_the_one_that_feels_forces(form: Any) -> None:
    rope = short_rope(form, model=Model("auto", force_tolerance=1.0))
    assert rope.fidelity == "rigid"
    rope.apply(pushing(0.0, STEP))
    assert rope.advance_to(STEP, EndMotion(), EndMotion()).valid
    assert (rope.fidelity, rope.fidelity_reason[:21]) == ("torsional", "the rigid model canno")
    assert hung(rope).fidelity_reason == "forces are applied to places of the rope"
