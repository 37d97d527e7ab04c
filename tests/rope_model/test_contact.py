"""Contact: the law, the element that has it, the rope in it."""

import math
import random
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from native_parts import fit_mesh, partition
from numpy.testing import assert_allclose, assert_array_equal
from scenes import hung, smooth_step, wound
from shared import difference

from rope_model import EndMotion, Mesh, Rope, Scene, Solver, balance_rope
from rope_model.method.mesh_fit import BLOW
from rope_model.method.mesh_pattern import WINDOW_DUE
from rope_model.physics import hermite
from rope_model.physics.contact import (
    ONSET,
    SUMS,
    ContactTerms,
    contact_law,
    correction_motion,
    largest_motion,
)
from rope_model.physics.contact_element import CONTACT_BALANCE, contact_element
from rope_model.physics.contact_error import (
    ContactSums,
    add_contact,
    contact_error,
    delay,
    length_for,
)
from rope_model.physics.element import (
    BALANCE,
    ELEMENT_DOF,
    ElementFidelity,
    element_functions,
    parameters,
)
from rope_model.physics.rope_contact import points_skipped
from rope_model.physics.shaft import KINDS, Body, distance, normal
from rope_model.shaft_parameters import Contact, Divider, Lining, Shaft, Sump

DIAMETER = 0.044
REST = (0.0, 0.0, 0.0)


def some_body(chance: random.Random, side: float) -> Body:
    def vector(low: float, high: float) -> tuple[float, float, float]:
        return chance.uniform(low, high), chance.uniform(low, high), chance.uniform(low, high)

    yaw = chance.uniform(-3, 3)
    return Body(
        vector(-1, 1), vector(0.1, 1), chance.uniform(0.01, 0.3), math.cos(yaw), math.sin(yaw), side
    )


def touched(seed: int) -> tuple[Body, tuple[float, ...]]:
    """A body and a point at which the rope is pressed."""
    chance = random.Random(seed)
    while True:
        body = some_body(chance, (-1.0, 1.0)[seed % 2])
        point = tuple(c + chance.uniform(-1.5, 1.5) for c in body.centre)
        if 0 < 0.5 * DIAMETER - distance(point, body) < DIAMETER:
            return body, point


