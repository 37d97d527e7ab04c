"""What steps leave and whether a run keeps what was asked of it; the audit is silent where the motion is right."""

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from invariants.books import integrals
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scenes import P120, TRIP, Trip, ends_at, hung, recorded, wound
from signal_names import of_both_ends

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from rope_model import (
    Accuracy,
    EndMotion,
    Layout,
    Mesh,
    Model,
    Rope,
    Scene,
    Solver,
    Swivel,
    balance_rope,
)
from rope_model.compiler import find_compiler
from rope_model.engine import NativeRope
from rope_model.method import step_errors
from rope_model.method.generalized_alpha import Coefficients, local_error
from rope_model.method.mesh_error import bend_error, length_for, turned_by_mesh
from rope_model.method.step_control import step_limits
from rope_model.physics.estimates import axial_frequency

ROPE = Rope(length=400.0, beta_K=0.0)
CONSTANT = float(local_error(Coefficients(0.6), 1.0, 1.0))


def step_of_wave(h: float, leg: float, strain_tt: float) -> step_errors.MeasuredStep:
    """Return a step of a rope at rest in whose left leg (m) a wave runs; its forces are as large as its strains."""
    return step_errors.MeasuredStep(
        h=h,
        bottom_s=leg,
        end_speed=0.0,
        strain_tt=(float(strain_tt), 0.0),
        position=0.0,
        force=ROPE.Qa,
    )


def test_errors_of_a_wave_add_up_to_its_phase() -> None:
    """Each step turns a wave of amplitude 1 by C (omega h)^3: it is off by all turns so far, as far as they last."""
    leg = 300.0
    h = 0.01
    n = 400
    omega = axial_frequency(ROPE, leg)
    turn = CONSTANT * (omega * h) ** 3
    sums = step_errors.ErrorSums()
    rates = omega * np.sin(omega * h * np.arange(n + 1))
    for pace in np.diff(rates) / h:
        sums = step_errors.add_errors(Scene(ROPE), sums, step_of_wave(h, leg, pace), CONSTANT)
    t = h * np.arange(n)
    lasts = step_errors.wave_duration(ROPE, omega)
    off = turn * lasts / h * (1 - np.exp(-t / lasts)) * np.sin(omega * t)
    # of each turn half is seen, and doubled: what goes with twice the wave's frequency is of one
    # step's size
    assert_allclose(step_errors.end_force_error(ROPE, sums), np.sqrt(np.mean(off**2)), rtol=0.01)


def test_errors_that_go_with_no_wave_do_not_add_up() -> None:
    leg = 300.0
    h = 0.01
    scene = Scene(ROPE)
    sums = step_errors.ErrorSums()
    rng = np.random.default_rng(1)
    for pace in 1e-9 / (CONSTANT * h * h) * rng.standard_normal(4000):
        sums = step_errors.add_errors(scene, sums, step_of_wave(h, leg, pace), CONSTANT)
    assert step_errors.end_force_error(
        ROPE, sums
    ) < step_errors.RATE_ERROR_FACTOR * 1e-9 * math.sqrt(4000)


def swing(omega: float, damping: float, h: float, duration: float) -> NDArray[np.float64]:
    """Return q and the mean of q_tt in a step of a mode under an acceleration with kinks, for steps of length ``h``."""
    method = Coefficients(0.6)
    w2 = omega * omega
    m = method.alpha_m
    f = method.alpha_f
    beta = method.beta
    gamma = method.gamma
    d = damping * w2
    rows = []
    q = v = a = b = 0.0
    for k in range(round(duration / h)):
        before = v
        q = q + h * v + h * h * (0.5 - beta) * b
        v = v + h * (1 - gamma) * b
        force = np.interp(
            (k + 1) * h, (0.0, 0.3, 0.8, 1.1, 2.0, 2.3, 2.8, 3.1), (0, 1, 1, 0, 0, -1, -1, 0)
        )
        answered = 1 + (1 - f) * (d * gamma * h + w2 * beta * h * h) / (1 - m)
        b = ((1 - f) * (force - d * v - w2 * q) + f * a - m * b) / (1 - m) / answered
        q += beta * h * h * b
        v += gamma * h * b
        a = force - d * v - w2 * q
        rows.append((q, (v - before) / h))
    return np.array(rows)


