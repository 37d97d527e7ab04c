"""The TMN-ETM pattern, its transformation there and back, and what a transfer keeps."""

import ctypes as ct
import math
from dataclasses import replace
from functools import partial
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from native_parts import fit_mesh, interpolate, partition, transform, window_due
from numpy.testing import assert_allclose, assert_array_equal
from scenes import ends_at, fixed_steps, recorded
from shared import Array

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from rope_model import Model, Scene, Swivel, balance_rope
from rope_model.method import mesh_pattern as tmn
from rope_model.method.mesh_fit import DUE, NO_DIVIDERS
from rope_model.method.mesh_pattern import inner_length, min_outer, transformation_due
from rope_model.method.partition import Partition
from rope_model.physics.element import PARAMETERS, element_functions
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.reference.transfer import transferred
from rope_model.solver_parameters import Mesh


def nodes(p: Partition) -> Array:
    return np.concatenate(([0.0], np.cumsum(p.lengths)))


def kinetic_energy(x: Array, lengths: Array) -> float:
    """Of the velocities ``x``, per mass of 1 kg/m, by the element's mass."""
    element = element_functions()
    P = np.zeros(len(PARAMETERS))
    P[0] = 1.0
    energy = 0.0
    rest = np.zeros(14)
    rest[[3, 10]] = 1.0
    for i, l in enumerate(lengths):
        rest[7] = l
        v = x[i : i + 2].ravel()
        mass = element.tangent(
            rest, 0 * rest, 0 * rest, l, element.reference(rest, l), P, 0.0, 0.0, 1.0, rest
        )[1]
        energy += 0.5 * float(v @ np.asarray(mass) @ v)
    return energy


def test_the_segments_are_a_two_to_one_pattern_about_the_lowest_point() -> None:
    p = partition(Mesh(end_levels=0), 120.0, 60.0)
    assert len(p.counts) == 7
    shares = np.array([1, 1 / 2, 1 / 4, 1 / 8, 1 / 4, 1 / 2, 1])
    assert_array_equal(p.lengths, np.repeat(p.coarse * shares, p.counts))
    assert_allclose(p.centre, 60.0, atol=p.coarse / 2)
    assert_allclose(p.coarse, 2.0, rtol=0.05)


def test_the_outermost_elements_are_halved_towards_the_clamped_ends() -> None:
    plain, p = (partition(Mesh(end_levels=levels), 120.0, 60.0) for levels in (0, 2))
    assert p.counts == plain.counts
    assert_allclose(p.lengths[:3], p.coarse * np.array([0.25, 0.25, 0.5]), rtol=1e-14)
    assert_array_equal(p.lengths[-3:], p.lengths[2::-1])
    assert_array_equal(p.lengths[3:-3], plain.lengths[1:-1])


LENGTHS = st.floats(40.0, 400.0)
PLACES = st.floats(0.0, 1.0)
MESH = st.lists(st.floats(0.2, 3.0), min_size=3, max_size=12)
GROWTH = st.just(0.0) | st.floats(0.01, 100.0)
COUNTS = st.builds(
    lambda two, three, four: (
        2 * two,
        4 * three * (two > 0),
        8 * four,
        4 * three * (two > 0),
        2 * two,
    ),
    *(st.integers(0, 3), st.integers(0, 3), st.integers(1, 6)),
)
PARTS = {"counts": COUNTS, "end_levels": st.integers(0, 3), "grading_length": GROWTH}
MESHES = st.builds(Mesh, coarse_length=st.floats(0.5, 4.0), **PARTS)


@settings(max_examples=100, deadline=None)
@given(mesh=MESHES, length=LENGTHS, place=PLACES)
def test_the_pattern_adds_up_to_the_rope_and_is_centred_as_it_can_be(
    mesh: Mesh, length: float, place: float
) -> None:
    assume(length > (inner_length(mesh.counts) + 3) * mesh.coarse_length)
    p = partition(mesh, length, place * length)
    assert_allclose(p.lengths.sum(), length, rtol=1e-12)  # a sum of some hundred lengths
    if mesh.grading_length == 0:
        assert sum(p.counts) + 2 * mesh.end_levels == p.lengths.size
    # of the pattern nothing is left out but what an end cuts off
    assert p.lengths.min() >= min(0.5**mesh.end_levels * p.coarse, p.fine_length) * (1 - 1e-9)
    fewest = min_outer(mesh.counts)
    assert min(p.counts[::6]) >= fewest
    assert p.counts[1:6] == mesh.counts
    # half a coarse element off, until half of the pattern is cut off
    if min(p.counts[::6]) > fewest:
        assert abs(p.centre - place * length) <= 0.5 * p.coarse * (1 + 1e-9)