def law(
    body: Body, point: Any, speed: Any = REST, c_q: float = 0.0, c_v: float = 0.0, **changed: float
) -> ContactTerms:
    return contact_law(
        Contact(**changed), DIAMETER, body, (0.1, -0.2, 0.3), tuple(point), tuple(speed), c_q, c_v
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_normal_is_the_gradient_of_the_distance(side: float) -> None:
    chance = random.Random(1)
    x = ca.SX.sym("x", 3)
    for _ in range(50):
        body = some_body(chance, side)
        gradient = ca.Function("gradient", [x], [ca.gradient(distance(x, body), x)])
        point = tuple(c + chance.uniform(-1.5, 1.5) for c in body.centre)
        n = normal(point, body)
        assert_allclose(n, np.array(gradient(point)).ravel(), atol=1e-12)
        # in a shaft: behind its wall
        assert body.side * distance(point, body) < 1e-3 or np.linalg.norm(n) == pytest.approx(
            1.0, abs=1e-8
        )


@pytest.mark.parametrize("turned", [0.0, 0.1, 1.0, 100.0])
def test_no_place_of_an_element_moves_by_more_than_half_of_what_its_nodes_say(
    turned: float,
) -> None:
    """Nodes that move and turn so that all adds up: the other half is for what it may come to."""
    chance = np.random.default_rng(1)
    l = 0.7
    for moved in chance.uniform(size=(100, 4)) * [1.0, turned, 1.0, turned]:
        rows = np.zeros((2, 6))
        rows[:, 1] = moved[[0, 2]]
        rows[:, 4] = moved[[1, 3]] * [1.0, -1.0]
        most = max(largest_motion(l, row, np.zeros(6)) for row in rows)
        for xi in np.linspace(0.0, 1.0, 21):
            assert (
                abs(np.dot(hermite.shape_functions(xi, l), rows[:, [1, 4]].ravel())) <= 0.5 * most
            )


def test_no_correction_moves_a_node_by_more_than_newtons_norm_says() -> None:
    chance = np.random.default_rng(1)
    longest = 3.0
    shortest = 0.2
    for row in chance.uniform(-1.0, 1.0, size=(100, 6)) / ([1.0] * 3 + [shortest] * 3):
        norm = np.abs(row * ([1.0] * 3 + [shortest] * 3)).max()
        assert largest_motion(longest, row, np.zeros(6)) <= correction_motion(
            norm, longest, shortest
        )


@pytest.mark.parametrize("seed", range(6))
def test_the_force_is_the_energys_gradient_without_losses(seed: int) -> None:
    body, point = touched(seed)

    def energy(p: Any) -> list[float]:
        return [law(body, p).sums[0]]

    force = law(body, point, friction=0.0, damping=0.0).force
    assert_allclose(
        difference(energy, point, 1e-6)[0], -np.array(force), atol=1e-5 * np.abs(force).max()
    )


@pytest.mark.parametrize("seed", range(6))
def test_the_tangent_is_the_forces_derivative_where_nothing_is_left_out(seed: int) -> None:
    """Across the surface, and along it where the pressure does not change with the speed."""
    body, point = touched(seed)
    n = np.array(normal(point, body))
    upper = np.zeros((3, 3))
    upper[np.triu_indices(3)] = law(body, point, c_q=1.0, friction=0.0, damping=0.0).tangent
    stiffness = difference(lambda p: law(body, p, friction=0.0, damping=0.0).force, point, 1e-6)
    assert_allclose(n @ (np.triu(upper, 1).T + upper) @ n, -n @ stiffness @ n, rtol=1e-5)
    speed = np.array((0.3, 0.1, -0.2))
    upper[np.triu_indices(3)] = law(body, point, speed, c_v=1.0, damping=0.0).tangent
    damping = difference(lambda v: law(body, point, v, damping=0.0).force, speed, 1e-6)
    assert_allclose(np.triu(upper, 1).T + upper, -damping, atol=1e-6 * np.abs(damping).max())


@pytest.mark.parametrize("seed", range(10))
def test_losses_are_never_negative_and_the_body_never_draws(seed: int) -> None:
    body, point = touched(seed)
    chance = random.Random(seed)
    for _ in range(20):
        sums = law(body, point, [chance.uniform(-9, 9) for _ in range(3)], damping=1.0).sums
        assert sums[SUMS.index("pressure")] >= 0
        assert sums[SUMS.index("dissipated")] >= 0


def element_case(fidelity: ElementFidelity, contact: Contact) -> tuple[list[Any], list[Any]]:
    """Inputs of the plain element, and of that with a floor and a divider, which lies on and in them."""
    rng = np.random.default_rng(3)
    dof = ELEMENT_DOF[fidelity]
    q = np.array([0, 0, 0, 1, 0.1, 0, 0.1, 1, 0.05, 0, 1, -0.1, 0, 0.3]) + 0.005 * rng.normal(
        size=14
    )
    kept = [*dof, *(7 + i for i in dof)]
    q = q[kept]
    v = rng.normal(size=len(kept))
    a = rng.normal(size=len(kept))
    element = element_functions(fidelity)
    l = 1.01
    F = np.array(element.reference(q, l)).ravel()
    P = np.array(parameters(Rope(), 9.81))
    floor = Body((0.0, -10.0, 0.0), (1e3, 10.02, 1e3), 0.0, 1.0, 0.0, 1.0)
    bar = Body((0.6, 0.2, 0.0), (0.0, 0.0, 9.0), 0.16, 1.0, 0.0, 1.0)
    numbers = [contact.stiffness, contact.damping, contact.friction, contact.slip_speed, 0.2]
    for body in (floor, bar):
        numbers += [*body.centre, *body.half, *body[2:], 0.0, 0.1, 0.2]
    return [q, v, a, l, F, P], [q, v, a, l, np.append(F, (1.0, 1.0)), np.append(P, numbers)]


@cache
def touching(fidelity: ElementFidelity) -> Any:
    return contact_element(
        fidelity, element_functions(fidelity), (KINDS.index("floor"), KINDS.index("divider"))
    )


@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_the_elements_contact_residual_is_its_energys_gradient_and_its_derivative_the_tangent(
    fidelity,
) -> None:
    element = touching(fidelity)
    without = element_functions(fidelity)
    lossless = Contact(friction=0.0, damping=0.0)
    plain, near = element_case(fidelity, lossless)

    def energy(q: Any) -> list[float]:
        return [float(element.balance(q, near[1], *near[3:])[BALANCE.index("damping_power") + 2])]

    def residual(q: Any) -> Any:
        return np.array(element.residual(q, *near[1:]) - without.residual(q, *plain[1:])).ravel()

    added = residual(near[0])
    assert np.abs(added).max() > 1e3
    assert_allclose(added, difference(energy, near[0], 1e-6)[0], atol=1e-5 * np.abs(added).max())
    near[4][-1] = 0.0  # a flat floor alone
    tangent = np.array(
        element.tangent(*near, 1, 0, 0, near[0])[1] - without.tangent(*plain, 1, 0, 0, plain[0])[1]
    )
    assert np.abs(tangent).max() > 1e3
    assert_allclose(tangent, difference(residual, near[0], 1e-6), atol=1e-5 * np.abs(tangent).max())


LONG_ELEMENT = 2.0  #: m
THIN = 0.01  #: m, size of a bar
PRESSED = 3e-3  #: m by which it is pressed in


def pressure_of_bar(place: float, size: float = THIN, pressed: float = PRESSED) -> float:
    """Force (N) of a round bar under two level elements in line, its axis at ``place`` (m) from their joint."""
    contact = Contact()
    total = 0.0
    for start in (-LONG_ELEMENT, 0.0):
        q = np.array([start, 0, 0, 1, 0, 0, 0, start + LONG_ELEMENT, 0, 0, 1, 0, 0, 0])
        bar = Body(
            (place, pressed - 0.5 * (size + DIAMETER), 0.0),
            (0.0, 0.0, 9.0),
            0.5 * size,
            1.0,
            0.0,
            1.0,
        )
        law = [contact.stiffness, contact.damping, contact.friction, contact.slip_speed, DIAMETER]
        P = [*parameters(Rope(), 9.81), *law, *bar.centre, *bar.half, *bar[2:], 0.0, 0.0, 0.0]
        element = contact_element("torsional", element_functions(), (KINDS.index("divider"),))
        rest = np.zeros(14)
        F = np.array(element_functions().reference(q, LONG_ELEMENT)).ravel()
        sums = np.array(element.balance(q, rest, LONG_ELEMENT, [*F, 1.0], P)).ravel()
        total += float(sums[len(BALANCE) + CONTACT_BALANCE.index("divider")])
    return total


def exact_pressure(size: float, pressed: float) -> float:
    """The integral along a straight line."""
    radius = 0.5 * (size + DIAMETER)
    onset = ONSET * DIAMETER
    half = math.sqrt(radius**2 - (radius - pressed) ** 2)
    x = np.linspace(-half, half, 200001)
    depth = radius - np.hypot(x, radius - pressed)
    soft = np.minimum(depth, onset)
    return float(np.trapezoid(Contact().stiffness * (soft**2 / (2.0 * onset) + depth - soft), x))


@pytest.mark.parametrize("pressed", [1e-4, PRESSED, 0.5 * DIAMETER])
def test_a_thin_bar_presses_as_much_wherever_it_is_along_the_elements(pressed: float) -> None:
    exact = exact_pressure(THIN, pressed)
    for place in (0.0, 1e-3, *np.linspace(-0.9, 0.9, 37)):
        # four Gauss points on each of four pieces whose ends have a square root of the depth
        assert pressure_of_bar(float(place), pressed=pressed) == pytest.approx(exact, rel=1e-3)


def test_what_a_thin_bar_presses_changes_smoothly_with_its_place() -> None:
    """From element to element, and from cell to cell: no jump where pieces begin or end elsewhere."""
    found = np.array([pressure_of_bar(x) for x in np.linspace(-0.03, 0.03, 121)])
    assert np.abs(np.diff(found)).max() < 1e-4 * found.mean()


@given(st.floats(0.0, math.inf), st.floats(1e-3, 0.1), st.floats(1e-4, 1.0), st.integers(1, 1000))
@example(9e134, 0.044, 0.011, 90)
@example(math.nan, 0.044, 0.011, 90)
def test_no_more_places_are_skipped_than_there_are(distance, diameter, weight, number):
    assert 0.0 <= points_skipped(distance, diameter, weight, float(number)) <= number


def test_what_a_mesh_does_not_resolve_falls_with_the_square_of_its_delay() -> None:
    def error(tau: float) -> float:
        sums = ContactSums()
        h = 1e-3
        longest = length_for(Scene(), tau)
        for k in range(1000):
            pressures = (0.0, 0.0, 0.0, 50.0 * (1.0 - math.cos(2.0 * math.pi * k * h)), 0.0, 7.0)
            sums = add_contact(Scene(), sums, h, pressures, longest)
        assert sums.largest == pytest.approx(100.0, rel=1e-3)
        assert sums.impulses == pytest.approx((0.0, 0.0, 0.0, 50.0, 0.0, 7.0), rel=1e-3)
        return float(contact_error(sums))

    assert math.log2(error(0.02) / error(0.01)) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("EI", [1e-6, 300.0, 1e5])
def test_the_length_of_a_delay_has_that_delay(EI: float) -> None:
    scene = Scene(Rope(EI=EI))
    assert delay(scene, length_for(scene, 0.01)) == pytest.approx(0.01, rel=1e-12)
    assert delay(scene, 0.0) == 0.0


@pytest.mark.parametrize("length", [30.0, 120.0, 1000.0])
@pytest.mark.parametrize("offset", [-0.9, 0.0, 0.7])
def test_elements_that_a_divider_may_press_follow_its_pressure(
    length: float, offset: float
) -> None:
    beside = Shaft(divider_2=Divider(size=0.05, y=-5.0, offset=offset))
    scene = Scene(Rope(length=length), mesh=Mesh("auto"), shaft=beside)
    mesh = fit_mesh(scene)
    places = [0.5]
    if mesh.kind != "eem":
        places.append(0.2)
    longest = max(partition(mesh, length, place * length).lengths.max() for place in places)
    # whole numbers of elements make those of a pattern a little longer than asked for
    assert longest < 1.05 * length_for(scene, BLOW)


@pytest.mark.parametrize(
    "shaft",
    [
        Shaft(divider_1=Divider(size=0.05, y=-5.0, offset=3.0)),
        Shaft(divider_1=Divider(size=0.05, y=-5.0, offset=-0.9), contact=Contact(stiffness=0.0)),
        Shaft(lining=Lining(width=6.0, depth=6.0), sump=Sump(level=-80.0)),
    ],
)
def test_bodies_that_are_far_do_not_hold_or_are_wide_leave_the_mesh(shaft: Shaft) -> None:
    assert fit_mesh(Scene(mesh=Mesh("auto"), shaft=shaft)) == fit_mesh(Scene(mesh=Mesh("auto")))


def test_an_element_near_no_body_is_the_plain_one() -> None:
    plain, near = element_case("torsional", Contact())
    near[4][-2:] = 0.0
    element = touching("torsional")
    without = element_functions()
    assert_array_equal(np.array(element.residual(*near)), np.array(without.residual(*plain)))
    tangents = (
        element.tangent(*near, 1, 2, 3, near[0])[1],
        without.tangent(*plain, 1, 2, 3, plain[0])[1],
    )
    assert_array_equal(*map(np.array, tangents))
    assert not np.array(element.balance(near[0], near[1], *near[3:]))[-len(CONTACT_BALANCE) :].any()


#: coupling, and height of the left end, m; in the way of the floor legs stood on it as bars, with
#: forces of some MN
@pytest.mark.parametrize(("coupling", "left"), [(0.0, -10.0), (1.0, 0.0)])
def test_a_rope_whose_floor_is_high_lies_on_it_and_hangs_from_its_ends(
    coupling: float, left: float
) -> None:
    plain = Rope(length=60.0)
    level = -20.0
    rope = Rope(length=60.0, Qb=coupling * plain.Qb, Qc=coupling * plain.Qc)
    scene = Scene(rope, mesh=Mesh("eem", elements=45), shaft=Shaft(sump=Sump(level=level)))
    seen = hung(balance_rope(scene), left=EndMotion(y=left)).signals(
        ("left.fy", "right.fy", "contact.floor")
    )
    weight = rope.mass_per_length * rope.length * scene.layout.gravity
    legs = (left - 2 * level) * rope.mass_per_length * scene.layout.gravity
    # the legs hang freely, and what lies on the floor hardly pulls at them
    assert_allclose(-seen["left.fy"] - seen["right.fy"], legs, rtol=0.1)
    assert_allclose(seen["contact.floor"], weight - legs, rtol=0.3)


def test_a_rope_on_its_way_to_rest_jumps_over_no_thin_beam() -> None:
    """Its right leg, which coupling moves by .48 m where the beam is, comes to rest against it."""
    beam = Divider(size=0.03, y=-45.0, offset=1.25, rounding=1.0)
    scene = Scene(Rope(length=110.0), mesh=Mesh("auto"), shaft=Shaft(divider_1=beam))
    rope = hung(balance_rope(scene))
    nodes = rope.rows()
    right = nodes[np.argmin(nodes[:, 2]) :]
    at_beam = right[np.argmin(np.abs(right[:, 2] - beam.y)), 1]
    assert at_beam < beam.offset
    assert rope.signals(("contact.divider",))["contact.divider"] > 10.0


def test_a_mesh_that_is_transformed_on_a_floor_keeps_the_energy_balance() -> None:
    """TMN-ETM on 30 m of rope, whose loop drags over the floor through several transformations."""
    mesh = Mesh("tmn", coarse_length=1.0, counts=(2, 4, 40, 4, 2))
    shaft = Shaft(sump=Sump(level=-13.6))
    scene = Scene(rope=Rope(length=30.0), mesh=mesh, shaft=shaft)
    speed = 3.0
    ramp = 1.0

    def motion(t: float) -> tuple[EndMotion, EndMotion]:
        s = min(t / ramp, 1.0)
        y = speed * (ramp * s**4 * (2.5 - 3 * s + s * s) + max(t - ramp, 0.0))
        v = speed * s**3 * (10 - 15 * s + 6 * s * s)
        a = speed * 30 * (s * (1 - s)) ** 2 / ramp
        return EndMotion(y=y, vy=v, ay=a), EndMotion(y=-y, vy=-v, ay=-a)

    rope = wound(balance_rope(scene, "native"), motion, 500, 0.005)
    energy = rope.state.energy_balance
    assert rope.state.counts.transformations > 2
    assert rope.signals(["contact.floor"])["contact.floor"] > 10
    assert energy.dissipated_contact > 10
    assert abs(energy.residual) < 1e-3 * energy.work_ends
    assert abs(energy.transformations) < 1e-3 * energy.work_ends


@pytest.mark.slow
def test_windows_follow_a_rope_that_is_lifted_past_a_divider() -> None:
    """The loop stays where it is on the rope: only windows move."""
    leans = Shaft(divider_1=Divider(size=0.1, y=-12.0, offset=-0.95))
    solver = Solver(step_max=0.01, tolerance=1e3)
    scene = Scene(rope=Rope(length=40.0, EI=30.0), shaft=leans, solver=solver)
    native = wound(balance_rope(scene), lifted, 60).state
    travelled = lifted(1.0)[0].y / native.partition.coarse
    assert 0 <= native.counts.transformations - travelled / WINDOW_DUE + 1.0 < travelled
    energy = native.energy_balance
    assert native.contact.impulses[KINDS.index("divider")] > 1.0
    assert abs(energy.transformations) < 1e-6 * energy.work_ends


def lifted(t: float) -> tuple[EndMotion, EndMotion]:
    y, v, a = (2.0 * x for x in smooth_step(t, 0.0, 0.6))
    return (EndMotion(y=y, vy=v, ay=a),) * 2
