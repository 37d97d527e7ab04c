"""The theory's reference numbers (section 7), each from the element's own force, stiffness and mass; how ropes hang."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from rods import chain_tangent, nothing_held, rod
from scipy.optimize import brentq, fsolve
from shared import Array, straight

from rope_model import EndMotion, Layout, Mesh, Model, Rope, Scene, Swivel
from rope_model.analysis.modes import Modes, modes_of
from rope_model.analysis.modes import natural_modes as modes_of_rope
from rope_model.analysis.modes import softest as softest_of
from rope_model.engine import NativeRope
from rope_model.physics.element import PARAMETERS, parameters
from rope_model.physics.frame import end_moment
from rope_model.physics.node import ANGLE, POSITION, SLOPE, arc_lengths
from rope_model.reference.equations import Equations
from rope_model.reference.outputs import lowest_point
from rope_model.reference.statics import (
    StaticsError,
    find_equilibrium,
    hanging_guess,
)

G = 9.81
ROPE = Rope()
UNCOUPLED = replace(ROPE, Qb=0.0, Qc=0.0)


def material(**values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in PARAMETERS])


@pytest.mark.parametrize(("Qb", "Qc"), [(2.336e5, 2.336e5), (2.371e5, 2.301e5)])
@pytest.mark.parametrize(
    ("length", "torque", "twist"), [(60.0, 4.58, 0.0242), (120.0, 9.17, 0.0967)]
)
def test_a_hanging_rope_held_at_both_ends_has_the_torque_and_twist_of_its_weight(
    length, torque, twist, Qb, Qc
) -> None:
    rope = replace(ROPE, length=length, Qb=Qb, Qc=Qc)
    s = np.linspace(0.0, length, 61)
    q = np.zeros((s.size, 7))
    q[:, 1] = -s
    q[:, 4] = -1.0
    # held against turning at both ends, lower end free to sink
    held = nothing_held(q)
    held[[0, -1]] = True
    held[0, 4] = held[-1, 1] = held[-1, 4] = False
    e = find_equilibrium(rod(np.diff(s), np.array(parameters(rope, G)), held, q), q)
    weight = rope.mass_per_length * G * length
    M0 = rope.Qc / rope.Qa * weight / 2
    D = rope.Qd - rope.Qb * rope.Qc / rope.Qa
    phi = -rope.Qc / rope.Qa * rope.mass_per_length * G / (2 * D) * s * (length - s)
    # linear theta: (1/60)^2 at worst
    assert_allclose([e.reaction[-1, ANGLE], -e.reaction[0, ANGLE]], M0, rtol=1e-3)
    assert_allclose(e.q[:, ANGLE], phi, rtol=0, atol=1e-3 * np.abs(phi).max())
    if Qb == Qc:  # the numbers as printed, to their digits
        assert_allclose([M0, np.abs(phi).max()], [torque, twist], rtol=2e-3)


def test_the_loop_yaws_and_so_relieves_the_torque_of_its_legs() -> None:
    rope = hung_up(ROPE, 0.0, right=Swivel())
    M = rope.state.motion.reaction[-1, ANGLE]
    D = ROPE.Qd - ROPE.Qb * ROPE.Qc / ROPE.Qa
    q = rope.state.motion.q
    lengths = rope.state.partition.lengths
    at_rest = rod(lengths, np.array(parameters(ROPE, G)), nothing_held(q), q)
    twist = float(lengths @ at_rest.strains(q, 0 * q)[1])
    # torque of the mean tension of two legs of 60 m, less what the twist takes back; the bend is
    # 1e-3 of the weight
    assert_allclose(M - D * twist / 120.0, 4.583, rtol=2e-3)
    # each leg is twisted by the yaw of the loop between them, which is not quite rigid
    assert_allclose(abs(twist), 2 * abs(rope.signals(["loop.yaw"])["loop.yaw"]), rtol=0.06)


#: of both sides, m; fine enough that the frequencies err by less than the independent models differ
FINE = Mesh("auto", loop_error=5e-4)


def hung_up(
    rope: Rope, height: float, right: Swivel, mesh: Mesh = FINE, spacing: float = 2.0
) -> NativeRope:
    """Return the engine's rope, locked on the left, whose left end is so far above the right one (m)."""
    scene = Scene(rope, Layout(spacing), Swivel(), right, mesh, model=Model("torsional"))
    engine = NativeRope(scene)
    status = engine.initialize(0.0, EndMotion(y=0.5 * height), EndMotion(y=-0.5 * height))
    assert status.valid, status.message
    assert engine.release_free_swivels().valid
    return engine


