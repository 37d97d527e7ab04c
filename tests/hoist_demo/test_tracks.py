"""Measured motions: made by the project's own simulator, with noise, in a camera's axes, and identified again."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measured_tracks import Array, camera, example, markers
from numpy.testing import assert_allclose
from scipy.optimize import least_squares
from shares import share_of

from hoist_demo.calibration import tracks
from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.fit import CONFIDENCE
from hoist_demo.calibration.tracks import Markers
from hoist_demo.command_line.main import main
from hoist_demo.files.reading import FileError, read


@pytest.fixture(autouse=True, scope="module")
def smoothed_once() -> Iterator[None]:
    """Equal paths of the ends are smoothed once: half of the time of these tests else."""
    smooth = tracks.make_smoothing_spline
    splines: dict[tuple[bytes, bytes], Any] = {}

    def kept(t: Array, x: Array) -> Any:
        key = (t.tobytes(), x.tobytes())
        if key not in splines:
            splines[key] = smooth(t, x)
        return splines[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tracks, "make_smoothing_spline", kept)
        yield


def track_of(path: Path) -> tuple[Any, Markers]:
    measurement_file = read(path, MeasurementFile)
    markers = measurement_file.measurements[0]
    assert isinstance(markers, Markers)
    return measurement_file, markers


def true_shares(problem: Any) -> Array:
    return np.array([share_of(problem.data[name], camera().TRUTH[name]) for name in problem.names])


def test_the_residuals_of_the_true_rope_are_noise(tmp_path: Path) -> None:
    """In turned axes, mm and Unix time, with offsets, a late camera, lost and swapped markers, and a lost end."""
    track = camera().write(tmp_path, markers(), 3).with_suffix(".csv")
    text = re.sub(r"(\n0\.9[04]?),[^,]*", r"\1,", track.read_text(encoding="utf-8"))
    track.write_text(
        re.sub(r"\n([\d.]+)", lambda t: f"\n{1.7e9 + float(t[1])}", text), encoding="utf-8"
    )
    measured, asked = track_of(track.with_suffix(".toml"))
    assert [*measured.problem.names] == ["torsional_stiffness", "bending_stiffness", "rope.beta_K"]
    residuals = (
        asked.predict(measured.problem.predictor(true_shares(measured.problem))) / asked.sigma
    )
    count = asked.values.size - 13
    # 5 % of the markers are lost, 2 of 4 in 2 % of the frames swapped; a frame with a mask more costs little
    assert 0.88 < count / markers().size < 0.95
    # of a normal error the loss keeps 0.93; 13 of the values found offsets and delay; in three standard errors
    assert_allclose(
        np.square(residuals[:count]).mean(), 0.93, atol=3 * math.sqrt(2 / count) + 13 / count
    )
    assert np.abs(residuals[count:]).max() < 4.0


def test_unlabelled_points_are_off_the_true_rope_by_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(camera(), "OFFSET", 0.0)
    path = camera().write(tmp_path, markers(), 3, **example("track_coverage").KINDS["unlabelled"])
    track = path.with_suffix(".csv")  # which loses one coordinate of one point
    track.write_text(
        re.sub(r"(\n1,(.*?,){6})[^,]*", r"\1", track.read_text(encoding="utf-8")), encoding="utf-8"
    )
    measured, asked = track_of(path)
    residuals = (
        asked.predict(measured.problem.predictor(true_shares(measured.problem))) / asked.sigma
    )
    points = asked.unknowns - 1
    assert residuals.size == 3 * points + 1
    assert 0.93 < 3 * points / markers().size < 0.97
    # two of three components are left; of a normal error the loss keeps 0.93; in three standard errors
    assert_allclose(np.square(residuals).sum() / (2 * points), 0.93, atol=3 / math.sqrt(points))


def test_the_delay_of_the_camera_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The motion of a camera that is late by three frames, which 4 ms of standard error do not expect, shifts back."""
    late = 3 * camera().FRAME
    shifted = np.concatenate((np.repeat(markers()[:1], 3, axis=0), markers()[:-3]))
    for name in ("DELAY", "OFFSET", "GRIPPER"):
        monkeypatch.setattr(camera(), name, 0.0)
    measured, asked = track_of(camera().write(tmp_path, shifted, 3))
    found = (
        asked.delay
        * asked.predict(measured.problem.predictor(true_shares(measured.problem)))[-1]
        / asked.sigma
    )
    # three standard errors of a shift in time, .1 ms each, and the pull towards none
    error = camera().SIGMA / np.linalg.norm(np.gradient(markers(), camera().FRAME, axis=0))
    assert_allclose(found, -late, atol=3 * error + late * (error / asked.delay) ** 2)


