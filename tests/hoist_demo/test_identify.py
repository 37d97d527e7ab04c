"""What ``balance-rope identify`` finds of a rope from measurements, and how well it is known."""

import os
import subprocess
import sys
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from checkout import ROOT
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pydantic import TypeAdapter
from rope_files import AT_REST, ROPE, written

from hoist_demo.calibration import measurements
from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.findings import OPEN, Finding, findings_of
from hoist_demo.calibration.fit import (
    CONFIDENCE,
    END_TOLERANCE,
    RANGE_VARIANCE,
    REACH,
    NotComputed,
    fit,
    intervals,
    sensitivities,
)
from hoist_demo.calibration.identify import identify, residuals_of, stacked
from hoist_demo.calibration.problem import CalibrationProblem
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cases.run_values import ParameterValues
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.export import _set_values
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.files.reading import FileError, read
from hoist_demo.files.rope_file import FOLLOWING, RopeFile
from hoist_demo.files.values import statuses, values_of
from rope_model import Rope, Scene, rope

pytestmark = pytest.mark.usefixtures("plain_figures")

WIDTH = '[[measured]]\nwhat = "loop width"\nvalue = 3.05\nsigma = 0.05\n'
TRACK = '[[measured]]\nwhat = "track"\nsignal = "loop.x"\nt = 9.0\nspeed = 8.0\nvalue = 0.1\nsigma = 0.01\n'


def test_a_linear_rope_is_within_its_interval_in_nine_cases_of_ten() -> None:
    rng = np.random.default_rng(5)
    matrix = rng.standard_normal((8, 3)) * [30.0, 60.0, 15.0]
    sets = 100
    hits = np.zeros(3)
    for _ in range(sets):
        truth = 0.2 + 0.6 * rng.random(3)
        values = matrix @ truth + rng.standard_normal(8)
        found = fit(lambda u, values=values: matrix @ u - values, 3)
        hits += np.abs(found.norm_params - truth) <= found.reaches
    # three standard errors of a share of 0.9 in so many sets
    assert_allclose(hits / sets, CONFIDENCE, atol=3 * np.sqrt(CONFIDENCE * (1 - CONFIDENCE) / sets))