@pytest.mark.parametrize("leg", [700.0, 210.0, 84.0, 42.0, 31.5])
@pytest.mark.parametrize("h", [0.005, 0.02])
def test_the_error_of_a_forced_wave_is_estimated_however_many_radians_a_step_takes_of_it(
    leg: float, h: float
) -> None:
    """From .04 to 3.9 radians; were the wave not stiff the estimate would be 2.3 times too large."""
    rope = Rope(length=leg / 0.7)
    duration = 4.0
    omega = float(axial_frequency(rope, leg))
    found = swing(omega, rope.beta_K, h, duration)
    exact = swing(omega, rope.beta_K, h / 40, duration)[39::40]
    scene = Scene(rope)
    sums = step_errors.ErrorSums()
    for _, pace in found:
        sums = step_errors.add_errors(scene, sums, step_of_wave(h, leg, pace), CONSTANT)
    off = np.sqrt(np.mean((found[:, 0] - exact[:, 0]) ** 2))
    assert 0.5 < step_errors.end_force_error(rope, sums) / off < 1.5


def test_a_wave_lasts_as_its_damping_lets_it_and_without_for_so_many_radians() -> None:
    waves = (1e-3, 100.0), (0.0, 100.0), (0.0, 1.0)
    found = [step_errors.wave_duration(Rope(beta_K=damping), omega) for damping, omega in waves]
    assert_allclose(found, [2.0 / (1e-3 * 100.0**2), 2.0 * 400.0 / 2.0 / 100.0, 60.0], rtol=1e-12)


@pytest.mark.parametrize("asked", [1e-2, 1e-3, 1e-4])
def test_ten_times_the_accuracy_takes_a_tenth_of_what_a_step_may_leave(asked: float) -> None:
    scenes = (Scene(ROPE, accuracy=Accuracy(a, 10 * a)) for a in (asked / 10, asked))
    strict, loose = (
        step_limits(scene, step_errors.ErrorSums(), 200.0, 10.0, CONSTANT) for scene in scenes
    )
    # errors are of second order in the step
    for name, factor in {
        "strain_rate": 10,
        "position": 10,
        "shortest": 10**0.5,
        "longest": 10**0.5,
    }.items():
        assert_allclose(factor * getattr(strict, name), getattr(loose, name), rtol=1e-12)


@pytest.mark.parametrize("EI", [50.0, 300.0, 3000.0])
@pytest.mark.parametrize("error", [0.05, 5e-3, 5e-4, 5e-5])
def test_elements_for_an_error_have_it(EI: float, error: float) -> None:
    scene = Scene(Rope(EI=EI))
    assert_allclose(bend_error(scene, length_for(scene, error)), error, rtol=1e-12)


#: drawn at random, as everything of evidence.promise is
STOPPED = (
    Scene(
        Rope(
            length=374.23,
            mass_per_length=11.925,
            EI=577.42,
            Qa=1.776e8,
            Qb=65708.5,
            Qc=65708.5,
            Qd=9208.3,
            rhoJ=4.3016e-3,
            diameter=0.05372,
        ),
        Layout(1.3698),
    ),
    Winding(
        travel=221.66,
        speed=5.9435,
        acceleration=1.4023,
        jerk=2.5468,
        start_delay=0.0,
        emergency_at=13.0389,
        emergency_deceleration=3.17,
    ),
)


def wind(scene: Scene, trip: Winding, **changes: Any) -> tuple[np.ndarray, list[float]]:
    """End forces and place of the loop every 20 ms, until 3 s behind the trip; the errors that the run estimates."""
    reference = s_curve(trip)
    rope = balance_rope(scene.with_(**changes))
    motion = partial(ends_at, reference, trip.travel)
    steps = round((reference.duration + 3.0) / 0.02)
    names = (*of_both_ends("fx", "fy", "fz"), "loop.x", "loop.y", "loop.z")
    return recorded(rope, motion, steps, names, 0.02), [
        *rope.signals(("status.end_force_error", "status.loop_error")).values()
    ]