def stiffness_of(system: Equations, q: Array) -> Any:
    return chain_tangent(system.with_reference(q), q, (1.0, 0.0, 0.0))


def natural_modes(system: Equations, q: Array, count: int) -> Modes:
    mass = chain_tangent(system.with_reference(q), q, (0.0, 0.0, 1.0))
    return modes_of(stiffness_of(system, q), mass, ~system.held, count)


def test_axial_and_torsional_waves_run_at_the_coupled_speeds() -> None:
    # the printed speeds belong to rhoJ = rho d^2/8 = 1.936e-3 kg m, not to the data set's rounded
    # 1.94e-3
    rope = replace(ROPE, rhoJ=ROPE.mass_per_length * ROPE.diameter**2 / 8)
    length = 100.0
    n = 120
    q = straight(np.linspace(0.0, length, n + 1))
    held = nothing_held(q)
    held[:, [1, 2, 4, 5]] = True
    held[[0, -1], 0] = held[[0, -1], ANGLE] = True
    system = rod(np.full(n, length / n), np.array(parameters(rope, 0.0)), held, q)
    # modes 1 to 3 of the slow wave, then the first of the fast one
    speeds = 2 * length * natural_modes(system, q, 4).frequencies / [1, 2, 3, 1]
    # linear theta errs by (pi k/n)^2/24 < 3e-4
    assert_allclose(speeds, [1201.93, 1201.93, 1201.93, 3906.39], rtol=3e-4)


#: element lengths of half a loop, from the end down: short where the clamp and the loop bend the
#: rope
END = np.geomspace(0.1, 1.6, 9)
LEG = 1.6
LOOP = np.geomspace(1.6, 0.125, 10)


def half(length: float) -> Array:
    """Element lengths from the end to the lowest point, near those above and adding up to ``length``."""
    loop = np.concatenate((LOOP, np.full(24, 0.125)))
    count = round((length - END.sum() - loop.sum()) / LEG)
    lengths = np.concatenate((END, np.full(max(count, 0), LEG), loop))
    return np.asarray(lengths * length / lengths.sum())


def loop_system(rope: Rope, torque: float) -> Equations:
    """Return a rope that is held on the left and, but for turning by the ``torque`` (N m), on the right."""
    lengths = np.concatenate((half(60.0), half(60.0)[::-1]))
    values = np.zeros((lengths.size + 1, 7))
    held = nothing_held(values)
    loads = np.zeros_like(values)
    held[[0, -1]] = True
    held[[0, -1], 4] = False
    held[-1, ANGLE] = False
    values[[0, -1], POSITION] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    loads[-1, ANGLE] = torque
    guess = hanging_guess(arc_lengths(lengths), *values[[0, -1], POSITION])
    return rod(lengths, np.array(parameters(rope, G)), held, values, loads, guess)


OUT = {0.0: (0.06518, 0.07751, 0.17880, 0.18815), 80.0: (0.05267, 0.13533, 0.13791, 0.22317)}
IN = {0.0: (0.07759, 0.11735, 0.18137, 0.24060), 80.0: (0.07244, 0.13822, 0.19542, 0.26189)}


