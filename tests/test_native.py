"""The native rope against RopeSimulator: the same steps, the same events, the same numbers."""

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import fixed_steps

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.parameters import Winding
from rope_model.engine import NativeRope
from rope_model.parameters import Mesh, Model, Rope, Scene, Solver, Swivel, rope_120, rope_240
from rope_model.simulation.balance_rope import BalanceRope
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.outputs.signal_table import SIGNALS
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.state import RopeState

Motions = Callable[[float], tuple[EndMotion, EndMotion]]


def winding(travel: float, speed: float, skip: float = 0.0) -> Motions:
    """Left end up by ``travel`` (m) at ``speed``."""
    trip = s_curve(Winding(travel=travel, speed=speed))

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        p = trip.at(t)
        return (
            EndMotion(y=p.position, vy=p.speed, ay=p.acceleration),
            EndMotion(y=travel - p.position, vy=-p.speed, ay=-p.acceleration),
        )

    return ends


def turn(rate: float) -> Motions:
    """Both conveyances turn about the vertical and about each other's middle, as one body."""

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        ramp = 2.0
        phi = rate * (t - ramp / math.pi * math.sin(math.pi * t / ramp)) / 2 if t < ramp else rate * (t - ramp / 2)
        w = rate * (1 - math.cos(math.pi * t / ramp)) / 2 if t < ramp else rate
        w_t = rate * math.pi / ramp * math.sin(math.pi * t / ramp) / 2 if t < ramp else 0.0
        c, s = math.cos(phi), math.sin(phi)

        def end(x: float) -> EndMotion:
            return EndMotion(
                x=x * c - x, z=-x * s, vx=-x * s * w, vz=-x * c * w,
                ax=-x * (c * w * w + s * w_t), az=x * (s * w * w - c * w_t), yaw=phi, yaw_rate=w,
            )  # fmt: skip

        return end(-1.0), end(1.0)

    return ends


def bounce(t: float) -> tuple[EndMotion, EndMotion]:
    """The left end is dropped by .5 m faster than the rope falls, and caught."""
    s = min(max(t - 0.1, 0.0) / 0.3, 1.0)
    y, v, a = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 - 60 * s**3 + 30 * s**4, 60 * s - 180 * s**2 + 120 * s**3
    return EndMotion(y=-0.5 * y, vy=-0.5 * v / 0.3, ay=-0.5 * a / 0.09), EndMotion()


SWIVEL = Swivel(mode="coulomb", release_time=0.5)
SHORT = Rope(length=60.0, installed_twist=1.5)
#: a correction about as large as the tolerance may be the last one in one form and not in the other
CLOSE = Solver(step_max=0.04, newton_tolerance=1e-10)
CASES: dict[str, tuple[Scene, Motions, float, float]] = {
    "winding": (rope_120().scene, winding(90.0, 8.0), 5.0, 0.01),
    "coarse levels": (rope_120("draft").scene, winding(90.0, 8.0), 6.0, 0.02),
    "stick and slip": (
        rope_240("draft").scene.with_(left=SWIVEL, right=SWIVEL, model=Model(), solver=CLOSE),
        winding(200.0, 10.0),
        2.2,  # every event multiplies the rounding before it
        0.02,
    ),
    "free swivels, one with a seal": (
        Scene(
            rope=SHORT,
            left=Swivel("free", release_time=0.2),
            right=replace(SWIVEL, seal_moment=0.05),
            solver=fixed_steps(0.01),
        ),
        winding(40.0, 4.0),
        3.0,
        0.01,
    ),
    "spatial": (Scene(rope=Rope(length=60.0), model=Model("spatial")), winding(40.0, 4.0), 2.0, 0.01),
    "planar, equal elements": (
        Scene(rope=Rope(length=60.0, Qb=0.0, Qc=0.0), mesh=Mesh("eem", elements=81)),
        winding(40.0, 4.0),
        2.0,
        0.01,
    ),
    "rigid, then raised": (
        Scene(rope=Rope(length=60.0), model=Model("auto", force_tolerance=0.2)),
        lambda t: (
            (EndMotion(z=max(t - 1.0, 0.0) ** 4, vz=4 * max(t - 1.0, 0.0) ** 3, az=12 * max(t - 1.0, 0.0) ** 2),) * 2
        ),
        1.3,
        0.01,
    ),
    "turned through a right angle": (
        Scene(rope=SHORT, mesh=Mesh("eem", elements=60), solver=Solver(rho_inf=0.8)),
        turn(1.5),
        2.5,
        0.02,
    ),
    "slack and caught": (Scene(rope=Rope(length=60.0)), bounce, 0.7, 0.01),
    "non-conservative": (
        Scene(rope=Rope(length=60.0, Qb=2.5e5, Qc=2.2e5), solver=Solver(newton_tolerance=3e-10)),
        winding(40.0, 4.0),
        1.5,
        0.01,
    ),
}


