"""The engine's shape of the rope: its lowest point, the distance of its legs, and when they are surely apart."""

import ctypes as ct
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from native_parts import Array, CLoopBottom, interpolate, loop_bottom, partition, shape
from numpy.testing import assert_allclose

from rope_model import Mesh
from rope_model.method.sampling import FINE, OUTLINE
from rope_model.physics.centreline import heading, nearest_turn, squared_distance
from rope_model.physics.node import arc_lengths
from rope_model.reference.outputs import curve_beside, lowest_point
from rope_model.reference.statics import hanging_guess
from rope_model.warnings.result_warnings import ends_yaw

hangings = st.tuples(
    *(st.floats(*bounds) for bounds in ((0.3, 6.0), (-30, 30), (-2, 2), (0.2, 4.0), (40, 200)))
)


def hang(
    spacing: float, height: float, z: float, coarse: float, length: float
) -> tuple[Array, Array, Array]:
    left = np.array([-0.5 * spacing, height, z])
    right = np.array([0.5 * spacing, 0.0, -z])
    cells = partition(
        Mesh(coarse_length=coarse, counts=(2, 4, 8, 4, 2)), length, 0.5 * (length + height)
    )
    return cells.nodes_s, left, right


def sway(hanging: tuple[float, ...], seed: int) -> tuple[Array, Array, Array]:
    """Configuration, element lengths and nodes of a rope that hangs crooked, its legs perhaps crossed."""
    s, left, right = hang(*hanging)
    q = hanging_guess(s, left, right)
    random = np.random.default_rng(seed)
    q[:, 0] += random.normal() * np.sin(3 * s / s[-1])
    q[:, 2] += random.normal() * np.sin(5 * s / s[-1])
    q += 0.01 * random.normal(size=q.shape)
    return q, np.diff(s), s


