"""Swivels that start relaxed: at a rest that friction can hold, from where they have slid to."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose
from scenes import hung, smooth_trip, wound

from rope_model import BalanceRope, EndMotion, Mesh, Model, Rope, RopeSimulator, Scene, Solver, Swivel, balance_rope
from rope_model.physics.swivel import friction_moment

SIDES = ("left", "right")
HEALTHY, FREE = Swivel(mode="coulomb"), Swivel(mode="free")
ROPE, RIGHT = Rope(length=40.0), EndMotion(y=20.0)
PLAIN = Scene(rope=ROPE, mesh=Mesh("eem", elements=24), left=HEALTHY, right=HEALTHY)
CURVED = Rope(length=40.0, initial_curvature=0.3, initial_curvature_angle=0.8)
SCENES = {
    "healthy": PLAIN,
    "one seized": PLAIN.with_(left=Swivel(), rope=Rope(length=40.0, installed_twist=1.0)),
    "free": PLAIN.with_(left=FREE, right=FREE),
    "one coefficient": PLAIN.with_(left=replace(HEALTHY, mu_static=0.0013), right=replace(HEALTHY, mu_static=0.0013)),
    # locked, its loop would wind up by more than a turn
    "twisted": PLAIN.with_(rope=Rope(length=40.0, installed_twist=15.0)),
    # its torque is not the same all along: both swivels slide
    "curved": PLAIN.with_(rope=CURVED),
}


def limit(rope: BalanceRope, swivel: Swivel, side: str) -> float:
    """Moment (N m) that the bearing holds, from the end's tension; the statics end within some 1e-8 N m."""
    if swivel.mode != "coulomb":
        return 0.0 if swivel.mode == "free" else 1e3
    tension = -rope.signals()[f"{side}.fy"]
    return friction_moment(swivel.mu_static, swivel.mean_diameter, swivel.seal_moment, tension)


@pytest.mark.parametrize("name", SCENES)
def test_friction_holds_the_rope_at_the_start_and_nothing_moves_then(name: str) -> None:
    scene = SCENES[name]
    rope = hung(balance_rope(scene), right=RIGHT)
    start, saved = rope.signals(), rope.save()
    for side, swivel in zip(SIDES, (scene.left, scene.right), strict=True):
        assert abs(start[f"{side}.swivel.torque"]) <= limit(rope, swivel, side) + 1e-8
    for _ in range(2):
        rope.restore(saved)
        for k in range(1, 51):
            assert rope.advance_to(0.02 * k, EndMotion(), RIGHT).valid
        later = rope.signals()
        for key in ("left.swivel.angle", "right.swivel.angle", "loop.yaw", "loop.x", "loop.y"):
            assert abs(later[key] - start[key]) < 1e-7
        if name == "healthy":
            assert later["count.swivel_events"] == 0


@pytest.mark.parametrize("twist", [0.0, 15.0])
def test_the_weaker_swivel_slides_by_the_angle_of_the_torque_that_it_does_not_hold(twist: float) -> None:
    rope = hung(balance_rope(PLAIN.with_(rope=replace(ROPE, installed_twist=twist))), right=RIGHT)
    now, (short, long) = rope.signals(), (10.0, 30.0)
    # of vertical legs with their ends held: D / L times the twist, and by the mean tension; that of 1 m of loop is not
    torsion = ROPE.Qd - ROPE.Qs**2 / ROPE.Qa
    held = ROPE.Qc / ROPE.Qa * ROPE.mass_per_length * 9.81 * (short**2 + long**2) / (2 * ROPE.length)
    kinetic = friction_moment(HEALTHY.mu_kinetic, HEALTHY.mean_diameter, 0.0, -now["left.fy"])
    assert_allclose(now["right.swivel.torque"], kinetic, rtol=1e-6)
    slid = (held - kinetic) * ROPE.length / torsion - 2 * now["loop.yaw"]
    assert_allclose(now["left.swivel.angle"], twist + slid, rtol=0, atol=0.05 * slid)
    assert_allclose(now["right.swivel.angle"], twist, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["healthy", "one seized", *(pytest.param(name, marks=pytest.mark.slow) for name in ("twisted", "curved"))]
)
def test_both_forms_start_from_the_same_rest(name: str) -> None:
    python = SCENES[name].with_(solver=Solver(kernels="portable"))
    native, rope = (hung(rope, right=RIGHT) for rope in (balance_rope(SCENES[name]), RopeSimulator(python)))
    keys = [f"{side}.{key}" for side in SIDES for key in ("swivel.torque", "swivel.angle", "fx", "fy")]
    # as near as the forms' statics come to each other
    assert_allclose([*native.signals(keys).values()], [*rope.signals(keys).values()], rtol=1e-9, atol=1e-7)


STRONG = replace(HEALTHY, mu_static=1.0, mu_kinetic=0.9)
HELD = {
    "friction that holds": PLAIN.with_(left=STRONG, right=STRONG),
    "released later": PLAIN.with_(left=replace(HEALTHY, release_time=0.5), right=replace(HEALTHY, release_time=0.5)),
    "spatial": PLAIN.with_(left=FREE, right=FREE, model=Model("spatial")),
    "planar": PLAIN.with_(model=Model("planar")),
    "rigid": PLAIN.with_(model=Model("rigid")),
}


@pytest.mark.parametrize("name", HELD)
def test_a_swivel_without_cause_to_slide_starts_as_it_was_hung_up(name: str) -> None:
    scene = HELD[name]
    locked = scene.with_(left=replace(scene.left, start="locked"), right=replace(scene.right, start="locked"))
    one, other = (hung(balance_rope(x), right=RIGHT) for x in (scene, locked))
    assert one.signals() == other.signals()
    assert (one.rows() == other.rows()).all()


def test_a_rope_hung_anew_after_a_trip_rests_within_the_limits_band() -> None:
    dirty = replace(HEALTHY, mu_static=0.02, mu_kinetic=0.015)
    scene = PLAIN.with_(left=dirty, right=dirty, rope=replace(ROPE, beta_K=0.02, torsion_damping=10.0))
    rope = wound(balance_rope(scene), lambda t: (smooth_trip(t, 10.0, 10.0, 0.0)[0], RIGHT), 3000, 0.02)
    assert rope.state.counts.swivel_events > 0
    after, anew = rope.signals(), hung(balance_rope(scene), EndMotion(y=10.0), RIGHT).signals()
    # the same rope, its ends at the same places: its torque differs by that of its twist, D / L of theory.md
    torsion = (ROPE.Qd - ROPE.Qs**2 / ROPE.Qa) / ROPE.length
    torque, twist = (after[f"right.swivel.{key}"] - anew[f"right.swivel.{key}"] for key in ("torque", "angle"))
    twist -= after["left.swivel.angle"] - anew["left.swivel.angle"]
    twist -= 2 * (after["loop.yaw"] - anew["loop.yaw"])
    band = 2 * min(limit(rope, dirty, side) for side in SIDES)
    assert abs(torque) <= band
    assert_allclose(torque, torsion * twist, rtol=0, atol=0.05 * band)
