"""The loop winds to the millimetre, keeps time exactly, stops cleanly and writes the same bytes twice."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hoist_demo.control.controller import Command
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.rope_plant import EndMotion, Reader, RopePlant, RopeStatus
from hoist_demo.cosimulation.result import Result
from hoist_demo.drive.plant import HoistPlant, PlantInput
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.components import Brake
from hoist_demo.recording.time_series import TIME, Recorder, Recording, read_csv, shape_rows, write_csv, write_shapes
from hoist_demo.report.figures import write_figures
from hoist_demo.report.markdown import write_report
from hoist_demo.report.rows import render
from hoist_demo.report.summary import summarize

RHO, G, LENGTH = 8.0, 9.81, 120.0


@dataclass
class FakeRope:
    """Two legs that weigh what they are long; fails or turns NaN at a given time."""

    fails_at: float = math.inf
    nan_at: float = math.inf
    shows_shape: bool = False
    times: list[tuple[float, float]] = field(default_factory=list)
    closed: bool = False
    forces: dict[str, float] = field(default_factory=dict)

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        self._hang(left, right)
        return RopeStatus(t0 < self.fails_at, "no hanging shape")

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> RopeStatus:
        self.times.append((t, h))
        self._hang(left, right)
        if t >= self.nan_at:
            self.forces["left.fy_mean"] = math.nan
        return RopeStatus(t < self.fails_at, "the loop has turned over")

    def signals(self) -> dict[str, float]:
        return dict(self.forces)

    def reader(self, names: Sequence[str]) -> Reader:
        return lambda: np.array([self.forces.get(name, math.nan) for name in names])

    def save(self) -> None:
        return None

    def restore(self, snapshot: object) -> None:
        raise AssertionError("a rope that cannot save is not restored")

    def free(self, snapshot: object) -> None:
        assert snapshot is None

    def units(self) -> dict[str, str]:
        return dict.fromkeys(("left.fy", "right.fy", "left.fy_mean", "right.fy_mean"), "N") | {"loop.y": "m"}

    def close(self) -> None:
        self.closed = True

    def _hang(self, left: EndMotion, right: EndMotion) -> None:
        bottom = (left.y + right.y - LENGTH) / 2.0
        for name, end in (("left", left), ("right", right)):
            self.forces[f"{name}.fy"] = self.forces[f"{name}.fy_mean"] = -RHO * G * (end.y - bottom)
        self.forces["loop.y"] = bottom
        if self.shows_shape:
            for k, (x, y) in enumerate(((-1.0, left.y), (0.0, bottom), (1.0, right.y))):
                point = {f"shape.x[{k + 1}]": x, f"shape.y[{k + 1}]": y, f"shape.z[{k + 1}]": 0.0}
                self.forces.update(point)


def _run(rope: RopePlant, winding: Winding, coupling: Coupling | None = None) -> Result:
    return Host(rope, Hoist(), winding, coupling).run()


@pytest.fixture(scope="module")
def full() -> Result:
    return _run(FakeRope(shows_shape=True), Winding())


@pytest.fixture(scope="module")
def short() -> Result:
    return _run(FakeRope(shows_shape=True), Winding(travel=2.0, settle=1.0))


def test_the_default_winding_ends_within_a_millimetre(full: Result) -> None:
    assert full.completed
    recording = full.recording
    np.testing.assert_allclose(recording["conveyance.left.y"][-1], 90.0, rtol=0, atol=1e-3)
    np.testing.assert_allclose(recording["conveyance.left.vy"][-1], 0.0, atol=1e-3)
    # the controller's own bound, not the model's: position error over 90 m at 7.67 m/s
    error = recording["reference.position"] - recording["conveyance.left.y"]
    assert np.max(np.abs(error)) < 0.025
    assert np.max(np.abs(recording["drive.torque"])) < Hoist().torque_limit


def test_the_right_conveyance_sinks_as_the_left_one_rises_up_to_the_stretch_of_the_ropes(full: Result) -> None:
    total = full.recording["conveyance.left.y"] + full.recording["conveyance.right.y"]
    # stretch of either side at most T l / EA = 1.7e5 N 105 m / 1.04e8 N
    np.testing.assert_allclose(total, 90.0, rtol=0, atol=0.18)


def test_lowering_mirrors_the_start_and_ends_within_a_millimetre() -> None:
    recording = _run(FakeRope(), Winding(travel=-30.0)).recording
    assert recording["conveyance.left.y"][0] == 90.0
    np.testing.assert_allclose(recording["conveyance.left.y"][-1], 60.0, rtol=0, atol=1e-3)


def test_the_drive_s_energy_is_balanced_over_the_whole_winding(full: Result) -> None:
    residual = full.recording["drive.energy_residual"]
    # the integrator's 1e-9 of 1e7 J per step, 3447 steps whose errors mostly cancel
    np.testing.assert_allclose(residual, 0.0, atol=0.1)
    assert full.recording["drive.work_motor"][-1] > 4e6


def test_work_on_both_partners_differs_by_the_order_of_the_step() -> None:
    # the force is held over the step: work of the held force against that of the hanging weight, error ~ H
    def defect(H: float) -> float:
        coupling = Coupling(step=H, scheme="impulse-preserving")
        recording = _run(FakeRope(), Winding(travel=10.0, settle=0.0), coupling).recording
        steps = 0.0
        for end in ("left", "right"):
            force, y = recording[f"{end}.fy"], recording[f"conveyance.{end}.y"]
            steps += float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(y)))
        return float(recording["drive.work_from_balance_rope"][-1]) - steps

    ratio = defect(0.02) / defect(0.01)
    # first order, to within the share of the start and the end of the trip
    np.testing.assert_allclose(ratio, 2.0, rtol=0.05)


def test_time_is_start_plus_k_steps_and_never_summed_up() -> None:
    rope = FakeRope()
    recording = _run(rope, Winding(travel=0.5, settle=0.0), Coupling(step=0.01, start=3.0)).recording
    expected = [3.0 + k * 0.01 for k in range(len(rope.times))]
    assert [t for t, _ in rope.times] == expected
    assert {h for _, h in rope.times} == {0.01}
    assert list(recording.time) == [*expected, 3.0 + len(rope.times) * 0.01]


def test_nothing_moves_before_the_reference_does(full: Result) -> None:
    recording = full.recording
    before = recording.time < 1.0
    # 100 steps of the integrator at 1e-9 on heights of 90 m
    np.testing.assert_allclose(recording["conveyance.left.y"][before], 0.0, atol=1e-7)
    np.testing.assert_allclose(recording["conveyance.right.y"][before], 90.0, rtol=0, atol=1e-7)


@pytest.mark.parametrize("settings", [{"fails_at": 1.5}, {"nan_at": 1.5}], ids=["invalid", "nan"])
def test_a_failing_rope_stops_the_loop_and_keeps_the_record(settings: dict[str, Any]) -> None:
    result = _run(FakeRope(**settings), Winding(travel=2.0))
    assert not result.completed
    # rows 0 to 1.5 s; the step from 1.5 s on is not used
    assert result.steps == 150
    np.testing.assert_array_equal(result.recording.time, [k * 0.01 for k in range(151)])
    assert "t = 1.5 s" in result.cause
    assert "turned over" in result.cause or "left.fy_mean" in result.cause
    assert all(np.all(np.isfinite(values)) for values in result.recording.signals.values())


def test_a_rope_that_cannot_hang_stops_before_the_first_row() -> None:
    result = _run(FakeRope(fails_at=-1.0), Winding(travel=2.0))
    assert not result.completed
    assert "no hanging shape" in result.cause
    assert result.steps == 0
    assert "no hanging shape" in render(summarize(result, Hoist(), Winding(), Coupling()))


def test_an_emergency_stop_comes_to_rest_before_the_landing() -> None:
    winding = Winding(emergency_at=9.0)
    recording = _run(FakeRope(), winding).recording
    stopped = recording.time > 9.0 + 6.0 / 5.0 + 5.0
    np.testing.assert_allclose(recording["conveyance.left.vy"][stopped], 0.0, atol=0.01)
    assert recording["conveyance.left.y"][-1] < 30.0


def test_progress_counts_up_to_one() -> None:
    heard: list[tuple[float, float]] = []

    def hear(fraction: float, t: float) -> bool:
        heard.append((fraction, t))
        return True

    Host(FakeRope(), winding=Winding(travel=0.5, settle=0.0)).run(hear)
    fractions = [f for f, _ in heard]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_progress_can_stop_the_run_and_the_record_is_kept() -> None:
    result = Host(FakeRope(), winding=Winding(travel=0.5, settle=0.0)).run(lambda f, t: t < 0.1)
    assert not result.completed
    assert "stopped by the user" in result.cause
    assert len(result.recording[TIME]) == result.steps == 10


def test_a_trip_longer_than_the_shaft_is_named() -> None:
    with pytest.raises(ValueError, match=r"travel = 91\.0 must be within"):
        Host(FakeRope(), winding=Winding(travel=91.0))


def test_csv_reads_back_to_ten_digits_with_its_units(short: Result, tmp_path: Path) -> None:
    write_csv(short.recording, tmp_path / "signals.csv")
    back = read_csv(tmp_path / "signals.csv")
    names = [name for name in short.recording.signals if not name.startswith("shape.")]
    assert list(back.signals) == names
    assert {name: back.units[name] for name in names} == {name: short.recording.units[name] for name in names}
    assert back.units["left.fy"] == "N"
    for name in names:
        # %.10g rounds to half a unit of the tenth digit
        np.testing.assert_allclose(back[name], short.recording[name], rtol=5e-10, atol=0)


def test_the_same_run_writes_the_same_bytes(short: Result, tmp_path: Path) -> None:
    again = _run(FakeRope(shows_shape=True), Winding(travel=2.0, settle=1.0))
    for k, result in enumerate((short, again)):
        folder = tmp_path / str(k)
        folder.mkdir()
        write_csv(result.recording, folder / "signals.csv")
        write_shapes(result.recording, shape_rows(result.recording), folder / "shapes.csv")
        write_figures(result.recording, Hoist(), folder)
    files = sorted(path.name for path in (tmp_path / "0").iterdir())
    assert {"signals.csv", "shapes.csv", "tracking.png", "forces.png", "shapes.png", "energies.png"} <= set(files)
    for name in files:
        assert (tmp_path / "0" / name).read_bytes() == (tmp_path / "1" / name).read_bytes(), name


def test_shapes_run_from_the_left_to_the_right_end(short: Result, tmp_path: Path) -> None:
    shape = short.recording.shape_at(0)
    assert shape is not None
    np.testing.assert_array_equal(shape, [[-1.0, 0.0, 0.0], [0.0, -15.0, 0.0], [1.0, 90.0, 0.0]])
    rows = shape_rows(short.recording, 3)
    assert rows[0] == 0
    assert rows[-1] == len(short.recording.time) - 1
    write_shapes(short.recording, rows, tmp_path / "shapes.csv")
    assert len((tmp_path / "shapes.csv").read_text().splitlines()) == 1 + 3 * 3


def test_what_is_known_along_the_rope_stands_beside_its_points(short: Result, tmp_path: Path) -> None:
    known = {f"shape.tension[{k + 1}]": np.full(len(short.recording.time), 100.0 * k) for k in range(3)}
    more = Recording(short.recording.signals | known, {**short.recording.units, "shape.tension[1]": "N"})
    write_shapes(more, [0], tmp_path / "shapes.csv")
    header, *lines = (tmp_path / "shapes.csv").read_text().splitlines()
    assert header == "time [s],point,x [m],y [m],z [m],tension [N]"
    assert [line.split(",")[-1] for line in lines] == ["0", "100", "200"]
    write_csv(more, tmp_path / "signals.csv")
    assert "shape" not in (tmp_path / "signals.csv").read_text()


def test_a_recording_grows_and_goes_on_from_any_of_its_rows() -> None:
    recorder = Recorder(("a", "b", "c"), {"a": "m"})
    for k in range(1000):
        recorder.add([float(k)], np.array([2.0 * k, math.nan]))
    recording = recorder.recording()
    np.testing.assert_array_equal(recording["b"], 2.0 * recording["a"])
    assert np.isnan(recording["c"]).all()
    assert recording.units == {"a": "m", "b": "", "c": ""}
    again = Recorder(("a", "b", "c"), {})
    again.resume(recording, 3)
    again.add([7.0], [8.0, 9.0])
    np.testing.assert_array_equal(again.recording()["a"], [0.0, 1.0, 2.0, 7.0])


def test_the_markdown_report_names_its_figures_and_says_what_is_assumed(short: Result, tmp_path: Path) -> None:
    rows = summarize(short, Hoist(), Winding(travel=2.0, settle=1.0), Coupling())
    figures = write_figures(short.recording, Hoist(), tmp_path)
    text = write_report(tmp_path / "report.md", "A trip", rows, figures).read_text(encoding="utf-8")
    for part in ("assumed", "real-time factor", "Energy balance", "final position error", *(p.name for p in figures)):
        assert part in text


def test_a_stop_by_the_brake_is_judged_by_its_way_and_not_by_a_reference_it_does_not_follow() -> None:
    hoist, winding = Hoist(brake=Brake()), Winding(emergency_at=9.0, emergency_law="two-stage", settle=5.0)
    result = Host(FakeRope(), hoist, winding).run()
    rows = {row.quantity: row.value for row in summarize(result, hoist, winding, Coupling())}
    recording = result.recording
    trip = int(np.argmin(np.abs(recording.time - 9.0)))
    way = recording["conveyance.left.y"][-1] - recording["conveyance.left.y"][trip]
    # the conveyance swings on its ropes about the rim's place: some centimetres
    np.testing.assert_allclose(float(rows["emergency stop, way to standstill at the rim"]), way, atol=0.1)
    assert 0.5 < float(rows["emergency stop, time to standstill"]) < 20.0
    # of the drive, until the trip: the controller's own bound
    assert float(rows["largest tracking error until then"]) < 25.0
    assert "final position error" not in rows


def test_a_stop_by_the_drive_still_follows_its_reference() -> None:
    winding = Winding(emergency_at=9.0)
    result = _run(FakeRope(), winding)
    rows = {row.quantity: row.value for row in summarize(result, Hoist(), winding, Coupling())}
    assert abs(float(rows["final error against the stop's reference"])) < 10.0
    # v^2 / (2 a) from the speed at 9 s, and the short ramps of 0.1 s
    speed = float(np.interp(9.0, result.recording.time, result.recording["reference.speed"]))
    way = float(rows["emergency stop, way to standstill at the rim"])
    assert speed**2 / 10.0 - 0.1 < way < speed**2 / 10.0 + 0.2 * speed


class _Says:
    """A controller whose every command is one and the same."""

    def __init__(self, said: Any) -> None:
        self.said = said

    def command(self, *_: object) -> Any:
        return self.said


@pytest.mark.parametrize(
    ("controller", "words"),
    [
        (lambda *_: _Says(1.5), r"command\(\) must return Command\(torque, limited, state\), not float"),
        (lambda *_: _Says(None), r"command\(\) must return Command\(torque, limited, state\), not NoneType"),
        (lambda *_: object(), r"needs the method command\(reference, measured, state, h\), and object has none"),
        (_Says(1.5), "must be a class, or a function of hoist and holding torque, not a _Says made already"),
    ],
)
def test_what_is_no_controller_is_told_so(controller: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Host(FakeRope(), controller=controller).run()


def test_a_torque_that_is_no_number_ends_the_run_with_one_line_that_names_it() -> None:
    result = Host(FakeRope(), controller=lambda *_: _Says(Command(math.nan, False, None))).run()
    assert result.cause == (
        "t = 0 s: the controller's torque = nan N m and brake = 0 must be finite: check its command()"
    )


def test_a_rope_force_that_is_no_number_is_named_by_the_drive() -> None:
    plant = HoistPlant(Hoist())
    state = plant.equilibrium(0.0, 90.0, -5e3, -5e3)
    step = plant.step(state, 0.01, PlantInput(0.0, math.nan, -5e3))
    assert not step.valid
    assert step.message == "drive: input is not finite: force_left"