@given(hanging=hangings, seed=st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_the_lowest_point_is_where_the_centre_line_is_level(
    hanging: tuple[float, ...], seed: int
) -> None:
    """Engine and reference take it from a parabola through samples."""
    assume(hanging[-1] > 15 * hanging[3] + abs(hanging[1]))
    q, lengths, s = sway(hanging, seed)
    bottom = loop_bottom(q, lengths)
    expected = lowest_point(q, s)
    node = int(np.clip(np.argmin(q[:, 1]), 1, s.size - 2))
    samples = np.linspace(s[node - 1], s[node + 1], FINE)
    h = samples[1] - samples[0]
    heights = curve_beside(q, s, node, samples, (1,))[0][0]
    bend = np.abs(np.diff(heights, 2)).max() / h**2
    assert_allclose(bottom.s, expected.s, rtol=0, atol=1e-7 * s[-1])
    # it is found within a sample, from where the rope rises by bend h^2 / 2 at most
    assert abs(bottom.position[1] - heights.min()) <= 0.5 * bend * h**2 + 1e-9
    position, slope = (x[:, 0] for x in curve_beside(q, s, node, np.array([bottom.s]), (0, 1, 2)))
    assert_allclose(bottom.position, position, atol=1e-11 * s[-1])
    assert_allclose(bottom.yaw, math.atan2(-slope[2], slope[0]), atol=1e-9)


def test_the_lowest_point_goes_on_evenly_where_another_node_becomes_the_lowest() -> None:
    places = []
    for tilt in (-1e-6, 1e-6):  # the lowest point lies midway between two nodes
        angles = 0.9 * (np.arange(6) - 2.5) + tilt
        q = np.zeros((6, 7))
        q[:, 0] = np.sin(angles)
        q[:, 1] = -np.cos(angles)
        q[:, 3] = np.cos(angles)
        q[:, 4] = np.sin(angles)
        places.append(loop_bottom(q, np.full(5, 0.9)).position)
    assert_allclose(places[0], places[1], atol=1e-5)


def test_the_lowest_point_of_an_arc_is_right_to_the_fifth_order() -> None:
    """A cubic's tangent is off inside of an element: the lowest point by the cube of the element's turn."""
    errors = []
    for turn in (0.4, 0.2):
        angles = turn * (np.arange(5) - 1.7)  # of a circle of radius 1, between its nodes
        q = np.zeros((5, 7))
        q[:, 0] = np.sin(angles)
        q[:, 1] = -np.cos(angles)
        q[:, 3] = np.cos(angles)
        q[:, 4] = np.sin(angles)
        bottom = loop_bottom(q, np.full(4, turn))
        errors.append(math.hypot(bottom.position[0], bottom.position[1] + 1.0))
        assert errors[-1] < 1e-3 * turn**4
    assert errors[1] < errors[0] / 30


def tangle(kind: str, seed: int) -> tuple[Array, Array]:
    """Configuration and element lengths of a rope that hangs as none should."""
    random = np.random.default_rng(seed)
    lengths = random.uniform(0.2, 2.0, random.integers(4, 60))
    s = arc_lengths(lengths)
    width = 10.0 ** random.uniform(-2, 1)
    q = np.zeros((lengths.size + 1, 7))
    along = s - random.uniform(0.2, 0.8) * s[-1]
    q[:, 0] = 0.5 * width * np.tanh(along / width)
    q[:, 1] = abs(along)
    q[:, 4] = np.sign(along)
    if kind == "wound":
        turned = random.uniform(0.0, 25.0) * abs(along) / s[-1]
        x = q[:, 0].copy()
        q[:, 0] = x * np.cos(turned)
        q[:, 2] = x * np.sin(turned)
    elif kind == "slack":
        q[:, :6] += 10.0 ** random.uniform(-3, 1) * random.normal(size=(s.size, 6))
    elif kind == "touching":
        q[:, 0] = np.sign(along) * 10.0 ** random.uniform(-12, -2)
    elif kind == "folded":
        q[:, :3] = np.cumsum(random.normal(size=(s.size, 3)), axis=0)
    return q, lengths


def of_each_leg(
    q: Array, lengths: Array, bottom: CLoopBottom, above: float
) -> tuple[Array, Array] | None:
    """Points of both legs, from the bottom upwards, from where each first reaches this height over it (m)."""
    points = shape(q, lengths, bottom.s, LOOP, OUTLINE)
    middle = len(points) // 2
    height = bottom.position[1] + above
    legs = []
    for leg in (points[middle::-1], points[middle:]):
        high = leg[:, 1] >= height
        if not high.any():
            return None
        i = int(np.argmax(high))
        below = leg[max(i - 1, 0)]
        first = leg[i]
        rise = first[1] - below[1]
        part = 1.0
        if rise > 0:
            part = (height - below[1]) / rise
        legs.append(np.vstack((below + part * (first - below), leg[i + (part >= 1.0) :])))
    if min(map(len, legs)) < 2:
        return None
    return legs[0], legs[1]


def distance(points: Array, line: Array) -> float:
    """Smallest distance (m) of the points from the pieces of a polygon."""
    pieces = line[:-1].T[:, None], np.diff(line.T)[:, None]
    return math.sqrt(squared_distance(points.T[:, :, None], *pieces).min())


LOOP = 4.0
DIAMETER = 0.044


@pytest.mark.parametrize("kind", ["wound", "slack", "touching", "folded"])
def test_the_clearance_of_legs_is_the_least_of_all_their_distances(
    parts: SimpleNamespace, kind: str
) -> None:
    """The engine passes over what is too far off by blocks of points; here all points are looked at."""
    seen = 0
    for seed in range(30):
        q, lengths = tangle(kind, seed)
        bottom = loop_bottom(q, lengths)
        s = arc_lengths(lengths)
        top = q[:, 1].max() - bottom.position[1]
        # just below the lower leg's top it has two points
        for above in (0.0, 0.3 * top, 0.999 * min(q[0, 1], q[-1, 1]) - 0.999 * bottom.position[1]):
            found = parts.leg_clearance(
                s.size, q, s, bottom, LOOP, DIAMETER, above, (ct.c_int * 2)(seed, 40)
            )
            legs = of_each_leg(q, lengths, bottom, above)
            expected = math.inf
            if legs is not None:
                expected = min(distance(*legs), distance(*legs[::-1])) - DIAMETER
            # sums in another order
            assert_allclose(found, expected, atol=1e-12 * s[-1])
            seen += math.isfinite(expected)
    assert seen > 30


@given(hanging=hangings, seed=st.integers(0, 1000), size=st.sampled_from((0.0, 0.3, 1.0)))
@settings(max_examples=100, deadline=None)
def test_legs_apart_are_not_turned(
    parts: SimpleNamespace, hanging: tuple[float, ...], seed: int, size: float
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    still = hanging_guess(*hang(*hanging))
    q, lengths, s = sway(hanging, seed)
    q = still + size * (q - still)
    line = ends_yaw(q)
    diameter = 0.05
    above = hanging[3]
    if apart(parts, q, lengths, s, diameter, above):
        bottom = loop_bottom(q, lengths)
        assert (
            parts.leg_clearance(s.size, q, s, bottom, above, diameter, above, (ct.c_int * 2)()) > 0
        )
        yaw = nearest_turn(bottom.yaw, line) - line
        assert abs(yaw) <= 0.5 * math.pi


def test_legs_that_touch_between_their_nodes_are_not_told_apart(parts: SimpleNamespace) -> None:
    """Straight legs 1 m apart, and an element of each that bulges by phi l / 4 towards the other."""
    s = np.linspace(0.0, 120.0, 17)
    phi = 0.3
    q = np.zeros((17, 7))
    lengths = np.diff(s)
    q[9:, 0] = 1.0
    q[:, 1] = -np.minimum(s, 120.0 - s)
    q[:8, 4] = -1.0
    q[9:, 4] = 1.0
    q[8, :2] = (0.5, -58.0)
    q[7:10, 3] = (0.01, 0.1, 0.01)
    assert apart(parts, q, lengths, s, 0.05, 1.0)
    q[[3, 4], 3] = (phi, -phi)
    q[[12, 13], 3] = (-phi, phi)
    at = np.linspace(0.0, 1.0, 101)
    bulges = [interpolate(q, s, s[k] + at * lengths[k])[:, :3] for k in (3, 12)]
    assert distance(*bulges) < 0.05
    assert not apart(parts, q, lengths, s, 0.05, 1.0)


def apart(
    parts: SimpleNamespace, q: Array, lengths: Array, s: Array, diameter: float, above: float
) -> bool:
    arrays = ct.create_string_buffer(ct.sizeof(ct.c_void_p) * 10)
    parts.arrays_of(q, q, q, q, lengths, s, s.size, arrays)
    return bool(parts.legs_apart(arrays, np.array(heading(ends_yaw(q))), diameter, above))


@pytest.mark.parametrize("lowest", [0, 4])
def test_a_rope_that_is_lowest_at_an_end_has_no_legs(parts: SimpleNamespace, lowest: int) -> None:
    lengths = np.full(4, 2.5)
    s = arc_lengths(lengths)
    q = np.zeros((5, 7))
    q[:, 1] = np.abs(s - s[lowest])
    q[:, 4] = -1.0
    if lowest == 0:
        q[:, 4] = 1.0
    q[:, 3] = 0.1
    assert_allclose(loop_bottom(q, lengths).s, s[lowest], rtol=0, atol=1e-12)
    here = CLoopBottom(float(s[lowest]), tuple(q[lowest, :3]), 0.0)
    assert parts.leg_clearance(5, q, s, here, LOOP, DIAMETER, 1.0, None) == math.inf
