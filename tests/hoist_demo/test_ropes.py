"""Several ropes in one hoist: sums, neighbours, a break; results of ``balance-rope wind``."""

import math
from contextlib import nullcontext
from dataclasses import astuple, replace
from itertools import count, pairwise, product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from rope_groups import CASE, KNOWN, Weight, rope, ropes_in
from shared import Capture

from hoist_demo.command_line import wind
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.breaking_rope import Break, BreakingRope, Piece
from hoist_demo.cosimulation.participants.rope_group import GroupedRope, RopeGroup, WholeRope
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.parameters import GRAVITY, Coupling, hoist_with
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.recording.nearness import polygon_distance
from rope_model import EndMotion, Neighbours

pytestmark = pytest.mark.usefixtures("plain_figures")
HEIGHT = 90.0


def group(*ropes: RopePlant, apart: float = 0.4) -> RopeGroup:
    first = -0.5 * apart * (len(ropes) - 1)
    return RopeGroup(
        [
            GroupedRope(f"rope{k}", one, SuspensionOffset(z=first + (k - 1) * apart))
            for k, one in enumerate(ropes, 1)
        ]
    )


def touching(*ropes: WholeRope, apart: float) -> RopeGroup:
    members = group(*ropes, apart=apart).members
    scenes = [one.whole.scene for one in ropes if one.whole is not None]
    neighbours = Neighbours(scenes, [member.suspension.origin for member in members])
    return RopeGroup(members, neighbours)


def at_height(y: float) -> tuple[EndMotion, EndMotion]:
    return EndMotion(y=y), EndMotion(y=HEIGHT + y)


@pytest.mark.parametrize("contact", [0.0, pytest.param(1e6, marks=pytest.mark.slow)])
def test_unequal_ropes_pull_with_their_weight_and_with_their_mass_times_the_acceleration(
    contact: float,
) -> None:
    given = {"contact_rope_stiffness": contact}
    unequal = (
        rope(**given),
        rope(-KNOWN, rope_length=118.8, **given),
        rope(2.0 * KNOWN, **given),
        rope(-KNOWN, **given),
    )
    if contact:
        # two are enough where they press each other
        ropes = touching(*unequal[:2], apart=0.06)
        mass = 8.0 * (120.0 + 118.8)
    else:
        ropes = group(*unequal)
        mass = 8.0 * (3 * 120.0 + 118.8)
    assert ropes.initialize(0.0, *at_height(0.0)).valid
    read = ropes.reader(["left.fy", "right.fy"])
    means = ropes.reader(["left.fy_mean", "right.fy_mean"])
    # what statics leaves of the balance, solved to 1e-6 N or so
    assert read().sum() == pytest.approx(-mass * GRAVITY, rel=1e-6)
    # both conveyances rise alike: a = A (1 - cos w t) / 2 for one period, so the momentum gained is mass A T / 2
    largest = 1.0
    T = 4.0
    H = 0.02
    w = 2 * math.pi / T
    impulse = 0.0
    for k in range(1, round(T / H) + 1):
        t = k * H
        a = largest * (1 - math.cos(w * t)) / 2
        v = largest * (t - math.sin(w * t) / w) / 2
        y = largest * (t**2 / 2 - (1 - math.cos(w * t)) / w**2) / 2
        ends = (EndMotion(y=y, vy=v, ay=a), EndMotion(y=HEIGHT + y, vy=v, ay=a))
        assert ropes.step(t - H, H, *ends).valid
        impulse -= H * float(means().sum())
    gained = impulse - mass * GRAVITY * T
    # the loop lags the ends by waves that take 0.03 s along a leg
    assert gained == pytest.approx(mass * largest * T / 2, rel=1e-3)
    assert all(account.missed < 2e-4 for account in ropes.accounts().values())
    assert any(account.peak > 1.0 for account in ropes.accounts().values()) == (contact > 0.0)


