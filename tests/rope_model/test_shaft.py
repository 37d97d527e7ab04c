"""How near the rope is to the bodies of its shaft, and how often it is turned about itself: exact geometry."""

import math
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from native_parts import CLoopBottom, clearances, interpolate, loop_turns, shape
from numpy.testing import assert_allclose, assert_array_equal
from scenes import Ends, ends_at, followed, going_aside, hung, wound
from shared import Array

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from hoist_demo.recording.passages import PASSAGE_SIGNALS, passages
from hoist_demo.recording.time_series import Recording
from rope_model import (
    EndMotion,
    Layout,
    Mesh,
    Model,
    Rope,
    Scene,
    Solver,
    balance_rope,
    rope_120,
)
from rope_model.boundary.bodies import NO_ROOM, RESOLUTION
from rope_model.messages.rules import first_text
from rope_model.physics import shaft as physics
from rope_model.physics.node import arc_lengths
from rope_model.physics.shaft import KINDS, Body, distance, min_distance
from rope_model.shaft_parameters import Contact, Conveyance, Divider, HeadRopes, Lining, Shaft, Sump

#: of the distances: sqrt(TINY), and places to 1e4 m in double precision
EXACT = 1e-10
RECTANGLE = Lining(6.0, 4.0, 0.5, 1.0, -1.0)
CIRCLE = Lining(6.0, 6.0, 1.0)
CAGE = Conveyance(2.0, 1.0, 4.0, 0.5)
ROPES = HeadRopes(0.04, 0.6)
#: turned by 30 degrees, its axis through X = 1 / cos 30 degrees
ACROSS = Divider(0.2, -3.0, 1.0, math.pi / 6, 0.0)
END = (10.0, 20.0, 30.0)


@pytest.mark.parametrize(
    ("body", "point", "expected"),
    [
        (physics.lining(RECTANGLE), (3.5, 1e3, -1.0), 0.5),  # from the wall at X = 4
        (physics.lining(RECTANGLE), (1.0, 0.0, 1.5), -0.5),  # behind the wall at Z = 1
        # the corner of radius 1 has its centre at (3, 0)
        (physics.lining(RECTANGLE), (3.3, 0.0, 0.4), 0.5),
        (physics.lining(CIRCLE), (1.2, -7.0, 1.6), 1.0),
        (physics.conveyance(CAGE, END), (10.0, 20.1, 30.0), 0.4),  # below its underside at 20.5
        (
            physics.conveyance(CAGE, END),
            (11.3, 22.0, 30.9),
            0.5,
        ),  # from its upright edge at (11, 30.5)
        (physics.conveyance(CAGE, END), (12.0, 18.5, 32.5), 3.0),  # from its corner: 1, 2, 2
        (
            physics.conveyance(CAGE, END),
            (10.8, 22.0, 30.1),
            -0.2,
        ),  # inside, nearest to the face at 11
        (
            physics.head_ropes(ROPES, CAGE, END),
            (10.3, 900.0, 30.7),
            0.48,
        ),  # from the outermost rope at 30.3
        (physics.head_ropes(ROPES, CAGE, END), (10.5, 30.0, 30.1), 0.48),  # from the row
        (physics.divider(ACROSS), (2.0 / math.sqrt(3.0), -2.5, 0.0), 0.4),  # above its axis
        (physics.divider(ACROSS), (0.0, -3.0, 0.0), 0.9),  # beside it
        # over its edge, along it by any length
        (physics.divider(ACROSS), (1.4 * 3**0.5 / 2 + 50.0, -2.5, -0.7 + 50.0 * 3**0.5), 0.5),
        (physics.divider(Divider(0.2, -3.0)), (0.3, -2.6, 5.0), 0.4),  # round
        (physics.floor(Sump(-20.0)), (3.0, -19.0, 5.0), 1.0),
        (physics.floor(Sump(-20.0)), (3.0, -20.3, 5.0), -0.3),
    ],
)
def test_distance_from_a_body_is_exact(
    body: Body, point: tuple[float, float, float], expected: float
) -> None:
    assert_allclose(distance(point, body), expected, atol=EXACT)