@pytest.mark.slow
def test_of_a_hundred_tracks_nine_in_ten_intervals_have_the_truth(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(camera(), "GRIPPER", 0.0)  # intervals know nothing of the grippers' errors
    inside = [
        found
        for found, _ in example("track_coverage").intervals_of_sets(markers(), range(100, 200))
    ]
    # within three standard errors
    assert_allclose(
        np.mean(inside, axis=0), CONFIDENCE, atol=3 * math.sqrt(CONFIDENCE * (1 - CONFIDENCE) / 100)
    )


@pytest.mark.slow
def test_a_cable_is_led_into_the_swing_in_which_a_track_begins(tmp_path: Path) -> None:
    measured, asked = track_of(
        camera().write(tmp_path, markers(), 3, **example("track_coverage").KINDS["moving"])
    )
    predictor = measured.problem.predictor(true_shares(measured.problem))
    middle = np.full(asked.starts, 0.5)
    found = least_squares(
        lambda u: asked.predict(predictor, *u) / asked.sigma, middle, bounds=(0.0, 1.0), max_nfev=8
    )
    assert (
        2 * found.cost / found.fun.size < 1.1
    )  # errors of one sigma, some of which the starts take up
    assert np.square(asked.predict(predictor) / asked.sigma).mean() > 15.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["moving", "unlabelled"])
def test_other_tracks_tell_the_truth(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    monkeypatch.setattr(camera(), "OFFSET", 0.0)
    ((_, errors),) = example("track_coverage").intervals_of_sets(markers(), range(1, 2), kind)
    assert np.abs(errors).max() < 0.03


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("d = 0.8", "left = 0.8", r"places\.left has the name of an end"),
        (
            "length = 1.0",
            "length = 0.3",
            r"swing.csv: largest distance of the ends = 0\.\d+ m must be from 0 to 0\.3 m",
        ),
        (",left.dx,left.dy", ",u,v", r"swing.csv has no column left\.dx"),
        (
            r"(\n0\.[234]\d?),[^,]*",
            r"\1,",
            r"lacks an end or its direction for 0\.32 s after t = 0\.18 s",
        ),
        (
            r"(\n0\.2,(.*?,){18})(.*?,){3}",
            r"\g<1>0,0,0,",
            r"row 12, .*left\.dz = 0, 0, 0 is no direction: give",
        ),
        (
            r"\n0\.2,(.*)(,[^,\n]*){2}",
            r"\n0.2,\1,1e200,1e200",
            r"row 12, .*right\.dz = .*, 1e\+200 is no direction",
        ),
        ('"swing.csv"', '"none.csv"', "none.csv is no table of numbers"),
        ("d = 0.8", "e = 0.8", r"swing.csv has no column e\.x"),
        ("d = 0.8", "d = 1.8", r"places\.d = 1\.8 m must be from 0 to 1 m"),
        ('"clamped"', '"hinged"', 'ends = "hinged" must be "clamped"'),
        ("sigma = 1e-3", "sigma = 1e-3\nskip = 9.0", r"no marker behind skip = 9 s"),
        ("axial_stiffness = 2e3", "axial_stiffness = 0.0", r"axial_stiffness = 0\.0 must be"),
        ("torque_factor = 0.0", "", r"without a construction \[known\] torque_factor"),
    ],
)
def test_what_is_wrong_with_a_track_is_told(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    path = camera().write(tmp_path, markers(), 0)
    for one in (path, path.with_suffix(".csv")):
        one.write_text(re.sub(old, new, one.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(FileError, match=problem):
        read(path, MeasurementFile)


def test_a_track_is_checked_by_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = camera().write(tmp_path, markers(), 0)
    assert main(["identify", str(path), "--check"]) == 0
    assert "the rope hangs where it is measured" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "t;left.x\n0,01;1,5\n",
            "has semicolons between its columns, and '0,01;1,5' may have decimal commas: give",
        ),
        ("t\tleft.x\n0.01\t1.5\n", "has tabs between its columns: give a CSV file with commas"),
        (
            "t,left.x\n0,01,1,5\n",
            "has 4 fields in line 2 and 2 names in line 1, as with decimal commas: give",
        ),
    ],
)
def test_a_table_with_other_separators_is_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "swing.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(f"swing.csv {said}")):
        tracks._require_commas(tmp_path / "swing.csv", "swing.csv")
