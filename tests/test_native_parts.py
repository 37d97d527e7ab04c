"""The native rope's mesh, frame, shape and signals give what the Python functions give.

Both do the same operations in the same order.  They may differ by what libm, numpy's vectorised sine, cosine and power,
and sums in another order round differently: 1e-12 of the quantities' size, where nothing else is said.
"""

from __future__ import annotations

import ctypes as ct
import math
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from rope_model.native.build import generate
from rope_model.native.structures import GROUPS, PathStructure, path_structure, scene_structure
from rope_model.numerics.generalized_alpha import Motion
from rope_model.numerics.kernels import LIBRARY_SUFFIX, find_compiler
from rope_model.parameters import Layout, Mesh, Rope, Scene, Swivel, SwivelMode
from rope_model.physics.guard import GuardState
from rope_model.physics.outline import heading
from rope_model.physics.shaft import KINDS as KINDS_OF_BODIES
from rope_model.shaft_parameters import Conveyance, Divider, HeadRopes, Lining, Shaft, Sump
from rope_model.simulation.adaptation import nearest_turn
from rope_model.simulation.audit import Audit
from rope_model.simulation.diagnostics import (
    LoopBottom,
    leg_clearance,
    loop_bottom,
    loop_turns,
    shape,
    shape_places,
)
from rope_model.simulation.ends import HangingEnds, Phase, SwivelState, nominal_points
from rope_model.simulation.fidelity import FIDELITIES, Fidelity
from rope_model.simulation.mesh import (
    Partition,
    distance_to_due,
    fit_mesh,
    partition,
    transform,
    transformation_due,
)
from rope_model.simulation.paths import EndPath
from rope_model.simulation.rope_system import arc_lengths
from rope_model.simulation.shaft import direction
from rope_model.simulation.signal_table import SIGNALS
from rope_model.simulation.signals import (
    added_mass_signals,
    along_signals,
    audit_signals,
    clearance_signals,
    contact_signals,
    end_signals,
    energy_signals,
    error_signals,
    group_of,
    guard_signals,
    loop_signals,
    nearest_signals,
    shape_signals,
    station_signals,
    stress_signals,
)
from rope_model.simulation.state import Counts, Crossing, EnergyBalance, Nearest, RopeState
from rope_model.simulation.statics import StaticsError, hanging_guess
from rope_model.simulation.transfer import interpolate, transfer_fields

Array = NDArray[np.float64]

NATIVE = Path(__file__).resolve().parent.parent / "rope_model" / "native"
FLAGS = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-ffp-contract=off")
PARTS = (
    "mesh.c",
    "transfer.c",
    "shape.c",
    "shaft.c",
    "guards.c",
    "signals.c",
    "rigid.c",
    "ends.c",
    "parameters.c",
    "text.c",
)
KINDS = ("tmn", "eem", "auto")
MODES: tuple[SwivelMode, ...] = ("locked", "free", "coulomb")
FIDELITY_NAMES = ("auto", "torsional", "spatial", "planar", "rigid")
GROUPS_OF_SIGNALS = (
    end_signals,
    loop_signals,
    stress_signals,
    energy_signals,
    audit_signals,
    error_signals,
    shape_signals,
    along_signals,
    added_mass_signals,
    clearance_signals,
    nearest_signals,
    contact_signals,
    guard_signals,
    station_signals,
)
#: groups that are computed where the equations are
ELSEWHERE = (added_mass_signals, contact_signals)
MESSAGE, ROUNDING = 512, 1e-12


class CPattern(ct.Structure):
    _fields_ = (
        ("coarse", ct.c_double),
        ("grading_length", ct.c_double),
        ("counts", ct.c_int32 * 7),
        ("end_levels", ct.c_int32),
    )


class CLoopBottom(ct.Structure):
    _fields_ = (("s", ct.c_double), ("position", ct.c_double * 3), ("yaw", ct.c_double))

    @staticmethod
    def of(bottom: LoopBottom) -> CLoopBottom:
        return CLoopBottom(bottom.s, tuple(bottom.position), bottom.yaw)