@settings(max_examples=100, deadline=None)
@given(mesh=MESHES, length=LENGTHS, place=PLACES, direction=st.sampled_from([-1, 1]))
def test_a_transformation_moves_one_element_and_back(
    mesh: Mesh, length: float, place: float, direction: int
) -> None:
    assume(length > (inner_length(mesh.counts) + 3) * mesh.coarse_length)
    p = partition(mesh, length, place * length)
    gives = p.counts[0]
    if direction > 0:
        gives = p.counts[6]
    assume(gives > min_outer(mesh.counts))
    there = transform(p, direction)
    assert there.lengths.size == p.lengths.size
    assert there.counts[1:6] == p.counts[1:6]
    assert (there.counts[0] - p.counts[0], there.counts[6] - p.counts[6]) == (direction, -direction)
    assert_allclose(there.lengths.sum(), length, rtol=1e-12)
    assert_allclose(there.centre - p.centre, direction * p.coarse, rtol=1e-9)
    back = transform(there, -direction)
    assert back.counts == p.counts
    assert_array_equal(back.lengths, p.lengths)
    if mesh.grading_length > 0:
        return  # three may become two
    # whole elements become one, or one becomes several
    before = {*pairwise(np.round(nodes(p) / p.coarse, 6).tolist())}
    after = {*pairwise(np.round(nodes(there) / p.coarse, 6).tolist())}
    for a, b in before ^ after:
        other = before
        if (a, b) in before:
            other = after
        within = [x for x in other if a <= x[0] and x[1] <= b]
        around = [x for x in other if x[0] <= a and b <= x[1]]
        assert around or (
            within and min(x[0] for x in within) == a and max(x[1] for x in within) == b
        )


def test_a_transformation_is_due_when_the_loop_has_travelled_and_not_due_back_at_once() -> None:
    p = partition(Mesh(), 120.0, 60.0)
    for direction in (-1, 1):
        at = p.centre + direction * (DUE * p.coarse + 1e-6)
        assert transformation_due(p, p.centre + direction * (DUE * p.coarse - 1e-6)) == 0
        assert transformation_due(p, at) == direction
        assert transformation_due(transform(p, direction), at) == 0
    # half of the pattern beyond the end of the rope, there is nothing left to give
    fewest = min_outer(p.counts[1:6])
    spent = replace(p, counts=(p.counts[0] + p.counts[6] - fewest, *p.counts[1:6], fewest))
    assert transformation_due(spent, 119.0) == 0


@settings(max_examples=60, deadline=None)
@given(length=st.floats(120.0, 2000.0), place=PLACES, growth=st.floats(0.01, 100.0))
def test_elements_of_the_legs_are_as_long_as_end_and_loop_allow(
    length: float, place: float, growth: float
) -> None:
    p = partition(Mesh(end_levels=0, grading_length=growth), length, place * length)
    units = p.lengths / p.coarse
    first = p.counts[0]
    last = p.counts[6]
    s = nodes(p) / p.coarse
    for size, a, b in zip(units, s, s[1:], strict=False):
        if size > 1.0 + 1e-9:
            assert size <= tmn.LEG_LENGTHS[-1] + 1e-9
            from_end = min(a, length / p.coarse - b)
            to_loop = first - b
            if b > first + 1e-9:
                to_loop = a - (length / p.coarse - last)
            assert size <= from_end + 1e-6
            assert tmn.GRADING * (size - 1) <= to_loop + 1e-6
            assert p.coarse * size**2 <= growth * (to_loop + 1e-6)


#: the leg's end, so far from which it faces a divider, is the left one; and the right one
SIDES = st.sampled_from([0, 1])


def facing(side: int, place: float) -> tuple[float, ...]:
    places = [math.inf] * len(NO_DIVIDERS)
    places[2 + side] = place
    return tuple(places)


