"""The native rope's mesh and what a transformation carries over give what the Python functions give."""

import ctypes as ct
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from native_parts import ROUNDING, Array, message
from numpy.testing import assert_allclose, assert_array_equal

from rope_model import Contact, Divider, Layout, Mesh, Rope, Scene, Shaft
from rope_model.codegen.structures import scene_structure
from rope_model.simulation.mesh.mesh_pattern import distance_to_due, transformation_due
from rope_model.simulation.mesh.partition import Partition, fit_mesh, partition, transform
from rope_model.simulation.mesh.transfer import interpolate, transfer_fields
from rope_model.simulation.rope_system import arc_lengths

KINDS = ("tmn", "eem", "auto")


class CPattern(ct.Structure):
    _fields_ = (("coarse", ct.c_double), ("grading_length", ct.c_double))
    _fields_ += (("counts", ct.c_int32 * 7), ("end_levels", ct.c_int32))


def c_of(group: Any) -> Any:
    scene = scene_structure(Scene().with_(**{type(group).__name__.lower(): group}))
    return getattr(scene, type(group).__name__.lower())


def c_partition(parts: SimpleNamespace, mesh: Mesh, length: float, bottom: float) -> tuple[Any, Array]:
    text = message()
    elements = parts.partition_elements(c_of(mesh), length, text)
    if elements == 0:
        raise ValueError(text.value.decode())
    assert text.value == b""
    pattern, lengths = CPattern(), np.full(elements + 1, -7.0)
    parts.partition(c_of(mesh), length, bottom, elements, pattern, lengths)
    assert lengths[-1] == -7.0  # not written beyond its end
    return pattern, lengths[:-1].copy()


def as_in_c(mesh: Partition) -> tuple[Any, Array]:
    return CPattern(mesh.coarse, mesh.grading_length, (ct.c_int32 * 7)(*mesh.counts), mesh.end_levels), mesh.lengths


def outcome(make: Callable[[], tuple[Any, Array]]) -> tuple[bytes, bytes] | str:
    """Pattern and lengths to the bit, or why there are none."""
    try:
        pattern, lengths = make()
    except ValueError as error:
        return str(error)
    return bytes(pattern), lengths.tobytes()


def element_counts(twos: tuple[int, int], fours: tuple[int, int], fine: int) -> tuple[int, int, int, int, int]:
    """Numbers of elements of all segments, without II and VI also without III and V."""
    if twos == (0, 0):
        fours = twos
    return 2 * twos[0], 4 * fours[0], 8 * fine, 4 * fours[1], 2 * twos[1]


meshes = st.builds(
    lambda kind, elements, l, twos, fours, fine, levels, growth, error: Mesh(
        kind, elements, l, element_counts(twos, fours, fine), levels, growth, error * (kind == "auto")
    ),
    st.sampled_from(KINDS),
    st.integers(2, 400),
    st.floats(0.3, 6.0),
    st.just((0, 0)) | st.tuples(st.integers(1, 3), st.integers(1, 3)),
    st.just((0, 0)) | st.tuples(st.integers(1, 3), st.integers(1, 3)),
    st.integers(1, 8),
    st.integers(0, 8),
    st.just(0.0) | st.floats(1e-3, 1e3),
    st.floats(1e-4, 0.2),
)
ropes = st.builds(lambda length, EI: Rope(length=length, EI=EI), st.floats(10.0, 600.0), st.floats(10.0, 3000.0))
zero = st.just(0.0)
layouts = st.builds(Layout, st.floats(0.3, 5.0))
shafts = st.builds(
    lambda name, divider, stiffness: Shaft(contact=Contact(stiffness=stiffness), **{name: divider}),
    st.sampled_from(["divider_1", "divider_2", "divider_3", "divider_4"]),
    st.builds(Divider, size=zero | st.floats(0.01, 0.5), offset=st.floats(-6, 6), direction=zero | st.floats(-3, 3)),
    zero | st.just(1e6),
)


@given(mesh=meshes, rope=ropes, layout=layouts, shaft=shafts)
@example(Mesh("auto", loop_error=1.0), Rope(length=9000.0, EI=0.01), Layout(8.0), Shaft())  # most end levels
@example(Mesh("auto"), Rope(), Layout(), Shaft(divider_3=Divider(size=0.05, offset=0.9)))
@settings(max_examples=200, deadline=None)
def test_fitted_mesh_is_the_same(parts: SimpleNamespace, mesh: Mesh, rope: Rope, layout: Layout, shaft: Shaft) -> None:
    scene = Scene(rope, layout, mesh=mesh, shaft=shaft)
    ours, expected = parts.fit_mesh(scene_structure(scene)), fit_mesh(scene)
    found = KINDS[ours.kind], ours.elements, tuple(ours.counts), ours.end_levels, ours.loop_error
    assert found == (expected.kind, expected.elements, expected.counts, expected.end_levels, expected.loop_error)
    assert_allclose(ours.coarse_length, expected.coarse_length, rtol=1e-15)
    assert_allclose(ours.grading_length, expected.grading_length, rtol=1e-15)


