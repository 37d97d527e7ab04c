"""The engine: steps that are repeated, cut and refused; the same bits by any optimiser, processor and vector."""

import ctypes
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from bounced_rope import SWIVEL
from numpy.testing import assert_allclose
from scenes import Ends, ends_at, fixed_steps, followed, hung

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from rope_model import (
    EndMotion,
    PointForces,
    balance_rope,
)
from rope_model.cases import rope_120, rope_240
from rope_model.codegen.build import library_of
from rope_model.compiler import find_compiler
from rope_model.engine import NativeRope, declare
from rope_model.parameters import Layout, Rope, Scene, Swivel
from rope_model.shaft_parameters import Air, Contact, Lining, Shaft
from rope_model.solver_parameters import Mesh, Model, Solver

Motions = Callable[[float], tuple[EndMotion, EndMotion]]


def winding(travel: float, speed: float) -> Motions:
    return partial(ends_at, s_curve(Winding(travel=travel, speed=speed)), travel)


CLOSE = Solver(step_max=0.04, newton_tolerance=1e-11)
STICKING = rope_240("draft").scene.with_(left=SWIVEL, right=SWIVEL, model=Model(), solver=CLOSE)
PLAIN = Rope(length=60.0)


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
    compilers = (os.environ["CC"], os.environ["OPTIMISING_CC"])
    command = [sys.executable, "-c", code]
    said = [
        subprocess.check_output(command, env=os.environ | {"CC": cc}, text=True) for cc in compilers
    ]
    assert said[0] == said[1]
    assert "left.fy" in said[0]


def test_half_steps_after_a_restored_state_are_bit_identical() -> None:
    scene = STICKING
    motions = winding(200.0, 10.0)
    h = 0.02
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


def test_a_step_that_takes_one_correction_errs_by_no_more_than_the_tolerance() -> None:
    """The engine accepts a correction for the error that it is reckoned to leave, and makes no other to see."""
    tolerance = 1e-5
    states = []
    errors = []
    for newton in (tolerance, 1e-11):
        # as long as the host's, so that both take the same steps
        solver = replace(fixed_steps(0.04), newton_tolerance=newton)
        rope = NativeRope(rope_120("draft").scene.with_(solver=solver, model=Model("torsional")))
        hung(rope, *winding(90.0, 8.0)(0.0))
        states.append(rope)
    loose, exact = states
    for k in range(1, 200):
        exact.restore_native(loose.native_state())
        before = loose.state.counts.newton
        for rope in (loose, exact):
            assert rope.advance_to(0.04 * k, *winding(90.0, 8.0)(0.04 * k)).valid
        if loose.state.counts.newton - before > 1:
            continue
        off = loose.state.motion.q - exact.state.motion.q
        errors.append(float(np.abs(off[:, :3]).max()))
    assert len(errors) > 100
    assert max(errors) < tolerance, sorted(errors)[-5:]


def test_a_step_to_a_swivel_event_that_diverges_is_taken_up_again_with_a_shorter_one() -> None:
    released = Swivel(mode="coulomb", release_time=10.0)
    even = Solver(
        step_max=0.03, tolerance=1e6, newton_tolerance=1e-7
    )  # no step is rejected for its error
    scene = rope_scene(find_case("kiruna-710").rope).with_(
        left=released, right=released, solver=even
    )
    twisted = scene.with_(rope=replace(scene.rope, installed_twist=9.0), model=Model("torsional"))
    step = scene.solver.step_max
    ends = winding(400.0, 16.0)
    rope = NativeRope(twisted)
    for k in followed(rope, ends, round(13.2 / step), step):
        assert k * step > 10.0 or rope.signals(("count.rejections",))["count.rejections"] == 0
    assert rope.state.counts.swivel_events > 5
    assert rope.state.counts.rejections > 1


def test_a_transformation_without_equilibrium_gets_less_time_and_is_refused_at_the_least() -> None:
    motions = winding(45.0, 8.0)
    h = 0.02
    scene = Scene(rope=PLAIN, solver=fixed_steps(h))
    rope = hung(balance_rope(scene), *motions(0.0))
    k = 0
    while not rope.state.counts.transformations:  # due where the last step began
        before = rope.save()
        k += 1
        assert rope.advance_to(k * h, *motions(k * h)).valid
    assert rope.state.counts.rejections == 0
    pushed = np.array([[1e7, 0.0, 0.0]])  # N: throws an element off within T < 0.1 s
    rope.apply(PointForces(np.array([20.0]), pushed, pushed, 0.0, 10.0))
    rope.restore(before)
    start = rope.time
    assert rope.advance_to(start + 1e-4, *motions(start + 1e-4)).valid
    assert (rope.state.counts.transformations, rope.state.counts.rejections) == (
        1,
        8,
    )  # T = 0.1 s / 2^8
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
    lanes, has = request.param
    flags = Path("/proc/cpuinfo")
    compiler = find_compiler()
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
    wide, narrow = (followed(rope, parting, 20) for rope in ropes)
    for _ in zip(wide, narrow, strict=True):
        assert ropes[0].signals() == ropes[1].signals()


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