def test_the_interval_of_a_linear_rope_is_that_of_its_covariance() -> None:
    rng = np.random.default_rng(8)
    matrix = rng.standard_normal((7, 3)) * [30.0, 60.0, 15.0]
    values = rng.standard_normal(7)

    def residuals(u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(matrix @ (u - 0.5) - values)

    found = fit(residuals, 3)
    expected = found.norm_params + found.reaches * [[-1.0], [1.0]]
    assert_allclose(intervals(residuals, found), np.clip(expected, 0.0, 1.0).T, rtol=1e-9)


def test_the_first_shares_alone_have_the_covariance_that_they_have_among_all() -> None:
    matrix = np.random.default_rng(2).standard_normal((9, 4)) * [30.0, 60.0, 25.0, 40.0]
    found = fit(lambda u: matrix @ (u - 0.4), 4)
    assert_allclose(found.of_first_params(2).covariance, found.covariance[:2, :2], rtol=1e-9)


def test_the_interval_of_a_bent_rope_is_where_the_squares_have_grown() -> None:
    # the first is measured by a cube of itself and, worse, by its sum with the second: seen along the first alone,
    # the squares that the second cannot lower are those of the cube
    found = fit(
        residuals := lambda u: np.array([8.0 * (u[0] ** 3 - 0.3), 5.0 * (u[0] + u[1] - 1.1)]), 2
    )
    low, high = intervals(residuals, found)[0]
    assert_allclose(
        [low, high], np.cbrt(0.3 + REACH / 8.0 * np.array([-1.0, 1.0])), rtol=END_TOLERANCE
    )
    assert found.norm_params[0] - low > 1.2 * (high - found.norm_params[0])


def test_a_direction_without_data_keeps_its_range_and_its_middle() -> None:
    # of u and v only the sum is measured
    found = fit(lambda u: 50.0 * u[:1] + 50.0 * u[1:] - 60.0, 2)
    assert_allclose(np.abs(found.undetermined_directions()), [[np.sqrt(0.5), np.sqrt(0.5)]])
    assert_allclose(found.norm_params, [0.6, 0.6], atol=1e-4)
    assert_allclose(np.diag(found.covariance), 0.5 * (RANGE_VARIANCE + 1 / (2 * 50.0**2)))
    assert found.correlations[0, 1] < -0.9


@pytest.mark.parametrize("best", [0.55, 0.9])
def test_a_search_turns_back_where_a_rope_cannot_be_computed(best: float) -> None:
    def residuals(u: NDArray[np.float64]) -> NDArray[np.float64]:
        if u[0] > 0.6:
            raise NotComputed("cannot hang")
        return np.array([9.0 * (u[0] - best), 3.0 * (u[0] + u[1] - 1.0)])

    found = fit(residuals, 2)
    assert_allclose(found.norm_params[0], min(best, 0.6), atol=0.01)
    low, high = intervals(residuals, found)[0]
    assert low < found.norm_params[0] <= high <= 0.6 + 0.01


def test_a_search_ends_at_an_error_that_is_none_of_the_rope() -> None:
    def residuals(u: NDArray[np.float64]) -> NDArray[np.float64]:
        if u[0] > 0.6:
            raise RuntimeError("a mistake in the code")
        return np.array([9.0 * (u[0] - 0.9)])

    with pytest.raises(RuntimeError, match="a mistake in the code"):
        fit(residuals, 1)


def test_a_rope_without_a_neighbour_is_refused() -> None:
    with pytest.raises(RuntimeError, match="narrow the ranges"):
        sensitivities(lambda u: np.full(2, 0.0 if u[0] == 0.5 else np.inf), np.array([0.5]))


def test_a_rope_that_is_measured_without_errors_is_found_again() -> None:
    problem = CalibrationProblem(rope("34x7", diameter=0.046, length=120.0), Scene())
    plan = [
        measurements.Mass(value=1.0, sigma=0.01),
        measurements.LoopWidth(value=1.0, sigma=0.01),
        measurements.SampleTorque(value=[0.0] * 2, sigma=0.1, load=1e4, twist=[0.0, 0.05]),
        measurements.SampleExtension(value=1.0, sigma=1e-5, load=5e4, length=10.0),
        measurements.AtRest(value=0.0, sigma=0.01, left_y=0.0, right_y=0.0, signal="loop.yaw"),
    ]
    truth = np.array([0.3, 0.6, 0.7, 0.55, 0.4])
    _, sigmas = stacked(plan)
    found = fit(residuals_of(problem, plan, problem.predict(truth, plan), sigmas), truth.size)
    # what Newton's method leaves of the yaw, 1e-5 rad, is 1e-3 of its sigma
    assert_allclose(found.norm_params, truth, atol=1e-3)


def test_what_a_swing_sweeps_is_that_of_its_track() -> None:
    problem = CalibrationProblem(rope("34x7", diameter=0.046, length=30.0), Scene())
    where: Any = {
        "left_y": 0.0,
        "right_y": 4.0,
        "travel": 4.0,
        "speed": 2.0,
        "signal": "loop.x",
        "sigma": 1.0,
    }
    times = tuple(np.linspace(3.0, 5.0, 21))
    plan = [measurements.Track(value=[0.0] * 21, t=times, **where)]
    plan.append(measurements.Swept(value=0.0, t=3.0, until=5.0, **where))
    *places, swept = problem.predict(np.full(5, 0.5), plan)
    assert swept > 0.05
    assert_allclose(swept, np.ptp(places))


def test_what_a_width_alone_does_not_tell_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = identify(read(written(tmp_path, ROPE + WIDTH), MeasurementFile))
    assert [name for name in found.names if found.is_determined(name)] == ["bending_stiffness"]
    assert {"torque_factor", "torsional_stiffness", "axial_stiffness"} <= {*found.open_directions()}
    width = 3.05
    error = 0.05
    EI = found.value("bending_stiffness")
    datum = found.calibrated_rope.data["bending_stiffness"]
    # EI ~ width^3
    assert_allclose(np.log(datum.high / EI), 3 * 1.645 * error / width, rtol=0.05)
    catalogue_rope = found.measurement_file.problem.catalogue_rope
    assert found.calibrated_rope.data["torque_factor"] == catalogue_rope.data["torque_factor"]
    assert found.candidates[0].error <= found.wanted_error
    # two directions of the same pair, as near-equal lacks of knowledge have them
    monkeypatch.setattr(
        type(found.fit),
        "undetermined_directions",
        lambda _: np.array([[0.8, 0.6, 0, 0, 0], [0.6, -0.8, 0, 0, 0]]),
    )
    assert found.open_directions() == ["mass_per_length and axial_stiffness"]


def test_what_is_found_is_a_file_for_every_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identify", str(written(tmp_path, ROPE + WIDTH)), "--out", str(tmp_path)]) == 0
    assert "Undetermined by the data" in capsys.readouterr().out
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    made = tmp_path / "rope.toml"
    assert "loop width" in report
    assert "<script" not in report

    found = read(made, RopeFile).values()
    values = values_of(found)
    assert values.keys() == {f"rope.{name}" for name in FOLLOWING}
    given = TypeAdapter(ParameterValues).validate_python({"from": str(made), "rope": {"EI": 99.0}})
    assert values_of(given) == values | {"rope.EI": 99.0}
    wanted = {"rope.EI": "calibrated", "rope.mass_per_length": "published", "rope.length": "given"}
    assert wanted.items() <= statuses(found).items()
    options = Namespace(rope=made, set=[], hoist="rope-120", ssp=False)
    exported = case_with_values(find_case("rope-120"), _set_values(find_case("rope-120"), options))
    assert values.items() <= exported.rope.items()
    assert exported.hoist.tail_rope_mass == values["rope.mass_per_length"]
    again = read(made, RopeFile).catalogue_rope
    assert again.data["bending_stiffness"].status == "calibrated"
    assert again.data["mass_per_length"].status == "published"
    assert isinstance(rope_scene(values).rope, Rope)


def test_measurements_that_contradict_each_other_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = written(tmp_path, ROPE + WIDTH + WIDTH.replace("3.05", "3.8"))
    assert main(["identify", str(source), "--out", str(tmp_path)]) == 1
    told = capsys.readouterr()
    assert "the measurements contradict the model or one another" in told.err
    assert "contradicted: " in told.out
    made = tmp_path / "rope.toml"
    assert "# the measurements contradict the model" in made.read_text(encoding="utf-8")
    bending = read(made, RopeFile).catalogue_rope.data["bending_stiffness"]
    assert bending.status == "contradicted"
    # no interval follows from them: the range of before stands
    before = rope("34x7", diameter=0.046).data["bending_stiffness"]
    assert_allclose([bending.low, bending.high], [before.low, before.high], rtol=1e-5)


MASS = '[[measured]]\nwhat = "mass"\nvalue = 8.368\nsigma = 0.02\n'
PULL = f'{AT_REST}signal = "left.fy"\nvalue = 3000.0\nsigma = 20.0\n'
STRETCH = '[[measured]]\nwhat = "sample extension"\nload = 50e3\nlength = 10.0\nvalue = 5.29e-2\nsigma = 1e-4\n'
HEAVY = MASS.replace("8.368", "18.45")


@pytest.mark.parametrize(
    ("measured", "compromises"),
    [
        (HEAVY, {"mass_per_length"}),
        # the rope hangs, whatever it is like: a force upwards has the wrong sign
        (PULL, {"mass_per_length"}),
        (
            HEAVY + WIDTH.replace("3.05", "30.0") + STRETCH,
            {"mass_per_length", "bending_stiffness", "axial_stiffness"},
        ),
    ],
    ids=[
        "a mass outside of its range",
        "a force with the wrong sign",
        "one value for each property",
    ],
)
def test_a_measurement_that_no_rope_of_the_ranges_meets_calibrates_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], measured: str, compromises: set[str]
) -> None:
    source = written(tmp_path, ROPE + measured)
    assert main(["identify", str(source), "--out", str(tmp_path)]) == 1
    told = capsys.readouterr()
    assert "the measurements contradict the model or one another" in told.err
    for name in compromises:
        assert f"{name} = " in told.err
    assert "end of its range, and the measurements ask for" in told.err
    assert "calibrated" not in told.out
    made = tmp_path / "rope.toml"
    assert "calibrated" not in made.read_text(encoding="utf-8")
    statuses_found = {
        name: datum.status for name, datum in read(made, RopeFile).catalogue_rope.data.items()
    }
    assert compromises <= {
        name for name, status in statuses_found.items() if status == "contradicted"
    }


