"""The native rope's frame, shape, mesh and what a transformation carries over are those of the Python functions."""

import ctypes as ct
import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from native_parts import ROUNDING, Array, CLoopBottom, message
from numpy.testing import assert_allclose, assert_array_equal

from rope_model import Contact, Divider, Layout, Mesh, Rope, Scene, Shaft
from rope_model.codegen.structures import scene_structure
from rope_model.physics.centreline import heading, nearest_turn
from rope_model.physics.node import arc_lengths
from rope_model.rules.mesh_pattern import (
    NO_DIVIDERS,
    distance_past_limit,
    inner_length,
    transformation_due,
)
from rope_model.rules.messages.result_warnings import ends_yaw
from rope_model.rules.partition import Partition
from rope_model.simulation.contact.self_contact import overlap_of
from rope_model.simulation.mesh.partition import fit_mesh, partition, transform, window_due
from rope_model.simulation.mesh.transfer import interpolate, transfer_fields
from rope_model.simulation.outputs import diagnostics
from rope_model.simulation.outputs.diagnostics import (
    LoopBottom,
    leg_clearance,
    legs_apart,
    loop_bottom,
)
from rope_model.simulation.stepping.statics import hanging_guess

hangings = st.tuples(
    *(st.floats(*bounds) for bounds in ((0.3, 6.0), (-30, 30), (-2, 2), (0.2, 4.0), (40, 200)))
)


def hang(
    spacing: float, height: float, z: float, coarse: float, length: float
) -> tuple[Array, Array, Array]:
    left, right = np.array([-0.5 * spacing, height, z]), np.array([0.5 * spacing, 0.0, -z])
    cells = partition(
        Mesh(coarse_length=coarse, counts=(2, 4, 8, 4, 2)), length, 0.5 * (length + height)
    )
    return cells.nodes_s, left, right


@given(hanging=hangings)
@settings(max_examples=100, deadline=None)
def test_hanging_guess_is_the_same(parts: SimpleNamespace, hanging: tuple[float, ...]) -> None:
    spacing, height, z, coarse, length = hanging
    assume(length > 15 * coarse)
    assume(
        length - abs(height) > 2 * np.hypot(spacing, 2 * z)
    )  # a shorter rope does not reach around its loop
    s, left, right = hang(*hanging)
    q, text = np.empty((s.size, 7)), message()
    parts.hanging_guess(s.size, s, left, right, q, text)
    assert text.value == b""
    # sine and cosine of an angle that two large arc lengths leave over
    assert_allclose(q, hanging_guess(s, left, right), rtol=ROUNDING, atol=ROUNDING * s[-1])


def sway(hanging: tuple[float, ...], seed: int) -> tuple[Array, Array, Array]:
    """Configuration, element lengths and nodes of a rope that hangs crooked, its legs perhaps crossed."""
    s, left, right = hang(*hanging)
    q, random = hanging_guess(s, left, right), np.random.default_rng(seed)
    q[:, 0] += random.normal() * np.sin(3 * s / s[-1])
    q[:, 2] += random.normal() * np.sin(5 * s / s[-1])
    q += 0.01 * random.normal(size=q.shape)
    return q, np.diff(s), s


