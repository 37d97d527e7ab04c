"""`balance-rope ropes`: its file, what it leaves, what it refuses."""

import csv
from pathlib import Path

import numpy as np
import pytest
from rope_groups import Weight

import balance_rope
from hoist_demo.cosimulation.participants.breaking_rope import Break, BreakingRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters
from hoist_demo.recording.time_series import read_csv
from hoist_demo.ropes.definition import read_ropes
from hoist_demo.study.reading import StudyError

ROPES = """
[ropes]
case = "rope-120"
level = "draft"

[fixed]
winding.travel = 4
winding.settle = 0.5
model.fidelity = "torsional"
coupling.step = 0.02

[[rope]]
name = "one"
z = -0.2

[[rope]]
name = "two"
z = 0.2
rope.length = 118.8
"""


def test_the_command_leaves_shares_sums_and_neighbours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "ropes.toml"
    path.write_text(ROPES.replace("[[rope]]", "hoist.friction_coefficient = 0.05\n[[rope]]", 1), encoding="utf-8")
    assert balance_rope.main(["ropes", str(path), "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "warning: the head ropes would slip at t = 0 s" in said
    told = [line.split() for line in said.splitlines()]
    assert ["status", "completed"] in told
    # a share has no unit
    assert {line[0]: line[2:] for line in told if line and line[0] in ("share_most", "yaw_peak", "torque_peak")} == {
        "share_most": [],
        "yaw_peak": ["deg"],
        "torque_peak": ["N", "m"],
    }
    with (tmp_path / "ropes.csv").open(encoding="utf-8") as file:
        rows = {row["rope"]: row for row in csv.DictReader(file)}
    # by weight, at rest
    assert float(rows["two"]["share_at_rest [1]"]) == pytest.approx(118.8 / 238.8, rel=1e-6)
    with (tmp_path / "neighbours.csv").open(encoding="utf-8") as file:
        (pair,) = csv.DictReader(file)
    assert 0.0 < float(pair["clearance [m]"]) < 0.4 - 0.044 + 1e-9
    assert (tmp_path / "signals.csv").is_file()


def test_what_a_rope_s_model_does_not_compute_is_no_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, planar = tmp_path / "ropes.toml", 'name = "two"\nmodel.fidelity = "planar"\nbreaks_at = 99\nbreaks_s = 30'
    path.write_text(ROPES.replace('name = "two"', planar), encoding="utf-8")
    assert balance_rope.main(["ropes", str(path), "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "warning: rope two ran as its planar model, which does not compute yaw and all else out of the plane" in said
    assert "rope one ran as" not in said
    assert "warning: rope two was to break at breaks_at = 99 s, and did not: the run ended at " in said
    one, two = said.split(" two, z = 0.2 m ")
    assert ("yaw_peak" in one, "torque_peak" in one) == (True, True)
    # sums of which a part is not computed are no results either, nor is a clearance of what keeps to its plane
    for words in ("yaw_peak", "torque_peak", "tilt about X", "moment about Y", "Smallest clearances"):
        assert words not in two
    assert "tilt about Z" in two
    with (tmp_path / "ropes.csv").open(encoding="utf-8") as file:
        rows = {row["rope"]: row for row in csv.DictReader(file)}
    assert (rows["two"]["yaw_peak [rad]"], rows["two"]["torque_peak [N.m]"]) == ("nan", "nan")
    assert float(rows["one"]["yaw_peak [rad]"]) > 0.01
    with (tmp_path / "neighbours.csv").open(encoding="utf-8") as file:
        assert [row["clearance [m]"] for row in csv.DictReader(file)] == ["nan"]
    signals = read_csv(tmp_path / "signals.csv")
    for name in ("two.loop.yaw", "two.left.my", "left.my", "right.mx", "left.fz"):
        assert np.isnan(signals[name]).all(), name
    for name in ("one.loop.yaw", "one.left.my", "two.left.fy", "left.mz", "left.fy"):
        assert np.isfinite(signals[name]).all(), name


def test_ropes_that_would_touch_where_they_hang_cannot_press_each_other(tmp_path: Path) -> None:
    path, near = tmp_path / "ropes.toml", ROPES.replace("z = 0.2", "z = -0.16")
    path.write_text(near, encoding="utf-8")
    assert not read_ropes(path, rope_parameters()).touching
    path.write_text(near.replace("[fixed]", "[fixed]\ncontact.rope_stiffness = 1e6"), encoding="utf-8")
    with pytest.raises(
        StudyError, match=r"two: an end that is 0\.04 m from that of one must be at least 0\.044 m away"
    ):
        read_ropes(path, rope_parameters())


@pytest.mark.parametrize(
    ("wrong", "right", "told"),
    [
        ('name = "two"', 'name = "one"', "name = 'one' must be given once"),
        ('name = "two"', 'name = "left"', "name = 'left' must be another: .*, and left, right, .*drive.* are taken"),
        (
            'name = "two"',
            'name = "one.b"',
            r"name = 'one\.b' must be of letters from A to z, digits and _, .* at most 40: .*name it anew",
        ),
        ("rope.length = 118.8", "winding.travel = 3", r"two: winding.travel must be the same for all ropes"),
        ("z = 0.2", "breaks_at = 3.0", r"breaks_at and breaks_s must stand together"),
        ("z = 0.2", 'z = "left"', r"two: z = 'left' must be a number"),
        (
            "rope.length = 118.8",
            "contact.rope_stiffness = 1e6",
            r"two: contact.rope_stiffness must be the same for all",
        ),
        (
            '"torsional"',
            '"planar"\ncontact.rope_stiffness = 1e6',
            r"one: model.fidelity = 'planar' must be torsional or spatial with contact.rope_stiffness = 1e\+06, for",
        ),
        ("rope.length = 118.8", "rope.lenght = 118.8", r"did you mean rope.length"),
        ("rope.length = 118.8", "rope.length = -1", r"two: rope"),
        ("rope.length = 118.8", "guard.torque = 5", r"guard.torque = 5 must be left out"),
        ('level = "draft"', 'level = "quick"', r"level = 'quick' must be one of"),
    ],
)
def test_ropes_that_cannot_be_are_refused_with_the_cure(tmp_path: Path, wrong: str, right: str, told: str) -> None:
    path = tmp_path / "ropes.toml"
    assert wrong in ROPES
    path.write_text(ROPES.replace(wrong, right), encoding="utf-8")
    with pytest.raises(StudyError, match=told):
        read_ropes(path, rope_parameters())


def test_a_break_beyond_the_rope_is_refused() -> None:
    with pytest.raises(ValueError, match=r"breaks_s = 130 m must be within 0 and rope.length = 120 m"):
        BreakingRope(Weight({}), 8.0, 120.0, Break(1.0, 130.0))


def test_the_four_ropes_of_the_documents_can_be_wound() -> None:
    path = Path(__file__).parents[1] / "docs" / "duties" / "four_ropes.toml"
    ropes = read_ropes(path, rope_parameters())
    assert [one.name for one in ropes.ropes] == ["sound", "short", "lively", "breaking"]
    assert ropes.hoist.tail_mass == 32.0
