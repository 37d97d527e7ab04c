"""The assumed axial strain: no locking, no motion without energy, and exact where the rope is straight."""

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import hung
from shared import Array, rotation

from rope_model import Mesh, Rope, Scene, balance_rope
from rope_model.physics import costello, hermite
from rope_model.physics.curved_element import CURVED_SIZE, curved_element
from rope_model.physics.element import (
    LEGENDRE_SQUARES,
    PARAMETERS,
    POINTS,
    WEIGHTS,
    AxialStrain,
    element_functions,
    interpolation,
    relative_coordinates,
    strains_at_nodes,
)
from rope_model.physics.node import NODE_DOF

ELEMENT = element_functions()
MATERIAL = {"Qa": 1e8, "Qs": 2e5, "Qd": 3e3, "EI": 300.0}


def parameters(**material: float) -> Array:
    return np.array([material.get(name, 0.0) for name in PARAMETERS])


def slopes(q: Array, l: float) -> tuple[Array, Array]:
    """r' and r'' (3, points) of an element."""
    rows = [(q[k], q[3 + k], q[7 + k], q[10 + k]) for k in range(3)]
    d = [[hermite.interpolate(xi, l, *row)[1] for xi in POINTS] for row in rows]
    c = [[hermite.bend(xi, l, *row) for xi in POINTS] for row in rows]
    return np.array(d), np.array(c)


def mean_strain(q: Array, l: float) -> float:
    return float(np.linalg.norm(slopes(q, l)[0], axis=0) @ np.array(WEIGHTS)) - 1.0


def unstrained(seed: int, turn: float) -> tuple[Array, float]:
    """A bent element in space without axial and torsional strain, and its length; it turns by ``turn`` (rad)."""
    chance = np.random.default_rng(seed)
    l = 1.7
    pose = rotation(chance.normal(size=3))
    tangents = [pose @ rotation(0.5 * turn * chance.normal(size=3)) @ [1.0, 0.0, 0.0] for _ in "lr"]
    q = np.zeros(2 * NODE_DOF)
    q[3:6], q[10:13] = tangents
    direction = pose @ np.array([1.0, 0.1 * turn, -0.05 * turn])
    shortest = 0.5 * l
    longest = 1.5 * l
    for _ in range(60):  # the chord with which the mean vanishes
        chord = 0.5 * (shortest + longest)
        q[7:10] = chord * direction
        if mean_strain(q, l) > 0:
            longest = chord
        else:
            shortest = chord
    return q, l


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("seed", range(4))
def test_no_motion_but_the_rigid_ones_goes_without_energy(turn: float, seed: int) -> None:
    """The element with a permanent curvature that is its present one, so that nothing is stressed."""
    q, l = unstrained(seed, turn)
    curved = curved_element(ELEMENT)
    d, c = slopes(q, l)
    k0 = np.cross(d, c, axis=0) / np.sum(d * d, axis=0)
    frame = np.asarray(ELEMENT.reference(q, l)).ravel()
    numbers = np.concatenate((k0.T.ravel(), [q[6], q[13], MATERIAL["EI"]]))
    assert numbers.size == CURVED_SIZE
    still = np.zeros(2 * NODE_DOF)
    F = np.concatenate((frame, numbers))
    R, J = curved.tangent(q, still, still, l, F, parameters(**MATERIAL), 1.0, 0.0, 0.0, q)
    assert_allclose(np.asarray(R).ravel(), 0.0, atol=1e-4)
    # a rotation turns the frame, but for the quadrature of its turn
    squares = np.linalg.eigvalsh(np.asarray(J))
    assert np.abs(squares[:6]).max() < 1e-3 * squares[6]
    assert squares[6] > 0.05 * MATERIAL["EI"]


