"""Trips of a duty: what is carried over, what a dwell changes, when they repeat, and how a duty goes on."""

import re
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import pytest
from checkout import EXAMPLES
from numpy.testing import assert_allclose, assert_array_equal

from hoist_demo.cases.case import Case
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.arrival_swing import ArrivalSwing
from hoist_demo.duty.schedule import Schedule, read_schedule
from hoist_demo.duty.table import (
    COLUMNS,
    READ,
    STEADY,
    place_at_rest,
    steady_from,
    trip_row,
    trip_table,
    worst,
)
from hoist_demo.duty.wind import WoundTrip, read_state, wind_duty, write_state
from hoist_demo.files.reading import FileError
from hoist_demo.parameters import GRAVITY

pytestmark = pytest.mark.usefixtures("plain_figures")


class Wound(NamedTuple):
    """Trips of a schedule, the place of the loop at rest before them, and the rope after them."""

    trips: list[WoundTrip]
    rest: tuple[float, float]
    rope: InProcessRope


DUTY = """
[duty]
hoist = "rope-120"
level = "draft"
repeat = {repeat}

[fixed]
model.fidelity = "{fidelity}"
coupling.step = 0.02
winding.settle = {settle}

[[trip]]
winding.travel = {travel}
hoist.payload_left = 5000
hoist.payload_right = 0

[[trip]]
winding.travel = -{travel}
hoist.payload_left = 0
hoist.payload_right = 5000
"""
USUAL = {"repeat": 1, "fidelity": "torsional", "settle": 5.0, "travel": 90.0}


def schedule_of(folder: Path, **chosen: Any) -> Schedule:
    path = folder / "duty.toml"
    path.write_text(DUTY.format(**USUAL | chosen), encoding="utf-8")
    return read_schedule(path)


def rope_of(schedule: Schedule) -> InProcessRope:
    return InProcessRope(rope_scene(schedule.pattern[0].rope_values, schedule.level), READ)


def wound(schedule: Schedule) -> list[WoundTrip]:
    return list(wind_duty(schedule, rope_of(schedule), torque_free={"": False}))


@pytest.fixture(scope="module")
def trips_at_rest(tmp_path_factory: pytest.TempPathFactory) -> Wound:
    """Two repetitions."""
    schedule = schedule_of(tmp_path_factory.mktemp("duty"), repeat=2, settle=15.0)
    rope = rope_of(schedule)
    rest = place_at_rest(schedule, rope)
    return Wound(list(wind_duty(schedule, rope, torque_free={"": False})), rest, rope)


def test_a_trip_begins_with_what_the_one_before_has_left(trips_at_rest: Wound) -> None:
    first, second, *_ = trips_at_rest.trips
    # payloads that change are no coarse table of positions
    assert trips_at_rest.rope.whole.warnings() == {}
    before = first.result.recording
    after = second.result.recording
    assert after.time[0] == before.time[-1]
    for name in (
        "loop.yaw",
        "loop.x",
        "loop.z",
        "left.fy",
        "left.swivel.torque",
        "conveyance.left.y",
    ):
        assert after[name][0] == before[name][-1]
    # and that is no rest
    assert abs(after["loop.x"][0] - before["loop.x"][0]) > 0.05