def test_the_torques_of_a_pair_of_opposite_lays_cancel() -> None:
    pair = group(rope(), rope(-KNOWN))
    hoist = hoist_with(CASE.hoist, [(8.0, 120.0)] * 2)
    winding = replace(CASE.winding, travel=10.0)
    run = Host(pair, hoist, winding, Coupling(step=0.02)).run()
    assert run.completed
    found = run.recording
    for end in ("left", "right"):
        torque = np.abs(found[f"rope1.{end}.swivel.torque"]).max()
        assert torque > 1.0
        assert np.abs(found[f"{end}.my"]).max() < 1e-6 * torque
        assert (
            np.abs(found[f"rope1.{end}.swivel.torque"] + found[f"rope2.{end}.swivel.torque"]).max()
            < 1e-6 * torque
        )
    assert_allclose(found["rope1.loop.yaw"], -found["rope2.loop.yaw"], rtol=0.0, atol=1e-9)


def test_two_equal_ropes_are_one_that_counts_twice() -> None:
    winding = replace(CASE.winding, travel=10.0)
    coupling = Coupling(step=0.02)
    once = Host(rope(), replace(CASE.hoist, tail_rope_number=2), winding, coupling).run().recording
    both = (
        Host(group(rope(), rope()), hoist_with(CASE.hoist, [(8.0, 120.0)] * 2), winding, coupling)
        .run()
        .recording
    )
    assert_allclose(both["left.fy"], 2.0 * once["left.fy"], rtol=1e-9)
    assert_allclose(both["conveyance.right.y"], once["conveyance.right.y"], rtol=0.0, atol=1e-9)


def test_moments_do_the_work_that_the_forces_do_at_the_ropes_ends() -> None:
    names = map(".".join, product(("left", "right"), ("fx", "fy", "fz", "mx", "my", "mz")))
    forces = dict.fromkeys(names, 0.0)
    forces |= {"left.fx": 30.0, "left.fy": -800.0, "left.fz": -20.0, "left.my": 3.0}
    one = Weight(forces)
    ropes = RopeGroup([GroupedRope("a", one, SuspensionOffset(x_left=0.2, z=-0.3))])
    conveyance = EndMotion(y=5.0, vx=0.1, vy=2.0, vz=-0.4, yaw=0.6, yaw_rate=0.7)
    ropes.initialize(0.0, conveyance, EndMotion())
    end, _ = one.ends[-1]
    fx, fy, fz, mx, my, mz = ropes.reader(
        [f"left.{name}" for name in ("fx", "fy", "fz", "mx", "my", "mz")]
    )()
    at_end = 30.0 * end.vx - 800.0 * end.vy - 20.0 * end.vz + 3.0 * end.yaw_rate
    assert fx * 0.1 + fy * 2.0 - fz * 0.4 + my * 0.7 == pytest.approx(at_end, rel=1e-12)
    # tilted about X by the rope's z, about Z by its x
    x = 0.2 * math.cos(0.6) - 0.3 * math.sin(0.6)
    z = -0.3 * math.cos(0.6) - 0.2 * math.sin(0.6)
    assert_allclose([mx, mz], [800.0 * z, -800.0 * x], rtol=1e-12)


def test_a_point_of_a_turning_conveyance_moves_by_the_rates_that_it_is_given() -> None:
    one = Weight({})
    H = 1e-3
    ropes = RopeGroup([GroupedRope("a", one, SuspensionOffset(x_left=0.2, z=-0.3))])

    def conveyance(t: float) -> EndMotion:
        return EndMotion(x=0.1 * t**2, vx=0.2 * t, ax=0.2, yaw=0.5 * t**2, yaw_rate=t)

    ropes.initialize(1.0 - H, conveyance(1.0 - H), EndMotion())
    for k in range(3):
        ropes.step(1.0 + (k - 1) * H, H, conveyance(1.0 + k * H), EndMotion())
    before, now, after = (left for left, _ in one.ends[-3:])
    # differences over 2 H err by H^2 / 6 times a third or fourth derivative, all below 4
    for place, speed, acceleration in (("x", "vx", "ax"), ("z", "vz", "az")):
        moved = getattr(after, place) - getattr(before, place)
        gained = getattr(after, speed) - getattr(before, speed)
        assert getattr(now, speed) == pytest.approx(moved / (2 * H), abs=4 * H**2)
        assert getattr(now, acceleration) == pytest.approx(gained / (2 * H), abs=4 * H**2)


def points_of(polygon: np.ndarray) -> np.ndarray:
    """Return 200 points of each side."""
    return np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(polygon)])