def errors(found: np.ndarray, exact: np.ndarray) -> tuple[float, float]:
    """Of the end force, RMS of the worse end over the largest; of the loop's place, m, the largest."""
    off = found - exact
    force = exact[:, :6].reshape(-1, 2, 3)
    worse = np.sqrt(np.mean(np.square(off[:, :6]).reshape(-1, 2, 3).sum(axis=2), axis=0)).max()
    return worse / np.linalg.norm(force, axis=2).max(), float(
        np.linalg.norm(off[:, 6:], axis=1).max()
    )


@pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")
def test_even_steps_put_the_loop_off_by_what_the_flow_through_it_lets_expect() -> None:
    """Of the fourth power of the speed and the second of the step: not a scene that any constant was found on."""
    trip = Winding(travel=90.0, speed=12.0, acceleration=1.5, jerk=2.0, start_delay=0.0)
    scene = Scene(Rope(length=130.0, EI=800.0))
    long, short, fine = (
        wind(scene, trip, solver=Solver(step_max=h, tolerance=1e6))[0] for h in (0.02, 0.01, 0.004)
    )
    peak = max(point.speed for point in s_curve(trip).points)
    for h, run in ((0.02, long), (0.01, short)):
        off = np.linalg.norm(run[:, 6:] - fine[:, 6:], axis=1).max()
        assert_allclose(off, step_errors.flow_error(scene, 2 * peak, h), rtol=0.35)


def test_clamps_which_hold_the_strain_of_their_node_do_not_hide_the_error_of_the_end_forces() -> (
    None
):
    trip = Winding(travel=4.0, speed=3.0, acceleration=4.0, jerk=8.0, start_delay=0.0)
    ends = (Swivel(attachment=kind) for kind in ("plumb", "clamped"))
    plumb, clamped = (
        wind(Scene(Rope(length=60.0), left=end, right=end), trip)[1][0] for end in ends
    )
    assert 0.5 < clamped / plumb < 2.0


@pytest.mark.slow
@pytest.mark.skipif(not find_compiler(), reason="minutes without a C compiler")
def test_an_emergency_stop_is_as_accurate_as_asked_and_says_how_accurate_it_is() -> None:
    """Of a rope on which no constant was found; even steps by the places of the nodes alone would miss it."""
    asked = Accuracy()
    # found out: a mesh and steps finer still move both errors by a thirtieth
    fine, _ = wind(
        *STOPPED, accuracy=Accuracy(end_force=1e-4, loop=1e-3), mesh=Mesh("auto", loop_error=5e-4)
    )
    loose, _ = wind(
        *STOPPED, accuracy=Accuracy(end_force=1.0, loop=1.0), solver=Solver(tolerance=0.1)
    )
    found, told = wind(*STOPPED, accuracy=asked)
    force, loop = errors(found, fine)
    assert force < asked.end_force < 10 * asked.end_force < errors(loose, fine)[0]
    assert loop < asked.loop
    # what the run says of itself
    assert 0.5 < told[0] / force < 2.0
    assert 0.5 < told[1] / loop < 2.0


FOUND = {"missing_loads", "unresolved_waves", "unresolved_bend"}
SHORT = Scene(rope=Rope(length=60.0))
AT_REST = EndMotion(y=0.0), EndMotion(y=40.0)
PLACE = ("loop.x", "loop.y", "loop.z")
H = 0.01
NO_CONTROL = 1e6  # of the step's error


def whole_trip(case: Trip) -> NativeRope:
    """The native rope after the whole trip."""
    scene = rope_scene(find_case(case.scene).rope, case.level)
    if scene.solver.step_max < case.H:
        # the host's steps are the rope's, however much they err; what Newton's method leaves of
        # such steps, up to 52 N at its default tolerance, would be missing too
        solver = replace(scene.solver, step_max=case.H, tolerance=NO_CONTROL, newton_tolerance=1e-7)
        scene = scene.with_(solver=solver)
    return wound(NativeRope(scene), case.ends, case.steps, case.H)