bodies = st.sampled_from(
    [
        physics.lining(RECTANGLE),
        physics.conveyance(CAGE, (0.0, 0.0, 0.0)),
        physics.head_ropes(ROPES, CAGE, (0.0, -5.0, 0.0)),
        physics.divider(ACROSS),
        physics.divider(replace(ACROSS, direction=-2.0, rounding=0.6)),
        physics.floor(Sump(-1.0)),
    ]
)
points = st.tuples(*[st.floats(-6.0, 6.0)] * 3)


@given(
    bodies, points, st.tuples(*[st.floats(0.0, 2.0)] * 3), st.lists(points, min_size=1, max_size=20)
)
def test_no_point_of_a_box_is_nearer_than_its_least_distance(
    body: Body, centre: Any, extent: Any, others: Any
) -> None:
    least = min_distance(centre, extent, body)
    for part in others:  # of the half widths, as sixths
        point = tuple(c + e * p / 6.0 for c, e, p in zip(centre, extent, part, strict=True))
        assert distance(point, body) >= least - EXACT
    assert least <= distance(centre, body) <= least + 2 * math.hypot(*extent) + EXACT


def hanging(
    radius: float, depth: float, elements: int, sideways: float = 0.0
) -> tuple[Array, Array]:
    """Nodes of two straight legs of this depth and half a circle between them, which leans out of plane: q, lengths."""
    total = 2 * depth + math.pi * radius
    s = np.linspace(0.0, total, elements + 1)
    phi = np.clip((s - depth) / radius, 0.0, math.pi)
    q = np.zeros((s.size, 7))
    down = np.minimum(s, depth) - np.maximum(s - depth - math.pi * radius, 0.0)
    q[:, 0] = -radius * np.cos(phi)
    q[:, 1] = -down - radius * np.sin(phi)
    q[:, 3] = np.sin(phi)
    q[:, 4] = -np.cos(phi)
    q[:, 2] = sideways * np.sin(phi)
    return q, np.diff(s)


#: bodies that do not hold the rope
PASSED = Contact(stiffness=0.0)
BEAMS = Divider(0.2, -4.0, 0.3, 0.4, 0.0), Divider(0.1, -10.7, -0.2, -1.0)
AROUND = Lining(6.0, 4.0, 0.3), Conveyance(1.2, 1.0, 3.0, 0.4), HeadRopes(0.03, 0.5)
EVERYTHING = Shaft(*AROUND, *BEAMS, sump=Sump(-14.0), contact=PASSED)


@given(st.integers(12, 60), st.floats(0.5, 1.5), st.floats(-2.0, 2.0), st.integers(0, 100))
@settings(max_examples=50, deadline=None)
def test_clearance_is_the_least_over_the_centre_line(
    elements: int, radius: float, sideways: float, seed: int
) -> None:
    q, lengths = hanging(radius, 10.0, elements, sideways)
    q[1:-1, :3] += 0.1 * np.random.default_rng(seed).normal(size=q[1:-1, :3].shape)
    scene = Scene(Rope(diameter=0.05), shaft=EVERYTHING)
    found = clearances(scene, q, lengths, 7.0)
    s = arc_lengths(lengths)
    lowest = int(np.argmin(q[:, 1]))
    at = np.linspace(0.0, s[-1], 20001)
    line = interpolate(q, s, at).T[:3]
    ends = q[[0, -1], :3].tolist()
    both = (at >= s[lowest], at <= s[lowest])
    cages = [physics.conveyance(EVERYTHING.conveyance, end) for end in ends]
    ropes = [physics.head_ropes(EVERYTHING.head_ropes, EVERYTHING.conveyance, end) for end in ends]
    expected = (
        distance(line, physics.lining(EVERYTHING.lining)).min(),
        min(distance(line[:, leg], cage).min() for leg, cage in zip(both, cages, strict=True)),
        min(distance(line[:, leg], row).min() for leg, row in zip(both, ropes, strict=True)),
        min(
            distance(line, physics.divider(x)).min()
            for x in (EVERYTHING.divider_1, EVERYTHING.divider_2)
        ),
        distance(line, physics.floor(EVERYTHING.sump)).min(),
    )
    # the samples stand at most that far apart
    apart = float(np.linalg.norm(np.diff(line), axis=0).max())
    for nearest, least in zip(found, expected, strict=True):
        assert (
            least - 0.025 - 0.5 * apart <= nearest.clearance <= least - 0.025 + RESOLUTION + EXACT
        )
        assert_allclose(interpolate(q, s, np.array([nearest.s]))[0][1], nearest.y, atol=1e-9)
        assert nearest.time == 7.0


