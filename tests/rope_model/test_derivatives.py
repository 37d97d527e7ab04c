"""Derivatives of the end loads are those of the communication step, at the default settings."""

import ctypes as ct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from derivative_cases import INPUTS, STEPS, Case, cases, derivative, differentiated, errors, winding
from numpy.testing import assert_allclose

from rope_model import EndMotion, rope_120
from rope_model.engine import NativeRope
from rope_model.signals.signal_table import LOADS

#: of the largest entry: differences of steps at the default tolerance of Newton's method are no
#: better
ALLOWED = 0.01
#: internal steps keep their lengths, which the error estimate of long divided steps would change:
#: case and step, ms
LARGEST_ERRORS = {
    ("Qb not Qc", 100.0): 0.02,
    # of so small differences Newton's last corrections are more than 1 %
    ("wires that rub", 0.001): 0.03,
    ("wires that rub", 10.0): 0.03,
}
DEFAULT = Case(rope_120().scene)


#: what stands for all cases in ``make test``, with the numbers of inputs that a difference shows
QUICK = {
    "torsional, locked swivels": 11,
    "swivels that stick": 11,
    "extrapolated": 11,
    "position given": 3,
    "a transformation": 11,
    "Qb not Qc": 11,
    "clamps that lean": 13,
}


@pytest.mark.parametrize("name", QUICK)
def test_derivatives_are_differences_of_the_step(name: str) -> None:
    found = errors(cases()[name], 0.02)
    assert len(found) >= QUICK[name], found
    assert max(found.values()) < ALLOWED, found


def test_derivatives_where_wires_rub_are_those_of_wires_that_go_on_as_they_do() -> None:
    found = errors(cases()["wires that rub"], 0.005)
    assert len(found) >= 8, found
    assert max(found.values()) < ALLOWED, found


def test_derivatives_are_differences_of_a_step_that_ends_at_an_event() -> None:
    found = errors(cases()["at an event"], 0.05)
    assert len(found) == 11
    assert max(found.values()) < ALLOWED, found


@pytest.mark.slow
@pytest.mark.parametrize("name", cases())
def test_derivatives_are_differences_of_steps_of_any_length(name: str) -> None:
    case = cases()[name]
    shown = 0
    for h in STEPS:
        if not case.shortest <= 1e-3 * h <= case.longest:
            continue
        found = errors(case, 1e-3 * h)
        shown += len(found)
        assert max(found.values(), default=0.0) < LARGEST_ERRORS.get((name, h), ALLOWED), (h, found)
    assert shown > 0


def test_all_derivatives_of_a_step_cost_two_steps_for_an_input_and_one_more() -> None:
    rope = differentiated(DEFAULT, 0.05).rope
    lib, handle, *_ = rope.library
    before = lib.rope_repeated_steps(handle)
    costs = []
    for side in (0, 1):
        for name in INPUTS[:11]:  # leans move clamped ends alone
            derivative(rope, side, name)
            costs.append(lib.rope_repeated_steps(handle) - before)
    assert costs == [1 + 2 * k for k in range(1, 23)]
    derivative(rope, 1, "vy")  # is known by now
    assert lib.rope_repeated_steps(handle) - before == costs[-1]


@pytest.mark.parametrize("h", [1e-6, 1e-5, 1e-3, 0.01, 0.05, 0.1])
def test_added_mass_is_the_derivative_along_an_acceleration_that_grows_over_the_step(
    h: float,
) -> None:
    # a consistent motion with accelerations that differ by a at the end, and do not differ at the
    # start; in less than 10 us the path leads beyond the step, and its end is not that of this
    # motion
    step = differentiated(replace(DEFAULT, bent=()), h)
    masses = step.rope.added_mass()
    size = 0.01
    at_end = max(h, 1e-5)
    motion = {"y": at_end * at_end / 6.0, "vy": at_end / 2.0, "ay": 1.0}
    if at_end > h:
        assert np.isfinite(masses).all()
        assert masses[0] > 0
        return
    for side, mass in enumerate(masses):
        changes = [{}, {}]
        changes[side] = {name: size * x for name, x in motion.items()}
        difference = step.difference(changes)
        assert difference is not None
        force = difference[6 * side + 1] / size
        assert_allclose(mass, -force, rtol=2e-3)


def test_added_mass_is_the_sum_of_the_derivatives_along_that_motion() -> None:
    h = 0.05  # three internal steps
    rope = differentiated(DEFAULT, h).rope
    by_y, by_vy, by_ay = (derivative(rope, 0, name)[1] for name in ("y", "vy", "ay"))
    assert_allclose(
        rope.added_mass()[0], -(by_ay + h / 2.0 * by_vy + h * h / 6.0 * by_y), rtol=1e-3
    )