@pytest.mark.parametrize(
    "case",
    [
        Trip("rope-120", "winding", "draft", 0.02),
        Trip("rope-120", "winding", "standard", 0.01),
        Trip("rope-120", "winding", "standard", 0.04),
        Trip("rope-120", "emergency stop", "standard", 0.02),
        Trip("rope-240", "emergency stop", "standard", 0.01),
    ],
    ids=str,
)
def test_the_audit_is_silent_in_windings_releases_emergency_stops_and_transformations(
    case: Trip,
) -> None:
    rope = whole_trip(case)
    state = rope.state
    audit = rope.state.audit
    assert state.counts.transformations > 15
    assert state.counts.swivel_events > 20 or case.scene == "rope-120"
    assert not FOUND & rope.warnings().keys()
    # a tenth of what is told
    assert audit.missing_force < 1e-4 * audit.force
    assert audit.missing_moment < 5e-4 * audit.force * rope.scene.layout.spacing


def up_and_stopped(t: float) -> tuple[EndMotion, EndMotion]:
    """The left end rises with an acceleration that grows for 0.1 s, and then falls as fast."""
    jerk = 40.0
    grown = min(t, 0.1)
    late = t - grown
    a = jerk * (grown - late)
    v = 0.5 * jerk * grown**2 + jerk * (grown * late - 0.5 * late**2)
    y = (
        jerk * grown**3 / 6.0
        + 0.5 * jerk * grown**2 * late
        + jerk * (0.5 * grown * late**2 - late**3 / 6.0)
    )
    return EndMotion(y=y, vy=v, ay=a), EndMotion()


def test_the_mean_end_forces_of_each_step_are_the_momentum_that_the_rope_gets() -> None:
    """In unequal steps; a trapezoidal rule of the end forces misses 20 N of them in an emergency stop."""
    rope = hung(balance_rope(SHORT))
    scene = SHORT
    weight = scene.rope.mass_per_length * scene.rope.length * scene.layout.gravity
    before = 0.0
    missing = []
    for h in (0.02, 0.02, 0.005, 0.01, 0.02, 0.02, 0.04, 0.01, 0.02, 0.02):
        t = rope.time + h
        status = rope.advance_to(t, *up_and_stopped(t))
        assert status.valid, status.message
        now = scene.rope.mass_per_length * float(integrals(rope)[0][1])
        pulls = sum(rope.signals(["left.fy_mean", "right.fy_mean"]).values())
        missing.append((now - before) / h + pulls + weight)
        before = now
    audited = rope.signals(["audit.momentum"])["audit.momentum"]
    assert_allclose(missing, 0.0, atol=audited + 1e-7 * weight)
    assert audited < 1e-4 * weight  # a tenth of what is told


def test_the_mean_end_forces_of_a_rigid_rope_are_the_momentum_that_it_gets() -> None:
    # the rigid rope has a rule of its own
    scene = SHORT.with_(model=Model("rigid"))
    rope = hung(balance_rope(scene))
    data = scene.rope
    arc = 0.5 * math.pi * scene.layout.spacing
    before = 0.0
    impulse = 0.0
    for t in (0.02, 0.1, 0.11, 0.15):
        h = t - rope.time
        assert rope.advance_to(t, *up_and_stopped(t)).valid
        left, _ = up_and_stopped(t)
        leg = 0.5 * (data.length - arc + left.y)
        now = data.mass_per_length * (leg * left.vy + 0.5 * arc * left.vy)
        pulls = sum(rope.signals(["left.fy_mean", "right.fy_mean"]).values())
        impulse = (
            (now - before) / h + pulls + data.mass_per_length * data.length * scene.layout.gravity
        )
        assert abs(impulse) < 1e-6 * abs(pulls)
        before = now