@given(hanging=hangings, seed=st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_loop_shape_and_clearance_are_the_same(
    parts: SimpleNamespace, hanging: tuple[float, ...], seed: int
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    q, lengths, s = sway(hanging, seed)
    bottom, expected = parts.loop_bottom(s.size, q, s), loop_bottom(q, lengths)
    # the parabola's minimum comes from second differences: the root of rounding of s, and of what s moves
    root = 1e-7
    assert_allclose(bottom.s, expected.s, atol=root)
    assert_allclose(bottom.position, expected.position, atol=root)
    assert_allclose(bottom.yaw, expected.yaw, atol=root)
    # the rest from the same point
    same = CLoopBottom.of(expected)
    for points in (2, 81, 161):
        places, xyz = np.full(points + 1, -7.0), np.full((points + 1, 3), -7.0)
        parts.shape_places(s[-1], expected.s, 4.0, points, places)
        assert_allclose(
            places[:-1],
            diagnostics.shape_places(lengths, expected.s, 4.0, points),
            atol=ROUNDING * s[-1],
        )
        assert places[-1] == -7.0
        parts.diagnostics_shape(s.size, q, s, points, places, xyz)
        assert_allclose(
            xyz[:-1], diagnostics.shape(q, lengths, expected.s, 4.0, points), atol=ROUNDING * s[-1]
        )
        assert np.all(xyz[-1] == -7.0)
    for above in (0.0, 0.3, hanging[0], 1e3):
        ours = parts.leg_clearance(s.size, q, s, same, 4.0, 0.044, above, (ct.c_int * 2)(seed, 40))
        assert_allclose(
            ours, leg_clearance(q, lengths, expected, 4.0, 0.044, above), atol=ROUNDING * s[-1]
        )


def tangle(kind: str, seed: int) -> tuple[Array, Array]:
    """Configuration and element lengths of a rope that hangs as none should."""
    random = np.random.default_rng(seed)
    lengths = random.uniform(0.2, 2.0, random.integers(4, 60))
    s, width, q = (
        arc_lengths(lengths),
        10.0 ** random.uniform(-2, 1),
        np.zeros((lengths.size + 1, 7)),
    )
    along = s - random.uniform(0.2, 0.8) * s[-1]
    q[:, 0], q[:, 1], q[:, 4] = 0.5 * width * np.tanh(along / width), abs(along), np.sign(along)
    if kind == "wound":
        turned, x = random.uniform(0.0, 25.0) * abs(along) / s[-1], q[:, 0].copy()
        q[:, 0], q[:, 2] = x * np.cos(turned), x * np.sin(turned)
    elif kind == "slack":
        q[:, :6] += 10.0 ** random.uniform(-3, 1) * random.normal(size=(s.size, 6))
    elif kind == "touching":
        q[:, 0] = np.sign(along) * 10.0 ** random.uniform(-12, -2)
    elif kind == "folded":
        q[:, :3] = np.cumsum(random.normal(size=(s.size, 3)), axis=0)
    return q, lengths


@pytest.mark.parametrize("kind", ["wound", "slack", "touching", "folded"])
def test_the_clearance_of_legs_that_tangle_is_the_same(parts: SimpleNamespace, kind: str) -> None:
    """C passes over what is too far off by blocks of points, Python looks at all."""
    seen = 0
    for seed in range(60):
        q, lengths = tangle(kind, seed)
        bottom, s = loop_bottom(q, lengths), arc_lengths(lengths)
        top = q[:, 1].max() - bottom.position[1]
        # just below the lower leg's top it has two points
        for above in (0.0, 0.3 * top, 0.999 * min(q[0, 1], q[-1, 1]) - 0.999 * bottom.position[1]):
            ours = parts.leg_clearance(
                s.size, q, s, CLoopBottom.of(bottom), 4.0, 0.044, above, (ct.c_int * 2)()
            )
            expected = leg_clearance(q, lengths, bottom, 4.0, 0.044, above)
            assert_allclose(ours, expected, atol=ROUNDING * s[-1])
            seen += math.isfinite(expected)
    assert seen > 60


@given(hanging=hangings, seed=st.integers(0, 1000), size=st.sampled_from((0.0, 0.3, 1.0)))
@settings(max_examples=100, deadline=None)
def test_legs_apart_are_not_turned(
    parts: SimpleNamespace, hanging: tuple[float, ...], seed: int, size: float
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    still, (q, lengths, s) = hanging_guess(*hang(*hanging)), sway(hanging, seed)
    q = still + size * (q - still)
    line, diameter, above = ends_yaw(q), 0.05, hanging[3]
    apart = legs_apart(q, lengths, diameter, above)
    assert apart == in_c(parts, q, lengths, s, diameter, above)
    if apart:
        bottom = loop_bottom(q, lengths)
        assert leg_clearance(q, lengths, bottom, above, diameter, above) > 0
        yaw = nearest_turn(bottom.yaw, line) - line
        assert abs(yaw) <= 0.5 * math.pi
        assert round(yaw / (2 * math.pi) - diagnostics.loop_turns(q, lengths, bottom).number) == 0


def test_legs_that_touch_between_their_nodes_are_not_told_apart(parts: SimpleNamespace) -> None:
    """Straight legs 1 m apart, and an element of each that bulges by phi l / 4 towards the other."""
    s, phi, q = np.linspace(0.0, 120.0, 17), 0.3, np.zeros((17, 7))
    lengths = np.diff(s)
    q[9:, 0], q[:, 1], q[:8, 4], q[9:, 4] = 1.0, -np.minimum(s, 120.0 - s), -1.0, 1.0
    q[8, :2], q[7:10, 3] = (0.5, -58.0), (0.01, 0.1, 0.01)
    assert legs_apart(q, lengths, 0.05, 1.0)
    q[[3, 4], 3], q[[12, 13], 3] = (phi, -phi), (-phi, phi)
    assert overlap_of(q, lengths, 0.05)[0] > 0
    assert not legs_apart(q, lengths, 0.05, 1.0)
    assert not in_c(parts, q, lengths, s, 0.05, 1.0)


def in_c(
    parts: SimpleNamespace, q: Array, lengths: Array, s: Array, diameter: float, above: float
) -> bool:
    arrays = ct.create_string_buffer(ct.sizeof(ct.c_void_p) * 10)
    parts.arrays_of(q, q, q, q, lengths, s, s.size, arrays)
    return bool(parts.legs_apart(arrays, np.array(heading(ends_yaw(q))), diameter, above))


@pytest.mark.parametrize("lowest", [0, 4])
def test_rope_lowest_at_an_end_is_read_alike(parts: SimpleNamespace, lowest: int) -> None:
    lengths = np.full(4, 2.5)
    s = arc_lengths(lengths)
    q = np.zeros((5, 7))
    q[:, 1], q[:, 4] = np.abs(s - s[lowest]), 1.0 if lowest == 0 else -1.0
    q[:, 3] = 0.1
    bottom, expected = parts.loop_bottom(5, q, s), loop_bottom(q, lengths)
    assert (bottom.s, tuple(bottom.position), bottom.yaw) == (
        expected.s,
        tuple(expected.position),
        expected.yaw,
    )
    loop = LoopBottom(float(s[lowest]), q[lowest, :3], 0.0)
    same = CLoopBottom.of(loop)
    assert leg_clearance(q, lengths, loop, 4.0, 0.044, 1.0) == math.inf
    assert parts.leg_clearance(5, q, s, same, 4.0, 0.044, 1.0, None) == math.inf


KINDS = ("tmn", "eem", "auto")


class CPattern(ct.Structure):
    _fields_ = (("coarse", ct.c_double), ("grading_length", ct.c_double))
    _fields_ += (
        ("counts", ct.c_int32 * 7),
        ("end_levels", ct.c_int32),
        ("windows", ct.c_int32 * 8),
    )


def c_of(group: Any) -> Any:
    scene = scene_structure(Scene().with_(**{type(group).__name__.lower(): group}))
    return getattr(scene, type(group).__name__.lower())


def c_partition(
    parts: SimpleNamespace,
    mesh: Mesh,
    length: float,
    bottom: float,
    divider_s: Sequence[float] = NO_DIVIDERS,
) -> tuple[Any, Array]:
    text, places = message(), np.array(divider_s)
    elements = parts.partition_elements(c_of(mesh), length, places, text)
    if elements == 0:
        raise ValueError(text.value.decode())
    assert text.value == b""
    pattern, lengths = CPattern(), np.full(elements + 1, -7.0)
    parts.partition(c_of(mesh), length, bottom, places, elements, pattern, lengths)
    assert lengths[-1] == -7.0  # not written beyond its end
    return pattern, lengths[:-1].copy()


def as_in_c(mesh: Partition) -> tuple[Any, Array]:
    return CPattern(
        mesh.coarse, mesh.grading_length, mesh.counts, mesh.end_levels, mesh.windows
    ), mesh.lengths


def outcome(make: Callable[[], tuple[Any, Array]]) -> tuple[bytes, bytes] | str:
    """Pattern and lengths to the bit, or why there are none."""
    try:
        pattern, lengths = make()
    except ValueError as error:
        return str(error)
    return bytes(pattern), lengths.tobytes()


def element_counts(
    twos: tuple[int, int], fours: tuple[int, int], fine: int
) -> tuple[int, int, int, int, int]:
    """Numbers of elements of all segments, without II and VI also without III and V."""
    if twos == (0, 0):
        fours = twos
    return 2 * twos[0], 4 * fours[0], 8 * fine, 4 * fours[1], 2 * twos[1]


zero = st.just(0.0)
pairs = st.just((0, 0)) | st.tuples(st.integers(1, 3), st.integers(1, 3))
meshes = st.builds(
    lambda kind, error, **more: Mesh(kind, loop_error=error * (kind == "auto"), **more),
    st.sampled_from(KINDS),
    st.floats(1e-4, 0.2),
    elements=st.integers(2, 400),
    coarse_length=st.floats(0.3, 6.0),
    counts=st.builds(element_counts, pairs, pairs, st.integers(1, 8)),
    end_levels=st.integers(0, 8),
    grading_length=zero | st.floats(1e-3, 1e3),
)
fitted = meshes.filter(lambda mesh: mesh.kind != "auto")
ropes = st.builds(
    lambda length, EI: Rope(length=length, EI=EI), st.floats(10.0, 600.0), st.floats(10.0, 3000.0)
)
layouts = st.builds(Layout, st.floats(0.3, 5.0))
shafts = st.builds(
    lambda name, divider, stiffness: Shaft(contact=Contact(stiffness=stiffness), **{name: divider}),
    st.sampled_from(["divider_1", "divider_2", "divider_3", "divider_4"]),
    st.builds(
        Divider,
        size=zero | st.floats(0.01, 0.5),
        offset=st.floats(-6, 6),
        direction=zero | st.floats(-3, 3),
    ),
    zero | st.just(1e6),
)


@given(mesh=meshes, rope=ropes, layout=layouts, shaft=shafts)
@example(
    Mesh("auto", loop_error=1.0), Rope(length=9000.0, EI=0.01), Layout(8.0), Shaft()
)  # most end levels
@example(Mesh("auto"), Rope(), Layout(), Shaft(divider_3=Divider(size=0.05, offset=0.9)))
@settings(max_examples=100, deadline=None)
def test_fitted_mesh_is_the_same(
    parts: SimpleNamespace, mesh: Mesh, rope: Rope, layout: Layout, shaft: Shaft
) -> None:
    scene = Scene(rope, layout, mesh=mesh, shaft=shaft)
    ours, expected = parts.fit_mesh(scene_structure(scene)), fit_mesh(scene)
    found = KINDS[ours.kind], ours.elements, tuple(ours.counts), ours.end_levels, ours.loop_error
    assert found == (
        expected.kind,
        expected.elements,
        expected.counts,
        expected.end_levels,
        expected.loop_error,
    )
    assert_allclose(ours.coarse_length, expected.coarse_length, rtol=1e-15)
    assert_allclose(ours.grading_length, expected.grading_length, rtol=1e-15)


#: places that dividers face; a rope that these may press has three l and more beside the loop
faces = st.just(NO_DIVIDERS) | st.tuples(
    *(st.just(math.inf) | st.floats(-20.0, 400.0) for _ in NO_DIVIDERS)
)


def has_legs(mesh: Mesh, length: float) -> bool:
    return mesh.kind == "tmn" and length / mesh.coarse_length - inner_length(mesh.counts) > 3.0


@given(mesh=fitted, length=st.floats(10.0, 400.0), part=st.floats(-0.1, 1.1), divider_s=faces)
@settings(max_examples=100, deadline=None)
def test_partition_is_the_same_to_the_bit(
    parts: SimpleNamespace, mesh: Mesh, length: float, part: float, divider_s: tuple[float, ...]
) -> None:
    assume(divider_s == NO_DIVIDERS or has_legs(mesh, length))
    ours = outcome(lambda: c_partition(parts, mesh, length, part * length, divider_s))
    assert ours == outcome(lambda: as_in_c(partition(mesh, length, part * length, divider_s)))


@given(mesh=fitted, length=st.floats(10.0, 400.0), data=st.data())
@settings(max_examples=25, deadline=None)
def test_loop_that_travels_is_alike(
    parts: SimpleNamespace, mesh: Mesh, length: float, data: st.DataObject
) -> None:
    bottom, divider_s = (
        data.draw(st.floats(0.0, length)),
        data.draw(faces if has_legs(mesh, length) else st.just(NO_DIVIDERS)),
    )
    try:
        old = partition(mesh, length, bottom, divider_s)
    except ValueError:
        assume(False)
    ours = pattern, lengths = c_partition(parts, mesh, length, bottom, divider_s)
    for place in data.draw(st.lists(st.floats(0.0, length), min_size=1, max_size=5)):
        slack, moved = data.draw(st.sampled_from((0.0, 1e-7))), data.draw(st.floats(-5.0, 5.0))
        divider_s = tuple(x + moved for x in divider_s)
        assert parts.window_due(pattern, np.array(divider_s)) == window_due(old, divider_s)
        while direction := transformation_due(old, place, slack):
            assert parts.mesh_distance_past_limit(pattern, place) == distance_past_limit(old, place)
            assert parts.mesh_transformation_due(pattern, place, slack) == direction
            old = transform(old, direction, divider_s)
            parts.partition_transform(
                pattern, int(direction), np.array(divider_s), len(lengths), lengths
            )
            assert [*map(bytes, ours)] == [*map(bytes, as_in_c(old))]
            assert parts.mesh_centre(pattern) == old.centre
        assert parts.mesh_transformation_due(pattern, place, slack) == 0
        assert parts.mesh_distance_past_limit(pattern, place) == distance_past_limit(old, place)


def rough(s: Array, seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(s.size, 7))


@given(
    old=st.lists(st.floats(0.05, 4.0), min_size=2, max_size=40),
    new=st.lists(st.floats(-0.1, 1.1), min_size=1, max_size=40),
    seed=st.integers(0, 1000),
)
@settings(max_examples=100, deadline=None)
def test_interpolated_values_are_equal(
    parts: SimpleNamespace, old: list[float], new: list[float], seed: int
) -> None:
    lengths = np.array(old)
    expected_s = arc_lengths(lengths)
    s = np.empty(lengths.size + 1)
    parts.arc_lengths(lengths.size, lengths, s)
    assert_array_equal(s, expected_s)
    # anywhere, at the nodes, and a hair beside them
    new_s = np.concatenate((np.array(new) * s[-1], s, s + 1e-10, s - 1e-8, s + 1e-8))
    x, y = rough(s, seed), np.full((new_s.size + 1, 7), -7.0)
    parts.transfer_interpolate(s.size, x, s, new_s.size, new_s, y)
    assert_allclose(y[:-1], interpolate(x, s, new_s), rtol=ROUNDING, atol=ROUNDING)
    assert np.all(y[-1] == -7.0)


@given(direction=st.sampled_from((1, -1)), growth=st.floats(0, 100), seed=st.integers(0, 1000))
def test_state_carried_elsewhere_is_equal(
    parts: SimpleNamespace, direction: int, growth: float, seed: int
) -> None:
    mesh = Mesh(grading_length=growth)
    old = partition(mesh, 120.0, 50.0)
    pattern, lengths = c_partition(parts, mesh, 120.0, 50.0)
    parts.partition_transform(pattern, direction, np.array(NO_DIVIDERS), len(lengths), lengths)
    new_s = arc_lengths(lengths)
    fields = np.array([rough(old.nodes_s, seed + k) for k in range(2)])
    work = np.full((10 + 14 * len(fields)) * new_s.size + 1, -7.0)  # as in core.h
    expected = transfer_fields(fields, old.nodes_s, transform(old, direction).nodes_s)
    addresses = (ct.c_void_p * 2)(*(x.ctypes.data for x in fields))
    parts.transfer_fields(new_s.size, old.nodes_s, new_s, 2, addresses, work)
    assert_allclose(fields, expected, rtol=ROUNDING, atol=ROUNDING)
    assert work[-1] == -7.0