@cache
def frequencies(height: float, theta: str) -> tuple[Array, Array]:
    right = Swivel(mode="free")
    if theta == "held":
        right = Swivel()
    modes = modes_of_rope(hung_up(UNCOUPLED, height, right), 10)
    out = modes.out_of_plane > 0.5
    return modes.frequencies[out][:4], modes.frequencies[~out][:4]


@pytest.mark.parametrize("height", [0.0, 80.0])
def test_the_natural_frequencies_are_those_of_the_independent_models(height: float) -> None:
    out, within = frequencies(height, "swivel")
    # the reference's two meshes agree to 0.2 %
    assert_allclose(out, OUT[height], rtol=5e-3)
    assert_allclose(within, IN[height], rtol=5e-3)


def test_locked_swivels_raise_the_yaw_modes_by_up_to_a_third() -> None:
    held, free = (np.sort(frequencies(0.0, theta)[0]) for theta in ("held", "swivel"))
    # modes whose legs swing together do not twist the rope and stay; where they move oppositely the
    # loop yaws
    swings = np.array([np.min(np.abs(held - f)) < 1e-4 * f for f in free])
    assert swings.sum() == 2

    def yawing(x: Array) -> Array:
        apart = np.abs(x[:, None] - free[swings]).min(axis=1)
        return x[apart > 1e-4 * x]

    ratio = yawing(held) / yawing(free)
    assert ratio.min() > 1.05
    assert_allclose(ratio.max(), 4 / 3, rtol=0.02)  # as printed: a third


def test_a_torque_yaws_the_loop_and_moves_the_legs_oppositely() -> None:
    torque = 4.58
    aside = 0.1537
    degrees = 5.64
    system = loop_system(UNCOUPLED, torque)
    ends = system.held_motion(0.0)[0][[0, -1], POSITION]
    q = find_equilibrium(system, hanging_guess(arc_lengths(system.lengths), *ends)).q
    bottom = lowest_point(q, arc_lengths(system.lengths))
    # 3 m above the lowest point, as in the source
    lowest = int(np.argmin(q[:, 1]))
    height = bottom.position[1] + 3.0
    left, right = (np.interp(height, leg[:, 1], leg[:, 2]) for leg in (q[lowest::-1], q[lowest:]))
    # tension falls to zero in the loop, and its shape decides: the theory asks for 2 %
    assert_allclose(np.abs([left, right]), aside, rtol=0.02)
    assert left * right < 0
    assert_allclose(abs(np.degrees(bottom.yaw)), degrees, rtol=0.02)
    # the end that is held gives the torque back
    assert_allclose(
        system.with_reference(q).residual(q, 0 * q, 0 * q)[0, ANGLE],
        -torque,
        rtol=1e-3,
    )


def test_turning_the_end_of_a_cantilever_once_round_rolls_it_up_to_a_circle() -> None:
    EI = 1.3
    L = 2.0
    n = 32
    x = np.linspace(0.0, 1.0, n + 1)
    # first guess: nine tenths of the way round, but for the end
    phi = 0.9 * 2 * np.pi * x
    R = L / (0.9 * 2 * np.pi)
    q = np.zeros((n + 1, 7))
    q[:, 0] = R * np.sin(phi)
    q[:, 1] = R * (1 - np.cos(phi))
    q[:, 3] = np.cos(phi)
    q[:, 4] = np.sin(phi)
    held = nothing_held(q)
    q[[0, -1], 3:6] = 1.0, 0.0, 0.0
    held[:, [2, 5, ANGLE]] = True  # a plane problem
    held[0] = True
    held[[0, -1], 3] = False
    held[-1, 4] = True
    system = rod(np.full(n, L / n), material(rho=1.0, Qa=1e4, Qd=1.0, EI=EI), held, q)
    e = find_equilibrium(system, q)
    moment = e.q[-1, 3] * e.reaction[-1, 4]  # r' x its force
    # cubic elements of 11 degrees, and Qa 1e4: locking of 1e-4
    assert_allclose(moment, 2 * np.pi * EI / L, rtol=1e-3)
    assert_allclose(e.q[-1, :2], 0.0, atol=1e-3 * L)  # closed
    assert_allclose(e.reaction[0, :2], 0.0, atol=1e-8)  # and no force