#: the signals of a state that the caller gives by its members, so that its layout is C's own business
SIGNALS_BY_MEMBERS = """
#include <string.h>
#include "signals.h"

void signals_by_members(int group, const Scene *scene, int fidelity, double t, double loop_yaw, const double *offsets,
                        const double *means, const int *phases, const double *signs,
                        const Path *paths, const double *energy_balance, const double *counts, double given_up_since,
                        const Audit *audit, const double *nearest, const double *crossing, const double *guard,
                        const Arrays *arrays, const double (*strains)[3], const LoopBottom *bottom, double *values) {
    State s;
    memset(&s, 0, sizeof s);
    s.t = t, s.loop_yaw = loop_yaw, s.fidelity = fidelity, s.given_up_since = given_up_since, s.audit = *audit;
    for (int k = 0; k < 2; k++) {
        s.offsets[k] = offsets[k], s.force_mean[k] = means[k], s.paths[k] = paths[k];
        s.swivels[k].phase = phases[k], s.swivels[k].sign = signs[k];
    }
    const double *l = energy_balance, *n = counts;
    EnergyBalance *e = &s.energy_balance;
    e->kinetic = l[0], e->strain = l[1], e->gravity = l[2], e->contact = l[3];
    e->work_ends = l[4], e->dissipated_material = l[5], e->dissipated_swivel = l[6];
    e->dissipated_contact = l[7], e->dissipated_wires = l[8], e->given_to_air = l[9];
    e->nonconservative = l[10], e->transformations = l[11], e->start = l[12];
    s.counts.steps = (int64_t)n[0], s.counts.rejections = (int64_t)n[1], s.counts.newton = (int64_t)n[2];
    s.counts.transformations = (int64_t)n[3], s.counts.swivel_events = (int64_t)n[4];
    s.counts.given_up = (int64_t)n[5];
    memcpy(s.nearest, nearest, sizeof s.nearest);
    memcpy(&s.crossing, crossing, sizeof s.crossing);
    memcpy(&s.guard, guard, sizeof s.guard);
    signals_of(group, scene, &s, arrays, strains, bottom, values);
}

void arrays_of(double *q, double *v, double *a, double *reaction, double *lengths, double *s, int nodes,
               Arrays *arrays) {
    Arrays of = {q, v, a, NULL, NULL, reaction, lengths, s, NULL, nodes - 1, nodes};
    *arrays = of;
}
"""


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The C functions by their names."""
    compiler = find_compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("native")
    path = folder / f"parts{LIBRARY_SUFFIX}"
    for name, text in generate().items():
        (folder / name).write_text(text, encoding="ascii")
    (folder / "by_members.c").write_text(SIGNALS_BY_MEMBERS, encoding="ascii")
    sources = [*(str(NATIVE / name) for name in PARTS), str(folder / "by_members.c")]
    subprocess.run([*compiler, *FLAGS, f"-I{NATIVE}", f"-I{folder}", *sources, "-o", str(path), "-lm"], check=True)
    library = ct.CDLL(str(path))
    n, x, p = ct.c_int, ct.c_double, ct.c_void_p
    signatures: dict[str, tuple[Any, ...]] = {
        "mesh_fit": (GROUPS[Mesh], p),
        "mesh_elements": (n, p, x, p),
        "mesh_partition": (None, p, x, x, n, p, p),
        "mesh_transform": (None, p, n, n, p),
        "mesh_centre": (x, p),
        "mesh_distance_to_due": (x, p, x),
        "mesh_transformation_due": (n, p, x, x),
        "mesh_arc_lengths": (None, n, p, p),
        "transfer_interpolate": (None, n, p, p, n, p, p),
        "transfer_fields": (None, n, p, p, n, p, p),
        "shape_nearest_turn": (x, x, x),
        "shape_loop_bottom": (CLoopBottom, n, p, p),
        "shape_leg_clearance": (x, n, p, p, p, x, x, x),
        "shape_legs_apart": (n, p, p),
        "shape_places": (None, x, x, x, n, p),
        "shape_points": (None, n, p, p, n, p, p),
        "shape_hanging_guess": (None, n, p, p, p, p, p),
        "signal_group": (n, n),
        "signals_by_members": (None, n, p, n, x, x, *[p] * 7, x, *[p] * 8),
        "arrays_of": (None, p, p, p, p, p, p, n, p),
    }
    for name, (result, *arguments) in signatures.items():
        getattr(library, name).restype, getattr(library, name).argtypes = result, arguments
    return SimpleNamespace(**{name: passing_arrays(getattr(library, name)) for name in signatures})


def passing_arrays(function: Any) -> Callable[..., Any]:
    """``function`` with numpy arrays (C order, float) and ctypes structures as pointers."""

    def address(x: Any) -> Any:
        if isinstance(x, np.ndarray):
            assert x.flags.c_contiguous
            assert x.dtype == float
            return x.ctypes.data
        return ct.addressof(x) if isinstance(x, ct.Structure | ct.Array) else x

    return lambda *arguments: function(*map(address, arguments))


def message() -> Any:
    return ct.create_string_buffer(MESSAGE)


def c_of(group: Any) -> Any:
    """A group of parameters as C sees it."""
    scene = scene_structure(Scene().with_(**{type(group).__name__.lower(): group}))
    return getattr(scene, type(group).__name__.lower())


def c_partition(parts: SimpleNamespace, mesh: Mesh, length: float, bottom: float) -> tuple[Any, Array]:
    """Pattern and lengths; ValueError with the message where it does not fit."""
    text = message()
    elements = parts.mesh_elements(c_of(mesh), length, text)
    if elements == 0:
        raise ValueError(text.value.decode())
    assert text.value == b""
    pattern, lengths = CPattern(), np.full(elements + 1, -7.0)
    parts.mesh_partition(c_of(mesh), length, bottom, elements, pattern, lengths)
    assert lengths[-1] == -7.0  # not written beyond its end
    return pattern, lengths[:-1].copy()


def as_in_c(mesh: Partition) -> tuple[Any, Array]:
    """Pattern and lengths."""
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
        kind, elements, l, element_counts(twos, fours, fine), levels, growth, error
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
ropes = st.builds(
    lambda length, EI: Rope(length=length, EI=EI),
    st.floats(10.0, 600.0),
    st.floats(10.0, 3000.0),
)
layouts = st.builds(Layout, st.floats(0.3, 5.0))


@given(mesh=meshes, rope=ropes, layout=layouts)
@example(mesh=Mesh("auto", loop_error=1.0), rope=Rope(length=9000.0, EI=0.01), layout=Layout(8.0))  # most end levels
@settings(max_examples=200, deadline=None)
def test_fitted_mesh_is_the_same(parts: SimpleNamespace, mesh: Mesh, rope: Rope, layout: Layout) -> None:
    scene = Scene(rope, layout, mesh=mesh)
    ours, expected = parts.mesh_fit(scene_structure(scene)), fit_mesh(scene)
    assert (KINDS[ours.kind], ours.elements, tuple(ours.counts), ours.end_levels) == (
        expected.kind,
        expected.elements,
        expected.counts,
        expected.end_levels,
    )
    assert_allclose(ours.coarse_length, expected.coarse_length, rtol=1e-15)
    assert_allclose(ours.grading_length, expected.grading_length, rtol=1e-15)
    assert ours.loop_error == expected.loop_error


@given(mesh=meshes.filter(lambda mesh: mesh.kind != "auto"), length=st.floats(10.0, 400.0), part=st.floats(-0.1, 1.1))
@settings(max_examples=200, deadline=None)
def test_partition_is_the_same_to_the_bit(parts: SimpleNamespace, mesh: Mesh, length: float, part: float) -> None:
    assert outcome(lambda: c_partition(parts, mesh, length, part * length)) == outcome(
        lambda: as_in_c(partition(mesh, length, part * length))
    )


@pytest.mark.parametrize(
    ("mesh", "length"),
    [(Mesh(coarse_length=1e-3), 120.0), (Mesh(coarse_length=1e-15), 120.0), (Mesh(), 20.9), (Mesh(), 1234567.8)],
)
def test_mesh_that_does_not_fit_is_refused_in_the_same_words(parts: SimpleNamespace, mesh: Mesh, length: float) -> None:
    with pytest.raises(ValueError) as expected:  # noqa: PT011 - the whole text is compared
        partition(mesh, length, 10.0)
    with pytest.raises(ValueError) as ours:  # noqa: PT011
        c_partition(parts, mesh, length, 10.0)
    assert str(ours.value) == str(expected.value)


def test_equal_elements_out_of_range_are_refused_as_the_parameters_refuse_them(parts: SimpleNamespace) -> None:
    # 'auto' may ask for them: parameters are made anew in Python, and checked there
    with pytest.raises(ValueError, match="elements") as expected:
        Mesh("eem", elements=20001)
    mesh, text = c_of(Mesh("eem")), message()
    mesh.elements = 20001
    assert parts.mesh_elements(mesh, 120.0, text) == 0
    assert text.value.decode() == str(expected.value)


@given(mesh=meshes.filter(lambda mesh: mesh.kind != "auto"), length=st.floats(10.0, 400.0), data=st.data())
@settings(max_examples=100, deadline=None)
def test_loop_that_travels_to_and_fro_transforms_alike(
    parts: SimpleNamespace, mesh: Mesh, length: float, data: st.DataObject
) -> None:
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
            parts.mesh_transform(pattern, direction, len(lengths), lengths)
            assert [*map(bytes, ours)] == [*map(bytes, as_in_c(old))]
            assert parts.mesh_centre(pattern) == old.centre
        assert parts.mesh_transformation_due(pattern, place, slack) == 0
        assert parts.mesh_distance_to_due(pattern, place) == distance_to_due(old, place)


@pytest.mark.parametrize("limit", [0.0, 0.6])
def test_loop_at_the_centre_or_a_limit_is_judged_alike(parts: SimpleNamespace, limit: float) -> None:
    mesh = partition(Mesh(), 120.0, 60.0)
    pattern, _ = c_partition(parts, Mesh(), 120.0, 60.0)
    for part in (-limit - 0.01, -limit, limit, limit + 0.01):
        place = mesh.centre + part * mesh.coarse
        for slack in (-1.0, 0.0, 1e-7, 100.0):
            assert parts.mesh_transformation_due(pattern, place, slack) == transformation_due(mesh, place, slack)


def rough(s: Array, seed: int) -> Array:
    """(nodes, 7): any values."""
    return np.random.default_rng(seed).normal(size=(s.size, 7))


@given(
    old=st.lists(st.floats(0.05, 4.0), min_size=2, max_size=40),
    new=st.lists(st.floats(-0.1, 1.1), min_size=1, max_size=40),
    seed=st.integers(0, 1000),
)
@settings(max_examples=200, deadline=None)
def test_interpolated_values_are_the_same(
    parts: SimpleNamespace, old: list[float], new: list[float], seed: int
) -> None:
    lengths = np.array(old)
    expected_s = arc_lengths(lengths)
    s = np.empty(lengths.size + 1)
    parts.mesh_arc_lengths(lengths.size, lengths, s)
    assert_array_equal(s, expected_s)
    # anywhere, at the nodes, and a hair beside them
    new_s = np.concatenate((np.array(new) * s[-1], s, s + 1e-10, s - 1e-8, s + 1e-8))
    x, y = rough(s, seed), np.full((new_s.size + 1, 7), -7.0)
    parts.transfer_interpolate(s.size, x, s, new_s.size, new_s, y)
    assert_allclose(y[:-1], interpolate(x, s, new_s), rtol=ROUNDING, atol=ROUNDING)
    assert np.all(y[-1] == -7.0)


@given(direction=st.sampled_from((1, -1)), growth=st.floats(0, 100), seed=st.integers(0, 1000))
def test_state_carried_to_a_transformed_mesh_is_the_same(
    parts: SimpleNamespace, direction: int, growth: float, seed: int
) -> None:
    mesh = Mesh(grading_length=growth)
    old = partition(mesh, 120.0, 50.0)
    pattern, lengths = c_partition(parts, mesh, 120.0, 50.0)
    parts.mesh_transform(pattern, direction, len(lengths), lengths)
    new_s = arc_lengths(lengths)
    fields = np.array([rough(old.nodes_s, seed + k) for k in range(2)])
    work = np.full((10 + 14 * len(fields)) * new_s.size + 1, -7.0)  # as in core.h
    expected = transfer_fields(fields, old.nodes_s, transform(old, direction).nodes_s)
    addresses = (ct.c_void_p * 2)(*(x.ctypes.data for x in fields))
    parts.transfer_fields(new_s.size, old.nodes_s, new_s, 2, addresses, work)
    assert_allclose(fields, expected, rtol=ROUNDING, atol=ROUNDING)
    assert work[-1] == -7.0


def tangents(q: Array) -> Array:
    d = q[:, 3:6]
    return d / np.sqrt(np.einsum("ij,ij->i", d, d))[:, None]


def unit(seed: int) -> Array:
    x = np.random.default_rng(seed).normal(size=3)
    return np.asarray(x / np.linalg.norm(x))


def random_curve(seed: int, nodes: int = 60, turns: float = 1.5) -> Array:
    """(nodes, 7): tangents that wander over the sphere without a jump, of any length."""
    random, u = np.random.default_rng(seed), np.linspace(0.0, 1.0, nodes)
    q = random.normal(size=(nodes, 7))
    for k in range(3, 6):
        q[:, k] = sum(a * np.cos(2 * np.pi * turns * m * u + b) for m, (a, b) in enumerate(random.normal(size=(3, 2))))
    return q


@given(angle=st.floats(-4.0, 4.0), last=st.floats(-100.0, 100.0))
def test_angle_counted_on_is_the_same(parts: SimpleNamespace, angle: float, last: float) -> None:
    assert parts.shape_nearest_turn(angle, last) == nearest_turn(angle, last)


def test_angle_half_a_turn_away_is_rounded_to_even_turns(parts: SimpleNamespace) -> None:
    for halves in range(-7, 8):
        assert parts.shape_nearest_turn(0.0, halves * math.pi) == nearest_turn(0.0, halves * math.pi)


hangings = st.tuples(
    st.floats(0.3, 6.0), st.floats(-30.0, 30.0), st.floats(-2.0, 2.0), st.floats(0.2, 4.0), st.floats(40.0, 200.0)
)


def hang(spacing: float, height: float, z: float, coarse: float, length: float) -> tuple[Array, Array, Array]:
    """Arc lengths and ends of a rope."""
    left, right = np.array([-0.5 * spacing, height, z]), np.array([0.5 * spacing, 0.0, -z])
    cells = partition(Mesh(coarse_length=coarse, counts=(2, 4, 8, 4, 2)), length, 0.5 * (length + height))
    return cells.nodes_s, left, right


@given(hanging=hangings)
@settings(max_examples=200, deadline=None)
def test_hanging_guess_is_the_same(parts: SimpleNamespace, hanging: tuple[float, ...]) -> None:
    spacing, height, z, coarse, length = hanging
    assume(length > 15 * coarse)
    assume(length - abs(height) > 2 * np.hypot(spacing, 2 * z))  # a shorter rope does not reach around its loop
    s, left, right = hang(*hanging)
    q, text = np.empty((s.size, 7)), message()
    parts.shape_hanging_guess(s.size, s, left, right, q, text)
    assert text.value == b""
    # sine and cosine of an angle that two large arc lengths leave over
    assert_allclose(q, hanging_guess(s, left, right), rtol=ROUNDING, atol=ROUNDING * s[-1])


@pytest.mark.parametrize("spacing", [0.02, 2.0, 9.0])
def test_hanging_guess_on_few_elements_is_the_same(parts: SimpleNamespace, spacing: float) -> None:
    for middle_at in np.linspace(-3.0, 3.0, 13):  # over the middles of all elements and beyond
        s, left, right = (
            np.array([0.0, 9.0, 13.0, 24.0]),
            np.array([0.0, middle_at, 0.0]),
            np.array([spacing, 0.0, 1.0]),
        )
        q, text = np.empty((4, 7)), message()
        parts.shape_hanging_guess(4, s, left, right, q, text)
        assert_allclose(q, hanging_guess(s, left, right), rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize(("spacing", "height"), [(60.0, 0.0), (2.0, 49.5), (2.0, -49.5), (2.0, 61.25)])
def test_rope_too_short_to_hang_is_refused_in_the_same_words(
    parts: SimpleNamespace, spacing: float, height: float
) -> None:
    s, left, right = np.linspace(0.0, 50.0, 41), np.array([0.0, height, 0.0]), np.array([spacing, 0.0, 0.0])
    q, text = np.empty((41, 7)), message()
    parts.shape_hanging_guess(41, s, left, right, q, text)
    with pytest.raises(StaticsError) as expected:
        hanging_guess(s, left, right)
    assert text.value.decode() == str(expected.value)


def sway(hanging: tuple[float, ...], seed: int) -> tuple[Array, Array, Array]:
    """Configuration, element lengths and nodes of a rope that hangs crooked, its legs perhaps crossed."""
    s, left, right = hang(*hanging)
    q, random = hanging_guess(s, left, right), np.random.default_rng(seed)
    q[:, 0] += random.normal() * np.sin(3 * s / s[-1])
    q[:, 2] += random.normal() * np.sin(5 * s / s[-1])
    q += 0.01 * random.normal(size=q.shape)
    return q, np.diff(s), s


@given(hanging=hangings, seed=st.integers(0, 1000))
@settings(max_examples=100, deadline=None)
def test_loop_shape_and_clearance_are_the_same(parts: SimpleNamespace, hanging: tuple[float, ...], seed: int) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    q, lengths, s = sway(hanging, seed)
    bottom, expected = parts.shape_loop_bottom(s.size, q, s), loop_bottom(q, lengths)
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
        assert_allclose(places[:-1], shape_places(lengths, expected.s, 4.0, points), atol=ROUNDING * s[-1])
        assert places[-1] == -7.0
        parts.shape_points(s.size, q, s, points, places, xyz)
        assert_allclose(xyz[:-1], shape(q, lengths, expected.s, 4.0, points), atol=ROUNDING * s[-1])
        assert np.all(xyz[-1] == -7.0)
    for above in (0.0, 0.3, hanging[0], 1e3):
        ours = parts.shape_leg_clearance(s.size, q, s, same, 4.0, 0.044, above)
        assert_allclose(ours, leg_clearance(q, lengths, expected, 4.0, 0.044, above), atol=ROUNDING * s[-1])


@given(hanging=hangings, seed=st.integers(0, 1000), size=st.sampled_from((0.0, 0.3, 1.0)))
@settings(max_examples=200, deadline=None)
def test_legs_that_lie_apart_have_not_turned(
    parts: SimpleNamespace, hanging: tuple[float, ...], seed: int, size: float
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    still, (q, lengths, s) = hanging_guess(*hang(*hanging)), sway(hanging, seed)
    q = still + size * (q - still)
    line, arrays = direction(q), ct.create_string_buffer(ct.sizeof(ct.c_void_p) * 10)
    parts.arrays_of(q, q, q, q, lengths, s, s.size, arrays)
    apart = parts.shape_legs_apart(arrays, np.array(heading(line)))
    if apart:
        bottom = loop_bottom(q, lengths)
        yaw = nearest_turn(bottom.yaw, line) - line
        assert abs(yaw) <= 0.5 * math.pi
        assert round(yaw / (2 * math.pi) - loop_turns(q, lengths, bottom).number) == 0


@pytest.mark.parametrize("lowest", [0, 4])
def test_rope_lowest_at_an_end_is_read_alike(parts: SimpleNamespace, lowest: int) -> None:
    lengths = np.full(4, 2.5)
    s = arc_lengths(lengths)
    q = np.zeros((5, 7))
    q[:, 1], q[:, 4] = np.abs(s - s[lowest]), 1.0 if lowest == 0 else -1.0
    q[:, 3] = 0.1
    bottom, expected = parts.shape_loop_bottom(5, q, s), loop_bottom(q, lengths)
    assert (bottom.s, tuple(bottom.position), bottom.yaw) == (expected.s, tuple(expected.position), expected.yaw)
    loop = LoopBottom(float(s[lowest]), q[lowest, :3], 0.0)
    same = CLoopBottom.of(loop)
    assert (
        parts.shape_leg_clearance(5, q, s, same, 4.0, 0.044, 1.0)
        == leg_clearance(q, lengths, loop, 4.0, 0.044, 1.0)
        == math.inf
    )


def any_rope(
    hanging: tuple[float, ...],
    seed: int,
    phases: tuple[Phase, Phase],
    modes: tuple[SwivelMode, SwivelMode],
    fidelity: Fidelity = "torsional",
) -> Any:
    """What a RopeSimulator shows of itself, with any numbers in it that belong to no motion."""
    q, lengths, s = sway(hanging, seed)
    random = np.random.default_rng(seed + 1)
    swivels = tuple(Swivel(mode, 0.1, 0.3, 0.2, 0.7) for mode in modes)
    states = tuple(SwivelState(phase, *random.normal(size=2)) for phase in phases)
    paths = tuple(
        EndPath(start, start + 1.0, start + 1.0, tuple(map(tuple, random.normal(size=(4, 6)))))
        for start in random.uniform(0, 2, 2)
    )
    v, a, b, a_rate, reaction = random.normal(size=(5, *q.shape))
    offsets = tuple(random.normal(size=2))
    state = RopeState(
        motion=Motion(2.0, q, v, a, b, a_rate, 0.01, 100 * reaction),
        partition=Partition(lengths),
        offsets=offsets,
        swivels=states,
        paths=paths,
        step_next=0.01,
        calm_since=0.0,
        last_interval=0.1,
        force_mean=tuple(random.normal(size=2)),
        loop_yaw=20 * random.normal(),
        fidelity=fidelity,
        fidelity_reason="",
        energy_balance=EnergyBalance(*random.normal(size=11)),
        given_up_since=random.normal(),
        audit=Audit()._replace(**dict(zip(Audit._fields[5:], random.uniform(0, 3, 7), strict=True))),
        counts=Counts(*map(int, random.integers(0, 2**40, 6))),
        nearest=tuple(Nearest(*random.normal(size=5)) for _ in KINDS_OF_BODIES),
        crossing=Crossing(*random.normal(size=4)),
        guard=GuardState(*random.normal(size=3)),
    )
    shaft = Shaft(
        Lining(8.0, 6.0, 0.3, *random.normal(size=2)),
        Conveyance(*random.uniform(0.5, 2.0, 4)),
        HeadRopes(0.05, 0.9),
        *(
            Divider(random.uniform(0.1, 0.5), y, random.normal(), random.normal(), part)
            for y, part in zip(random.normal(-5.0, 10.0, 4), (0.0, 0.3, 0.7, 1.0), strict=True)
        ),
        Sump(-20.0),
    )
    scene = Scene(Rope(Qb=2.4e5, Qc=2.1e5), Layout(hanging[0]), *swivels, shaft=shaft)
    strains = random.normal(size=(lengths.size, 3))
    return SimpleNamespace(
        scene=scene,
        state=state,
        loop=loop_bottom(q, lengths),
        ends=HangingEnds(nominal_points(hanging[0]), paths, swivels, states, offsets),
        system=SimpleNamespace(strains=lambda _: strains),
        s=s,
    )


def group_values(parts: SimpleNamespace, group: int, rope: Any) -> Array:
    """Values at their signals' numbers; NaN where the group leaves them alone."""
    state, m, bottom = rope.state, rope.state.motion, CLoopBottom.of(rope.loop)
    phases = (ct.c_int * 2)(*(x.phase.value for x in state.swivels))
    signs, offsets, means = (np.array(x) for x in ([x.sign for x in state.swivels], state.offsets, state.force_mean))
    paths = (PathStructure * 2)(*map(path_structure, state.paths))
    audit = np.concatenate([np.ravel(x) for x in state.audit])
    nearest, crossing = np.ravel(state.nearest), np.array(state.crossing)
    guard = np.array([*state.guard[:3], *state.guard.since])
    energy_balance, counts = np.array(state.energy_balance), np.array(state.counts, dtype=float)
    arrays, values = ct.create_string_buffer(ct.sizeof(ct.c_void_p) * 10), np.full(len(SIGNALS) + 1, np.nan)
    parts.arrays_of(m.q, m.v, m.a, m.reaction, state.partition.lengths, rope.s, len(m.q), arrays)
    parts.signals_by_members(
        group, scene_structure(rope.scene), FIDELITY_NAMES.index(state.fidelity), m.t, state.loop_yaw, offsets,
        means, phases, signs, paths, energy_balance, counts, state.given_up_since, audit, nearest, crossing, guard,
        arrays, rope.system.strains(m.q), bottom, values
    )  # fmt: skip
    assert np.isnan(values[-1])
    return values[:-1]


