"""The element's frames against frames built from numbers."""

import numpy as np
from conftest import rotation
from element_states import ELEMENT, MATERIAL, STEP, STRAIN, Array, State, balance, energy, seeds, some_state, turned
from scipy.integrate import solve_ivp

from rope_model.physics.frame import smallest_rotation_rate


def curve(x: Array) -> tuple[Array, Array, Array]:
    """r, r' (n, 3) and theta (n,) of a smooth, bent and twisted rope."""
    r = np.column_stack((np.sin(1.3 * x), x + 0.2 * x**2, 0.5 * np.cos(2 * x)))
    d = np.column_stack((1.3 * np.cos(1.3 * x), 1 + 0.4 * x, -np.sin(2 * x)))
    return r, d, 0.8 * np.sin(2 * x)


def on_curve(l: float) -> Array:
    """(14,): an element of length l on the curve."""
    r, d, theta = curve(np.array([0.3, 0.3 + l]))
    return np.column_stack((r, d, theta)).ravel()


@seeds
def test_what_becomes_the_reference_keeps_its_energies_and_its_spin(seed: int) -> None:
    s, P = some_state(seed), some_state(seed).P(**MATERIAL)
    q, v = s.q.copy(), s.v.copy()
    gained = np.asarray(ELEMENT.transport(q, v, s.a, s.l, s.F)).ravel()
    q[13] += gained[0]
    own = State(q, v, s.a, s.l, q)
    before, after = energy(s.q, s.v, s.l, s.F, P, STRAIN), energy(q, v, s.l, own.F, P, STRAIN)
    np.testing.assert_allclose(after, before, rtol=1e-12)
    # the angle's rate at the right node and its own rate: those of the spin there
    d, d_t, d_tt = (x[10:13] for x in (s.q, s.v, s.a))
    p = s.reference[10:13] / np.linalg.norm(s.reference[10:13])

    def spin(t: float) -> float:
        at, rate = d + t * d_t + 0.5 * t * t * d_tt, d_t + t * d_tt
        return float(smallest_rotation_rate(p, np.zeros(3), at, rate))

    expected = [spin(0.0), (spin(STEP) - spin(-STEP)) / (2 * STEP)]
    np.testing.assert_allclose(gained[1:], expected, rtol=1e-7, atol=1e-7)


def test_the_way_to_a_shape_does_not_matter_but_for_the_quadrature() -> None:
    rng, error, rest = np.random.default_rng(2), [], np.zeros(14)
    maps = np.eye(3) + 0.4 * rng.normal(size=(3, 3, 3))
    for l in (0.2, 0.1, 0.05):
        shapes = [turned(on_curve(l), A) for A in maps]
        frames = [ELEMENT.reference(x, l) for x in shapes]
        turn = sum(float(ELEMENT.transport(shapes[k], rest, rest, l, frames[k - 1])[0]) for k in range(3))
        # the frame at a node has turned by the area that the node's tangents enclose on the sphere
        first, last = (area(*(x[k : k + 3] for x in shapes)) for k in (3, 10))
        error.append(abs(turn - (last - first)))
    # three Gauss points: error l^7 per element, or less where its factor changes sign
    assert np.min(np.log2(np.array(error[:-1]) / error[1:])) > 6.5


def area(*corners: Array) -> float:
    """Signed area of the spherical triangle of these directions."""
    a, b, c = (x / np.linalg.norm(x) for x in corners)
    return 2.0 * float(np.arctan2(a @ np.cross(b, c), 1 + a @ b + b @ c + c @ a))


