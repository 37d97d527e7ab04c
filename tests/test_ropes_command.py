"""`balance-rope ropes`: its file, what it leaves, what it refuses."""

from __future__ import annotations

import csv
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from rope_groups import Weight

import balance_rope
from hoist_demo.command_line import ropes
from hoist_demo.cosimulation.participants.breaking_rope import Break, BreakingRope
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_parameters
from hoist_demo.cosimulation.participants.rope_plant import RopeStatus
from hoist_demo.recording.fidelity import code_of
from hoist_demo.recording.time_series import Recording, read_csv
from hoist_demo.ropes.definition import read_ropes
from hoist_demo.ropes.table import outcome, without_neglected
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


@pytest.mark.parametrize("part", [0.0, 0.5])
def test_an_interrupted_run_shows_how_far_it_is_and_leaves_what_was_recorded(
    part: float, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = list[float]()

    @contextmanager
    def impatient() -> Iterator[Callable[[float, float], bool]]:
        def advance(fraction: float, t: float) -> bool:
            shown.append(t)
            if fraction >= part:
                os.kill(os.getpid(), signal.SIGINT)
            return True

        yield advance

    monkeypatch.setattr(ropes, "progress_bar", impatient)
    path = tmp_path / "ropes.toml"
    path.write_text(ROPES, encoding="utf-8")
    assert balance_rope.main(["ropes", str(path), "--out", str(tmp_path)]) == 130
    said = capsys.readouterr()
    assert said.err == f"balance-rope: stopped: t = {shown[-1]:.6g} s: stopped by the user\n"
    assert "ropes.csv, neighbours.csv, signals.csv" in said.out
    time = read_csv(tmp_path / "signals.csv").time
    np.testing.assert_allclose(time, [0.0, *shown[:-1]], atol=1e-9)
    with (tmp_path / "ropes.csv").open(encoding="utf-8") as file:
        assert [row["rope"] for row in csv.DictReader(file)] == ["one", "two"]


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


def test_that_a_rope_did_not_break_is_not_said_of_a_run_that_was_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> RopeStatus:
        return RopeStatus(False, "it fails")

    monkeypatch.setattr(InProcessRope, "step", fails)
    path = tmp_path / "ropes.toml"
    path.write_text(ROPES.replace('name = "two"', 'name = "two"\nbreaks_at = 2\nbreaks_s = 30'), encoding="utf-8")
    assert balance_rope.main(["ropes", str(path), "--out", str(tmp_path)]) == 1
    said = capsys.readouterr()
    assert "it fails" in said.err
    assert "was to break" not in said.out


def test_a_plane_rope_without_torque_has_no_yaw_as_a_result() -> None:
    nothing = np.zeros(2)
    signals = {"time": np.arange(2.0), "left.my": nothing + 5.0, "one.left.my": nothing, "one.loop.yaw": nothing}
    signals["one.status.fidelity"] = np.full(2, code_of("planar"))
    recording = Recording(signals, {})
    assert not np.isnan(without_neglected(recording, {"one": True})["one.loop.yaw"]).any()
    masked = without_neglected(recording, {"one": False})
    assert all(np.isnan(masked[name]).all() for name in ("left.my", "one.left.my", "one.loop.yaw"))


def test_the_status_tells_of_each_rope_what_it_struck_and_that_it_passed_through_itself() -> None:
    nothing, later = np.zeros(3), np.array([0.0, 1.0, 1.0])
    broken = np.array([0.0, 1.0, np.nan])
    signals = {
        "time": np.arange(3.0),
        "one.loop.y": nothing,
        "one.loop.crossings": later,
        "one.loop.crossed_at": 7.0 * later,
        "one.loop.crossed_y": -12.0 * later,
        "two.loop.y": broken,
        "two.nearest.divider.clearance": 0.5 - broken,
        "two.nearest.divider.touched_at": 6.0 * broken,
        "two.nearest.divider.y": -13.0 * broken,
        "two.contact.divider": 1e3 * broken,
    }
    assert outcome(True, Recording(signals, {}), ["one", "two"]) == (
        "completed, but rope one passed through its other leg or what hangs above that (t = 7 s, around y = -12 m), "
        "and rope two struck a divider (from t = 6 s on, deepest at y = -13 m); rope two broke by t = 2 s; of its "
        "loop, torques and clearances what was before is told"
    )
    idle = {name: signals[name] for name in ("time", "one.loop.y")} | {"one.loop.crossings": nothing}
    assert outcome(True, Recording(idle, {}), ["one"]) == "completed"


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


def test_contact_that_the_case_has_set_is_named_as_the_case_s(tmp_path: Path) -> None:
    path = tmp_path / "ropes.toml"
    auto = ROPES.replace("rope-120", "slack-rope").replace("torsional", "auto").replace("travel = 4", "travel = 90")
    path.write_text(auto, encoding="utf-8")
    told = r"with contact.rope_stiffness = 1e\+07, of the case slack-rope, for .* or set contact.rope_stiffness = 0 in"
    with pytest.raises(StudyError, match=told):
        read_ropes(path, rope_parameters())
    path.write_text(auto.replace("[fixed]", "[fixed]\ncontact.rope_stiffness = 0"), encoding="utf-8")
    assert not read_ropes(path, rope_parameters()).touching


def test_a_break_beyond_the_rope_is_refused() -> None:
    with pytest.raises(ValueError, match=r"breaks_s = 130 m must be within 0 and rope.length = 120 m"):
        BreakingRope(Weight({}), 8.0, 120.0, Break(1.0, 130.0))


def test_the_four_ropes_of_the_documents_can_be_wound() -> None:
    path = Path(__file__).parents[1] / "docs" / "duties" / "four_ropes.toml"
    ropes = read_ropes(path, rope_parameters())
    assert [one.name for one in ropes.ropes] == ["sound", "short", "lively", "breaking"]
    assert ropes.hoist.tail_mass == 32.0
