"""Permanent curvature: its energy, rods with closed forms, the 45 degree bend, ropes that have it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from curved_scenes import EI, K0, scene
from numpy.testing import assert_allclose
from rods import CurvedRod, nothing_held
from scenes import hung, passed, smooth_step, wound
from scipy.integrate import solve_ivp
from scipy.optimize import root
from shared import Array, difference, rotation
from signal_names import of_both_ends

from rope_model import EndMotion, Layout, Mesh, Model, Rope, Scene, Solver, Swivel, balance_rope
from rope_model.parameters import Attachment, SwivelMode
from rope_model.physics.curved_element import curved_functions
from rope_model.physics.element import element_functions
from rope_model.physics.initial_curvature import START, curvature_components, curvature_vectors
from rope_model.reference.statics import find_equilibrium

BENT = curved_functions()
ELEMENT = element_functions()
#: the elements are the beginning of this rope
SET = Rope(
    length=3.0,
    initial_curvature=K0,
    initial_curvature_angle=0.7,
    curvature_left=0.1,
    curvature_middle_across=0.2,
)


def numbers(q: Array, l: float, e1: Any = START) -> Array:
    """What a curved element has in its reference ``q`` (14,)."""
    return np.concatenate(
        (curvature_vectors(curvature_components(SET, 0.0, l), l, q, e1)[:9], q[[6, 13]], [EI])
    )


def frame(q: Array, l: float) -> Array:
    return np.array(ELEMENT.reference(q, l)).ravel()


def element_state(seed: int) -> tuple[Array, float]:
    """An element that is bent, twisted and stretched; its left end hangs down."""
    chance = np.random.default_rng(seed)
    l = 1.3
    slopes = np.array([[0.0, -1.02, 0.0], [0.3, -0.9, 0.2]]) + np.array(
        [[0.0], [0.1]]
    ) * chance.normal(size=3)
    left = chance.normal(size=3)
    right = left + l * (slopes.mean(axis=0) + 0.05 * chance.normal(size=3))
    return np.concatenate(
        (left, slopes[0], chance.normal(size=1), right, slopes[1], chance.normal(size=1))
    ), l


def energy(q: Array, l: float, F: Array, C: Array) -> float:
    return float(BENT.energy(q, l, F, C))


@pytest.mark.parametrize("seed", range(4))
def test_force_and_tangent_are_derivatives_of_the_energy(seed: int) -> None:
    reference, l = element_state(seed)
    F = frame(reference, l)
    C = numbers(reference, l)
    q = reference + 0.2 * np.random.default_rng(seed + 10).normal(size=14)
    R = np.array(BENT.residual(q, l, F, C)).ravel()
    J = np.array(BENT.tangent(q, l, F, C, 1.0))
    assert_allclose(R, difference(lambda x: energy(x, l, F, C), q), atol=1e-8)
    assert_allclose(
        J, difference(lambda x: np.array(BENT.residual(x, l, F, C)).ravel(), q), atol=1e-8
    )
    assert np.abs(J).max() > 0.1


def test_a_rigid_turn_costs_nothing() -> None:
    q, l = element_state(1)
    Q = rotation(np.array([0.5, -0.8, 0.3]))
    turned = q.copy()
    for at in (0, 3, 7, 10):
        turned[at : at + 3] = Q @ q[at : at + 3]
    before = energy(q, l, frame(q, l), numbers(q, l))
    after = energy(turned, l, frame(turned, l), numbers(turned, l, tuple(Q @ START)))
    assert after == pytest.approx(before, rel=1e-12)


def on_a_curve(l: float, moved: float) -> Array:
    """An element of length ``l`` on a smooth space curve, which has ``moved``; at its left end it hangs down."""
    q = []
    for s in (0.0, l):
        still = 0.4 * s**2 + 0.1 * s**3, -s + 0.1 * s**3, 0.15 * s**3 - 0.05 * s**2
        way = 0.2 * s**2 + 0.3 * s**3, 0.2 * s**2, 0.5 * s**2 - 0.2 * s**4
        slope = 0.8 * s + 0.3 * s**2, -1 + 0.3 * s**2, 0.45 * s**2 - 0.1 * s
        turn = 0.4 * s + 0.9 * s**2, 0.4 * s, s - 0.8 * s**3
        q += [a + moved * b for a, b in zip((*still, *slope), (*way, *turn), strict=True)]
        q.append(0.3 * s)
    return np.array(q)


def test_the_energy_stays_when_the_present_shape_becomes_the_reference() -> None:
    """But for what three Gauss points leave, per length and step: it falls with the sixth power of the length."""
    changes = []
    for l in (1.0, 0.5, 0.25):
        reference = on_a_curve(l, 0.0)
        q = on_a_curve(l, 0.01)
        F = frame(reference, l)
        C = numbers(reference, l)
        now = q.copy()
        now[13] += np.array(ELEMENT.transport(q, 0 * q, 0 * q, l, F)).ravel()[0]
        changes.append(abs(energy(now, l, frame(now, l), numbers(now, l)) - energy(q, l, F, C)) / l)
    orders = np.log2(np.array(changes[:-1]) / changes[1:])
    assert (orders > 5.5).all(), (changes, orders)


def arc(elements: int, k: float, length: float) -> Array:
    """q of a rod bent to a circle, from the origin down, to where the loop of a rope bends."""
    s = np.linspace(0.0, length, elements + 1)
    q = np.zeros((elements + 1, 7))
    q[:, 0] = 0.5 * k * s**2 * np.sinc(0.5 * k * s / np.pi) ** 2
    q[:, 1] = -s * np.sinc(k * s / np.pi)
    q[:, 3] = np.sin(k * s)
    q[:, 4] = -np.cos(k * s)
    return q


ROD = Rope(length=2.0, Qb=0.0, Qc=0.0, EI=300.0, initial_curvature=0.4)


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5, 1.0])
def test_a_bent_rod_that_is_turned_about_itself_stores_the_closed_form(part: float) -> None:
    """Half a turn of all sections costs 2 EI k k0 L; the torques of all nodes are its slope."""
    k = 0.5
    k0 = ROD.initial_curvature
    L = ROD.length
    turn = math.pi * part
    q = arc(4, k, L)
    q[:, 6] = turn
    rod = CurvedRod.of_rope(ROD, q, nothing_held(q))
    R = rod.residual(q, 0 * q, 0 * q)
    bending = rod.bending(q)
    # a cubic of 0.5 m bent by 0.25 rad errs by (k l)^4 / 720 = 5e-6 of its curvature
    assert bending == pytest.approx(
        0.5 * ROD.EI * L * (k * k + k0 * k0 - 2 * k * k0 * math.cos(turn)), abs=1e-3
    )
    assert R[:, 6].sum() == pytest.approx(ROD.EI * k * k0 * math.sin(turn) * L, abs=1e-3)


@pytest.mark.slow
def test_a_straight_rod_that_is_let_go_closes_to_a_ring() -> None:
    rope = replace(ROD, length=math.pi, initial_curvature=2.0)
    q = arc(12, 0.0, rope.length)
    held = np.zeros((13, 7), dtype=bool)
    held[0, [0, 1, 2, 3, 5, 6]] = True
    found = find_equilibrium(CurvedRod.of_rope(rope, q, held), q).q
    # a cubic that turns by x = 2 pi / 12 errs by x^4 / 720 = 1e-4 of it, in twelve elements by
    # 6.6e-4; the stretch adds as much
    assert_allclose(found[-1, :6], found[0, :6], atol=2e-3)
    assert_allclose(found[:, 6], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("meshes", "within"),
    [((6, 12), 0.002), pytest.param((6, 12, 24), 0.0001, marks=pytest.mark.slow)],
)
def test_a_straight_rod_that_is_let_go_takes_a_curvature_that_varies_along_it(
    meshes: tuple[int, ...], within: float
) -> None:
    """Its sections turn as the curvature says, d1 and -d2 being e1 and e2 of the clamp; the error falls with h^2."""
    ends = np.array([[0.9, 0.1, 0.7], [-0.5, 0.3, 0.6]])
    names = ("left", "middle", "right")
    at = np.arange(7) / 6
    varying = {f"curvature_{name}": float(x) - 0.4 for name, x in zip(names, ends[0], strict=True)}
    varying |= {
        f"curvature_{name}_across": float(y) for name, y in zip(names, ends[1], strict=True)
    }
    along, across = (np.interp(at, (0.0, 0.5, 1.0), x) for x in ends)
    along[[1, 4]] += 0.5, -0.3
    across[[2, 5]] += -0.4, 0.2
    rope = replace(
        ROD,
        **varying,
        curvature_1=0.5,
        curvature_4=-0.3,
        curvature_2_across=-0.4,
        curvature_5_across=0.2,
    )

    def rates(s: float, y: Array) -> Array:
        D = y[3:].reshape(3, 3)
        bend = np.array(
            [np.interp(s / rope.length, at, along), -np.interp(s / rope.length, at, across), 0.0]
        )
        return np.concatenate((D[2], np.cross(bend @ D, D).ravel()))

    start = np.array([0, 0, 0, 0, 0, 1, 1, 0, 0, 0, -1, 0], dtype=float)
    tip = solve_ivp(rates, (0.0, rope.length), start, rtol=1e-9, atol=1e-9, max_step=0.1).y[:3, -1]
    errors = []
    for elements in meshes:
        q = arc(elements, 0.0, rope.length)
        held = np.zeros((elements + 1, 7), dtype=bool)
        held[0, [0, 1, 2, 3, 5, 6]] = True
        errors.append(
            float(
                np.abs(find_equilibrium(CurvedRod.of_rope(rope, q, held), q).q[-1, :3] - tip).max()
            )
        )
    assert errors[-1] < within  # m, of a rod of 2 m
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 1.9).all(), errors


def test_a_cable_that_hardly_resists_torsion_takes_its_curvature() -> None:
    """Where its tangent is not positive a correction climbs, and the search has to take more inertia."""
    cable = Rope(
        length=0.9, mass_per_length=0.05, Qa=2e3, Qb=0.0, Qc=0.0, Qd=1e-4, EI=3.5e-3, rhoJ=2.25e-7
    )
    along = replace(cable, curvature_left=0.05, curvature_middle=-1.15, curvature_right=0.37)
    rope = replace(
        along, curvature_left_across=0.83, curvature_middle_across=0.34, curvature_right_across=1.25
    )
    of = scene(Mesh("eem", elements=16)).with_(rope=rope, layout=Layout(spacing=0.4))
    found = hung(balance_rope(of), right=EndMotion(y=0.1)).signals(
        ["loop.yaw", "left.fy", "right.fy"]
    )
    # recorded from this engine (-0.011685 in the limit); its weight is carried
    assert found["loop.yaw"] == pytest.approx(-0.0115776, abs=1e-6)
    weight = rope.mass_per_length * rope.length * of.layout.gravity
    assert found["left.fy"] + found["right.fy"] == pytest.approx(-weight, rel=1e-8)


BEND = Rope(
    length=25 * math.pi, Qa=1e7, Qb=0.0, Qc=0.0, Qd=1e7 / 12, EI=1e7 / 12, initial_curvature=0.01
)  # E = 1e7, G = E/2, 1 x 1, radius 100, 45 degrees


def bend_tip(elements: int, load: float) -> Array:
    q = arc(elements, 0.01, BEND.length)
    held = np.zeros(q.shape, dtype=bool)
    loads = np.zeros(q.shape)
    held[0, [0, 1, 2, 3, 5, 6]] = True
    loads[-1, 2] = load
    return find_equilibrium(CurvedRod.of_rope(BEND, q, held, loads), q).q[-1, :3]


def rod_tip(load: float, shear: float = 0.0) -> Array:
    """The same by shooting from the clamp: moments m, r x force, sections D (d3: tangent); ``shear`` in 1/N."""

    def rates(s: float, y: Array) -> Array:
        D = y[3:12].reshape(3, 3)
        m = y[12:]
        force = np.array([0.0, 0.0, load])
        bend = D @ m / np.array([BEND.EI, BEND.EI, BEND.Qd]) + np.array(
            [BEND.initial_curvature, 0.0, 0.0]
        )
        tangent = (1 + D[2] @ force / BEND.Qa) * D[2] + shear * (force - (D[2] @ force) * D[2])
        return np.concatenate((tangent, np.cross(bend @ D, D).ravel(), -np.cross(tangent, force)))

    def end(m: Array) -> Array:
        start = np.concatenate((np.zeros(3), [0, 0, 1, 1, 0, 0, 0, -1, 0], m))
        start[6:9] = np.cross([0, -1, 0], [0, 0, 1])
        end: Array = solve_ivp(rates, (0.0, BEND.length), start, rtol=1e-8, atol=1e-6).y[:, -1]
        return end

    x, y, _ = PUBLISHED[load][1]
    found = root(lambda m: end(m)[12:] / load, load * np.array([-y, -x, 0.0]), tol=1e-9)
    assert found.success
    return end(found.x)[:3]


#: tip of the 45 degree bend, without the sense of the axes, from K.-J. Bathe and S. Bolourchi, Int.
#: J. Numer. Methods Eng. 14 (1979), and J. C. Simo and L. Vu-Quoc, Comput. Methods Appl. Mech. Eng.
#: 58 (1986)
PUBLISHED = {
    300.0: ((22.5, 59.2, 39.5), (22.33, 58.84, 40.08)),
    600.0: ((15.9, 47.2, 53.4), (15.79, 47.23, 53.37)),
}


@pytest.mark.parametrize(
    ("load", "meshes", "within"),
    [
        (600.0, (4, 8), 0.03),
        pytest.param(300.0, (4, 8, 16), 0.005, marks=pytest.mark.slow),
        pytest.param(600.0, (4, 8, 16), 0.005, marks=pytest.mark.slow),
    ],
)
def test_the_45_degree_bend(load: float, meshes: tuple[int, ...], within: float) -> None:
    """Published by elements of straight beams; the curved element converges to the rod's equations."""
    exact = rod_tip(load)
    errors = [float(np.abs(bend_tip(elements, load) - exact).max()) for elements in meshes]
    assert errors[-1] < within  # m, of a radius of 100 m
    assert errors[0] < 0.06
    # its torsional strain is uniform, and the torque along a curved rod is not: second order, from
    # below (1.90 from 4 to 8 elements, 1.98 from 8 to 16)
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > (1.89, 1.97)[: len(errors) - 1]).all(), (
        errors
    )
    # eight straight beams of each: 0.7 % and 0.11 % of the radius
    for tip, within in zip(PUBLISHED[load], (0.695, 0.11), strict=True):
        assert_allclose(np.abs(exact), tip, atol=within)
    # they shear, with G A = E A / 2
    assert_allclose(rod_tip(load, 2.0 / BEND.Qa), exact, rtol=0, atol=0.004)


