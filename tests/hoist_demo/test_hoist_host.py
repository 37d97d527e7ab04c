"""The loop winds to the millimetre, keeps time exactly, stops cleanly and writes the same bytes twice."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from numpy.testing import assert_allclose
from rope_groups import Weight

from hoist_demo.control.controller import Command, Measurement, SpeedController
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import RopePlant, Scheme
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.parameters import Arrival, Coupling, Hoist, Winding
from hoist_demo.parameters.components import Brake
from hoist_demo.recording.incidents import stops
from hoist_demo.recording.time_series import shape_rows, write_csv, write_shapes
from hoist_demo.report.figures import STYLE, write_figures
from hoist_demo.report.panel_layout import lay_out_stack, legend, stacked_panels
from hoist_demo.report.summary import summarize
from hoist_demo.report.verdict import judge
from hoist_demo.run.metrics import measure
from rope_model import EndMotion, Status

RHO = 8.0
G = 9.81
LENGTH = 120.0


@dataclass
class FakeRope(Weight):
    """Two legs that weigh what they are long; fails or turns NaN at a given time."""

    forces: dict[str, float] = field(default_factory=dict)
    fails_at: float = math.inf
    nan_at: float = math.inf
    shows_shape: bool = False
    times: list[tuple[float, float]] = field(default_factory=list)

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self._hang(left, right)
        return Status(t0 < self.fails_at, "no hanging shape")

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        self.times.append((t, h))
        self._hang(left, right)
        if t >= self.nan_at:
            self.forces["left.fy_mean"] = math.nan
        return Status(t < self.fails_at, "the loop has turned over")

    def units(self) -> dict[str, str]:
        lengths = [name for name in self.forces if name.startswith(("loop.", "shape."))]
        return dict.fromkeys(self.forces, "N") | dict.fromkeys(lengths, "m")

    def _hang(self, left: EndMotion, right: EndMotion) -> None:
        bottom = (left.y + right.y - LENGTH) / 2.0
        for name, end in (("left", left), ("right", right)):
            self.forces[f"{name}.fy"] = self.forces[f"{name}.fy_mean"] = -RHO * G * (end.y - bottom)
        self.forces["loop.y"] = bottom
        if not self.shows_shape:
            return
        for k, (x, y) in enumerate(((-1.0, left.y), (0.0, bottom), (1.0, right.y))):
            self.forces |= {
                f"shape.x[{k + 1}]": x,
                f"shape.y[{k + 1}]": y,
                f"shape.z[{k + 1}]": 0.0,
            }


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
    assert np.max(np.abs(recording["reference.position"] - recording["conveyance.left.y"])) < 0.025
    assert np.max(np.abs(recording["drive.torque"])) < Hoist().torque_limit


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
            force = recording[f"{end}.fy"]
            y = recording[f"conveyance.{end}.y"]
            steps += float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(y)))
        return float(recording["drive.work_from_balance_rope"][-1]) - steps

    # first order, to within the share of the start and the end of the trip
    np.testing.assert_allclose(defect(0.02) / defect(0.01), 2.0, rtol=0.05)


def test_time_is_start_plus_k_steps_and_never_summed_up() -> None:
    rope = FakeRope()
    recording = _run(
        rope, Winding(travel=0.5, settle=0.0), Coupling(step=0.01, start=3.0)
    ).recording
    expected = [3.0 + k * 0.01 for k in range(len(rope.times))]
    assert [t for t, _ in rope.times] == expected
    assert {h for _, h in rope.times} == {0.01}
    assert list(recording.time) == [*expected, 3.0 + len(rope.times) * 0.01]


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
    assert (result.completed, result.steps) == (False, 0)
    assert "no hanging shape" in result.cause
    assert "no hanging shape" in judge(result, Hoist(), [RopeData({}, {}, {})]).summary


def test_csv_reads_back_to_ten_digits_with_its_units(short: Result, tmp_path: Path) -> None:
    write_csv(short.recording, tmp_path / "signals.csv")
    back = pd.read_csv(tmp_path / "signals.csv")
    names = [name for name in short.recording.signals if not name.startswith("shape.")]
    assert [column.partition(" ")[0] for column in back] == names
    assert {"time [s]", "left.fy [N]", "loop.y [m]"} <= {*back}
    # %.10g rounds to half a unit of the tenth digit
    np.testing.assert_allclose(
        back, np.column_stack([short.recording[name] for name in names]), rtol=5e-10, atol=0
    )


def test_the_same_run_writes_the_same_bytes(short: Result, tmp_path: Path) -> None:
    again = _run(FakeRope(shows_shape=True), Winding(travel=2.0, settle=1.0))
    written = []
    for k, result in enumerate((short, again)):
        folder = tmp_path / str(k)
        folder.mkdir()
        write_csv(result.recording, folder / "signals.csv")
        write_shapes(result.recording, shape_rows(result.recording), folder / "shapes.csv")
        write_figures(result.recording, Hoist(), folder)
        written.append({path.name: path.read_bytes() for path in folder.iterdir()})
    first, second = written
    assert {
        "signals.csv",
        "shapes.csv",
        "tracking.png",
        "forces.png",
        "shapes.png",
        "energies.png",
    } <= first.keys()
    assert first == second


def test_no_text_of_a_stack_of_panels_is_cut_or_covers_another() -> None:
    titles = ("Numbers with a factor", "Long numbers", "A curve with a long name")
    curves = ((0.0, 2e-9), (-1234.5678, -1234.5677), (0.0, 1.0))
    with matplotlib.rc_context(STYLE):
        figure, axes = stacked_panels(titles)
        for ax, values in zip(axes, curves, strict=True):
            ax.plot((0.0, 1.0), values, label="a curve with a long name, and another one")
            ax.set_ylabel("[N m]")
            legend(ax)
        axes[-1].set_xlabel("time [s]")
        lay_out_stack(figure, axes)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    boxes = []
    hidden = [label for ax in axes for label in _hidden_labels(ax)]
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text.get_text() and text.get_visible() and text not in hidden:
            boxes.append((text.get_text(), text.get_window_extent(canvas.get_renderer())))
    assert {*titles, "[N m]", "1e\N{MINUS SIGN}9"} <= {name for name, _ in boxes}
    for name, box in boxes:
        assert box.x0 >= 0.0, name
        assert box.y0 >= 0.0, name
        assert box.x1 <= figure.bbox.x1, name
        assert box.y1 <= figure.bbox.y1, name
    for (one, box), (other, beside) in combinations(boxes, 2):
        assert not box.overlaps(beside), (one, other)


def _hidden_labels(ax: Axes) -> Iterator[Text]:
    """Yield the labels of ticks that the axes do not show."""
    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        for tick in axis.majorTicks:
            if not low <= tick.get_loc() <= high:
                yield tick.label1
            yield tick.label2


def test_a_stop_by_the_brake_is_judged_by_its_way_and_not_by_a_reference_it_does_not_follow() -> (
    None
):
    hoist = Hoist(brake=Brake())
    winding = Winding(emergency_at=9.0, emergency_law="two-stage", settle=5.0)
    result = Host(FakeRope(), hoist, winding).run()
    rows = {row.quantity: row.value for row in summarize(result, hoist, winding, Coupling())}
    recording = result.recording
    trip = int(np.argmin(np.abs(recording.time - 9.0)))
    # the conveyance first stands still where its ropes let it go furthest
    stop, _ = stops(recording, winding.emergency_at, hoist.sheave_radius)
    way = np.abs(recording["conveyance.left.y"][trip:] - recording["conveyance.left.y"][trip])
    np.testing.assert_allclose(stop.stopping_distance, way.max())
    assert 0.5 < stop.time < 20.0
    # a brake too weak for the load has no stopping distance
    weak = Hoist(brake=Brake(torque=3e4))
    runs = (result, hoist), (Host(FakeRope(), weak, winding).run(), weak)
    assert_allclose(
        [measure(*run, Arrival()).metrics["stop_distance"] for run in runs], [way.max(), math.nan]
    )
    # of the drive, until the trip: the controller's own bound
    assert float(rows["largest tracking error until then"]) < 25.0
    assert "final position error" not in rows


# a controller that samples within the communication step does what it does in shorter steps, repeated or not

SAMPLED = Winding(travel=4.0, speed=4.0, jerk=2.0, start_delay=0.2, settle=0.8)
FORCES = {
    "left.fy": -2000.0,
    "right.fy": -7500.0,
    "left.fy_mean": -2000.0,
    "right.fy_mean": -7500.0,
}


class TakenBack(FakeRope):
    def save(self) -> dict[str, float]:
        return dict(self.forces)

    def restore(self, snapshot: dict[str, float]) -> None:
        self.forces = dict(snapshot)


class Counting(SpeedController):
    """Remembers, in a state that it changes in place, where each of its samples asked the hoist to be."""

    calls = 0

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        self.calls += 1
        if state is None:
            state = {"inner": None, "places": []}
        self.latest = state
        self.latest["places"].append(reference.position)
        found = super().command(reference, measured, self.latest["inner"], h)
        self.latest["inner"] = found.state
        return found._replace(state=self.latest)


def sample(step: float, rope: RopePlant, scheme: Scheme | None = None) -> tuple[Result, Counting]:
    made: list[Counting] = []

    def controller(hoist: Hoist, torque: float) -> Counting:
        made.append(Counting(hoist, torque))
        return made[0]

    coupling = Coupling(step=step, sample=0.01)
    result = Host(rope, Hoist(), SAMPLED, coupling, controller=controller, scheme=scheme).run()
    assert result.completed
    return result, made[0]


@pytest.mark.parametrize("step", [0.02, 0.04])
def test_the_hoist_moves_as_with_a_step_of_one_sample(step: float) -> None:
    every = round(step / 0.01)
    long, short = (sample(h, Weight(FORCES))[0].recording for h in (step, 0.01))
    shared = short.time[::every].size  # the longer step may end behind the shorter one
    assert_allclose(long.time[:shared], short.time[::every], rtol=1e-15)
    # the rope pulls constantly, so what is left is the drive's integration, 1e-9 of a step
    for name in ("conveyance.left.y", "conveyance.right.y", "drive.torque_command"):
        assert_allclose(
            long[name][:shared], short[name][::every], rtol=1e-6, atol=1e-8, err_msg=name
        )


def test_samples_that_are_taken_back_leave_nothing_behind() -> None:
    result, controller = sample(0.02, TakenBack(), Iterative("secant", tolerance=1e-6))
    assert result.recording["coupling.exchanges"][-1] > 1.5 * result.steps
    asked = [result.trajectory.at(0.01 * k).position for k in range(2 * result.steps + 1)]
    assert_allclose(controller.latest["places"], asked, rtol=1e-12, atol=1e-12)
    assert controller.calls > len(asked)


def test_a_scheme_that_divides_the_step_has_no_samples_within_it() -> None:
    with pytest.raises(
        ValueError, match=r"sample = 0\.01 must be at least the communication step 0\.02 s"
    ):
        Coupling(step=0.02, sample=0.01, scheme="energy-controlled")
