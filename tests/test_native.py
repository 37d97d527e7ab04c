"""The native rope against RopeSimulator, and with vectors of four elements against any processor's: equal numbers."""

import ctypes
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import Ends, ends_at, fixed_steps, followed, hung, smooth_step, turn, wound

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from rope_model import (
    SIGNALS,
    BalanceRope,
    EndMotion,
    Form,
    PointForces,
    RopeSimulator,
    RopeState,
    balance_rope,
)
from rope_model.cases import rope_120, rope_240
from rope_model.codegen.build import library_of
from rope_model.compiler import find_compiler
from rope_model.engine import NativeRope, declare
from rope_model.parameters import Layout, Rope, Scene, Swivel
from rope_model.shaft_parameters import Air, Contact, Lining, Shaft
from rope_model.simulation import rope_system
from rope_model.simulation.rope_system import RopeSystem
from rope_model.solver_parameters import Mesh, Model, Solver

States = Iterator[tuple[RopeState, ...]]
Motions = Callable[[float], tuple[EndMotion, EndMotion]]


def winding(travel: float, speed: float) -> Motions:
    return partial(ends_at, s_curve(Winding(travel=travel, speed=speed)), travel)


def bounce(t: float) -> tuple[EndMotion, EndMotion]:
    """The left end is dropped by .5 m faster than the rope falls, and caught."""
    y, v, a = (-0.5 * x for x in smooth_step(t, 0.1, 0.3))
    return EndMotion(y=y, vy=v, ay=a), EndMotion()


def raised(t: float) -> tuple[EndMotion, EndMotion]:
    late = max(t - 1.0, 0.0)
    return (EndMotion(z=late**4, vz=4 * late**3, az=12 * late**2),) * 2


SWIVEL, FREE = Swivel(mode="coulomb", release_time=0.5), Swivel("free", release_time=0.2)
SHORT = Rope(length=60.0, installed_twist=1.5)
#: a correction about as large as the tolerance may be the last one in one form and not in the other
CLOSE = Solver(step_max=0.04, newton_tolerance=1e-11)
STICKING = rope_240("draft").scene.with_(left=SWIVEL, right=SWIVEL, model=Model(), solver=CLOSE)
SEALED = Scene(
    rope=SHORT, left=FREE, right=replace(SWIVEL, seal_moment=0.05), solver=fixed_steps(0.01)
)
PLAIN, UNCOUPLED = Rope(length=60.0), Rope(length=60.0, Qb=0.0, Qc=0.0)
TURNED = Scene(rope=SHORT, mesh=Mesh("eem", elements=60), solver=Solver(rho_inf=0.8))
UNEQUAL = Scene(rope=Rope(length=60.0, Qb=2.5e5, Qc=2.2e5), solver=Solver(newton_tolerance=3e-11))
#: scene, motions, duration, communication step
CASES: dict[str, tuple[Scene, Motions, float, float]] = {
    "winding": (
        rope_120().scene.with_(solver=Solver(newton_tolerance=3e-7)),
        winding(90.0, 8.0),
        4.0,
        0.01,
    ),
    "coarse levels": (rope_120("draft").scene, winding(90.0, 8.0), 3.6, 0.02),
    "stick and slip": (
        STICKING,
        winding(200.0, 10.0),
        2.2,
        0.02,
    ),  # every event multiplies the rounding before it
    "free swivels, one with a seal": (SEALED, winding(40.0, 4.0), 3.0, 0.01),
    "spatial": (Scene(rope=PLAIN, model=Model("spatial")), winding(40.0, 4.0), 1.1, 0.01),
    "planar": (Scene(rope=UNCOUPLED, mesh=Mesh("eem", elements=81)), winding(40.0, 4.0), 1.1, 0.01),
    "rigid, then raised": (
        Scene(rope=PLAIN, model=Model("auto", force_tolerance=0.2)),
        raised,
        1.3,
        0.01,
    ),
    "turned through a right angle": (TURNED, partial(turn, 2.25, 2.5), 2.5, 0.02),
    "slack and caught": (Scene(rope=PLAIN), bounce, 0.7, 0.01),
    "non-conservative": (UNEQUAL, winding(40.0, 4.0), 1.1, 0.01),
}
#: test_swivel starts both forms with swivels; a slack rope is wound in test_scenarios
SLOW = ("free swivels, one with a seal", "slack and caught")
#: what happens in some of them
MEETS = {"winding": {"transformation"}, "rigid, then raised": {"model torsional"}}
MEETS["stick and slip"] = {"left swivel slips -", "left swivel sticks"}