def uncoupled(angle: float, k0: float = K0) -> Scene:
    return scene(Qb=0.0, Qc=0.0, initial_curvature=k0, initial_curvature_angle=angle).with_(
        model=Model("torsional")
    )


def test_in_its_plane_a_clamped_rope_only_takes_the_moment() -> None:
    """The work of a uniform moment goes with the turn from end to end, which clamps fix."""
    straight = hung(balance_rope(uncoupled(0.0, 0.0)))
    curved = hung(balance_rope(uncoupled(0.0)))
    # three Gauss points integrate the curvature of elements of 1 m to 1e-5 of the turn
    assert_allclose(curved.state.motion.q, straight.state.motion.q, atol=2e-5)
    now = curved.signals()
    before = straight.signals()
    moment = K0 * curved.scene.rope.EI
    assert now["left.mz"] - before["left.mz"] == pytest.approx(-moment, rel=1e-4)
    assert now["right.mz"] - before["right.mz"] == pytest.approx(moment, rel=1e-4)


def test_a_direction_is_a_turn_of_both_ends() -> None:
    """The section at the left end, and with it the whole rope, turned about the tangent."""
    # about Y: against the left tangent, along the right one
    turned = hung(balance_rope(uncoupled(0.0)), EndMotion(yaw=-1.0), EndMotion(y=2.0, yaw=1.0))
    laid = hung(balance_rope(uncoupled(1.0)), right=EndMotion(y=2.0))
    assert_allclose(turned.state.motion.q[:, :6], laid.state.motion.q[:, :6], atol=1e-7)