def test_before_the_first_step_derivatives_are_those_of_a_step_of_step_max() -> None:
    scene = DEFAULT.scene
    rope = NativeRope(scene)
    other = NativeRope(scene)
    for one in (rope, other):
        assert one.initialize(0.0, *winding(0.0)).valid
    assert other.advance_to(scene.solver.step_max, *winding(0.0)).valid
    for name in INPUTS[:11]:
        assert_allclose(derivative(rope, 0, name), derivative(other, 0, name), rtol=1e-9, atol=1e-9)
    assert_allclose(rope.added_mass(), other.added_mass(), rtol=1e-9)


def test_a_saved_state_and_a_rejected_step_leave_the_derivatives_as_they_are() -> None:
    rope = differentiated(DEFAULT, 0.05).rope
    before = derivative(rope, 1, "vy")
    mass = rope.added_mass()
    other = NativeRope(DEFAULT.scene)
    assert other.restore_native(rope.native_state()).valid
    assert derivative(other, 1, "vy").tolist() == before.tolist()
    assert other.added_mass() == mass
    assert not rope.advance_to(rope.time + 0.05, EndMotion(y=1e3), EndMotion()).valid
    assert derivative(rope, 1, "vy").tolist() == before.tolist()
    other.restore(rope.snapshot())
    assert derivative(other, 1, "vy").tolist() == before.tolist()


def test_bytes_with_a_step_that_led_elsewhere_are_refused() -> None:
    rope = differentiated(DEFAULT, 0.01).rope
    saved = bytearray(rope.native_state())
    size = (len(saved) - ct.sizeof(ct.c_double) * (3 + 2 * len(INPUTS) + 2)) // 2
    for at, wrong in (
        (2 * size, np.nan),
        (2 * size, 0.0),
        (size, 100.0),
    ):  # the step's stop; the start's time
        spoilt = saved.copy()
        spoilt[at : at + 8] = np.float64(wrong).tobytes()
        assert not rope.restore_native(bytes(spoilt)).valid
    assert rope.restore_native(bytes(saved)).valid


@pytest.mark.parametrize(
    "name", ["torsional, locked swivels", "swivels that slip", "contact with a beam"]
)
def test_derivatives_change_no_bit_of_the_run(name: str) -> None:
    case = cases()[name]
    states = []
    for looks in (False, True):
        rope = NativeRope(case.scene)
        assert rope.initialize(0.0, *case.motion(0.0)).valid
        for k in range(1, 12):
            assert rope.advance_to(0.05 * k, *case.motion(0.05 * k)).valid
            if looks:
                derivative(rope, 0, "ay")
                rope.added_mass()
        states.append(rope.native_state())
    assert states[0] == states[1]


#: codes of fesetround on x86; other processors have others
ROUNDING_MODES = {"downward": 0x400, "upward": 0x800, "toward zero": 0xC00}


@contextmanager
def rounding(mode: int) -> Iterator[None]:
    libm = ct.CDLL("libm.so.6")
    before = libm.fegetround()
    assert libm.fesetround(mode) == 0
    try:
        yield
    finally:
        libm.fesetround(before)


@pytest.mark.skipif(
    "x86_64" not in __import__("platform").machine(), reason="codes of the modes are those of x86"
)
@pytest.mark.parametrize("mode", ROUNDING_MODES.values(), ids=ROUNDING_MODES)
def test_results_do_not_depend_on_the_hosts_rounding_mode(mode: int) -> None:
    scene = DEFAULT.scene
    ropes = [NativeRope(scene), NativeRope(scene)]
    names = (*LOADS, "loop.x", "loop.y", "loop.z", "loop.yaw", "loop.turns", "loop.crossings")
    steps = [winding(0.02 * k) for k in range(200)]  # over a transformation
    for rope in ropes:
        assert rope.initialize(0.0, *steps[0]).valid
        rope.signals(names)  # what Python prepares once
    for k, ends in enumerate(steps[1:], start=1):
        assert ropes[0].advance_to(0.02 * k, *ends).valid
        with rounding(mode):
            done = ropes[1].advance_to(0.02 * k, *ends)
        assert done.valid, done.message
    usual = ropes[0].signals(names)
    with rounding(mode):
        other = ropes[1].signals(names)
    # steps may be divided otherwise: what the accuracy allows, 1e-3 of the forces and 10 mm
    for name in names:
        allowed = 1e-2
        if name in LOADS:
            allowed = 1e-3 * usual["left.fy"]
        assert abs(other[name] - usual[name]) <= abs(allowed), (name, usual[name], other[name])