@settings(max_examples=100, deadline=None)
@given(
    length=st.floats(120.0, 1000.0),
    bottom=st.floats(0.3, 0.7),
    part=st.floats(-0.1, 1.1),
    side=SIDES,
)
def test_a_leg_is_refined_about_the_divider_that_it_faces(length, bottom, part, side) -> None:
    mesh = Mesh(coarse_length=1.0)
    place = part * length
    plain = partition(mesh, length, bottom * length)
    p = partition(mesh, length, bottom * length, facing(side, place))
    assert p.lengths.size == plain.lengths.size + tmn.WINDOW * (
        tmn.WINDOW_PARTS - 1
    )  # wherever it is
    assert p.counts == plain.counts
    assert_allclose(p.lengths.sum(), length, rtol=1e-12)
    s = nodes(p)
    if side == 1:
        s = length - s[::-1]
    leg = p.counts[6 * side] * p.coarse
    lengths = np.diff(s)
    # a window begins within half an l of its place
    reach = (0.5 * tmn.WINDOW - 0.5 - 1e-6) * p.coarse
    near = (s[:-1] < place + reach) & (s[1:] > place - reach)
    within = near & (s[:-1] > p.coarse * (1 - 1e-9)) & (s[1:] < leg * (1 + 1e-9))
    assert np.all(lengths[within] <= p.coarse / tmn.WINDOW_PARTS * (1 + 1e-9))


@given(place=st.floats(20.0, 35.0), moves=st.floats(-10.0, 10.0), side=SIDES)
def test_a_window_follows_its_divider(place: float, moves: float, side: int) -> None:
    p = partition(Mesh(coarse_length=1.0), 120.0, 60.0, facing(side, place))
    off = abs((place + moves) / p.coarse - 0.5 * tmn.WINDOW - p.windows[2 + side])
    there = facing(side, place + moves)
    assert window_due(p, there) == (off > tmn.WINDOW_DUE)
    followed = transform(p, 0, there)
    assert not window_due(followed, there)
    assert followed.counts == p.counts
    assert followed.lengths.size == p.lengths.size
    assert followed.windows == partition(Mesh(coarse_length=1.0), 120.0, 60.0, there).windows


def carry(x: Array, old_s: Array, new_s: Array) -> Array:
    return transferred(x[None], old_s, new_s)[0]


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_transfer_reaches_no_further_than_some_elements(direction: int) -> None:
    p = partition(Mesh(), 120.0, 60.0)
    old_s = nodes(p)
    new_s = nodes(transform(p, direction))
    x = np.random.default_rng(1).normal(size=(old_s.size, 7))
    change = np.abs(carry(x, old_s, new_s) - interpolate(x, old_s, new_s)).max(axis=1)
    merged = 0.5 * (new_s[:-1] + new_s[1:])[np.diff(np.searchsorted(old_s + 1e-9, new_s)) > 1]
    assert merged.size == 4 + 2 + 1  # to l/4, to l/2, to l
    away = np.abs(new_s[:, None] - merged).min(axis=1) / 2.0  # l
    assert change[away < 1].max() > 0.1
    # what the mass matrix of equal elements lets through to the next
    assert np.all(change[away > 1] <= 2.0 * 0.5 ** (away[away > 1] - 1))
    assert_array_equal(change[[0, -1]], 0.0)


@pytest.mark.parametrize("direction", [-1, 1])
@pytest.mark.parametrize("growth", [0.0, 30.0])
def test_the_engine_transfers_what_the_reference_does(
    parts: SimpleNamespace, direction: int, growth: float
) -> None:
    """By banded normal equations on one side, by a least-squares fit on the other."""
    old = partition(Mesh(grading_length=growth), 120.0, 50.0)
    old_s = nodes(old)
    new_s = nodes(transform(old, direction))
    fields = np.random.default_rng(1).normal(size=(2, old_s.size, 7))
    expected = transferred(fields, old_s, new_s)
    work = np.empty(14 * len(fields) * new_s.size + 10 * new_s.size)  # as in transfer.h
    addresses = (ct.c_void_p * 2)(*(x.ctypes.data for x in fields))
    parts.transfer_fields(new_s.size, old_s, new_s, 2, addresses, work)
    # normal equations square the condition of the fit, 1e2
    assert_allclose(fields, expected, rtol=0, atol=1e-10)


def test_a_split_reproduces_the_element() -> None:
    rng = np.random.default_rng(3)
    s = np.array([0.0, 1.7, 3.0])
    halves = np.array([0.0, 0.85, 1.7, 2.35, 3.0])
    x = rng.normal(size=(3, 7))
    split = carry(x, s, halves)
    assert_allclose(split, interpolate(x, s, halves), rtol=0, atol=1e-13)
    anywhere = np.linspace(0.0, 3.0, 61)
    expected = interpolate(x, s, anywhere)
    assert_allclose(interpolate(split, halves, anywhere), expected, rtol=0, atol=1e-13)  # rounding


