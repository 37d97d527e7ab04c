"""The audit of the rope's motion: silent where the motion is right, and not where it is made wrong."""

from dataclasses import replace

import pytest
from scenes import Trip, hung, wound

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from rope_model import EndMotion, Mesh, Rope, RopeSimulator, Scene, Solver
from rope_model.engine import NativeRope
from rope_model.numerics.generalized_alpha import Coefficients
from rope_model.physics.accuracy import turned_by_mesh
from rope_model.simulation.ends.ends import HangingEnds
from rope_model.simulation.rope_system import Array

pytest.importorskip("rope_model.codegen.build")

FOUND = {"missing_loads", "unresolved_waves", "unresolved_bend"}
SHORT = Scene(rope=Rope(length=60.0))
AT_REST = EndMotion(y=0.0), EndMotion(y=40.0)
H = 0.01
NO_CONTROL = 1e6  # of the step's error


def wind(case: Trip) -> NativeRope:
    """The native rope after the whole trip."""
    scene = rope_data(find_case(case.scene).rope, case.level)
    if scene.solver.step_max < case.H:
        # the host's steps are the rope's, however much they err; what Newton's method leaves of such steps, up to 52 N
        # at its default tolerance, would be missing too
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
def test_the_audit_is_silent_in_windings_releases_emergency_stops_and_transformations(case: Trip) -> None:
    rope = wind(case)
    state, audit = rope.state, rope.state.audit
    assert state.counts.transformations > 20
    assert state.counts.swivel_events > 20 or case.scene == "rope-120"
    assert not FOUND & rope.warnings().keys()
    # a tenth of what is told
    assert audit.missing_force < 1e-4 * audit.force
    assert audit.missing_moment < 5e-4 * audit.force * rope.scene.layout.spacing


def test_a_smooth_trip_may_take_long_steps_but_an_emergency_stop_in_them_is_told() -> None:
    rope = wind(Trip("rope-120", "emergency stop", "standard", 0.04))
    told = rope.warnings()
    assert FOUND & told.keys() == {"unresolved_waves"}
    # 40 ms in the axial period of half the rope are 1.55; Newton's method shortens some
    assert rope.signals(["audit.steps_per_period"])["audit.steps_per_period"] < 3.0
    assert "(bound 3)" in told["unresolved_waves"]
    # a sixth of that period, 62 ms
    assert "lower step_max to 0.01 s" in told["unresolved_waves"]


def test_a_force_of_100_newtons_that_acts_inside_for_one_step_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The ends' forces then do not answer for all of the accelerations."""
    rope = wound(RopeSimulator(SHORT.with_(solver=Solver(tolerance=NO_CONTROL))), lambda _: AT_REST, 1)
    loads = HangingEnds.load

    def with_blow(self: HangingEnds, nodes: int) -> Array:
        load = loads(self, nodes)
        load[nodes // 2, 1] += 100.0
        return load

    with monkeypatch.context() as patched:
        patched.setattr(HangingEnds, "load", with_blow)
        rope.model._latest.clear()
        assert rope.advance_to(2 * H, *AT_REST).valid
    rope.model._latest.clear()
    # what the method makes in its first step of a force that has just come
    method = Coefficients(SHORT.solver.rho_inf)
    part = method.gamma * (1 - method.alpha_f) / (1 - method.alpha_m)
    assert rope.state.audit.missing_force == pytest.approx(100.0 * part, rel=1e-6)
    assert "are missing between the end forces, the weight" in rope.warnings()["missing_loads"]


@pytest.mark.parametrize(
    ("mesh", "told"),
    [
        *((Mesh("eem", elements=n), "sharpest bend") for n in (24, 40)),
        (Mesh("eem", elements=60), "too long for the bend"),
        *((mesh, None) for mesh in (Mesh("eem", elements=80), Mesh(), Mesh("auto"))),
    ],
)
def test_elements_too_long_for_the_bend_are_told_and_no_others(mesh: Mesh, told: str | None) -> None:
    rope = wound(NativeRope(SHORT.with_(mesh=mesh)), lambda t: AT_REST, 1)
    assert ("unresolved_bend" in rope.warnings()) == (told is not None)
    assert (told or "") in rope.warnings().get("unresolved_bend", "")


def test_what_a_coarse_mesh_does_to_the_loop_is_told_before_anything_moves() -> None:
    """60 equal elements on the 120 m rope: yawed by 1.2 degrees for 3.0, and 13 cm too high."""
    scene, ends = Scene(), (EndMotion(y=30.0), EndMotion())
    found = []
    for mesh in (Mesh("eem", elements=60), Mesh("auto", loop_error=5e-4)):
        rope = hung(NativeRope(scene.with_(mesh=mesh)), *ends)
        found.append(rope.signals(("loop.y", "loop.yaw", "status.loop_error")))
        text = rope.warnings().get("unresolved_bend", "")
        assert ("elements of 2 m" in text) == (mesh.kind == "eem")
    coarse, fine = found
    off, turned = coarse["loop.y"] - fine["loop.y"], abs(coarse["loop.yaw"] - fine["loop.yaw"])
    assert 0.5 < coarse["status.loop_error"] / off < 2.0
    assert turned > 0.5 * abs(fine["loop.yaw"])
    assert 0.5 < turned_by_mesh(scene, 2.0) / turned < 2.0
