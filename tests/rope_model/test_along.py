"""Tension and stresses along the rope: closed forms at rest, balances in motion, and what each fidelity has of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from native_parts import loop_bottom, shape, shape_places
from numpy.testing import assert_allclose
from scenes import fixed_steps, hung, smooth_trip, wound

from rope_model import (
    BalanceRope,
    Layout,
    Mesh,
    Model,
    Rope,
    Scene,
    Stations,
    balance_rope,
)
from rope_model.fidelity.choice import Fidelity
from rope_model.physics.estimates import loop_width, natural_width
from rope_model.physics.node import arc_lengths
from rope_model.signals.signal_table import SHAPE_POINTS

HIGH = 12.0
TRAVEL = 8.0
H = 0.01
#: 30 m rope; its mesh is transformed on the way
SHORT = Scene(
    rope=Rope(length=30.0),
    mesh=Mesh(coarse_length=1.6, counts=(2, 4, 40, 4, 2)),
    solver=fixed_steps(H),
)
UNCOUPLED = SHORT.with_(rope=replace(SHORT.rope, Qb=0.0, Qc=0.0))
SECTION = math.pi * SHORT.rope.diameter**3
BOTTOM = SHAPE_POINTS // 2


def move(scene: Scene, steps: int, fidelity: Fidelity | None = None) -> BalanceRope:
    """A smooth trip of 8 m in 5 s, after so many steps of 10 ms."""
    if fidelity is not None:
        scene = scene.with_(model=Model(fidelity=fidelity))
    return wound(balance_rope(scene), lambda t: smooth_trip(t, TRAVEL, 5.0, HIGH), steps)


def with_stations(wound: BalanceRope, station: Stations) -> BalanceRope:
    """The rope in the state of one that was wound, with other stations."""
    rope = balance_rope(wound.scene.with_(station=station))
    rope.restore(wound.state)
    return rope


def bottom_of(rope: BalanceRope) -> float:
    """Arc length (m) of the lowest point."""
    return float(loop_bottom(rope.state.motion.q, rope.state.partition.lengths).s)


def along(rope: BalanceRope, name: str, points: str = "shape") -> np.ndarray:
    """``shape.tension`` and its like, or those of stations, from the left to the right end."""
    return np.array(
        [*rope.signals(f"{points}.{name}[{i + 1}]" for i in range(SHAPE_POINTS)).values()]
    )


def places(rope: BalanceRope) -> np.ndarray:
    bottom = bottom_of(rope)
    return shape_places(rope.scene.rope.length, bottom, loop_width(rope.scene), SHAPE_POINTS)


def test_free_loop_has_the_bending_stress_and_the_tension_of_its_elastica() -> None:
    rope = UNCOUPLED.rope
    g = 9.81
    width = (rope.EI / (rope.mass_per_length * g)) ** (1 / 3)
    scene = UNCOUPLED.with_(
        layout=Layout(spacing=natural_width(UNCOUPLED)), mesh=Mesh(kind="eem", elements=300)
    )
    still = move(scene, 0)
    # kappa = 1.09661 / width: the root mean square over elements of 0.03 widths errs by 1e-3 at
    # most
    assert_allclose(
        along(still, "bending")[BOTTOM], 32 * rope.EI * 1.09661 / width / SECTION, rtol=2e-3
    )
    # no side force at this width: no tension at the lowest point, of 900 N in the legs; 0.5 % of
    # the width make 0.39 N
    assert abs(along(still, "tension")[BOTTOM]) < 0.3


@pytest.mark.parametrize("width", [1.0, 2.0, 6.0])
def test_tension_at_the_lowest_point_is_the_side_force_at_rest(width: float) -> None:
    still = move(UNCOUPLED.with_(layout=Layout(spacing=width)), 0)
    # the tangent is horizontal to 1e-3 there, and the weight below half an element is 30 N
    assert_allclose(along(still, "tension")[BOTTOM], still.signals()["left.fx"], atol=0.05)


def test_tension_of_a_leg_at_rest_is_that_of_a_hanging_chain() -> None:
    still = move(UNCOUPLED, 0)
    s = places(still)
    ends = still.signals()
    leg = (s > 0) & (s < bottom_of(still) - 4.0)
    expected = np.hypot(-ends["left.fy"] - 9.81 * SHORT.rope.mass_per_length * s, ends["left.fx"])
    # a leg follows its force but for bending, which dies away within sqrt(EI/T) = 0.7 m of the
    # clamp
    far = leg & (s > 3.0)
    assert_allclose(along(still, "tension")[far], expected[far], rtol=2e-3)
    assert np.count_nonzero(far) >= 5


@pytest.mark.parametrize("steps", [0, 130, 260, 480])
def test_tension_summed_up_from_the_left_end_arrives_as_the_reaction_at_the_right(
    steps: int,
) -> None:
    rope = move(SHORT, steps)
    ends = rope.signals()
    # what Newton's method leaves over
    assert_allclose(
        along(rope, "tension")[[0, -1]], [-ends["left.fy"], -ends["right.fy"]], atol=1e-3
    )


@pytest.mark.parametrize(("steps", "off"), [(0, 1e-3), (130, 0.02), (260, 0.02)])
def test_torsion_is_that_of_the_torque_all_along(steps: int, off: float) -> None:
    rope = move(SHORT, steps)
    torque = rope.signals()["right.swivel.torque"]
    assert abs(torque) > 0.4
    # the torque is what the elements' strains and their rates say; the swivel's is the reaction to
    # theta
    assert_allclose(along(rope, "torsion"), 16 * abs(torque) / SECTION, rtol=off)
    assert_allclose(along(rope, "torque", "station"), torque, rtol=off)


@pytest.mark.parametrize("kind", ["bending", "torsion"])
def test_stress_along_the_rope_reaches_its_largest_value_and_is_never_above(kind: str) -> None:
    for steps in (0, 130, 260):
        rope = move(SHORT, steps)
        values = along(rope, kind)
        largest = rope.signals()[f"stress.{kind}_max"]
        assert values.max() <= largest * (1 + 1e-12)
        # between points: the loop's are 0.2 m apart, a tenth of its bend
        assert values.max() > 0.98 * largest


@pytest.mark.parametrize("steps", [100, 250])
def test_rigid_rope_has_the_tension_of_its_ends_and_nearly_that_of_the_flexible_rope(
    steps: int,
) -> None:
    rigid, planar = (move(UNCOUPLED, steps, fidelity) for fidelity in ("rigid", "planar"))
    ends = rigid.signals()
    assert_allclose(
        along(rigid, "tension")[[0, -1]], [-ends["left.fy"], -ends["right.fy"]], rtol=1e-9
    )
    # 5 % of 2 kN: the loop's own motion and its side force, which the rigid rope has not
    assert_allclose(along(rigid, "tension"), along(planar, "tension"), atol=100.0)


@pytest.mark.parametrize(
    "length", [30.0, *(pytest.param(x, marks=pytest.mark.slow) for x in (120.0, 1000.0)), 4000.0]
)
def test_points_show_a_round_loop_however_deep_it_hangs(length: float) -> None:
    scene = UNCOUPLED.with_(
        rope=replace(UNCOUPLED.rope, length=length), mesh=Mesh(), model=Model("planar")
    )
    rope = hung(balance_rope(scene))
    q = rope.state.motion.q
    lengths = rope.state.partition.lengths
    pieces = np.diff(shape(q, lengths, bottom_of(rope), loop_width(scene), SHAPE_POINTS).T[:2])
    corners = np.diff(np.unwrap(np.arctan2(pieces[1], pieces[0])))
    # a circle as wide as the loop turns by 5.7 degrees over a 40th of two widths; where a free loop
    # bends most, and where the pieces have begun to grow, it is up to three times as much
    assert np.max(np.abs(corners)) < math.radians(17.0)
    assert_allclose(np.sum(corners), math.pi, atol=0.1)


def test_stations_stay_in_the_rope_while_the_points_of_its_shape_move() -> None:
    before = move(SHORT, 0)
    after = move(SHORT, 400)
    s = along(after, "s")
    assert_allclose(s, places(after), rtol=1e-12)
    assert abs(s[BOTTOM] - places(before)[BOTTOM]) > 3.0
    # tension is smooth along the rope: stations .4 m apart show that of the points within its
    # change on half of that
    at_stations = np.interp(
        s, np.linspace(0.0, SHORT.rope.length, SHAPE_POINTS), along(after, "tension", "station")
    )
    assert_allclose(
        at_stations, along(after, "tension"), atol=0.5 * 0.375 * 9.81 * SHORT.rope.mass_per_length
    )


def test_a_station_midway_between_nodes_is_on_their_cubic() -> None:
    after = move(SHORT, 400)
    s = arc_lengths(after.state.partition.lengths)[20:22]
    a, b = after.state.motion.q[20:22]
    where = s.mean() / SHORT.rope.length
    found = [along(with_stations(after, Stations(where, where)), axis, "station") for axis in "xyz"]
    middle = 0.5 * (a[:3] + b[:3]) + np.diff(s) / 8 * (a[3:6] - b[3:6])
    assert_allclose(np.transpose(found), np.tile(middle, (SHAPE_POINTS, 1)), atol=1e-12)