@given(mesh=meshes.filter(lambda mesh: mesh.kind != "auto"), length=st.floats(10.0, 400.0), part=st.floats(-0.1, 1.1))
@settings(max_examples=200, deadline=None)
def test_partition_is_the_same_to_the_bit(parts: SimpleNamespace, mesh: Mesh, length: float, part: float) -> None:
    ours = outcome(lambda: c_partition(parts, mesh, length, part * length))
    assert ours == outcome(lambda: as_in_c(partition(mesh, length, part * length)))


@pytest.mark.parametrize(
    ("mesh", "length"),
    [(Mesh(coarse_length=1e-3), 120.0), (Mesh(coarse_length=1e-15), 120.0), (Mesh(), 20.9), (Mesh(), 1234567.8)],
)
def test_mesh_that_does_not_fit_is_refused_in_the_same_words(parts: SimpleNamespace, mesh: Mesh, length: float) -> None:
    refused = outcome(lambda: as_in_c(partition(mesh, length, 10.0)))
    assert isinstance(refused, str)
    assert outcome(lambda: c_partition(parts, mesh, length, 10.0)) == refused


@given(mesh=meshes.filter(lambda mesh: mesh.kind != "auto"), length=st.floats(10.0, 400.0), data=st.data())
@settings(max_examples=50, deadline=None)
def test_loop_that_travels_is_alike(parts: SimpleNamespace, mesh: Mesh, length: float, data: st.DataObject) -> None:
    bottom = data.draw(st.floats(0.0, length))
    try:
        old = partition(mesh, length, bottom)
    except ValueError:
        assume(False)
    ours = pattern, lengths = c_partition(parts, mesh, length, bottom)
    for place in data.draw(st.lists(st.floats(0.0, length), min_size=1, max_size=5)):
        slack = data.draw(st.sampled_from((0.0, 1e-7)))
        while direction := transformation_due(old, place, slack):
            assert parts.mesh_distance_to_due(pattern, place) == distance_to_due(old, place)
            assert parts.mesh_transformation_due(pattern, place, slack) == direction
            old = transform(old, direction)
            parts.partition_transform(pattern, int(direction), len(lengths), lengths)
            assert [*map(bytes, ours)] == [*map(bytes, as_in_c(old))]
            assert parts.mesh_centre(pattern) == old.centre
        assert parts.mesh_transformation_due(pattern, place, slack) == 0
        assert parts.mesh_distance_to_due(pattern, place) == distance_to_due(old, place)


def rough(s: Array, seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(s.size, 7))


@given(
    old=st.lists(st.floats(0.05, 4.0), min_size=2, max_size=40),
    new=st.lists(st.floats(-0.1, 1.1), min_size=1, max_size=40),
    seed=st.integers(0, 1000),
)
@settings(max_examples=200, deadline=None)
def test_interpolated_values_are_equal(parts: SimpleNamespace, old: list[float], new: list[float], seed: int) -> None:
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
def test_state_carried_elsewhere_is_equal(parts: SimpleNamespace, direction: int, growth: float, seed: int) -> None:
    mesh = Mesh(grading_length=growth)
    old = partition(mesh, 120.0, 50.0)
    pattern, lengths = c_partition(parts, mesh, 120.0, 50.0)
    parts.partition_transform(pattern, direction, len(lengths), lengths)
    new_s = arc_lengths(lengths)
    fields = np.array([rough(old.nodes_s, seed + k) for k in range(2)])
    work = np.full((10 + 14 * len(fields)) * new_s.size + 1, -7.0)  # as in core.h
    expected = transfer_fields(fields, old.nodes_s, transform(old, direction).nodes_s)
    addresses = (ct.c_void_p * 2)(*(x.ctypes.data for x in fields))
    parts.transfer_fields(new_s.size, old.nodes_s, new_s, 2, addresses, work)
    assert_allclose(fields, expected, rtol=ROUNDING, atol=ROUNDING)
    assert work[-1] == -7.0
