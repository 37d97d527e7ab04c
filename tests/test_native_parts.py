"""The native rope's frame, shape and signals give what the Python functions give.

Both do the same operations in the same order; tests/native_parts.py says how they may differ.
"""

import ctypes as ct
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from native_parts import ROUNDING, Array, CLoopBottom, message
from numpy.testing import assert_allclose

from rope_model.native.structures import PathStructure, path_structure, scene_structure
from rope_model.numerics.generalized_alpha import Motion
from rope_model.parameters import Layout, Mesh, Rope, Scene, Swivel, SwivelMode
from rope_model.physics.guard import GuardState
from rope_model.physics.outline import heading
from rope_model.physics.shaft import KINDS as KINDS_OF_BODIES
from rope_model.shaft_parameters import Conveyance, Divider, HeadRopes, Lining, Shaft, Sump
from rope_model.simulation.adaptation import nearest_turn
from rope_model.simulation.audit import Audit
from rope_model.simulation.diagnostics import (
    LoopBottom,
    direction,
    leg_clearance,
    legs_apart,
    loop_bottom,
    loop_turns,
    shape,
    shape_places,
)
from rope_model.simulation.ends import HangingEnds, Phase, SwivelState, nominal_points
from rope_model.simulation.fidelity import FIDELITIES, Fidelity
from rope_model.simulation.mesh import Partition, partition
from rope_model.simulation.paths import EndPath
from rope_model.simulation.rope_system import arc_lengths
from rope_model.simulation.self_contact import overlap_of
from rope_model.simulation.signal_table import SIGNALS
from rope_model.simulation.signals import added_mass_signals, contact_signals, group_of
from rope_model.simulation.state import Counts, Crossing, EnergyBalance, Nearest, RopeState
from rope_model.simulation.statics import hanging_guess

MODES: tuple[SwivelMode, ...] = ("locked", "free", "coulomb")
FIDELITY_NAMES = ("auto", "torsional", "spatial", "planar", "rigid")
#: in the order of their numbers in C
GROUPS_OF_SIGNALS = tuple(dict.fromkeys(map(group_of, SIGNALS)))
#: groups that are computed where the equations are
ELSEWHERE = (added_mass_signals, contact_signals)


@given(angle=st.floats(-4.0, 4.0), last=st.floats(-100.0, 100.0))
def test_angle_counted_on_is_the_same(parts: SimpleNamespace, angle: float, last: float) -> None:
    assert parts.shape_nearest_turn(angle, last) == nearest_turn(angle, last)


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


def tangle(kind: str, seed: int) -> tuple[Array, Array]:
    """Configuration and element lengths of a rope that hangs as none should."""
    random = np.random.default_rng(seed)
    lengths = random.uniform(0.2, 2.0, random.integers(4, 60))
    s, width, q = arc_lengths(lengths), 10.0 ** random.uniform(-2, 1), np.zeros((lengths.size + 1, 7))
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
            ours = parts.shape_leg_clearance(s.size, q, s, CLoopBottom.of(bottom), 4.0, 0.044, above)
            expected = leg_clearance(q, lengths, bottom, 4.0, 0.044, above)
            assert_allclose(ours, expected, atol=ROUNDING * s[-1])
            seen += math.isfinite(expected)
    assert seen > 60


@given(hanging=hangings, seed=st.integers(0, 1000), size=st.sampled_from((0.0, 0.3, 1.0)))
@settings(max_examples=200, deadline=None)
def test_legs_that_lie_apart_have_not_turned(
    parts: SimpleNamespace, hanging: tuple[float, ...], seed: int, size: float
) -> None:
    assume(hanging[-1] > 15 * hanging[3])
    still, (q, lengths, s) = hanging_guess(*hang(*hanging)), sway(hanging, seed)
    q = still + size * (q - still)
    line, diameter, above = direction(q), 0.05, hanging[3]
    apart = legs_apart(q, lengths, diameter, above)
    assert apart == in_c(parts, q, lengths, s, diameter, above)
    if apart:
        bottom = loop_bottom(q, lengths)
        assert leg_clearance(q, lengths, bottom, above, diameter, above) > 0
        yaw = nearest_turn(bottom.yaw, line) - line
        assert abs(yaw) <= 0.5 * math.pi
        assert round(yaw / (2 * math.pi) - loop_turns(q, lengths, bottom).number) == 0


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


def in_c(parts: SimpleNamespace, q: Array, lengths: Array, s: Array, diameter: float, above: float) -> bool:
    """``legs_apart`` of the native form."""
    arrays = ct.create_string_buffer(ct.sizeof(ct.c_void_p) * 10)
    parts.arrays_of(q, q, q, q, lengths, s, s.size, arrays)
    return bool(parts.shape_legs_apart(arrays, np.array(heading(direction(q))), diameter, above))


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
    for signal in (-1, len(SIGNALS), 10**6):
        assert math.isnan(parts.rope_signal(parts.signals_rope(), signal))