def test_the_interpolation_is_the_elements_own_cubic() -> None:
    s = np.array([0.0, 2.0])
    c = np.random.default_rng(4).normal(size=(4, 3))

    def powers(z: Array) -> Array:
        return z[:, None] ** [0, 1, 2, 3]

    def rates(z: Array) -> Array:
        return z[:, None] ** [0, 0, 1, 2] * [0, 1, 2, 3]

    x = np.zeros((2, 7))
    x[:, POSITION] = powers(s) @ c
    x[:, SLOPE] = rates(s) @ c
    x[:, ANGLE] = [1.0, 5.0]
    at = np.linspace(0.0, 2.0, 9)
    y = interpolate(x, s, at)
    assert_allclose(y[:, POSITION], powers(at) @ c, atol=1e-13)
    assert_allclose(y[:, SLOPE], rates(at) @ c, atol=1e-13)
    assert_allclose(y[:, ANGLE], 1 + 2 * at, atol=1e-13)


@settings(max_examples=60, deadline=None)
@given(old=MESH, new=MESH, seed=st.integers(0, 1000))
def test_what_a_transfer_loses_is_orthogonal_to_every_new_field(
    old: list[float], new: list[float], seed: int
) -> None:
    # any two meshes of one rope, nested or not; integrated without mass matrices
    old_s, new_s = (np.concatenate(([0.0], np.cumsum(l))) / sum(l) for l in (old, new))
    x = np.random.default_rng(seed).normal(size=(old_s.size, 7))
    y = carry(x, old_s, new_s)
    knots = np.union1d(old_s, new_s)
    points, weights = np.polynomial.legendre.leggauss(5)
    at = 0.5 * (knots[:-1, None] + knots[1:, None] + np.diff(knots)[:, None] * points).ravel()
    weight = (0.5 * np.diff(knots)[:, None] * weights).ravel()
    lost = interpolate(x, old_s, at) - interpolate(y, new_s, at)
    for node in range(1, new_s.size - 1):
        for rows, columns in ((POSITION, POSITION), (SLOPE, POSITION), (ANGLE, ANGLE)):
            field = np.zeros((new_s.size, 7))
            field[node, rows] = 1.0
            product = interpolate(field, new_s, at)[:, columns] * lost[:, columns]
            assert np.abs(weight @ product).max() < 1e-8  # arc lengths are the same within 1e-9


def test_a_merge_errs_with_the_fourth_power_of_the_length() -> None:
    lost = []
    for elements in (8, 16, 32):
        s = np.linspace(0.0, 6.0, 2 * elements + 1)
        merged = np.linspace(0.0, 6.0, elements + 1)
        v = np.zeros((s.size, 7))
        k = 2 * np.pi / 9.0
        for i, (waves, phase) in enumerate(((1.0, 0.3), (2.0, 1.1), (1.5, 2.0))):
            v[:, i] = np.sin(waves * k * s + phase)
            v[:, 3 + i] = waves * k * np.cos(waves * k * s + phase)
        v[:, ANGLE] = np.cos(k * s)
        lost.append(
            kinetic_energy(interpolate(carry(v, s, merged), merged, s) - v, np.diff(s)) ** 0.5
        )
    assert_allclose(np.log2(np.array(lost[:-1]) / lost[1:]), 4.0, atol=0.3)
    # at the middle of an element Hermite interpolation misses the fourth derivative times l^4/384;
    # waves of 4.5 to 9 m
    assert lost[-1] < 2 * 6.0**0.5 * (2 * np.pi / 4.5 * 6.0 / 32) ** 4 / 384


def uncoupled(name: str) -> Scene:
    scene = rope_scene(find_case(name).rope)
    locked = Swivel(mode="locked")
    rope = replace(scene.rope, Qb=0.0, Qc=0.0)
    return scene.with_(
        rope=rope, left=locked, right=locked, solver=fixed_steps(0.01), model=Model("planar")
    )


@pytest.mark.slow
@pytest.mark.parametrize("travel", [100.0, 400.0])
def test_joined_elements_of_a_deep_shaft_move_the_loop_by_less_than_the_mesh_may_err(
    travel: float,
) -> None:
    scene = uncoupled("monopol-1000")
    asked = 5e-3
    reference = s_curve(Winding(travel=travel, speed=8.0))
    auto = fit_mesh(scene.with_(mesh=Mesh("auto", loop_error=asked)))
    assert auto.grading_length > 0
    ropes = [
        balance_rope(scene.with_(mesh=mesh)) for mesh in (auto, replace(auto, grading_length=0.0))
    ]
    motion = partial(ends_at, reference, travel)
    steps = round(reference.duration / 0.01)
    one, other = (recorded(rope, motion, steps, ("loop.x", "loop.y", "loop.z")) for rope in ropes)
    assert np.linalg.norm(one - other, axis=1)[24::25].max() < 0.5 * asked