def together(
    ropes: Sequence[BalanceRope], motions: Sequence[Motions], duration: float, h: float
) -> Iterator[tuple[RopeState, ...]]:
    """The states of all ropes at the start and after each step, each rope moved in its own way."""
    for rope, ends in zip(ropes, motions, strict=True):
        status = rope.initialize(0.0, *ends(0.0))
        assert status.valid, status.message
    yield tuple(rope.state for rope in ropes)
    for k in range(1, round(duration / h) + 1):
        for rope, ends in zip(ropes, motions, strict=True):
            status = rope.advance_to(k * h, *ends(k * h))
            assert status.valid, status.message
        yield tuple(rope.state for rope in ropes)


def lift(motions: Motions, by: float) -> Motions:
    """The same in another height: the same forces but for rounding."""
    return lambda t: tuple(replace(end, y=end.y + by) for end in motions(t))  # type: ignore[return-value]


@pytest.mark.slow
@pytest.mark.skipif("OPTIMISING_CC" not in os.environ, reason="the tests have no C compiler of the system")
def test_the_optimiser_does_not_change_a_bit() -> None:
    """So the tests may compile with little of it."""
    code = (
        "from rope_model import EndMotion, balance_rope, rope_120\n"
        "rope = balance_rope(rope_120().scene, 'native')\n"
        "rope.initialize(0.0, EndMotion(), EndMotion(y=90.0))\n"
        "for t in (0.02 * k for k in range(1, 51)): rope.advance_to(t, EndMotion(y=t**3), EndMotion(y=90.0))\n"
        "print({name: value.hex() for name, value in rope.signals().items() if isinstance(value, float)})"
    )
    said = [
        subprocess.run(
            [sys.executable, "-c", code], env=os.environ | {"CC": cc}, capture_output=True, text=True, check=True
        ).stdout
        for cc in (os.environ["CC"], os.environ["OPTIMISING_CC"])
    ]
    assert said[0] == said[1]
    assert "left.fy" in said[0]


@pytest.mark.parametrize("case", CASES)
def test_native_rope_takes_the_same_steps_to_the_same_forces(case: str) -> None:
    scene, motions, duration, h = CASES[case]
    reference, native, higher = RopeSimulator(scene), NativeRope(scene), NativeRope(scene)
    largest = difference = rounding = 0.0
    ends = motions, motions, lift(motions, 7.3)
    for a, b, c in together((reference, native, higher), ends, duration, h):
        assert a.counts._replace(newton=0) == b.counts._replace(newton=0)
        assert (a.fidelity, a.fidelity_reason) == (b.fidelity, b.fidelity_reason)
        # a moment creeps up to the static limit: its last bits decide when it gets there
        assert [(e.what, pytest.approx(e.t, abs=1e-5)) for e in a.events] == [(e.what, e.t) for e in b.events]
        forces, of_native, same = (state.motion.reaction[[0, -1], :3] for state in (a, b, c))
        largest = max(largest, float(np.abs(forces).max()))
        difference = max(difference, float(np.abs(forces - of_native).max()))
        rounding = max(rounding, float(np.abs(of_native - same).max()))
    assert a.counts.steps > 10
    assert b.counts.newton == pytest.approx(a.counts.newton, rel=0.02)  # the search for an event may take one more
    # the elimination goes inwards from both ends and multiplies with reciprocals: other roundings, the same equations
    assert difference < max(1e-9 * largest, 3 * rounding)
    assert rounding < (1e-6 if a.counts.swivel_events else 1e-8) * largest  # or the case would show nothing
    expected, got = reference.signals(SIGNALS), native.signals(SIGNALS)
    forces_and_moments = {n for n in SIGNALS if n.partition(".")[2] in ("fx", "fy", "fz", "fy_mean", "mx", "my", "mz")}
    scale = dict.fromkeys(SIGNALS, 1.0) | dict.fromkeys(forces_and_moments, largest)
    scale |= {name: largest for name in SIGNALS if name.startswith(("shape.tension", "station.tension"))}
    scale |= {name: 1e7 for name in SIGNALS if name.startswith(("stress", "shape.bending", "shape.torsion"))}
    scale |= {name: max(abs(a.energy_balance.total), 1e4) for name in SIGNALS if name.startswith("energy")}
    scale |= {name: max(abs(a.energy_balance.total), 1e4) for name in SIGNALS if name.startswith("audit")}
    # differences of forces over 1e-3 m/s^2
    scale |= {name: 3 * rounding / 1e-3 / 1e-8 for name in SIGNALS if name.endswith("added_mass")}
    scale |= {name: 10.0 for name in SIGNALS if name.endswith("swivel.torque")}  # of a rope that carries 19 N m
    scale["count.newton"] = 0.02 * a.counts.newton / 1e-8
    scale |= {"status.end_force_error": 0.01 * expected["status.end_force_error"] / 1e-8}  # of differences of strains
    # where swivels slip, the instants of the events carry the rounding on
    relative = 1e-6 if a.counts.swivel_events else 1e-8
    allowed = {n: relative * scale[n] for n in SIGNALS}
    # so does the rope in another height
    elsewhere = higher.signals()
    slipping = [n for n in SIGNALS if ".swivel." in n]
    allowed |= {n: max(allowed[n], 3 * abs(got[n] - elsewhere[n])) for n in slipping}
    # three times what a torque that changes by 2 N m/s gains between instants that lie 1e-5 s apart, as above
    assert max(allowed[n] for n in slipping) < 3 * 2.0 * 1e-5
    wrong = {n: (expected[n], got[n]) for n in SIGNALS if not abs(expected[n] - got[n]) <= allowed[n]}
    assert not wrong