def together(
    ropes: Sequence[BalanceRope], motions: Sequence[Motions], duration: float, h: float
) -> States:
    """The states of all ropes at the start and after each step, each rope moved in its own way."""
    pairs = zip(ropes, motions, strict=True)
    for _ in zip(
        *(followed(rope, ends, round(duration / h), h) for rope, ends in pairs), strict=True
    ):
        yield tuple(rope.state for rope in ropes)


def lift(motions: Motions, by: float) -> Motions:
    """The same in another height: the same forces but for rounding."""
    return lambda t: tuple(replace(end, y=end.y + by) for end in motions(t))  # type: ignore[return-value]


@pytest.mark.slow
@pytest.mark.skipif(
    "OPTIMISING_CC" not in os.environ, reason="the tests have no C compiler of the system"
)
def test_the_optimiser_does_not_change_a_bit() -> None:
    code = (
        "from rope_model import EndMotion, balance_rope, rope_120\n"
        "rope = balance_rope(rope_120().scene, 'native')\n"
        "rope.initialize(0.0, EndMotion(), EndMotion(y=90.0))\n"
        "for t in (0.02 * k for k in range(1, 51)): rope.advance_to(t, EndMotion(y=t**3), EndMotion(y=90.0))\n"
        "print({name: value.hex() for name, value in rope.signals().items() if isinstance(value, float)})"
    )
    compilers, command = (
        (os.environ["CC"], os.environ["OPTIMISING_CC"]),
        [sys.executable, "-c", code],
    )
    said = [
        subprocess.check_output(command, env=os.environ | {"CC": cc}, text=True) for cc in compilers
    ]
    assert said[0] == said[1]
    assert "left.fy" in said[0]


#: signals of both forms
COMPARED = [name for name in SIGNALS if not name.endswith(".added_mass")]


@pytest.mark.parametrize(
    "case", [pytest.param(x, marks=[pytest.mark.slow] * (x in SLOW)) for x in CASES]
)
def test_native_rope_takes_the_same_steps_to_the_same_forces(case: str) -> None:
    scene, motions, duration, h = CASES[case]
    reference, native, higher = RopeSimulator(scene), NativeRope(scene), NativeRope(scene)
    largest = difference = rounding = slackest = 0.0
    happened: set[str] = set()
    ends = motions, motions, lift(motions, 7.3)
    for a, b, c in together((reference, native, higher), ends, duration, h):
        assert a.counts._replace(newton=0) == b.counts._replace(newton=0)
        assert (a.fidelity, a.fidelity_reason) == (b.fidelity, b.fidelity_reason)
        # a moment creeps up to the static limit: its last bits decide when it gets there
        assert [(e.what, pytest.approx(e.t, abs=1e-5)) for e in a.events] == [
            (e.what, e.t) for e in b.events
        ]
        happened |= {event.what for event in b.events}
        forces, of_native, same = (state.motion.reaction[[0, -1], :3] for state in (a, b, c))
        slackest = min(slackest, float(forces[0, 1]))
        largest = max(largest, float(np.abs(forces).max()))
        difference = max(difference, float(np.abs(forces - of_native).max()))
        rounding = max(rounding, float(np.abs(of_native - same).max()))
    assert a.counts.steps > 10
    assert MEETS.get(case, set()) <= happened
    assert case != "slack and caught" or slackest < 0
    assert b.counts.newton == pytest.approx(
        a.counts.newton, rel=0.02
    )  # the search for an event may take one more
    # the elimination goes inwards from both ends and multiplies with reciprocals: other roundings, the same equations
    assert difference < max(1e-9 * largest, 3 * rounding)
    assert (
        rounding < (1e-6 if a.counts.swivel_events else 1e-8) * largest
    )  # or the case would show nothing
    expected, got = reference.signals(COMPARED), native.signals(COMPARED)
    ends = [name for name in COMPARED if name.startswith(("left.", "right."))]
    forces_and_moments = {name for name in ends if SIGNALS[name].unit in ("N", "N.m")}
    scale = dict.fromkeys(COMPARED, 1.0) | dict.fromkeys(forces_and_moments, largest)
    scale |= {
        name: largest for name in COMPARED if name.startswith(("shape.tension", "station.tension"))
    }
    scale |= {
        name: 1e7
        for name in COMPARED
        if name.startswith(("stress", "shape.bending", "shape.torsion"))
    }
    scale |= {
        name: max(abs(a.energy_balance.total), 1e4)
        for name in COMPARED
        if name.startswith("energy")
    }
    scale |= {
        name: max(abs(a.energy_balance.total), 1e4) for name in COMPARED if name.startswith("audit")
    }
    scale |= {
        name: 10.0 for name in COMPARED if name.endswith("swivel.torque")
    }  # of a rope that carries 19 N m
    scale["count.newton"] = 0.02 * a.counts.newton / 1e-8
    scale |= {
        "status.end_force_error": 0.01 * expected["status.end_force_error"] / 1e-8
    }  # of differences of strains
    # where swivels slip, the instants of the events carry the rounding on
    relative = 1e-6 if a.counts.swivel_events else 1e-8
    allowed = {n: relative * scale[n] for n in COMPARED}
    # so does the rope in another height
    elsewhere = higher.signals()
    slipping = [n for n in COMPARED if ".swivel." in n]
    allowed |= {n: max(allowed[n], 3 * abs(got[n] - elsewhere[n])) for n in slipping}
    # three times what a torque that changes by 2 N m/s gains between instants that lie 1e-5 s apart, as above
    assert max(allowed[n] for n in slipping) < 3 * 2.0 * 1e-5
    assert not {
        n: (expected[n], got[n]) for n in COMPARED if not abs(expected[n] - got[n]) <= allowed[n]
    }