def test_the_energy_balance_closes_with_the_square_of_the_step() -> None:
    def missing(steps: int) -> float:
        free = Solver(step_max=1 / steps, tolerance=1e6, newton_tolerance=1e-10, rho_inf=1.0)
        of = scene(Mesh("eem", elements=40), beta_K=0.0)
        return abs(passed(replace(of, solver=free), steps, 1 / steps).state.energy_balance.residual)

    losses = [missing(steps) for steps in (200, 400, 800)]
    orders = np.log2(np.array(losses[:-1]) / losses[1:])
    assert (orders > 1.7).all(), (losses, orders)


def test_a_transformed_mesh_keeps_the_direction() -> None:
    """Torque and yaw along a winding are those of a mesh that stays; nothing else makes them without coupling."""
    of = uncoupled(1.0)
    of = of.with_(rope=replace(of.rope, curvature_middle=0.2, curvature_right_across=-0.1))
    solver = Solver(step_max=0.005)
    tmn = passed(of.with_(mesh=Mesh("tmn", coarse_length=0.25), solver=solver), 120)
    eem = passed(of.with_(mesh=Mesh("eem", elements=80), solver=solver), 120)
    assert tmn.state.counts.transformations >= 1
    one = tmn.signals()
    other = eem.signals()
    for name in ("left.my", "right.my", "loop.yaw"):
        assert one[name] == pytest.approx(other[name], rel=0.01), name
    energy = tmn.state.energy_balance
    assert abs(energy.transformations) < 1e-3 * energy.strain