def test_a_straight_rope_is_stretched_and_twisted_evenly_on_uneven_elements() -> None:
    e = 1e-3
    tau = 0.2
    material = MATERIAL | {"Qk": 3e3, "Qe": 40.0}
    P = parameters(**material)
    balance = np.zeros((4, NODE_DOF))
    s = 0.0
    for k, l in enumerate((0.3, 1.9, 0.8)):
        q = np.zeros((2, NODE_DOF))
        q[:, 0] = (1.0 + e) * np.array([s, s + l])
        q[:, 3] = 1.0 + e
        q[:, 6] = tau * np.array([s, s + l])
        flat = q.ravel()
        still = np.zeros_like(flat)
        R = ELEMENT.residual(flat, still, still, l, ELEMENT.reference(flat, l), P)
        balance[k : k + 2] += np.asarray(R).reshape(2, NODE_DOF)
        s += l
    laws = {name: material[name] for name in ("Qa", "Qs", "Qk", "Qe")}
    tension = costello.tension(*laws.values(), e, tau)
    torque = costello.torque(material["Qs"], material["Qk"], material["Qd"], material["Qe"], e, tau)
    expected = np.zeros_like(balance)
    expected[[0, -1], 0] = -tension, tension
    expected[[0, -1], 6] = -torque, torque
    assert_allclose(balance, expected, atol=1e-9 * tension)


def test_a_rope_that_hangs_plumb_is_exact() -> None:
    """Its strain is linear, its height a parabola."""
    length = 5.0
    P = parameters(**MATERIAL, rho=8.0, g=9.81)
    weight = 8.0 * 9.81
    nodes = np.array([0.0, 1.1, 2.0, length])
    balance = np.zeros((4, NODE_DOF))
    for k, l in enumerate(np.diff(nodes)):
        s = nodes[k : k + 2]
        q = np.zeros((2, NODE_DOF))
        tension = weight * (length - s)
        q[:, 1] = -s - weight * (length * s - 0.5 * s**2) / MATERIAL["Qa"]
        q[:, 4] = -1.0 - tension / MATERIAL["Qa"]
        flat = q.ravel()
        still = np.zeros_like(flat)
        F = ELEMENT.reference(flat, l)
        uncoupled = P.copy()
        uncoupled[PARAMETERS.index("Qs")] = 0.0
        R = ELEMENT.residual(flat, still, still, l, F, uncoupled)
        balance[k : k + 2] += np.asarray(R).reshape(2, NODE_DOF)
    expected = np.zeros_like(balance)
    expected[0, 1] = weight * length
    assert_allclose(balance, expected, atol=1e-7)


def test_a_hanging_loop_converges_with_the_fourth_power_of_the_elements_length() -> None:
    """Its height and the pull at its ends, whatever the axial stiffness."""
    for Qa in (1e7, 1.2e8):
        rope = Rope(length=48.0, Qa=Qa, Qb=0.0, Qc=0.0)
        found = []
        for elements in (24, 48, 96, 384):
            hanging = hung(balance_rope(Scene(rope, mesh=Mesh("eem", elements=elements))))
            found.append([*hanging.signals(["left.fx", "loop.y"]).values()])
        errors = np.abs(np.array(found[:-1]) - found[-1])
        orders = np.log2(errors[:-1] / errors[1:])
        assert orders.min() > 3.7
        # of elements of 1 m: 0.06 % and 1 mm
        assert errors[1, 0] < 1e-3 * abs(found[-1][0])
        assert errors[1, 1] < 1e-3


def test_the_strain_before_stiffens_the_element_by_all_its_parts() -> None:
    """The tangent with another element's strain has the forces of that strain in its geometric stiffness."""
    chance = np.random.default_rng(5)
    q, l = unstrained(1, 0.6)
    before = q + 1e-3 * chance.normal(size=q.size)
    x = ca.SX.sym("x", q.size)
    relative = relative_coordinates()
    mean = sum(
        w * ca.norm_2((interpolation(xi, ca.SX(l)) @ relative @ x)[:3])
        for xi, w in zip(POINTS, WEIGHTS, strict=True)
    )
    parts = AxialStrain.of(mean - 1, *strains_at_nodes(x))
    expected = np.zeros((q.size, q.size))
    for part, factor in zip(parts, LEGENDRE_SQUARES, strict=True):
        strain = ca.Function("strain", [x], [part])
        bend = ca.Function("bend", [x], [ca.hessian(part, x)[0]])
        change = float(strain(before)) - float(strain(q))
        assert abs(change) > 1e-5
        expected += l * MATERIAL["Qa"] * factor * change * np.asarray(bend(q).full())
    still = np.zeros(q.size)
    F = ELEMENT.reference(q, l)
    P = parameters(**MATERIAL)
    with_it, without = (
        np.asarray(ELEMENT.tangent(q, still, still, l, F, P, 1.0, 0.0, 0.0, y)[1])
        for y in (before, q)
    )
    assert_allclose(with_it - without, expected, rtol=0, atol=1e-9 * np.abs(with_it).max())