def test_states_go_from_one_to_the_other() -> None:
    scene, motions, _, h = CASES["winding"]
    native, reference = wound(NativeRope(scene), motions, 100, h), RopeSimulator(scene)
    reference.restore(native.save())
    for rope in (native, reference):
        assert rope.advance_to(1.05, *motions(1.05)).valid
    # heights of 90 m are rounded by 1.4e-14 m, which the shortest elements' axial stiffness makes 1e-5 N on either side
    assert_allclose(
        native.state.motion.reaction, reference.state.motion.reaction, rtol=0, atol=3e-5
    )
    back = NativeRope(scene)
    back.restore(reference.state)
    assert back.state.motion.q.tobytes() == reference.state.motion.q.tobytes()
    assert back.advance_to(1.1, *motions(1.1)).valid


def test_half_steps_after_a_restored_state_are_bit_identical() -> None:
    scene, motions, _, h = CASES["stick and slip"]
    rope = hung(NativeRope(scene), *motions(0.0))
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


def test_one_correction_of_a_step_leaves_less_than_is_reckoned(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parts, solve = [], RopeSystem._newton

    def watched(
        system: RopeSystem, near: Any, x: Any, c: Any, tolerance: float, before: Any
    ) -> Any:
        once, exact = (solve(system, near, x, c, least, before) for least in (1e3, 1e-11))
        if before is not None and once.newton.error > 1e-9:
            assert (once.newton.iterations, exact.newton.iterations > 1) == (1, True)
            parts.append(system.norm(once.q - exact.q) / once.newton.error)
        return exact

    monkeypatch.setattr(rope_system, "SMALL", 1e3)
    monkeypatch.setattr(RopeSystem, "_newton", watched)
    list(followed(RopeSimulator(rope_120("draft").scene), winding(90.0, 8.0), 400, 0.04))
    assert len(parts) > 200
    assert max(parts) < 1.0


def test_a_step_to_a_swivel_event_that_diverges_is_taken_up_again_with_a_shorter_one() -> None:
    released = Swivel(mode="coulomb", release_time=10.0)
    even = Solver(
        step_max=0.03, tolerance=1e6, newton_tolerance=1e-7
    )  # no step is rejected for its error
    scene = rope_scene(find_case("kiruna-710").rope).with_(
        left=released, right=released, solver=even
    )
    twisted = scene.with_(rope=replace(scene.rope, installed_twist=9.0), model=Model("torsional"))
    step, ends = scene.solver.step_max, winding(400.0, 16.0)
    rope = NativeRope(twisted)
    for k in followed(rope, ends, round(13.2 / step), step):
        assert k * step > 10.0 or rope.signals(("count.rejections",))["count.rejections"] == 0
    assert rope.state.counts.swivel_events > 5
    assert rope.state.counts.rejections > 1


def test_a_transformation_without_equilibrium_gets_less_time_and_is_refused_at_the_least(
    form: Form,
) -> None:
    motions, h = winding(45.0, 8.0), 0.02
    scene = Scene(rope=PLAIN, solver=fixed_steps(h))
    rope, k = hung(balance_rope(scene, form), *motions(0.0)), 0
    while not rope.state.counts.transformations:  # due where the last step began
        before, k = rope.save(), k + 1
        assert rope.advance_to(k * h, *motions(k * h)).valid
    assert rope.state.counts.rejections == 0
    pushed = np.array([[1e7, 0.0, 0.0]])  # N: throws an element off within T < 0.1 s
    rope.apply(PointForces(np.array([20.0]), pushed, pushed, 0.0, 10.0))
    rope.restore(before)
    start = rope.time
    assert rope.advance_to(start + 1e-4, *motions(start + 1e-4)).valid
    assert (rope.state.counts.transformations, rope.state.counts.rejections) == (
        1,
        7,
    )  # T = 0.1 s / 2^7
    rope.restore(before)
    rope.retune(scene.with_(solver=replace(scene.solver, step_min=0.01)))
    status = rope.advance_to(start + 1e-4, *motions(start + 1e-4))
    assert not status.valid
    assert "transformation of the mesh fails" in status.message
    assert (rope.time, rope.state.counts.transformations) == (start, 0)


#: thirteen elements: no form's lanes are full at the end
BASE = Scene(
    rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=13), left=Swivel(mode="coulomb")
)
SHAFT = Shaft(
    lining=Lining(width=3.4, depth=3.0),
    contact=Contact(rope_stiffness=1e7),
    air=Air(density=1.2, vx=4.0),
)
WIDE = {
    "torsional": BASE,
    "spatial": BASE.with_(model=Model(fidelity="spatial")),
    "planar": BASE.with_(model=Model(fidelity="planar"), left=Swivel(mode="locked")),
    "curved wires": BASE.with_(
        rope=Rope(
            length=30.0,
            EI_stick=2000.0,
            initial_curvature=0.05,
            curvature_4=0.03,
            curvature_middle_across=0.02,
        )
    ),
    "shaft": BASE.with_(shaft=SHAFT),
}