@given(
    hanging=hangings,
    seed=st.integers(0, 1000),
    phases=st.tuples(*[st.sampled_from(Phase)] * 2),
    modes=st.tuples(*[st.sampled_from(MODES)] * 2),
    fidelity=st.sampled_from(FIDELITIES),
)
@settings(max_examples=60, deadline=None)
def test_signals_are_the_same(
    parts: SimpleNamespace,
    hanging: tuple[float, ...],
    seed: int,
    phases: tuple[Phase, Phase],
    modes: tuple[SwivelMode, SwivelMode],
    fidelity: Fidelity,
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    rope = any_rope(hanging, seed, phases, modes, fidelity)
    computed = (function(rope) for function in GROUPS_OF_SIGNALS if function not in ELSEWHERE)
    expected, ours = {name: value for values in computed for name, value in values.items()}, {}
    for group in range(len(GROUPS_OF_SIGNALS)):
        values = group_values(parts, group, rope)
        ours |= {name: x for name, x in zip(SIGNALS, values, strict=True) if not np.isnan(x)}
    assert ours.keys() == expected.keys()
    # points along the rope: of the largest one's size, because invented values jump from element to element
    size = {name.partition("[")[0]: rope.s[-1] for name in expected}
    for name, value in expected.items():
        if name.startswith(("shape.", "station.")):
            size[name.partition("[")[0]] = max(abs(value), size[name.partition("[")[0]])
    for name, value in expected.items():
        atol = ROUNDING * size[name.partition("[")[0]]
        assert_allclose(ours[name], value, rtol=ROUNDING, atol=atol, err_msg=name)


def test_group_of_a_signal_holds_it(parts: SimpleNamespace) -> None:
    rope = any_rope((2.0, 3.0, 0.1, 2.0, 120.0), 1, (Phase.SLIP, Phase.STICK), ("coulomb", "locked"))
    for group, function in enumerate(GROUPS_OF_SIGNALS):
        members = [name for k, name in enumerate(SIGNALS) if parts.signal_group(k) == group]
        assert members == [name for name in SIGNALS if group_of(name) is function]
        computed = ~np.isnan(group_values(parts, group, rope))
        assert [name for name, is_there in zip(SIGNALS, computed, strict=True) if is_there] == (
            [] if function in ELSEWHERE else members
        )
    assert {parts.signal_group(k) for k in (-1, len(SIGNALS), 10**6)} == {-1}
