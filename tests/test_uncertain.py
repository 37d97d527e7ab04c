"""`balance-rope uncertain`: windings over ranges, and the datum that causes the spread."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from balance_rope import main
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, rope_parameters
from hoist_demo.recording.time_series import read_csv
from hoist_demo.study.reading import StudyError
from hoist_demo.uncertainty.definition import read_uncertain
from hoist_demo.uncertainty.page import too_few
from hoist_demo.uncertainty.spread import Spread, draw

SCENE = """
[uncertain]
case = "rope-120"
level = "draft"
samples = 8
measures = ["left_swivel_torque", "rope_force_ripple"]
[rope]
construction = "34x7"
diameter = 0.044
[known]
mass_per_length = 7.7
axial_stiffness = 9e7
torsional_stiffness = 40.0
"""
TRIP = "[fixed]\nwinding.travel = 1.0\nwinding.settle = 1.0\n"
PARAMETERS = rope_parameters()


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_samples_fill_the_ranges_and_make_the_ropes(tmp_path: Path) -> None:
    asked = read_uncertain(written(tmp_path, SCENE), PARAMETERS)
    assert [*asked.data] == ["torque_factor", "bending_stiffness"]
    samples = draw(asked)
    shares = np.array([[asked.data[name].share(x) for name, x in values.items()] for values in samples])
    # eight points of a Sobol sequence: one in each eighth of each range
    assert_allclose(np.sort(np.floor(8 * shares), axis=0), np.arange(8)[:, None] + [0, 0])
    run = asked.run(samples[0])
    rope = rope_data(run.fmu).rope
    assert_allclose(rope.Qc, samples[0]["torque_factor"] * 9e7 * 0.044)
    assert rope.length == run.hoist.tail_rope_length == 120.0
    assert rope.mass_per_length == run.hoist.tail_rope_mass == 7.7


def test_the_datum_that_causes_a_result_has_its_share(tmp_path: Path) -> None:
    asked = read_uncertain(written(tmp_path, SCENE.replace("samples = 8", "samples = 256")), PARAMETERS)
    samples = draw(asked)
    columns = {name: np.array([values[name] for values in samples]) for name in asked.data}
    u, v = (np.argsort(np.argsort(columns[name])) / 255 for name in asked.data)
    # of independent ranks the sum with weights 2 and 1 has variances of 4 and 1; a monotone function changes no rank
    columns |= {"left_swivel_torque": np.exp(2 * u + v), "rope_force_ripple": np.full(256, 3.0)}
    causes = Spread(asked, columns).causes("left_swivel_torque")
    assert_allclose([*causes.values()], [0.8, 0.2, 0.0], atol=0.03)
    assert Spread(asked, columns).causes("rope_force_ripple") == {}
    assert too_few(Spread(asked, columns)) == ""


def test_windings_over_the_ranges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, SCENE + TRIP)
    assert main(["uncertain", str(path), "--workers", "1", "--out", str(tmp_path)]) == 0
    assert "caused by torque_factor" in capsys.readouterr().out
    table = read_csv(tmp_path / "windings.csv")
    # held ends carry c1 d times the mean tension, of legs of 15 and 105 m, but for the little that the yaw lets go
    held = table["torque_factor"] * 0.044 * 7.7 * 9.81 * (15**2 + 105**2) / 240
    assert_allclose(table["left_swivel_torque"], held, rtol=0.05)
    assert "bending stiffness" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (("samples = 8", "samples = 100"), "samples = 100 must be a power of two from 8 on"),
        (("samples = 8", 'samples = 8\nbearing = "air"'), "bearing = 'air' must be one of rolling, plain"),
        (("samples = 8", 'samples = 8\nbearing = ["plain"]'), r"bearing = \['plain'\] must be one of rolling, plain"),
        (("left_swivel_torque", "yaw"), "'yaw' is not a metric: choose of cycle_time"),
        (('"rope-120"', '"rope"'), "case = 'rope' must be one of rope-120"),
        (('"34x7"', '"7"'), "construction = '7' is out of range"),
        (("[known]", "[fixed]\nrope.EI = 3\n[known]"), "rope.EI follows from the properties"),
        (('construction = "34x7"', 'from = "nowhere.toml"'), r"nowhere.toml: cannot be read"),
        (("= 7.7", "= 7700.0"), r"mass_per_length = 7700\.0 must be within 0\.755 and 77\.6 kg/m, .*: check its unit"),
        (("= 7.7", "= { low = 0.007, high = 7.7 }"), r"mass_per_length = .* must be within 0\.755 and 77\.6 kg/m"),
        (("[known]", "[known]\ntorque_factor = 0.01\nbending_stiffness = 180.0"), "nothing varies"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path: Path, change: tuple[str, str], problem: str) -> None:
    with pytest.raises(StudyError, match=problem):
        read_uncertain(written(tmp_path, SCENE.replace(*change)), PARAMETERS)


@pytest.mark.parametrize("name", ["rope-120", "kiruna-355"])
def test_the_worked_files_are_right(name: str) -> None:
    asked = read_uncertain(Path(__file__).parents[1] / "docs" / "uncertain" / f"{name}.toml", PARAMETERS)
    assert len(asked.data) >= 4