def test_a_twisted_helix_is_held_by_loves_force_and_couple() -> None:
    a = 1.0
    alpha = np.radians(30.0)
    M_t = 0.5
    GJ = 0.8
    EA = 1e4
    n = 48
    F = 0.05801270
    K = 0.89951905
    # a turn about Z
    s = np.linspace(0.0, 2 * np.pi * a / np.cos(alpha), n + 1)
    phi = s * np.cos(alpha) / a
    stretch = 1 + F * np.sin(alpha) / EA
    q = np.zeros((n + 1, 7))
    q[:, :3] = np.column_stack((a * np.cos(phi), a * np.sin(phi), s * np.sin(alpha)))
    d = np.column_stack(
        (-np.cos(alpha) * np.sin(phi), np.cos(alpha) * np.cos(phi), np.full(n + 1, np.sin(alpha)))
    )
    q[:, SLOPE] = stretch * d
    q[:, ANGLE] = M_t / GJ * s
    held = nothing_held(q)
    held[[0, -1]] = True
    system = rod(np.diff(s), material(rho=1.0, Qa=EA, Qd=GJ, EI=1.0, rhoJ=0.1), held, q)
    e = find_equilibrium(system, q)
    # the shape is an equilibrium: it stays
    assert_allclose(e.q[:, :3], q[:, :3], atol=1e-3)
    # the couple about the axis of all that holds an end; theta's moment is about the tangent
    for node, sense in ((-1, 1.0), (0, -1.0)):
        r = e.q[node, POSITION]
        slope = e.q[node, SLOPE]
        f = e.reaction[node]
        couple = np.cross(r, f[POSITION]) + end_moment(slope, f[SLOPE], f[ANGLE])
        assert_allclose(sense * f[POSITION], [0, 0, F], atol=5e-3 * F)
        assert_allclose(sense * couple, [0, 0, K], atol=5e-3 * K)


def softest(system: Equations, q: Array, twist: float) -> float:
    """Smallest eigenvalue of the tangent with the far end turned by ``twist``."""
    q = q.copy()
    q[:, ANGLE] = twist * arc_lengths(system.lengths) / arc_lengths(system.lengths)[-1]
    return softest_of(stiffness_of(system, q), ~system.held)


def test_a_clamped_rod_buckles_at_the_known_twist() -> None:
    EI = 1.0
    GJ = 0.7
    L = 1.0
    s = np.linspace(0.0, L, 25)
    q = straight(s)
    held = nothing_held(q)
    held[[0, -1]] = True
    held[[0, -1], 3] = False
    system = rod(np.diff(s), material(Qa=1e4, Qd=GJ, EI=EI), held, q)
    twist = brentq(lambda x: softest(system, q, x), 6.0, 20.0, xtol=1e-8)
    # fourth order in l: 3e-5 with 24 elements
    assert_allclose(GJ * twist / EI, 8.986819, rtol=1e-4)