def test_without_bodies_nothing_is_near() -> None:
    found = clearances(Scene(), *hanging(1.0, 10.0, 20), 7.0)
    assert {(x.clearance, x.touched_at) for x in found} == {(1e6, 0.0)}


@pytest.mark.parametrize("turns", [0.0, 0.2, 0.5, -0.5, 1.3, -2.75])
def test_turns_of_a_helix_are_counted(turns: float) -> None:
    """The right leg winds about the left one, and the short left leg's side goes on straight above it."""
    depth = 40.0
    short = 12.0
    y = np.linspace(0.0, depth, 161)
    angle = (
        2 * math.pi * turns * (1.0 - y / depth)
    )  # yaw of the right side as seen from the left one
    right = np.column_stack((np.cos(angle), y, -np.sin(angle)))
    left = np.column_stack((np.zeros(40), np.linspace(short, 0.0, 40), np.zeros(40)))
    q = np.zeros((201, 7))
    q[:40, :3] = left
    q[40:, :3] = right
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(q[:, :3], axis=0), axis=1))))
    yaw = 2 * math.pi * turns
    middle = 0.5 * (q[39, :3] + q[40, :3]) - [0.0, 0.5, 0.0]
    bottom = CLoopBottom(
        0.5 * (s[39] + s[40]), tuple(middle), math.atan2(math.sin(yaw), math.cos(yaw))
    )
    found = loop_turns(q, np.diff(s), bottom)
    assert_allclose(found.number, turns, atol=1e-12)
    assert 0.0 < found.sharpest_y + 0.5 < depth


NOW = [f"clearance.{kind}" for kind in KINDS]
SO_FAR = [f"nearest.{kind}.clearance" for kind in KINDS]
SHORT = Scene(Rope(length=30.0), mesh=Mesh("eem", elements=16), shaft=EVERYTHING)


def test_the_nearest_so_far_is_the_least_of_all_clearances() -> None:
    rope = balance_rope(SHORT, "native")
    steps = followed(rope, going_aside, 25)
    seen = np.array([[*rope.signals(NOW).values(), *rope.signals(SO_FAR).values()] for _ in steps])
    now, so_far = np.hsplit(seen, 2)
    least = np.minimum.accumulate(now, axis=0)
    assert np.all(so_far <= least + RESOLUTION)
    assert np.all(so_far >= least - RESOLUTION)
    times = rope.signals([f"nearest.{kind}.time" for kind in KINDS]).values()
    assert 0.0 in times  # what moves away
    assert 0.0 < max(times) <= 0.25


def test_bodies_do_not_change_the_motion_by_a_bit() -> None:
    with_them, without = (
        wound(balance_rope(scene, "native"), going_aside, 25)
        for scene in (SHORT, SHORT.with_(shaft=Shaft()))
    )
    assert_array_equal(with_them.state.motion.q, without.state.motion.q)


MEETING = Scene(Rope(length=15.0), mesh=Mesh("eem", elements=16))


@pytest.mark.parametrize("stiffness", [0.0, 1e7])
def test_legs_that_have_touched_without_any_yaw_are_told_ever_after(stiffness: float) -> None:
    """They hang from ends that are half a diameter apart, which then part."""
    scene = MEETING.with_(shaft=Shaft(contact=Contact(rope_stiffness=stiffness)))
    near = scene.layout.spacing - 0.5 * scene.rope.diameter

    def parting(t: float) -> Ends:
        return EndMotion(x=near - t**3, vx=-3 * t**2, ax=-6 * t), EndMotion()

    rope = wound(balance_rope(scene), parting, 10, 0.1)
    seen = rope.signals(PASSAGE_SIGNALS | {"loop.yaw", "loop.clearance"})
    assert abs(seen["loop.yaw"]) < 0.1
    assert seen["loop.clearance"] > 0.2
    assert seen["loop.crossings"] == 0
    assert 0.3 * scene.rope.diameter < seen["loop.overlap"] < 0.7 * scene.rope.diameter
    assert seen["loop.touched_at"] == 0.0
    touch = "touched"
    if stiffness:
        touch = "pressed"
    assert f"{touch} each other, first at t = " in rope.warnings()["leg_contact"]
    record = Recording({name: np.array([value]) for name, value in seen.items()}, {})
    assert "its other leg (from t = " in passages(record)