def test_a_rigid_rotation_dissipates_nothing_but_for_the_interpolation() -> None:
    # the angle is linear between the nodes, so is its rate: the spin of a section errs by l^2, the power by its square
    w, power = np.array([0.3, -1.1, 0.7]), []
    for l in (0.1, 0.05, 0.025):
        q, v = on_curve(l), np.zeros(14)
        for k in (0, 3, 7, 10):
            v[k : k + 3] = np.cross(w, q[k : k + 3])
        v[[6, 13]] = [w @ q[k : k + 3] / np.linalg.norm(q[k : k + 3]) for k in (3, 10)]
        s = State(q, v, v, l, q)
        P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
        power.append(balance(q, v, l, s.F, P)["damping_power"] / l)
        v[13] += l  # and a rotation with twisting does
        assert balance(q, v, l, s.F, P)["damping_power"] / l > 1e-3
    np.testing.assert_allclose(np.log2(np.array(power[:-1]) / power[1:]), 4.0, atol=0.3)


def smallest_rotation(pole: Array, t: Array) -> Array:
    """(3, 3): the smallest rotation from ``pole`` to ``t``."""
    axis = np.cross(pole, t)
    sine, cosine = float(np.linalg.norm(axis)), float(pole @ t)
    return rotation(axis / sine * np.arctan2(sine, cosine))


@seeds
def test_the_frame_rate_is_how_fast_the_frame_turns_about_the_tangent(seed: int) -> None:
    s, rng = some_state(seed), np.random.default_rng(seed)
    (d, pole), (change, pole_change) = (s.q[3:6], s.reference[3:6]), rng.normal(size=(2, 3))

    def unit(x: Array) -> Array:
        return np.asarray(x / np.linalg.norm(x))

    def frame_at(x: float) -> Array:
        p = unit(pole + x * pole_change)
        # carried along to the neighbour of the pole without turning about it
        carried = smallest_rotation(unit(pole), p) if x else np.eye(3)
        return smallest_rotation(p, unit(d + x * change)) @ carried

    here = frame_at(0.0)
    np.testing.assert_allclose(here @ unit(pole), unit(d), atol=1e-15)
    # d(frame)/dx frame^T is the cross product with the turning vector
    spin = (frame_at(STEP) - frame_at(-STEP)) / (2 * STEP) @ here.T
    turning = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
    turn = np.cross(pole, pole_change) / (pole @ pole)
    found = smallest_rotation_rate(unit(pole), turn, d, change)
    np.testing.assert_allclose(found, turning @ unit(d), rtol=1e-6, atol=1e-7)


def test_a_section_turned_with_the_rope_has_the_twist_of_the_element() -> None:
    # carried along the curve, turning at tau about the tangent: theta' = tau where the curve is the reference
    pole, rate = np.array([0.6, 0.0, 0.8]), 0.7

    def tangent(x: float) -> Array:
        d = curve(np.array([x]))[1][0]
        return np.asarray(d / np.linalg.norm(d))

    def rotation(x: float, m: Array) -> Array:
        t, t_x = tangent(x), (tangent(x + STEP) - tangent(x - STEP)) / (2 * STEP)
        return np.cross(np.cross(t, t_x) + rate * t, m)

    e = np.array([0.0, 1.0, 0.0])  # across the pole
    start = smallest_rotation(pole, tangent(0.0)) @ e
    section = solve_ivp(rotation, (0.0, 1.0), start, rtol=1e-10, atol=1e-12).y[:, -1]
    # the same from a straight reference along the pole, to the curve's own
    zero, t = smallest_rotation(pole, tangent(1.0)) @ e, tangent(1.0)
    theta = np.arctan2(np.cross(zero, section) @ t, zero @ section)
    straight_rope = np.tile(np.concatenate((np.zeros(3), pole, [0.0])), 2)
    s, gained, rest = np.linspace(0.0, 1.0, 21), 0.0, np.zeros(14)
    for i in range(20):
        r, d, _ = curve(s[i : i + 2])
        straight_rope[7:10] = pole * (s[i + 1] - s[i])
        F = ELEMENT.reference(straight_rope, s[i + 1] - s[i])
        q = np.column_stack((r, d, np.zeros(2))).ravel()
        gained += float(ELEMENT.transport(q, rest, rest, s[i + 1] - s[i], F)[0])
    # cubics of 1/20 of the curve
    np.testing.assert_allclose(theta + gained, rate, atol=1e-5)