def test_distance_of_random_polygons_is_that_of_their_points_in_the_limit() -> None:
    rng = np.random.default_rng(3)
    for _ in range(6):
        one = rng.normal(size=(5, 3))
        other = rng.normal(size=(6, 3)) + 0.5
        distance, place = polygon_distance(one, other)
        fine = [points_of(one), points_of(other)]
        gaps = np.linalg.norm(fine[0][:, None] - fine[1][None], axis=-1)
        side = max(np.linalg.norm(np.diff(p, axis=0), axis=1).max() for p in (one, other)) / 199
        assert distance <= gaps.min() + 1e-12
        assert gaps.min() <= distance + side
        for p in fine:
            assert np.linalg.norm(p - place, axis=1).min() == pytest.approx(
                0.5 * distance, abs=side
            )


def test_the_ends_of_a_halved_step_lie_on_a_path_between_its_own() -> None:
    h = 0.02
    size = 1e-5
    before = EndMotion(
        x=0.1, y=1.0, z=0.0, vx=0.1, vy=8.0, vz=-0.2, ax=1.0, ay=0.5, az=0.0, yaw=0.1, yaw_rate=0.3
    )
    after = EndMotion(
        x=0.1021,
        y=1.16,
        z=-0.004,
        vx=0.11,
        vy=8.01,
        vz=-0.2,
        ay=0.6,
        az=0.1,
        yaw=0.11,
        yaw_rate=0.6,
    )
    assert_allclose(astuple(before.on_the_way(after, h, 0.0)), astuple(before), atol=1e-12)
    assert_allclose(astuple(before.on_the_way(after, h, h)), astuple(after), atol=1e-9)
    near, at, far = (
        np.array(astuple(before.on_the_way(after, h, 0.4 * h + k * size))) for k in (-1, 0, 1)
    )
    rates = (far - near) / (2.0 * size)
    # rounding over the difference, and its square times a third derivative of some 1e4
    assert_allclose(rates[[*range(6), 9]], at[[*range(3, 9), 10]], atol=1e-5)


def test_a_piece_that_falls_gives_the_conveyance_all_the_momentum_of_its_weight() -> None:
    mass = 8.0
    length = 100.0
    leg = 60.0
    piece = Piece.of(0.0, mass, length, leg, (EndMotion(y=0.0), EndMotion(y=-10.0)))
    # the break begins 20 m below the end and falls 80 m
    T = math.sqrt(2 * 80.0 / GRAVITY)
    t = np.linspace(0.0, T, 20001)[:-1]
    force = np.array([piece.load(float(x), EndMotion(y=0.0)).force for x in t])
    # at rest before and after: the impulse is the weight's; the midpoint rule misses half the last value's step
    impulse = -(force.sum() - 0.5 * force[0] + 0.5 * force[-1]) * T / 20000
    assert impulse == pytest.approx(mass * length * GRAVITY * T, rel=1e-6)
    assert force[0] == pytest.approx(-mass * leg * GRAVITY)
    assert piece.load(T + 0.01, EndMotion(y=0.0)).force == pytest.approx(-mass * length * GRAVITY)


def test_a_hoist_with_a_rope_that_breaks_runs_through() -> None:
    ropes = group(rope(), BreakingRope(rope(), 8.0, 120.0, Break(6.0, 30.0)))
    hoist = hoist_with(replace(CASE.hoist, conveyance_mass=2e4), [(8.0, 120.0)] * 2)
    run = Host(ropes, hoist, replace(CASE.winding, travel=30.0), Coupling(step=0.02)).run()
    assert run.completed, run.cause
    found = run.recording
    assert_array_equal(np.isfinite(found["rope2.loop.yaw"]), found.time < 6.005)
    # what is left of it hangs: 30 m from the left conveyance, which has risen beyond, 90 m from the right one
    weights = {end: found[f"rope2.{end}.fy"][-1] / (-8.0 * GRAVITY) for end in ("left", "right")}
    assert_allclose([weights["left"], weights["right"]], [30.0, 90.0], rtol=2e-3)


