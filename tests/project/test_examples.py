"""The scripts in examples/ and README's code run as they stand; what each shows is checked by a number."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from checkout import ROOT
from documents import EXAMPLES, FMU, README, lines_of, readme_code
from exports import FLAVOURS
from numpy.testing import assert_allclose

from rope_model.compiler import find_compiler


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]) -> Path:
    """A folder with the FMU where the documents have it."""
    if "native-2" not in FLAVOURS:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("examples")
    (folder / "build").mkdir()
    shutil.copyfile(fmu_of("native-2"), folder / FMU)
    return folder


def summary(lines: list[str]) -> dict[str, float]:
    """A run's summary by quantity."""
    found = re.findall(r"^  (.+?)  +(-?[\d.e+-]+)(?: .*)?$", "\n".join(lines), re.M)
    return {quantity: float(value) for quantity, value in found}


def test_every_example_is_listed_and_fits_on_a_page() -> None:
    scripts = {path.name: path.read_text(encoding="utf-8") for path in EXAMPLES.glob("*.py")}
    page = (ROOT / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| \[(\w+\.py)\]", page, re.M)) == {*scripts}
    assert all(20 <= len(text.splitlines()) <= 150 for text in scripts.values())


@pytest.mark.slow
def test_air_in_the_shaft_does_what_the_theory_page_says(tmp_path: Path) -> None:
    _, *rows = lines_of(EXAMPLES / "air_in_the_shaft.py", tmp_path)
    moved = [float(row.split()[-2]) for row in rows]
    # as docs/theory/ends.md rounds them: at rest, passed by conveyances, blown at by a gallery, blown at all along
    assert_allclose(moved, [9e-3, 0.6e-3, 6e-3, 0.20, 0.28, 2.6, 4.0], rtol=0.06)


@pytest.mark.slow
def test_a_swing_tells_friction_between_wires_from_viscous_damping(tmp_path: Path) -> None:
    lines = lines_of(EXAMPLES / "damping_law.py", tmp_path)
    numbers = [float(re.findall(r": ([\d.]+) stand", line)[0]) for line in lines]
    viscous = numbers[::2]
    friction = numbers[1::2]
    assert min(viscous) > 2.0
    assert max(friction) < 1.1


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_released_swivel_ends_stuck_below_its_static_friction(tmp_path: Path) -> None:
    lines = lines_of(EXAMPLES / "swivel_release.py", tmp_path)
    assert any("slips" in line for line in lines)
    assert "holds" in lines[-3]
    assert 0.0 < float(lines[-1].split()[-1]) <= 1.0


@pytest.mark.parametrize(
    ("script", "arguments", "off"),
    [
        # a reel's curvature adds its moment: coupling and the loop's yaw, 4 degrees, turn a part of it away
        pytest.param("reel_set.py", (), 5e-3, marks=pytest.mark.slow),
        # rigid against elastic: the legs' longitudinal waves run 4 m in a millisecond, and the ramp takes 4 s
        ("study.py", (), 1e-3),
        # both forms of the rope, each in steps of its own that meet the same tolerance
        pytest.param("reference_rope.py", (), 1e-3, marks=pytest.mark.slow),
        # at rest the spring has taken up the payload; 12 mm of balance rope more weigh 0.5 N of 4905
        ("iterated_steps.py", (FMU,), 1e-3),
    ],
)
def test_an_example_ends_with_one_times_what_it_compares_with(
    script: str, arguments, off, folder: Path
) -> None:
    assert float(lines_of(EXAMPLES / script, folder, *arguments)[-1].split()[-1]) == pytest.approx(
        1.0, abs=off
    )


def test_readme_s_fmu_code_ends_with_the_weights_of_the_legs(folder: Path, tmp_path: Path) -> None:
    said = lines_of(readme_code("Use the FMU", tmp_path), folder)[-1]
    *_, left, right, yaw = found = [float(x) for x in re.findall(r"-?\d[\d.e-]*", said)]
    # digits that README shows, the rest cut off
    told = re.search(r"`\((8\.0, .*)\)`", README)
    for x, shown in zip(found, told[1].replace("...", "").split(", "), strict=True):
        assert f"{x}".startswith(shown)
    # 10 m up and 10 m down: 25 m and 95 m of 8 kg/m; waves still run
    assert [left, right] == pytest.approx([-25 * 8 * 9.81, -95 * 8 * 9.81], abs=40.0)
    assert abs(yaw) < 0.2


@pytest.mark.slow
def test_a_controller_of_one_s_own_winds_and_ends_below_the_landing(folder: Path) -> None:
    said = summary(lines_of(EXAMPLES / "own_controller.py", folder, FMU))
    assert said["travel reached, left conveyance"] == pytest.approx(90.0, abs=0.2)
    # the law of the example has no position loop; its text says 0.14 m
    assert said["final position error"] == pytest.approx(140.0, abs=5.0)


@pytest.mark.slow
def test_a_hoist_of_one_s_own_winds_with_its_rope_and_leaves_a_table(folder: Path) -> None:
    said = summary(lines_of(EXAMPLES / "own_hoist.py", folder, FMU))
    assert said["travel reached, left conveyance"] == pytest.approx(150.0, abs=0.01)
    recording = pd.read_csv(folder / "build" / "signals.csv")
    # 185 m of 10 kg/m between ends 150 m apart: the right leg is 167.5 m long
    assert recording["right.fy [N]"][0] == pytest.approx(-167.5 * 10.0 * 9.81, rel=0.01)


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_controller_from_a_linear_model_follows_the_trip_closer_than_pi(tmp_path: Path) -> None:
    head, pi, lqg = (
        line.split() for line in lines_of(EXAMPLES / "lqg.py", tmp_path, "as designed")
    )
    k = head.index("tracking_error") - len(head)
    # docs/tutorial/own_controller.md says 15 mm and 31 mm
    assert [float(row[k]) for row in (lqg, pi)] == pytest.approx([0.015, 0.031], abs=1e-3)


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_virtual_sensor_sees_the_rope_s_pull_and_not_its_loop(tmp_path: Path) -> None:
    _, row = lines_of(EXAMPLES / "virtual_sensor.py", tmp_path, "as designed")
    errors = [float(x) for x in row.replace("/", "").split()[2::2]]
    sizes = [float(x) for x in row.replace("/", "").split()[3::2]]
    left, _, loop, _, _ = (error / size for error, size in zip(errors, sizes, strict=True))
    # docs/tutorial/own_controller.md says 0.1 kN of 0.33 kN
    assert left == pytest.approx(0.3, abs=0.03)
    assert loop > 0.9


@pytest.mark.slow
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_an_optimal_trip_is_shorter_than_s_curves_but_arrives_later_than_the_gentle_one(
    tmp_path: Path,
) -> None:
    head, *rows = (line.split() for line in lines_of(EXAMPLES / "optimal_trip.py", tmp_path))
    # columns are counted from the end: the name of a trip may have spaces
    time = head.index("trajectory_time") - len(head)
    cycle = head.index("cycle_time") - len(head)
    times = [float(row[time]) for row in rows]
    cycles = [float(row[cycle]) for row in rows]
    # docs/tutorial/own_controller.md says 22.18 s, and 22.61 s against 22.46 s
    assert times[-1] == pytest.approx(22.18, abs=0.02)
    assert [cycles[-1], cycles[0]] == pytest.approx([22.61, 22.46], abs=0.02)