@pytest.fixture(scope="module", params=[(2, "avx2"), (4, "avx512vbmi")], ids=["plain", "wide"])
def narrower(request: pytest.FixtureRequest) -> type[NativeRope]:
    """The rope whose processor says that its vectors are narrower than they are."""
    (lanes, has), flags, compiler = request.param, Path("/proc/cpuinfo"), find_compiler()
    if (
        platform.machine() != "x86_64"
        or not flags.is_file()
        or has not in flags.read_text(encoding="utf-8")
    ):
        pytest.skip(f"asks Linux on x86_64 for a processor with {has}")
    if compiler is None:
        pytest.skip("needs a C compiler")
    library = declare(ctypes.CDLL(str(library_of(lanes, compiler))))

    class Narrower(NativeRope):
        _library = staticmethod(lambda: library)

    return Narrower


@pytest.mark.parametrize("name", WIDE)
def test_all_forms_have_the_same_bits(narrower: type[NativeRope], name: str) -> None:
    def parting(t: float) -> Ends:
        up = float(t > 0.0)  # from rest, at once
        return EndMotion(y=0.5 * t * t, vy=t, ay=up), EndMotion(y=-0.5 * t * t, vy=-t, ay=-up)

    ropes = NativeRope(WIDE[name]), narrower(WIDE[name])
    wide, narrow = ([rope.signals() for _ in followed(rope, parting, 20)] for rope in ropes)
    assert wide == narrow


def test_a_deep_rope_with_unequal_and_strong_coupling_comes_to_rest() -> None:
    """Corrections went to and fro between two shapes, and 10,000 of them ended in a refusal."""
    rope = Rope(
        length=931.0,
        Qa=1.29e8,
        Qb=-501292.0,
        Qc=-796307.0,
        Qd=10837.0,
        EI=1194.0,
        mass_per_length=12.4,
    )
    scene = Scene(rope, mesh=Mesh("auto"), layout=Layout(spacing=1.27))
    seen = hung(NativeRope(scene), right=EndMotion(y=-228.0)).signals(("left.fy", "right.fy"))
    weight = rope.mass_per_length * rope.length * scene.layout.gravity
    assert_allclose(-sum(seen.values()), weight, rtol=1e-6)