def test_the_cases_meet_what_they_are_for() -> None:
    """Transformations, slips, another fidelity and a slack rope happen in the cases above."""
    seen: set[str] = set()
    for name in ("winding", "stick and slip", "rigid, then raised"):
        scene, motions, duration, h = CASES[name]
        for (state,) in together([NativeRope(scene)], [motions], duration, h):
            seen |= {event.what for event in state.events}
    assert {"transformation", "left swivel slips -", "left swivel sticks", "model torsional"} <= seen
    scene, motions, duration, h = CASES["slack and caught"]
    tensions = [state.motion.reaction[0, 1] for (state,) in together([NativeRope(scene)], [motions], duration, h)]
    assert min(tensions) < 0


def test_states_go_from_one_to_the_other() -> None:
    scene, motions, _, h = CASES["winding"]
    native, reference = NativeRope(scene), RopeSimulator(scene)
    native.initialize(0.0, *motions(0.0))
    for k in range(1, 101):
        native.advance_to(k * h, *motions(k * h))
    reference.restore(native.save())
    for rope in (native, reference):
        assert rope.advance_to(1.05, *motions(1.05)).valid
    # heights of 90 m are rounded by 1.4e-14 m, which the shortest elements' axial stiffness makes 1e-5 N on either side
    assert_allclose(native.state.motion.reaction, reference.state.motion.reaction, rtol=0, atol=3e-5)
    back = NativeRope(scene)
    back.restore(reference.state)
    assert back.state.motion.q.tobytes() == reference.state.motion.q.tobytes()
    assert back.advance_to(1.1, *motions(1.1)).valid


def test_half_steps_after_a_restored_state_are_bit_identical() -> None:
    scene, motions, _, h = CASES["stick and slip"]
    rope = NativeRope(scene)
    rope.initialize(0.0, *motions(0.0))
    happened: set[str] = set()
    for k in range(1, 331):
        saved = rope.native_state()
        ends = []
        for _ in range(2):
            assert rope.restore_native(saved).valid
            for part in (0.5, 1.0):
                assert rope.advance_to((k - 1 + part) * h, *motions((k - 1 + part) * h)).valid
                happened |= {event.what for event in rope.state.events}
            ends.append(rope.native_state())
        assert ends[0] == ends[1]
    assert {"transformation", "left swivel slips -", "left swivel sticks"} <= happened


def test_a_step_to_a_swivel_event_that_diverges_is_taken_up_again_with_a_shorter_one() -> None:
    released = Swivel(mode="coulomb", release_time=10.0)
    even = Solver(tolerance=1e6, newton_tolerance=1e-7)  # no step is rejected for its error
    scene = rope_data(find_case("kiruna-710").rope).with_(left=released, right=released, solver=even)
    rope = NativeRope(scene.with_(rope=replace(scene.rope, installed_twist=9.0), model=Model("torsional")))
    step, ends = scene.solver.step_max, winding(400.0, 16.0)
    assert rope.initialize(0.0, *ends(0.0)).valid
    for k in range(1, round(13.2 / step) + 1):
        status = rope.advance_to(k * step, *ends(k * step))
        assert status.valid, status.message
        assert k * step > 10.0 or rope.signals(("count.rejections",))["count.rejections"] == 0
    assert rope.state.counts.swivel_events > 5
    assert rope.state.counts.rejections > 1