def test_each_trip_of_a_duty_is_designed_for_its_own_way_and_the_nominal_payload(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = list[tuple[float, float, float]]()

    def swing(case: Case, start: float) -> ArrivalSwing:
        asked.append((start, start + case.winding.travel, case.hoist.payload_left))
        return ArrivalSwing(frequency=1.0 + 0.01 * (start + case.winding.travel), damping=0.1)

    monkeypatch.setattr("hoist_demo.design.arrival_swing.swing_at_arrival", swing)
    trips = "".join(
        f"[[trip]]\nwinding.travel = {x}\nhoist.payload_left = {m}\n"
        for x, m in ((20.0, 1e3), (5.0, 9e3))
    )
    path = tmp_path / "duty.toml"
    fixed = "controller = 'input-shaping'\nhoist.payload_left = 3000.0"
    path.write_text(
        f"[duty]\nhoist = 'rope-120'\nrepeat = 3\n[fixed]\n{fixed}\n{trips}", encoding="utf-8"
    )
    schedule = read_schedule(path)
    ends = [20.0, 25.0, 45.0, 50.0, 70.0, 75.0]
    assert [schedule.landing(k) for k in range(7)] == [0.0, *ends]
    runs = [schedule.trip(k) for k in range(1, 7)]
    assert [run.shaper.frequency for run in runs] == pytest.approx(
        [1.0 + 0.01 * end for end in ends]
    )
    assert [run.hoist.payload_left for run in runs] == [1e3, 9e3] * 3
    assert sorted({*asked}) == [(a, b, 3e3) for a, b in zip([0.0, *ends], ends, strict=False)]


def test_a_dwell_ends_with_the_payload_of_the_next_trip(tmp_path: Path) -> None:
    first, _ = wound(schedule_of(tmp_path, fidelity="rigid", settle=60.0, travel=20.0))
    tensions = [first.result.recording[f"drive.tension_{side}"] for side in ("left", "right")]
    dwell = round(60.0 / 0.02)
    for tension, change in zip(tensions, (-5000.0, 5000.0), strict=True):
        # the second before loading begins, and the last: the swing of either is averaged out to a thousandth
        before = tension[-dwell + 700 : -dwell + 750].mean()
        after = tension[-50:].mean()
        assert after - before == pytest.approx(change * GRAVITY, rel=2e-3)


def test_trips_from_rest_miss_what_builds_up(trips_at_rest: Wound) -> None:
    rows = [trip_row(trip, trips_at_rest.rest) for trip in trips_at_rest.trips]
    trips = trip_table(rows, 2)
    found = {one.name: one for one in worst(trips, 2)}
    assert found["loop_yaw"].trip > 2
    assert found["loop_yaw"].value > 1.3 * found["loop_yaw"].first_cycle
    assert_array_equal(trips["yaw_start"][1:], trips["yaw_end"][:-1])
    assert_allclose(trips["landing"], [90.0, 0.0] * 2, rtol=0.0, atol=1e-12)
    assert steady_from(trips, 2) is None


def test_a_duty_goes_on_from_its_file_with_the_same_bits(tmp_path: Path) -> None:
    schedule = schedule_of(tmp_path, repeat=2, settle=2.0, travel=20.0)
    rope = rope_of(schedule)
    path = tmp_path / "last_trip.npz"
    rest = place_at_rest(schedule, rope)
    rows = []
    for trip in wind_duty(schedule, rope, torque_free={"": False}):
        rows.append(trip_row(trip, rest))
        if trip.number == 2:
            assert trip.result.end is not None
            write_state(path, trip_table(rows, 2), trip.result.end, rope, schedule)
    other = rope_of(schedule)
    place_at_rest(schedule, other)
    kept, end = read_state(path, other, schedule)
    again = [
        trip_row(trip, rest)
        for trip in wind_duty(schedule, other, torque_free={"": False}, after=end, done=2)
    ]
    for name in COLUMNS:
        assert_array_equal([r[name] for r in kept + again], [r[name] for r in rows], err_msg=name)
    whole = path.read_bytes()
    for content in (b"", whole[:100], whole[: len(whole) // 2], b"no archive"):
        path.write_bytes(content)
        with pytest.raises(
            ValueError,
            match=rf"last_trip\.npz' must be a checkpoint .* or delete {re.escape(str(path))}",
        ):
            read_state(path, other, schedule)
    path.write_bytes(whole)
    longer = schedule.model_copy(
        update={"pattern": schedule_of(tmp_path, settle=3.0, travel=20.0).pattern}
    )
    changed = r"but trip 1: winding\.settle is 2\.0 there, 3\.0 here, trip 2: .* 3\.0 here: give"
    with pytest.raises(ValueError, match=changed):
        read_state(path, other, longer)


def test_a_duty_of_several_ropes_winds_them_all_and_goes_on_with_the_same_bits(
    tmp_path: Path,
) -> None:
    ropes = "[[rope]]\nname = 'a'\nz = 0.3\n[[rope]]\nname = 'b'\nz = -0.3\nQb = 0\nQc = 0\n"
    hoist = f"name = 'two'\nlike = 'rope-120'\n{ropes}"
    (tmp_path / "two.toml").write_text(hoist, encoding="utf-8")
    text = DUTY.format(**USUAL | {"settle": 2.0, "travel": 5.0}).replace(
        "rope-120", str(tmp_path / "two.toml")
    )
    (tmp_path / "duty.toml").write_text(text, encoding="utf-8")
    schedule = read_schedule(tmp_path / "duty.toml")
    both = schedule.ropes(READ)
    path = tmp_path / "last_trip.npz"
    names = {rope.name: rope.torque_free for rope in both.data()}
    rest = place_at_rest(schedule, both.plant, [*names])
    rows = []
    for trip in wind_duty(schedule, both.plant, names):
        rows.append(trip_row(trip, rest))
        if trip.number == 1:
            assert trip.result.end is not None
            write_state(path, trip_table(rows, 2), trip.result.end, both.plant, schedule)
    # the drive carries both, and each rope has its own yaw: none without coupling
    assert schedule.pattern[0].hoist.tail_rope_mass == 16.0
    assert rows[0]["a.loop_yaw"] > 1e-3 > rows[0]["b.loop_yaw"]
    other = schedule.ropes(READ)
    place_at_rest(schedule, other.plant, [*names])
    kept, end = read_state(path, other.plant, schedule)
    again = [
        trip_row(trip, rest) for trip in wind_duty(schedule, other.plant, names, after=end, done=1)
    ]
    for name in rows[0]:
        assert_array_equal([r[name] for r in kept + again], [r[name] for r in rows], err_msg=name)


def test_a_cycle_is_steady_once_what_is_left_of_the_transient_changes_by_a_hundredth() -> None:
    # yaw 1 + 2^-n, of 1.5 at most: trip n and n - 2 differ by 3/4 2^(2 - n) / 1.5 = 2^(1 - n), below 0.01 from n = 8 on
    zeros = dict.fromkeys(COLUMNS, 0.0)
    yaws = {float(n): {"loop_yaw": 1.0 + 0.5**n, "position_error": -(0.5**n)} for n in range(1, 13)}
    trips = trip_table([zeros | {"trip": number, **columns} for number, columns in yaws.items()], 2)
    assert (worst(trips, 2)[-1].name, worst(trips, 2)[-1].value) == ("position_error", 0.5)
    assert_allclose(trips["difference"][2:], [0.5 ** (n - 1) for n in range(3, 13)], rtol=1e-12)
    assert steady_from(trips, 2) == 8
    assert 0.5**7 <= STEADY < 0.5**6


@pytest.mark.parametrize(
    ("wrong", "right", "told"),
    [
        (
            "winding.travel = -90.0",
            "winding.travel = 90.0",
            r"trip 2: winding.travel = 90 m leads to 180 m",
        ),
        (
            "hoist.payload_left = 5000",
            "hoist.sheave_radius = 2.0",
            r"trip 1: hoist.sheave_radius = .* the same",
        ),
        (
            "hoist.payload_left = 0",
            'hoist.payload_left = { value = 0, unit = "m" }',
            r"the same as kg",
        ),
        (
            "winding.travel = 90.0",
            "winding.travel = 90.0\nwinding.emergency_at = 5",
            r"emergency_at must be left out",
        ),
    ],
)
def test_a_schedule_that_cannot_be_is_refused_with_the_cure(
    tmp_path: Path, wrong: str, right: str, told: str
) -> None:
    path = tmp_path / "duty.toml"
    text = DUTY.format(**USUAL)
    assert wrong in text
    path.write_text(text.replace(wrong, right), encoding="utf-8")
    with pytest.raises(FileError, match=told):
        read_schedule(path)


@pytest.mark.parametrize(("name", "count"), [("day", 300), ("damped", 120), ("palabora", 30)])
def test_the_schedules_of_the_documents_can_be_wound(name: str, count: int) -> None:
    path = EXAMPLES / "duties" / f"{name}.toml"
    assert read_schedule(path).count == count


def test_the_command_leaves_a_table_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    schedule_of(tmp_path, settle=2.0, travel=5.0)
    file = tmp_path / "duty.toml"
    hard = file.read_text(encoding="utf-8").replace(
        "[fixed]", "[fixed]\nwinding.acceleration = 4.9\nwinding.jerk = 40"
    )
    file.write_text(hard, encoding="utf-8")
    arguments = ["duty", str(tmp_path / "duty.toml"), "--out", str(tmp_path / "out")]
    figure = "hoist_demo.report.figures.write_duty_figure"
    # the figure is that of the trips in the end: drawn once
    with monkeypatch.context() as undrawn:
        undrawn.setattr(figure, lambda _, path: path)
        assert main(arguments) == 0
    assert main([*arguments, "--repeat", "2"]) == 0
    monkeypatch.setattr(figure, lambda _, path: path)
    told = capsys.readouterr().out
    warned = ("slip safety in normal winding is", "the left conveyance ends its dwell")
    assert all(text in told for text in (*warned, "2 of 4 trips are there already"))
    assert "hoist.payload_left,varied,kg,varied" in (tmp_path / "out" / "data.csv").read_text(
        encoding="utf-8"
    )
    units = {line.split()[0]: line.split()[2] for line in told.splitlines() if " in trip " in line}
    # angles in degrees, and no unit of pure numbers: "in trip" follows
    assert (units["loop_yaw"], units["turns"], units["sway"]) == ("deg", "in", "m")
    trips = pd.read_csv(tmp_path / "out" / "trips.csv")
    assert_array_equal(trips["trip [1]"], [1.0, 2.0, 3.0, 4.0])
    assert "loop_yaw [rad]" in trips
    assert (tmp_path / "out" / "duty.png").stat().st_size > 0
    file.write_text(hard.replace("[fixed]", "[fixed]\nhoist.slack_tension = 9e4"), encoding="utf-8")
    assert main([*arguments[:-1], str(tmp_path / "slack")]) == 1
    assert (
        "1: emergency stop at t = 1.1 s: head ropes pulled less than hoist.slack_tension"
        in capsys.readouterr().err
    )