def test_legs_that_pass_through_each_other_without_any_yaw_are_counted() -> None:
    """The left leg bulges beyond the right one, in front of it, then lower down behind it, and is straight again."""
    rope = hung(balance_rope(MEETING.with_(solver=Solver(tolerance=1e6, step_min=1e-12))))
    rest = rope.state
    counted = []
    for k, (x, upper, lower) in enumerate(((3.0, 0.2, 0.2), (3.0, 0.2, -0.2), (0.0, 0.0, 0.0))):
        q = rest.motion.q.copy()
        q[3:5, 0] += x
        q[3:5, 2] = upper, lower
        rope.restore(rope.state._replace(motion=replace(rest.motion, q=q, t=rope.time)))
        # too short for the rope to move
        status = rope.advance_to((k + 1) * 1e-9, EndMotion(), EndMotion())
        assert status.valid, status.message
        counted.append((abs(rope.state.crossing.net), rope.state.crossing.number))
    assert counted == [(0.0, 0.0), (1.0, 1.0), (0.0, 2.0)]
    assert abs(rope.state.loop_yaw) < 0.1


@pytest.mark.parametrize("fidelity", ["planar", "rigid"])
def test_a_rope_whose_right_end_hangs_left_of_its_left_end_has_passed_through_nothing(
    fidelity: Any,
) -> None:
    rope = balance_rope(Scene(Rope(length=15.0, Qb=0.0, Qc=0.0), model=Model(fidelity)))
    seen = hung(rope, EndMotion(x=4.0)).signals(("loop.yaw", "loop.turns", "loop.crossings"))
    assert [*seen.values()] == [math.pi, 0.0, 0.0]


def test_turns_are_the_yaw_but_for_what_passed_through() -> None:
    # it hangs into a divider where the loop of 120 m between ends at 0 and 90 m has its bottom
    shaft = Shaft(divider_3=Divider(0.5, -14.0), contact=PASSED)
    rope = balance_rope(Scene(Rope(installed_twist=12.0), shaft=shaft), "native")
    names = ("loop.yaw", "loop.turns", "loop.crossings", "loop.crossed_at")
    values = hung(rope, right=EndMotion(y=90.0), t=1.5).signals(names)
    assert values["loop.crossings"] == 1.0
    assert values["loop.crossed_at"] == 1.5
    assert_allclose(values["loop.yaw"] / (2 * math.pi) - values["loop.turns"], 1.0, atol=1e-9)


#: m: landings of the ends below
LEAST_ARC = EndMotion(y=0.0), EndMotion(y=90.0)


@pytest.mark.parametrize(
    ("shaft", "told"),
    [
        (
            Shaft(lining=Lining(1.0, 3.0)),
            "an end of the rope lies 0.522 m in the shaft's lining, which is 1 m",
        ),
        (
            Shaft(lining=Lining(3.0, 3.0, z=2.0)),
            "an end of the rope lies 0.522 m in the shaft's lining, which is 3 m",
        ),
        (
            Shaft(lining=Lining(3.0, 0.01)),
            "an end of the rope lies 0.017 m in the shaft's lining, which is 3 m wide",
        ),
        (
            Shaft(sump=Sump(50.0)),
            "an end of the rope hangs 50 m below the sump's floor, sump.level = 50 m",
        ),
        # pressed but for their middle, and not at all
        (Shaft(lining=Lining(2.03, 3.0), sump=Sump(-20.0)), ""),
        (Shaft(lining=Lining(1.0, 3.0), sump=Sump(50.0), contact=Contact(stiffness=0.0)), ""),
        (Shaft(), ""),
    ],
)
def test_a_body_that_leaves_the_ends_no_room_is_named(shaft: Shaft, told: str) -> None:
    scene = rope_120().scene.with_(shaft=shaft)
    assert (
        first_text(NO_ROOM, scene, "torsional", *LEAST_ARC)
        .removeprefix("no equilibrium: ")
        .startswith(told)
    )
    assert bool(first_text(NO_ROOM, scene, "torsional", *LEAST_ARC)) == bool(told)
    assert first_text(NO_ROOM, scene, "rigid", *LEAST_ARC) == ""


