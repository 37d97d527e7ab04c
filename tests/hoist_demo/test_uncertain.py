"""Windings over ranges of what is not known of a rope: ``balance-rope uncertain``."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from checkout import EXAMPLES
from numpy.testing import assert_allclose
from rope_files import AT_REST, ROPE, written
from shares import share_of

from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.files.reading import FileError, read
from hoist_demo.files.values import ParameterValue, unreached
from hoist_demo.uncertainty.definition import UncertaintyFile
from hoist_demo.uncertainty.page import remarks, too_few
from hoist_demo.uncertainty.spread import UncertaintyResult, draw, remarks_of, wind_once

pytestmark = pytest.mark.usefixtures("plain_figures")

SCENE = """
[uncertain]
hoist = "rope-120"
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


def test_samples_fill_the_ranges_and_make_the_ropes(tmp_path: Path) -> None:
    asked = read(written(tmp_path, SCENE), UncertaintyFile)
    assert [*asked.data] == ["torque_factor", "bending_stiffness"]
    samples = draw(asked)
    shares = []
    for values in samples:
        shares.append([share_of(asked.data[name], x) for name, x in values.items()])
    # eight points of a Sobol sequence: one in each eighth of each range
    assert_allclose(np.sort(np.floor(8 * np.array(shares)), axis=0), np.arange(8)[:, None] + [0, 0])
    run = asked.run(samples[0])
    rope = rope_scene(run.rope_values).rope
    assert_allclose(rope.Qc, samples[0]["torque_factor"] * 9e7 * 0.044)
    assert rope.length == run.hoist.tail_rope_length == 120.0
    assert rope.mass_per_length == run.hoist.tail_rope_mass == 7.7
    found = {one.name: one.status for one in asked.provenance()}
    wanted = {"rope.Qa": "given", "rope.rhoJ": "derived"}
    assert {key: found[key] for key in (*wanted, "rope.Qc")} == wanted | {"rope.Qc": "varied"}


def test_the_datum_that_causes_a_result_has_its_share(tmp_path: Path) -> None:
    asked = read(written(tmp_path, SCENE.replace("samples = 8", "samples = 256")), UncertaintyFile)
    samples = draw(asked)
    columns = {}
    for name in asked.data:
        columns[name] = np.array([values[name] for values in samples])
    u, v = (np.argsort(np.argsort(columns[name])) / 255 for name in asked.data)
    # of independent ranks the sum with weights 2 and 1 has variances of 4 and 1; a monotone function changes no rank
    columns |= {"left_swivel_torque": np.exp(2 * u + v), "rope_force_ripple": np.full(256, 3.0)}
    causes = UncertaintyResult(asked, columns).causes("left_swivel_torque")
    assert_allclose([*causes.values()], [0.8, 0.2, 0.0], atol=0.03)
    assert UncertaintyResult(asked, columns).causes("rope_force_ripple") == {}
    assert too_few(UncertaintyResult(asked, columns)) == ""


def test_windings_over_the_ranges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, SCENE + TRIP)
    assert main(["uncertain", str(path), "--workers", "1", "--out", str(tmp_path)]) == 0
    assert "caused by torque_factor" in capsys.readouterr().out
    table = pd.read_csv(tmp_path / "windings.csv").rename(
        columns=lambda name: name.partition(" ")[0]
    )
    # held ends carry c1 d times the mean tension, of legs of 15 and 105 m, but for the little that the yaw lets go
    held = table["torque_factor"] * 0.044 * 7.7 * 9.81 * (15**2 + 105**2) / 240
    assert_allclose(table["left_swivel_torque"], held, rtol=0.05)
    assert "bending stiffness" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_rope_that_passed_through_itself_sets_no_range(tmp_path: Path) -> None:
    coupled = SCENE.replace("torsional_stiffness", "torque_factor = 0.12\ntorsional_stiffness")
    asked = read(written(tmp_path, coupled + TRIP + "layout.spacing = 0.4\n"), UncertaintyFile)
    values = {name: datum.middle for name, datum in asked.data.items()}
    found, (told,) = wind_once(asked, values)
    assert np.isnan([*found.values()]).all()
    assert told.startswith("left out: the rope passed through its other leg")


@pytest.mark.parametrize(
    ("reason", "code"),
    [("", 0), ("warning: slack", 0), ("stopped: a cause", 1), ("left out: x", 1)],
)
def test_each_winding_that_does_not_count_decides_the_exit_code(
    tmp_path: Path, reason: str, code: int
) -> None:
    asked = read(written(tmp_path, SCENE), UncertaintyFile)
    reasons = {}
    told = []
    if reason:
        reasons[reason] = 1
        told.append(f"in 1 of 8 windings: {reason}")
    result = UncertaintyResult(asked, {}, reasons)
    assert (result.exit_code, result.completed) == (code, 8 - code)
    assert remarks(result) == told