def test_a_snapshot_leads_back_to_before_the_break() -> None:
    one = BreakingRope(rope(), 8.0, 120.0, Break(0.015, 30.0))
    one.initialize(0.0, *at_height(0.0))
    read = one.reader(["left.fy", "loop.yaw"])
    one.step(0.0, 0.01, *at_height(0.0))
    kept = one.save()
    before = read()
    one.step(0.01, 0.01, *at_height(0.0))
    one.step(0.02, 0.01, *at_height(0.0))
    assert not np.isfinite(read()[1])
    one.restore(kept)
    assert_array_equal(read(), before)


ROPES = """
name = "Two ropes"
like = "rope-120"
level = "draft"

[hoist]
friction_coefficient = 0.25

[winding]
travel = 4
settle = 0.5

[model]
fidelity = "torsional"

[coupling]
step = 0.02

[[rope]]
name = "one"
z = -0.2

[[rope]]
name = "two"
z = 0.2
length = 118.8
"""


@pytest.mark.usefixtures("plain_figures")
def test_several_ropes_have_the_verdict_and_the_report_of_one(
    tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "ropes.toml"
    path.write_text(
        ROPES.replace("0.25", "0.05", 1).replace("travel = 4", "travel = 1"), encoding="utf-8"
    )
    assert (
        main(["wind", str(path), "--out", str(tmp_path), "--signals", "left.fy", "two.loop.y"]) == 0
    )
    said, told = capsys.readouterr()
    assert "slip safety at rest is 0." in told
    signals = pd.read_csv(tmp_path / "signals.csv")
    assert [*signals] == ["time [s]", "left.fy [N]", "two.loop.y [m]"]
    # the verdict has the sum, with three decimals at most
    (pull,) = [
        line
        for line in said.splitlines()
        if line.startswith("pull of all 2 ropes on the left conveyance")
    ]
    most = float(pull.split(" to ")[1].split()[0])
    assert most == pytest.approx(-1e-3 * signals["left.fy [N]"].min(), abs=5e-3)
    assert [line for line in said.splitlines() if line.startswith("clearance between one and two ")]
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    # by weight, at rest
    share = report.partition("## Balance rope, two")[2].partition(
        "share of the pull of all, at rest | "
    )[2]
    assert float(share.split(" %")[0]) == pytest.approx(100.0 * 118.8 / 238.8, abs=0.05)
    for name in (
        "report.html",
        "one.shapes.csv",
        "two.shapes.csv",
        "two.exposure.csv",
        "loop.png",
        "data.csv",
    ):
        assert (tmp_path / name).is_file(), name


def test_an_fmu_is_refused_with_several_ropes(tmp_path: Path, capsys: Capture) -> None:
    (path := tmp_path / "ropes.toml").write_text(ROPES, encoding="utf-8")
    assert main(["wind", str(path), "--fmu", "rope.fmu"]) == 2
    assert (
        "--fmu rope.fmu is for a hoist with one [[rope]]: leave it out" in capsys.readouterr().err
    )


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_several_ropes_go_on_from_an_interrupt_with_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    # the second has broken before the interrupt at 0.6 s
    text = ROPES.replace('name = "two"', 'name = "two"\nbreaks_at = 0.3\nbreaks_s = 30')
    (path := tmp_path / "ropes.toml").write_text(text, encoding="utf-8")
    command = [
        "wind",
        str(path),
        "--quick",
        "--travel",
        "0.5",
        "--level",
        "draft",
        "--signals",
        "left.fy",
        "one.loop.y",
    ]
    assert main([*command, "--out", str(tmp_path / "whole")]) == 0
    asked = count()
    with monkeypatch.context() as patch:
        patch.setattr(wind, "interruption", lambda *_: nullcontext(lambda: next(asked) >= 59))
        assert main([*command, "--out", str(tmp_path / "parts")]) == 130
    kept = tmp_path / "parts" / "last_good.npz"
    assert f"the same command with --resume {kept} goes on" in capsys.readouterr().err
    assert main([*command, "--out", str(tmp_path / "parts"), "--resume", str(kept)]) == 0
    whole, parts = (pd.read_csv(tmp_path / name / "signals.csv") for name in ("whole", "parts"))
    pd.testing.assert_frame_equal(whole, parts, check_exact=True)


@pytest.mark.usefixtures("no_figures")
def test_what_a_rope_s_model_does_not_compute_is_no_result(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "ropes.toml"
    planar = 'name = "two"\nmodel.fidelity = "planar"\nbreaks_at = 99\nbreaks_s = 30'
    path.write_text(ROPES.replace('name = "two"', planar), encoding="utf-8")
    assert main(["wind", str(path), "--out", str(tmp_path)]) == 0
    said, warned = capsys.readouterr()
    assert (
        "rope two ran as its planar model, which does not compute yaw and all else out of the plane"
        in warned
    )
    assert "rope one ran as" not in warned
    assert "rope two was to break at breaks_at = 99 s, and did not: the run ended at " in warned
    assert "turns of the legs about each other, one" in said
    for words in ("turns of the legs about each other, two", "clearance between one and two"):
        assert words not in said
    # sums of which a part is not computed are no results either
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    moments = report.partition("## All ropes on the left conveyance")[2].partition("##")[0]
    assert [word in moments for word in ("tilt about X", "moment about Y", "tilt about Z")] == [
        False,
        False,
        True,
    ]
    signals = pd.read_csv(tmp_path / "signals.csv").rename(
        columns=lambda name: name.partition(" ")[0]
    )
    for name in ("two.loop.yaw", "two.left.my", "left.my", "right.mx", "left.fz"):
        assert np.isnan(signals[name]).all(), name
    for name in ("one.loop.yaw", "one.left.my", "two.left.fy", "left.mz", "left.fy"):
        assert np.isfinite(signals[name]).all(), name


@pytest.mark.slow
def test_of_a_rope_that_breaks_what_was_before_is_told(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "ropes.toml"
    path.write_text(
        ROPES.replace('name = "two"', 'name = "two"\nbreaks_at = 2.0\nbreaks_s = 30'),
        encoding="utf-8",
    )
    assert main(["wind", str(path), "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "rope two broke by t = 2.02 s; its loop, torques and clearances are those before" in said
    swings = [
        line for line in said.splitlines() if line.startswith("sideways swing of the loop, two")
    ]
    assert [float(line.split("t = ")[1].split()[0]) <= 2.0 for line in swings] == [True]
    # of bodies that are not there nothing is told
    assert "clearance from" not in said
    assert pd.read_csv(tmp_path / "two.shapes.csv")["time [s]"].max() <= 2.0


def test_ropes_that_would_touch_where_they_hang_cannot_press_each_other(tmp_path: Path) -> None:
    path = tmp_path / "ropes.toml"
    near = ROPES.replace("z = 0.2", "z = -0.16")
    path.write_text(near, encoding="utf-8")
    assert not ropes_in(path).touching
    path.write_text(
        near.replace("[model]", "[contact]\nrope_stiffness = 1e6\n[model]"), encoding="utf-8"
    )
    with pytest.raises(
        ValueError, match=r"two: an end that is 0\.04 m from that of one must be at least 0\.044 m"
    ):
        ropes_in(path)


@pytest.mark.parametrize(
    ("wrong", "right", "told"),
    [
        ('name = "two"', 'name = "one"', "name = 'one' must be given once"),
        (
            'name = "two"',
            'name = "left"',
            "name = 'left' must be another: .*, and left, right, .*drive.* are taken",
        ),
        (
            '"torsional"',
            '"planar"\n[contact]\nrope_stiffness = 1e6',
            "one: model.fidelity = 'planar' must be",
        ),
        ("length = 118.8", "guard.torque = 5", r"guard.torque must be left out"),
    ],
)
def test_ropes_that_cannot_be_are_refused_with_the_cure(
    tmp_path: Path, wrong: str, right: str, told: str
) -> None:
    path = tmp_path / "ropes.toml"
    assert wrong in ROPES
    path.write_text(ROPES.replace(wrong, right), encoding="utf-8")
    with pytest.raises(ValueError, match=told):
        ropes_in(path)


def test_a_break_beyond_the_rope_is_refused() -> None:
    with pytest.raises(
        ValueError, match=r"breaks_s = 130 m must be within 0 and rope.length = 120 m"
    ):
        BreakingRope(Weight({}), 8.0, 120.0, Break(1.0, 130.0))