def test_a_value_at_an_end_of_its_range_is_named_and_keeps_the_range(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # 8.49 kg/m is a quarter of a sigma beyond the catalogue's 8.485: no contradiction
    source = written(tmp_path, ROPE + MASS.replace("8.368", "8.49") + WIDTH)
    assert main(["identify", str(source), "--out", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert (
        "mass_per_length = 8.4852 kg/m is the upper end of its range, and the measurements ask for more"
        in told.err
    )
    assert "widen the range of mass_per_length in [known]" in told.err
    data = read(tmp_path / "rope.toml", RopeFile).catalogue_rope.data
    before = rope("34x7", diameter=0.046).data["mass_per_length"]
    assert data["mass_per_length"].status == before.status
    assert_allclose(
        [data["mass_per_length"].low, data["mass_per_length"].high],
        [before.low, before.high],
        rtol=1e-5,
    )
    assert data["bending_stiffness"].status == "calibrated"


def test_a_share_held_at_its_end_is_no_degree_of_freedom() -> None:
    # two shares and three values: the first asks for 3, beyond its range; the second is found of the two others
    values = np.array([3.0, 0.4, 0.4 + 2 / 50.0])
    matrix = np.array([[50.0, 0.0], [0.0, 50.0], [0.0, 50.0]])
    found = fit(residuals := lambda u: matrix @ u - 50.0 * values, 2)
    assert found.held.tolist() == [1, 0]
    assert_allclose(found.norm_params, [1.0, 0.42], atol=1e-6)
    # two degrees of freedom: exp(-chi^2 / 2)
    chi2 = (50.0 * 2.0) ** 2 + 2 * 1.0**2
    assert_allclose(found.p_value, np.exp(-0.5 * chi2), rtol=1e-3, atol=1e-300)
    assert_allclose(intervals(residuals, found)[0], [0.0, 1.0])
    assert_allclose(
        intervals(residuals, found)[1],
        0.42 + REACH / np.hypot(50.0, 50.0) * np.array([-1, 1]),
        rtol=1e-6,
    )
    # a share whose best value is within its range is free, however near to its end
    assert fit(lambda u: np.array([50.0 * (u[0] - 0.9999)]), 1).held.tolist() == [0]


def test_a_profile_lets_a_share_at_its_end_come_back() -> None:
    # only the sum is told well, and it asks for the second share beyond its range: where the first grows, the second
    # leaves its end, so that the first is uncertain by what the second may give way
    matrix = np.array([[60.0, 60.0], [0.0, 4.0]])
    values = np.array([60.0 * 1.5, 4.0 * 1.1])
    found = fit(residuals := lambda u: matrix @ u - values, 2)
    assert found.held.tolist() == [0, 1]
    low, high = intervals(residuals, found)[0]
    assert_allclose(found.norm_params[0] - low, REACH / 60.0, rtol=0.05)
    least = float(np.sum(np.square(residuals(found.norm_params))))
    grown = [
        float(np.sum(np.square(residuals(np.array([high, v])))))
        for v in np.linspace(0.0, 1.0, 2001)
    ]
    assert_allclose(np.sqrt(min(grown) - least), REACH, rtol=2 * END_TOLERANCE)


def test_an_interval_as_wide_as_the_range_is_not_called_calibrated() -> None:
    # steep where it is found, but the squares never grow by REACH^2: the interval decides, not the linear reach
    def residuals(u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array([1.6 * np.tanh(20.0 * (u[0] - 0.5))])

    found = fit(residuals, 1)
    ends = intervals(residuals, found)
    assert found.reaches[0] < OPEN
    assert_allclose(ends, [[0.0, 1.0]])
    assert findings_of(found, ends) == [Finding.UNDETERMINED]


def test_a_trip_is_wound_once_for_all_that_is_measured_in_it(tmp_path: Path) -> None:
    short = ROPE.replace("120.0", "30.0") + "[known]\n"
    short += "mass_per_length = 8.37\naxial_stiffness = 9e7\ntorque_factor = 0.01\ntorsional_stiffness = 900.0\n"
    where = "t = [1.0, 1.5]\nleft_y = 0.0\nright_y = 8.0\ntravel = 2.0\nspeed = 4.0\n"
    signals = {"loop.x": (0.0, 0.01), "loop.yaw": (0.0, 0.01), "left.fy": (-1000.0, 1e4)}
    for name, (value, sigma) in signals.items():
        short += f'[[measured]]\nwhat = "track"\nsignal = "{name}"\nvalue = {[value] * 2}\nsigma = {sigma}\n{where}'
    short += (
        '[[measured]]\nwhat = "swept"\nsignal = "loop.y"\nvalue = 2.0\nsigma = 9.0\nuntil = 1.5\n'
    )
    short += where.replace("[1.0, 1.5]", "0.5")
    file = read(written(tmp_path, short), MeasurementFile)
    windings = list[int]()
    identify(file, windings.append)
    assert len(windings) > 2  # one unknown: some ropes are tried
    assert set(windings) == {1}
    # another trip is another winding
    predictor = file.problem.predictor(np.full(1, 0.5))
    other = read(
        written(tmp_path, short.replace("travel = 2.0", "travel = 1.0", 1)), MeasurementFile
    )
    file.problem.predict(np.full(1, 0.5), other.measurements, predictor)
    assert predictor.windings == 2


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (ROPE.replace("34x7", "7x7") + WIDTH, "construction = '7x7' is out of range"),
        (ROPE, r"measured is missing: give it"),
        (
            ROPE + WIDTH.replace("loop width", "colour"),
            "what = 'colour' must be one of 'loop width', 'mass'",
        ),
        (ROPE + WIDTH.replace("0.05", "0"), "sigma = 0 must be greater than 0"),
        (
            ROPE + "[known]\nbending_stiffness = { low = 3.0, high = 2.0 }\n" + WIDTH,
            "low = 3 must be at most",
        ),
        (
            ROPE + "[fixed]\nrope.EI = 3.0\n" + WIDTH,
            r"rope.EI follows from the properties: give \[known\]",
        ),
        (
            ROPE
            + '[[measured]]\nwhat = "sample torque"\nload = [1, 2, 3]\nvalue = [1, 2]\nsigma = 1\n',
            "load has 3",
        ),
        (
            ROPE + WIDTH + "[sought]\nair.drag = 1.0\n",
            "air.drag = 1.0 must be { low, high }, in order",
        ),
        (
            ROPE + TRACK + "travel = 90.0\nleft_y = 0.0\nright_y = 130.0\n",
            "must be less than .* = 120 m apart",
        ),
        (ROPE + WIDTH + "[want]\n", r"want = {} is not a key"),
        (
            ROPE + WIDTH + '[fixed]\nmodel.fidelity = "planar"\n',
            r"\[fixed\] model.fidelity = 3 must be .torsional.",
        ),
        (
            ROPE
            + WIDTH
            + "[fixed]\nair.drag = 1.0\n[sought]\nair.drag = { low = 0.5, high = 2.0 }\n",
            r"\[fixed\] air.drag = 1.0 is also in \[sought\]",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_told(tmp_path: Path, text: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read(written(tmp_path, text), MeasurementFile)


@pytest.mark.parametrize(
    "both",
    [pytest.param(False, marks=pytest.mark.slow), True],
    ids=["output", "output and messages"],
)
def test_a_reader_that_leaves_changes_no_exit_code(tmp_path: Path, both: bool) -> None:
    source = written(tmp_path, ROPE + HEAVY)
    command = [
        sys.executable,
        "-m",
        "hoist_demo",
        "identify",
        str(source),
        "--out",
        str(tmp_path / "found"),
    ]
    root = str(ROOT)
    receiver, sender = os.pipe()
    os.close(receiver)  # the reader is gone before the first line
    with os.fdopen(sender, "wb") as out:
        messages: Any = subprocess.PIPE
        if both:
            messages = out
        done = subprocess.run(
            command, stdout=out, stderr=messages, env=os.environ | {"PYTHONPATH": root}, check=False
        )
    assert done.returncode == 1
    assert both or b"warning: the measurements contradict the model" in done.stderr
    assert (tmp_path / "found" / "report.html").is_file()
