"""Ends that are clamped as an input says, or hinged: against the elastica, beams, symmetries and rigid rotations."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scenes import Ends, fixed_steps, hung, smooth_step, wound
from scipy.integrate import solve_bvp

from rope_model import (
    EndMotion,
    Layout,
    Mesh,
    Rope,
    Scene,
    Solver,
    Swivel,
    balance_rope,
)
from rope_model.analysis.modes import natural_modes
from rope_model.codegen.structures import scene_structure
from rope_model.engine import NativeRope
from rope_model.method.swivel_phases import Phase
from rope_model.solver_parameters import Model

Array = NDArray[np.float64]
#: a cable of 1.2 m, hardly extensible
CABLE = Rope(
    length=1.2,
    mass_per_length=0.1,
    Qa=1e5,
    Qb=0.0,
    Qc=0.0,
    Qd=8e-3,
    EI=1e-2,
    rhoJ=1e-6,
    diameter=0.008,
    beta_K=0.02,
)
SPAN = 0.6
LEVEL = EndMotion(lean=0.5 * math.pi), EndMotion(lean=-0.5 * math.pi)


def scene(attachment: Any = "clamped", elements: int = 40, **rope: float) -> Scene:
    held = Swivel(attachment=attachment)
    mesh = Mesh("eem", elements=elements)
    solver = Solver(step_max=0.005)
    return Scene(replace(CABLE, **rope), Layout(spacing=SPAN), held, held, mesh, solver=solver)


def elastica(lean: float | None) -> tuple[float, float, float]:
    """Pull across, moment of the left end and depth of an inextensible heavy rod, symmetric; None: hinged.

    Half of it by shooting for the whole boundary value problem: EI phi'' = H sin(phi) - V cos(phi), with phi the angle
    from the horizontal, V = -w (L/2 - s) the vertical force and phi = 0 in the middle.
    """
    w = CABLE.mass_per_length * 9.81
    half = 0.5 * CABLE.length

    def slopes(s: Array, y: Array, p: Array) -> Array:
        phi, bend, _, _ = y
        return np.vstack(
            (
                bend,
                (p[0] * np.sin(phi) + w * (half - s) * np.cos(phi)) / CABLE.EI,
                np.cos(phi),
                np.sin(phi),
            )
        )

    def ends(a: Array, b: Array, p: Array) -> Array:
        held = a[1]
        if lean is not None:
            held = a[0] - (lean - 0.5 * math.pi)
        return np.array([held, a[2], a[3], b[0], b[2] - 0.5 * SPAN])

    s = np.linspace(0.0, half, 400)
    guess = np.vstack(
        (-1.2 * (1 - s / half), np.full(s.size, 2.0), 0.5 * SPAN * s / half, -0.4 * s / half)
    )
    found = solve_bvp(slopes, ends, s, guess, p=[0.3], tol=1e-9, max_nodes=100_000)
    assert found.success, found.message
    return float(found.p[0]), float(CABLE.EI * found.y[1, 0]), float(-found.y[3, -1])


@pytest.mark.parametrize("lean", [0.5 * math.pi, 0.2, None])
def test_an_end_held_at_any_angle_or_hinged_hangs_as_the_elastica(lean: float | None) -> None:
    attachment = "hinged"
    ends = (EndMotion(), EndMotion())
    if lean is not None:
        attachment = "clamped"
        ends = (EndMotion(lean=lean), EndMotion(lean=-lean))
    rope = hung(balance_rope(scene(attachment, 80), "native"), *ends)
    pull, moment, depth = elastica(lean)
    found = rope.signals(["right.fx", "right.fy", "left.mz", "loop.y"])
    # 20 elements are off by 1.1 mm, so 80 by 256 times less; the clamps give way by less, as the
    # rope does
    assert_allclose(-found["right.fx"], pull, rtol=2e-4)
    assert_allclose(
        found["right.fy"], -0.5 * CABLE.mass_per_length * 9.81 * CABLE.length, rtol=1e-6
    )
    assert_allclose(found["left.mz"], moment, atol=1e-5)
    assert_allclose(-found["loop.y"], depth, atol=1e-5)


def test_a_plane_across_is_as_good_as_that_of_the_loop() -> None:
    rope = hung(balance_rope(scene(), "native"), *LEVEL)
    side = 0.5 * SPAN
    ends = (
        EndMotion(x=s * side, z=-s * side, yaw=-0.5 * math.pi, lean_z=s * 0.5 * math.pi)
        for s in (1.0, -1.0)
    )
    across = hung(balance_rope(scene(), "native"), *ends)
    names = ("left.fx", "left.fy", "left.mz"), ("left.fz", "left.fy", "left.mx")
    (fx, fy, mz), (fz, fy_across, mx) = (
        [*r.signals(of).values()] for r, of in zip((rope, across), names, strict=True)
    )
    # X, Y, Z turned about Y becomes Z, Y, -X; both are equilibria to 1e-11 of the rope's length
    assert_allclose((fz, fy_across, -mx), (fx, fy, mz), rtol=1e-8)


@pytest.mark.parametrize(
    ("attachment", "roots"),
    [("clamped", (4.7300408, 7.8532046)), ("hinged", (math.pi, 2 * math.pi))],
)
def test_a_straight_rope_without_weight_swings_as_a_beam(
    attachment: str, roots: tuple[float, float]
) -> None:
    rope = NativeRope(scene(attachment).with_(layout=Layout(spacing=CABLE.length, gravity=1e-9)))
    if attachment == "clamped":
        hung(rope, *LEVEL)
    else:
        hung(rope)
    modes = natural_modes(rope, 6).frequencies
    exact = (
        np.square(np.divide(roots, CABLE.length))
        * math.sqrt(CABLE.EI / CABLE.mass_per_length)
        / (2 * math.pi)
    )
    # each in both planes; cubic elements are off by (k l)^4 / 720, the clamps by 1e-4 of an
    # element's length
    assert_allclose(modes[:4], np.repeat(exact, 2), rtol=2e-5)


def test_a_clamp_that_turns_about_plumb_carries_the_rope_along_without_strain() -> None:
    """The axis of a clamp goes round a cone: without spin it would turn the section by the cone's solid angle."""
    lean = 1.0
    torque = {"Qb": 0.05, "Qc": 0.05, "installed_twist": 2.0}
    rope = balance_rope(scene(**torque), "native")

    def ends(t: float) -> Ends:
        s = min(t / 4.0, 1.0)
        angle = math.pi * (10 * s**3 - 15 * s**4 + 6 * s**5)
        rate = math.pi * 30 * (s * (1 - s)) ** 2 / 4.0
        bend = math.pi * 60 * s * (1 - s) * (1 - 2 * s) / 16.0
        c = math.cos(angle)
        z = -math.sin(angle)
        r = 0.5 * SPAN
        motions = (
            EndMotion(
                x=r * k * (c - 1),
                z=r * k * z,
                vx=r * k * z * rate,
                vz=-r * k * c * rate,
                ax=r * k * (z * bend - c * rate**2),
                az=-r * k * (c * bend + z * rate**2),
                yaw=angle * math.cos(lean),
                yaw_rate=rate * math.cos(lean),
                lean=-k * lean * c,
                lean_z=-k * lean * z,
            )
            for k in (-1, 1)
        )
        left, right = motions
        return left, right

    names = ["left.swivel.torque", "left.fx", "left.fy", "left.my"]
    before, after = (wound(rope, ends, steps).signals(names) for steps in (0, 1000))
    # by 180 degrees: X turns round; it has swung out in 6 s, by damping of 20 ms at some 10 rad/s,
    # to 1e-3
    assert_allclose(after["left.fx"], -before["left.fx"], rtol=5e-3)
    for name in names[:1] + names[2:]:
        assert_allclose(after[name], before[name], rtol=5e-3)