def ring_is_stable(elements: int, EI: float, GJ: float, twist: float) -> bool:
    """A closed ring of radius 1 of a straight rod, ``twist`` put in before it was closed."""
    n = elements
    x = np.linspace(0.0, 1.0, elements + 1)
    cosine = np.cos(2 * np.pi * x)
    sine = np.sin(2 * np.pi * x)
    zero = np.zeros(n + 1)

    def ring(p: Array) -> Array:
        return np.column_stack(
            (p[0] * cosine, p[0] * sine, zero, -p[1] * sine, p[1] * cosine, zero, twist * x)
        )

    P = material(Qa=1e5, Qd=GJ, EI=EI)
    start = ring(np.ones(2))
    system = rod(np.full(n, 2 * np.pi / n), P, nothing_held(start), start)

    # in equilibrium by symmetry but for its radius and stretch
    def imbalance(p: Array) -> Array:
        q = ring(p)
        return np.asarray(system.residual(q, 0 * q, 0 * q)[n // 2, [0, 4]])

    q = ring(fsolve(imbalance, np.ones(2), xtol=1e-12))
    closed = np.vstack((np.eye(7 * n), np.eye(7, 7 * n)))
    stiffness = closed.T @ stiffness_of(system, q) @ closed
    # rigid motions and rolling cost nothing: zero to 1e-10
    return bool(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0] > -1e-6)


def test_a_twisted_ring_leaves_its_plane_at_michells_twist() -> None:
    EI = 1.0
    GJ = 0.8
    critical = []
    for elements in (24, 48):
        low = 3 * np.pi * EI / GJ
        high = 4 * np.pi * EI / GJ
        while high - low > 4e-3:
            middle = 0.5 * (low + high)
            if ring_is_stable(elements, EI, GJ, middle):
                low = middle
            else:
                high = middle
        critical.append(low)
    # a linear theta errs by l^2: extrapolated
    assert_allclose(
        (4 * critical[1] - critical[0]) / 3, 2 * np.pi * np.sqrt(3) * EI / GJ, rtol=5e-3
    )


COUPLING = 2.336e5


@pytest.mark.parametrize("coupling", [0.0, COUPLING])
@pytest.mark.parametrize("height", [0.0, 80.0])
@pytest.mark.parametrize(
    ("EI", "spacing"), [(50.0, 1.5), (50.0, 3.0), (300.0, 2.0), (1000.0, 1.5), (1000.0, 3.0)]
)
def test_the_hanging_shape_is_found(
    EI: float, spacing: float, height: float, coupling: float
) -> None:
    rope = Rope(EI=EI, Qb=coupling, Qc=coupling)
    mesh = Mesh("tmn", coarse_length=2.0, counts=(2, 4, 40, 4, 2), end_levels=0)
    found = hung_up(rope, height, Swivel(), mesh, spacing)
    q = found.state.motion.q
    reaction = found.state.motion.reaction
    weight = rope.mass_per_length * G * rope.length
    # the theory's bound; measured 1e-10
    assert_allclose(reaction[[0, -1], 1].sum(), weight, rtol=1e-9)
    # rounding of 60 m coordinates in the strain of the shortest element: 1e-5 N, ten times that at
    # most
    shortest = found.state.partition.lengths.min()
    rounding = rope.Qa * 60.0 * np.finfo(float).eps / shortest
    assert_allclose(reaction[1:-1], 0.0, atol=10 * rounding)
    # nowhere compressed, nowhere folded
    t = q[:, 3:6] / np.linalg.norm(q[:, 3:6], axis=1)[:, None]
    assert np.min(np.sum(t[1:] * t[:-1], axis=1)) > 0
    assert_allclose(np.linalg.norm(q[:, 3:6], axis=1), 1.0, atol=1e-3)


def test_a_search_without_success_says_what_is_left_and_what_to_check(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # a free end under a load that nothing balances
    s = np.linspace(0.0, 1.0, 3)
    q = straight(s)
    loads = np.zeros_like(q)
    loads[-1, 1] = 5.0
    data = Rope(length=1.0, mass_per_length=1.0, Qa=10.0, Qb=0.0, Qc=0.0, Qd=1.0, EI=1.0, rhoJ=0.1)
    system = rod(np.diff(s), np.array(parameters(data, 0.0)), nothing_held(q), q, loads)
    monkeypatch.setattr("rope_model.reference.statics.MAX_CORRECTIONS", 50)
    with pytest.raises(StaticsError, match="N are left unbalanced; check twist"):
        find_equilibrium(system, q)