def test_a_smooth_trip_may_take_long_steps_but_an_emergency_stop_in_them_is_told() -> None:
    rope = whole_trip(Trip("rope-120", "emergency stop", "standard", 0.04))
    told = rope.warnings()
    assert FOUND & told.keys() == {"unresolved_waves"}
    # 40 ms in the axial period of half the rope are 1.55; Newton's method shortens some
    assert rope.signals(["audit.steps_per_period"])["audit.steps_per_period"] < 3.0
    assert "(bound 3)" in told["unresolved_waves"]
    # a sixth of that period, 62 ms
    assert "lower step_max to 0.01 s" in told["unresolved_waves"]


def test_a_blow_between_short_communication_steps_is_told() -> None:
    """Its impulse over the least time of a judgement is a force above the bound."""
    short = 1e-3  # s
    impulse = 0.1  # N s: 100 N for one of these steps
    rope = wound(
        NativeRope(SHORT.with_(solver=Solver(tolerance=NO_CONTROL))), lambda _: AT_REST, 2, short
    )
    state = rope.state
    v = state.motion.v.copy()
    node = len(state.motion.v) // 2
    # what the rope got, and no end force, weight or body gave
    v[node, 1] += impulse / (SHORT.rope.mass_per_length * state.partition.lengths[node])
    rope.restore(state._replace(motion=replace(state.motion, v=v)))
    assert "missing_loads" not in rope.warnings()
    wound(rope, lambda _: AT_REST, 8, short, first=2)
    assert "are missing between the end forces, the weight" in rope.warnings()["missing_loads"]


@pytest.mark.parametrize(
    ("mesh", "loop", "told"),
    [
        *((Mesh("eem", elements=n), 0.01, "sharpest bend") for n in (24, 38)),
        (Mesh("eem", elements=48), 1e-3, "too long for the bend"),
        *((mesh, 0.01, None) for mesh in (Mesh("eem", elements=48), Mesh(), Mesh("auto"))),
    ],
)
def test_elements_too_long_for_the_bend_are_told_and_no_others(
    mesh: Mesh, loop: float, told: str | None
) -> None:
    scene = SHORT.with_(mesh=mesh, accuracy=Accuracy(loop=loop))
    rope = wound(NativeRope(scene), lambda t: AT_REST, 1)
    assert ("unresolved_bend" in rope.warnings()) == (told is not None)
    assert (told or "") in rope.warnings().get("unresolved_bend", "")


def test_what_a_coarse_mesh_does_to_the_loop_is_told_before_anything_moves() -> None:
    """40 equal elements on the 120 m rope: one and a half lengths of its bend."""
    scene = Scene()
    ends = (EndMotion(y=30.0), EndMotion())
    found = []
    for mesh in (Mesh("eem", elements=40), Mesh("auto", loop_error=5e-4)):
        rope = hung(NativeRope(scene.with_(mesh=mesh)), *ends)
        found.append(rope.signals((*PLACE, "loop.yaw", "status.loop_error")))
        assert ("elements of 3 m" in rope.warnings().get("unresolved_bend", "")) == (
            mesh.kind == "eem"
        )
    coarse, fine = found
    off = math.dist([coarse[name] for name in PLACE], [fine[name] for name in PLACE])
    assert 0.5 < coarse["status.loop_error"] / off < 2.0
    # by up to so much, where the nodes lie badly
    turned = abs(coarse["loop.yaw"] - fine["loop.yaw"])
    assert 0.2 < turned / turned_by_mesh(scene, 3.0) < 1.0


def test_short_communication_steps_over_transformations_leave_no_load_missing() -> None:
    """A transformation corrects the motion at an instant: over 10 ns that would be thousands of newtons."""
    chance = np.random.default_rng(1)
    rope = hung(balance_rope(P120.scene, "native"), right=EndMotion(y=90.0))
    t = 0.0
    while t < 9.0:
        t += float(10.0 ** chance.uniform(-8.0, math.log10(0.02)))
        status = rope.advance_to(t, *ends_at(TRIP, 90.0, t))
        assert status.valid, status.message
    assert rope.state.counts.transformations > 3
    assert "missing_loads" not in rope.warnings()