def test_clamps_that_lean_in_space_keep_the_balances() -> None:
    leaning = scene(elements=12, Qb=0.02, Qc=0.02).with_(solver=fixed_steps(0.01))

    def ends(t: float) -> Ends:
        return tuple(
            EndMotion(z=t**3, vz=3 * t**2, az=6 * t, lean=k * (1.2 - t**2), lean_z=0.4 + 2 * t**2)
            for k in (1, -1)
        )

    native = wound(balance_rope(leaning), ends, 30)
    audited = native.signals(
        ["audit.momentum", "audit.moment", "energy.residual", "energy.kinetic"]
    )
    # clamps are among the loads: momentum and moment close to the step's error, energy to numerical
    # dissipation
    assert audited["audit.momentum"] < 0.01
    assert audited["audit.moment"] < 0.01
    assert abs(audited["energy.residual"]) < 0.02 * audited["energy.kinetic"]


def test_free_swivels_of_clamps_that_lean_in_space_begin_at_rest() -> None:
    free = Swivel("free", attachment="clamped")
    mesh = Mesh("eem", elements=16)
    ends = EndMotion(lean=0.3, lean_z=0.2), EndMotion(y=20.0, lean=-0.3, lean_z=0.2)
    rope = hung(balance_rope(Scene(Rope(length=60.0), left=free, right=free, mesh=mesh)), *ends)
    assert_allclose(
        [*rope.signals(["left.swivel.torque", "right.swivel.torque"]).values()], 0.0, atol=1e-6
    )