@pytest.mark.parametrize("shaft", [Shaft(lining=Lining(1.0, 3.0)), Shaft(sump=Sump(0.1))])
def test_a_rope_without_room_is_refused_before_it_is_hung_up(shaft: Shaft) -> None:
    rope = balance_rope(rope_120().scene.with_(shaft=shaft))
    status = rope.initialize(0.0, *LEAST_ARC)
    assert status.message == first_text(NO_ROOM, rope.scene, "torsional", *LEAST_ARC) != ""


def scene_of(length: float, EI: float, coupling: float, spacing: float, shaft: Shaft) -> Scene:
    rope = Rope(length=length, EI=EI, Qb=coupling, Qc=coupling)
    return Scene(rope, Layout(spacing), model=Model("torsional"), shaft=shaft)


EDGES = Divider(0.13, -6.98, -1.04, rounding=0.3), Divider(0.16, -4.18, 0.958, rounding=0.3)
BARS = Divider(0.236, -6.94, 0.213, rounding=0.3), Divider(0.166, -8.22, -0.817)
#: scenes whose loop strikes dividers, and their trips
STRUCK = {
    "edges and a floor": (
        scene_of(
            19.56,
            92.7,
            -2.336e5,
            1.591,
            Shaft(divider_1=EDGES[0], divider_2=EDGES[1], sump=Sump(-6.72)),
        ),
        Winding(travel=7.29, speed=5.76, acceleration=1.653),
    ),
    "bars": (
        scene_of(22.52, 359.3, 4.67e4, 2.308, Shaft(divider_1=BARS[0], divider_2=BARS[1])),
        Winding(travel=7.01, speed=3.744, acceleration=1.624),
    ),
}


def windings(line: Array, divider: Divider) -> int:
    """Turns about the divider's axis of the rope, closed far above its ends: 1 where it hangs below, 0 beside."""
    top = np.array([[line[0, 0], 1e3], [line[-1, 0], 1e3]])
    closed = np.vstack([top[:1], line[:, :2], top[1:], top[:1]]) - (divider.offset, divider.y)
    angle = np.unwrap(np.arctan2(closed[:, 1], closed[:, 0]))
    return round(float(angle[-1] - angle[0]) / (2.0 * math.pi))


def passes(lines: list[Array], divider: Divider) -> bool:
    """Whether a rope of these shapes, one after the other, comes through a divider."""
    return len({windings(line, divider) for line in lines}) > 1


def depth(line: Array, divider: Divider) -> float:
    """Depth (m) of the rope's straight pieces in a divider, seen along it."""
    start = line[:-1, :2] - (divider.offset, divider.y)
    way = np.diff(line[:, :2], axis=0)
    along = np.clip(-(start * way).sum(-1) / (way * way).sum(-1), 0.0, 1.0)
    return 0.5 * divider.size - float(np.linalg.norm(start + along[:, None] * way, axis=-1).min())


@pytest.mark.parametrize("name", STRUCK)
@pytest.mark.parametrize("stiffness", [1e6, 0.0])
def test_contact_holds_what_would_come_through(name: str, stiffness: float) -> None:
    """By the recorded shapes alone, without the rope's own distances."""
    scene, trip = STRUCK[name]
    scene = scene.with_(shaft=replace(scene.shaft, contact=Contact(stiffness=stiffness)))
    rope = balance_rope(scene)
    reference = s_curve(trip)
    lines = []
    for k in followed(
        rope, partial(ends_at, reference, trip.travel), round((reference.duration + 2.0) / 0.01)
    ):
        if k % 5 == 0:
            q = rope.state.motion.q
            lengths = rope.state.partition.lengths
            lines.append(shape(q, lengths, 0.5 * scene.rope.length, scene.layout.spacing, 161))
    assert "passed_bodies" in rope.warnings()
    dividers = scene.shaft.divider_1, scene.shaft.divider_2
    assert any(passes(lines, one) for one in dividers) == (stiffness == 0.0)
    deepest = max(depth(line, one) for line, one in product(lines, dividers))
    assert (deepest > 0.5 * scene.rope.diameter) == (stiffness == 0.0)
    assert deepest < 0.0 or stiffness == 0.0
    # half a diameter beyond touch
    assert (
        min(line[:, 1].min() for line in lines) > scene.shaft.sump.level - 0.5 * scene.rope.diameter
        or not stiffness
    )