def end_about_vertical(end: EndMotion, x0: float, angle: float) -> EndMotion:
    """Return the ``end``, whose nominal point is at ``x0`` (m), of a hoist turned by ``angle`` (rad) about Y."""
    c = math.cos(angle)
    s = math.sin(angle)
    x = x0 + end.x
    lean = end.lean
    return replace(
        end,
        x=x * c + end.z * s - x0,
        z=end.z * c - x * s,
        yaw=end.yaw + angle,
        lean=lean * c + end.lean_z * s,
        lean_z=end.lean_z * c - lean * s,
    )


LEANING = scene(Mesh("eem", elements=20), Qb=0.0, Qc=0.0)
ATTACHMENTS: tuple[tuple[Attachment, SwivelMode, EndMotion, EndMotion], ...] = (
    ("plumb", "locked", EndMotion(), EndMotion()),
    ("hinged", "locked", EndMotion(x=-0.5), EndMotion(z=0.5)),
    ("hinged", "free", EndMotion(x=-0.5), EndMotion(z=0.5)),
    ("clamped", "locked", EndMotion(lean=0.4), EndMotion(lean=-0.3)),
    ("clamped", "locked", EndMotion(lean_z=0.4), EndMotion(lean_z=0.2)),
    ("clamped", "free", EndMotion(lean=0.3, lean_z=0.4), EndMotion(lean_z=0.2)),
)