def test_a_remark_of_many_windings_has_the_range_of_its_numbers() -> None:
    texts = [[f"yawed by {yaw} rad (bound 0.5 rad)"] for yaw in ("9.5e-01", "0.61", "10")]
    assert remarks_of([*texts, [], ["struck"]]) == {
        "yawed by 0.61 to 10 rad (bound 0.5 rad)": 3,
        "struck": 1,
    }


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (("samples = 8", "samples = 100"), "samples = 100 must be a power of two from 8 on"),
        (
            ("samples = 8", 'samples = 8\nbearing = "air"'),
            "bearing = 'air' must be '', 'rolling' or 'plain'",
        ),
        (
            ("samples = 8", 'samples = 8\nbearing = ["plain"]'),
            r"bearing = \['plain'\] must be '', 'rolling'",
        ),
        (("left_swivel_torque", "yaw"), "measures 1 = 'yaw' must be 'cycle_time'"),
        (('"rope-120"', '"rope"'), "hoist = 'rope' must be a file, NAME.toml, or one of rope-120"),
        (("[known]", "[fixed]\nrope.EI = 3\n[known]"), "rope.EI follows from the properties"),
        (('construction = "34x7"', 'from = "nowhere.toml"'), r"nowhere.toml: cannot be read"),
        (
            ("= 7.7", "= 7700.0"),
            r"mass_per_length = 7700 must be within 0\.755 and 77\.6 kg/m, .*: check its unit",
        ),
        (
            ("= 7.7", "= { low = 0.007, high = 7.7 }"),
            r"mass_per_length = .* must be within 0\.755 and 77\.6 kg/m",
        ),
        (("[known]", "[known]\ntorque_factor = 0.01\nbending_stiffness = 180.0"), "nothing varies"),
        (
            ("[known]", "[fixed]\nhoist.tail_rope_mass = 9.0\n[known]"),
            r"\[fixed\] hoist.tail_rope_mass = 9.0 follows from the rope's \[known\] mass_per_length",
        ),
        (
            ("samples = 8", 'samples = 8\nbearing = "rolling"'),
            r"bearing = 'rolling' varies a friction that swivels",
        ),
    ],
)
def test_what_is_wrong_with_ranges_is_told(
    tmp_path: Path, change: tuple[str, str], problem: str
) -> None:
    with pytest.raises(FileError, match=problem):
        read(written(tmp_path, SCENE.replace(*change)), UncertaintyFile)


def test_friction_that_is_given_beside_a_bearing_is_refused(tmp_path: Path) -> None:
    swivels = '[fixed]\nswivels.mode = "coulomb"\n'
    rolling = SCENE.replace("samples = 8", 'samples = 8\nbearing = "rolling"') + swivels
    assert "running_friction" in read(written(tmp_path, rolling), UncertaintyFile).data
    with pytest.raises(
        FileError, match=r"\[fixed\] left.swivel.mu_static = 0.3 follows from \[uncertain\] bearing"
    ):
        read(written(tmp_path, f"{rolling}left.swivel.mu_static = 0.3\n"), UncertaintyFile)


def test_a_given_value_that_a_run_does_not_have_is_named() -> None:
    given = {name: ParameterValue(1.0) for name in ("rope.EI", "air.drag", "hoist.payload_left")}
    told = [*unreached(given, {"rope.EI": 1.0, "air.drag": 2.0})]
    assert len(told) == 2
    assert told[0].startswith(
        "[fixed] air.drag = 1.0 does not reach the rope or the hoist, which has 2.0"
    )
    assert told[1].startswith(
        "[fixed] hoist.payload_left = 1.0 is a value that this command does not take"
    )


@pytest.mark.parametrize("command", ["uncertain", "identify"])
def test_check_hangs_the_rope(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    where = f'{AT_REST}signal = "loop.yaw"\nvalue = 0.1\nsigma = 1.0\n'
    text = {"uncertain": f"{SCENE}[fixed]\n", "identify": f"{ROPE}{where}[fixed]\n"}[command]
    path = str(written(tmp_path, f"{text}layout.spacing = 2.0\n"))
    assert main([command, path, "--check"]) == 0
    path = str(written(tmp_path, f"{text}layout.spacing = 300.0\n"))
    assert main([command, path, "--check"]) == 2
    assert "the rope of 120 m cannot hang between ends 300 m apart" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["rope-120", "kiruna-355"])
def test_the_worked_files_are_right(name: str) -> None:
    asked = read(EXAMPLES / "uncertain" / f"{name}.toml", UncertaintyFile)
    assert len(asked.data) >= 4