@pytest.mark.parametrize("attachment", ["hinged", "clamped"])
def test_the_strain_of_an_end_does_not_feel_that_it_turns(
    parts: SimpleNamespace, attachment: Any
) -> None:
    q = np.random.default_rng(3).random((4, 7))
    turn = np.zeros((4, 7))
    node = int(attachment == "clamped")
    turn[:, 3:6] = np.cross([0.3, -0.2, 0.5], q[:, 3:6])
    strain = parts.end_strain(scene_structure(scene(attachment)), 4, q, turn + 2e-3 * q, 0)
    assert strain == pytest.approx(2e-3 * float(np.linalg.norm(q[node, 3:6])), rel=1e-12)


def test_only_a_clamp_leans() -> None:
    rope = balance_rope(scene("hinged", 12))
    assert (
        "left.swivel.attachment = clamped"
        in rope.initialize(0.0, EndMotion(lean=0.1), EndMotion()).message
    )
    hung(rope, EndMotion(), EndMotion())
    rigid = hung(balance_rope(scene("hinged", 12).with_(model=Model("rigid"))))
    assert_allclose(rigid.state.motion.q[[0, -1], 0], (-0.5 * SPAN, 0.5 * SPAN))
    assert (
        "right.lean_z = 0.1 rad"
        in rope.advance_to(0.01, EndMotion(), EndMotion(lean_z=0.1)).message
    )
    told = (
        hung(balance_rope(scene(elements=12)))
        .advance_to(0.01, EndMotion(lean_z=0.01), EndMotion())
        .message
    )
    assert re.search(r"left.lean_z .* 333 rad/s\^2 \(inputs.acceleration_max = 100\)", told), told


RUBS = Swivel(
    mode="coulomb",
    attachment="hinged",
    mu_static=0.1,
    mu_kinetic=0.08,
    release_time=0.01,
    start="locked",
)


def test_the_friction_of_a_swivel_grows_with_the_tension_along_a_rope_that_leans() -> None:
    """A rope of 30 m between hinges 29 m apart pulls mostly sideways."""
    held = replace(RUBS, mode="locked")
    rope = Rope(length=30.0)
    taut = Scene(
        rope, Layout(spacing=29.0), RUBS, held, Mesh("eem", elements=60), model=Model("torsional")
    )

    def turning(t: float) -> Ends:
        angle, rate, _ = (6.0 * x for x in smooth_step(t, 0.0, 1.0))
        return EndMotion(yaw=angle, yaw_rate=rate), EndMotion()

    wound_up = wound(balance_rope(taut), turning, 50)
    assert wound_up.state.swivels[0].phase is Phase.SLIP
    found = wound_up.signals(["left.fx", "left.fy", "left.fz", "left.swivel.torque"])
    *force, torque = found.values()
    # bending turns the force by 1e-2 from the tangent, which takes half its square from the tension
    assert torque == pytest.approx(
        -0.5 * RUBS.mu_kinetic * RUBS.mean_diameter * float(np.linalg.norm(force)), rel=2e-4
    )


def test_a_swivel_on_which_the_rope_stands_has_no_friction_but_its_seal() -> None:
    """The clamps hold the cable's ends upwards: its weight presses on the swivels."""
    up = EndMotion(lean=0.9 * math.pi), EndMotion(lean=-0.9 * math.pi)
    swivel = replace(
        RUBS, attachment="clamped", seal_moment=1e-4, start="relaxed", release_time=0.0
    )
    base = scene(installed_twist=1.0, Qd=0.1)
    rope = hung(balance_rope(base.with_(left=swivel), "native"), *up)
    found = rope.signals(["left.fy", "left.swivel.torque"])
    # friction of the weight alone would hold 2e-3 N m
    assert found["left.fy"] < -0.5
    assert abs(found["left.swivel.torque"]) == pytest.approx(swivel.seal_moment, rel=1e-6)


def test_a_rope_between_ends_apart_across_is_free_of_twist_where_both_conveyances_yaw_with_them() -> (
    None
):
    """Without the yaw it is twisted by twice the direction of its ends; the installed twist can take that out."""
    direction = -math.atan2(0.1, SPAN)
    plumb = scene("plumb")
    across = EndMotion(z=0.1)
    yawed = EndMotion(yaw=direction)

    def torque(of: Scene, left: EndMotion, right: EndMotion) -> float:
        return float(hung(balance_rope(of, "native"), left, right).signals()["left.swivel.torque"])

    twisted = torque(plumb, EndMotion(), across)
    assert abs(twisted) > 1e-4
    assert abs(torque(plumb, yawed, replace(across, yaw=direction))) < 1e-6 * abs(twisted)
    installed = plumb.with_(rope=replace(plumb.rope, installed_twist=2.0 * direction))
    assert abs(torque(installed, EndMotion(), across)) < 1e-6 * abs(twisted)