@pytest.mark.parametrize(("attachment", "mode", "left", "right"), ATTACHMENTS)
def test_a_curved_rope_turned_about_the_vertical_loads_its_ends_alike(
    attachment: Attachment, mode: SwivelMode, left: EndMotion, right: EndMotion
) -> None:
    held = Swivel(mode=mode, attachment=attachment)
    angle = 1.2
    of = LEANING.with_(left=held, right=held)
    loads = []
    for turned in (0.0, angle):
        side = 0.5 * of.layout.spacing
        ends = end_about_vertical(left, -side, turned), end_about_vertical(right, side, turned)
        found = hung(balance_rope(of), *ends).signals()
        names = (*of_both_ends("fx", "fy", "fz"), *of_both_ends("mx", "my", "mz"))
        vectors = np.array([found[name] for name in names]).reshape(4, 3)
        c = math.cos(turned)
        s = math.sin(turned)
        loads.append([(x * c - z * s, y, x * s + z * c) for x, y, z in vectors])
    # a locked hinge also keeps a twist of 1e-5 rad from the way on which the search for the
    # equilibrium turned it, with and without curvature; the others differ by rounding
    within = 1e-8
    if (attachment, mode) == ("hinged", "locked"):
        within = 1e-4
    assert_allclose(loads[1], loads[0], rtol=0, atol=within * float(np.abs(loads[0]).max()))


@pytest.mark.parametrize("attachment", ["hinged", "clamped"])
def test_no_energy_appears_where_the_left_end_of_a_curved_rope_turns(
    attachment: Attachment,
) -> None:
    """A clamp that leans round a cone, or a hinge that is moved aside, takes the curvature along."""

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        x, v, a = smooth_step(t, 0.0, 1.0)
        turn = 4.0 * x
        size = 0.4 * x * (attachment == "clamped")
        lean = size * math.cos(turn)
        lean_z = size * math.sin(turn)
        return EndMotion(z=0.5 * x, vz=0.5 * v, az=0.5 * a, lean=lean, lean_z=lean_z), EndMotion(
            y=x, vy=v, ay=a
        )

    def residual_share(k0: float) -> float:
        held = Swivel(attachment=attachment)
        rope = replace(LEANING.rope, initial_curvature=k0)
        wound_up = wound(balance_rope(LEANING.with_(rope=rope, left=held, right=held)), ends, 120)
        balance = wound_up.state.energy_balance
        return abs(balance.residual) / balance.work_ends

    # the integrator's own loss is 1e-4 of the work with and without curvature
    assert residual_share(K0) < 2.0 * residual_share(0.0) + 1e-5
