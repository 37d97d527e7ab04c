"""Studies: a file is checked whole, runs are named by their data, measured, recorded, and survive a dead worker."""

import json
import math
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest
from dask.distributed import Client
from numpy.testing import assert_allclose

from hoist_demo.cases.case import Case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import Stopwatch
from hoist_demo.design.arrival_swing import ArrivalSwing
from hoist_demo.files.reading import FileError
from hoist_demo.parameters import Arrival, Hoist, Winding
from hoist_demo.recording.time_series import Recording
from hoist_demo.run.data import build
from hoist_demo.run.metrics import ARRIVALS, measure
from hoist_demo.study import definition
from hoist_demo.study.cluster import cluster, run_samples
from hoist_demo.study.definition import Study, StudyRun, read_study
from hoist_demo.study.objective import Constraint, Objective
from hoist_demo.study.outcome import CUT_SHORT, ERROR, Outcome, execute
from hoist_demo.study.perform import run_study
from hoist_demo.study.sampling import Range, latin_hypercube
from hoist_demo.study.store import Store, read_results
from hoist_demo.study.trends import not_monotonic

Read = Callable[..., Study]
SHORT = """
[fixed]
winding.travel = 0.2
winding.settle = 0.3
winding.start_delay = 0.1
arrival.window = 0.2
"""


def invent_trip(swing: float, creep: float = 0.0, **trip: float) -> tuple[Result, Hoist]:
    """A trip that follows its reference, then swings with 1.5 Hz at the right conveyance."""
    hoist = Hoist()
    winding = Winding(**{"travel": 10.0, "settle": 6.0, **trip})
    reference = s_curve(winding)
    t = np.arange(0.0, reference.duration + winding.settle, 0.01)
    s = reference.sample(t)
    after = np.maximum(t - reference.duration, 0.0)
    x = swing / 2 * np.sin(2 * math.pi * 1.5 * after) * np.exp(-0.1 * after)
    left = s[:, 0] * (1.0 - creep / winding.travel * np.exp(-after))
    zero = np.zeros_like(t)
    signals = {
        "time": t,
        "reference.position": s[:, 0],
        "conveyance.left.y": left,
        "conveyance.left.vy": np.gradient(left, t),
        "conveyance.right.y": 90.0 - left + x,
        "conveyance.right.vy": np.gradient(90.0 - left + x, t),
        "drive.angle": left / hoist.sheave_radius,
        "drive.torque": np.full_like(t, -5e3),
        "drive.torque_limited": zero,
        "drive.rate": np.gradient(left, t) / hoist.sheave_radius,
        "drive.tension_ratio": np.full_like(t, 1.5),
        "drive.work_motor": 1e3 * np.minimum(t, 5.0) - 500.0 * np.maximum(t - 5.0, 0.0),
        "loop.x": 1.0 - 0.2 * np.sin(t),
        "stress.bending_max": 9.96e7 * np.cos(t),
        "left.fy": -8e3 + 10.0 * np.sin(2 * math.pi * 5 * t),
        "right.fy": -1e3 - 20.0 * t,
        "left.swivel.rate": np.where((t > 3.0) & (t < 5.0), -0.5, 0.0),
        "left.swivel.slipping": ((t > 3.0) & (t < 5.0)).astype(float),
        "left.swivel.torque": -2.0 * t,
    }
    clocks = {f"{name}_clock": Stopwatch() for name in ("drive", "rope", "start")}
    run: Any = {
        "completed": True,
        "cause": "",
        "steps": t.size,
        "trajectory": reference,
        "winding": winding,
    }
    return Result(recording=Recording(signals, {}), **run, **clocks), hoist


def test_metrics_of_a_made_up_trip_are_the_given_numbers() -> None:
    result, hoist = invent_trip(swing=0.01)
    found = measure(result, hoist, Arrival()).metrics
    assert found["torque_rms"] == pytest.approx(5e3)
    assert found["slip_safety"] == pytest.approx((hoist.tension_ratio_limit - 1) / 0.5)
    assert found["motor_energy_drawn"] == pytest.approx(5e3, rel=1e-9)
    assert found["motor_energy"] == pytest.approx(5e3 - 500.0 * (result.recording.time[-1] - 5.0))
    # p-p of a sine that decays by 0.1 1/s, first extremes at 1/6 and 1/2 s
    assert found["swing_right"] == pytest.approx(
        0.005 * (math.exp(-1 / 60) + math.exp(-0.05)), rel=1e-3
    )
    assert found["swing_left"] == pytest.approx(0.0, abs=1e-12)
    assert found["swing_frequency"] == pytest.approx(1.5, abs=1e-3)
    # amplitude over sqrt 2, whole periods in the window of 1.01 s nearly
    assert found["rope_force_ripple"] == pytest.approx(10.0 / math.sqrt(2.0), rel=0.02)
    assert found["rope_force_range"] == pytest.approx(20.0 * result.recording.time[-1], rel=1e-9)
    assert found["sway"] == pytest.approx(0.2, rel=1e-3)
    assert math.isnan(found["sway_across"])
    assert found["bending_stress"] == pytest.approx(9.96e7)
    assert found["left_slip"] == pytest.approx(1.0, rel=0.01)
    assert found["left_slip_time"] == pytest.approx(2.0, abs=0.02)
    assert found["left_starting_torque"] == pytest.approx(6.0, abs=0.05)


@pytest.mark.parametrize(
    ("swing", "creep", "arrival", "wait", "within"),
    [
        # speed amplitude 0.005 * 2 pi 1.5 e^(-0.1 t) = 0.047 m/s falls below 0.03 m/s after 4.5 s, within half a period
        (
            0.01,
            0.0,
            Arrival(speed_band=0.03, position_band=0.1),
            10 * math.log(0.005 * 2 * math.pi * 1.5 / 0.03),
            0.4,
        ),
        (0.0, 0.1, Arrival(speed_band=0.05, position_band=0.01), math.log(10.0), 0.03),
    ],
)
def test_cycle_time_waits_for_the_swing_and_for_the_creep_that_is_none(
    swing, creep, arrival, wait, within
) -> None:
    result, hoist = invent_trip(swing, creep)
    found = measure(result, hoist, arrival).metrics
    assert found["cycle_time"] - found["trajectory_time"] == pytest.approx(wait, abs=within)
    assert (found["swing_right"] < 1e-12) == (swing == 0.0)


def test_a_stop_never_arrives_and_a_trip_within_the_band_takes_no_time() -> None:
    for name, value, cycle in (
        ("emergency_at", 4, math.nan),
        ("emergency_at", 0.5, math.nan),
        ("travel", 1e-4, 0.0),
    ):
        found = measure(*invent_trip(0.0, **{name: value}), Arrival()).metrics
        assert_allclose(found["cycle_time"], cycle)
        assert [math.isnan(found[name]) for name in ARRIVALS] == [math.isnan(cycle)] * 3


def test_a_run_that_a_guard_cuts_short_is_for_objectives_of_stops_alone(read: Read) -> None:
    study = read(SHORT + "guard.window = 1e-9")
    outcome = execute(study.samples[0].data, study.fmu)
    assert (outcome.status, "its guard tripped" in outcome.cause) == (CUT_SHORT, True)
    costs = [
        Objective({name: 1.0}, 1.0).of_run(vars(outcome)).cost
        for name in ("torque_peak", "guard_time")
    ]
    assert [math.isfinite(cost) for cost in costs] == [False, True]


def counting(
    study: Study, store: Store, ran: list[str]
) -> Callable[[Sequence[StudyRun]], list[str]]:
    """Carries out samples at once: the metric cycle_time is the distance of gains.speed from 2e5."""

    def run(samples: Sequence[StudyRun]) -> list[str]:
        keys = [s.data.key(study.fmu_hash) for s in samples]
        done = store.finished_keys(keys)
        for key, sample in zip(keys, samples, strict=True):
            if key not in done:
                cost = abs(sample.data.gains.speed / 2e5 - 1.0)
                store.write(
                    key, sample.data, Outcome("completed", "", {"cycle_time": cost}, {}), "w"
                )
                ran.append(key)
        return keys

    return run


@pytest.mark.parametrize("status", ["completed", "stopped", CUT_SHORT, ERROR, "passed", "warned"])
def test_each_run_that_is_not_whole_is_named_and_decides_the_exit_code(
    read: Read, tmp_path: Path, status: str
) -> None:
    study = read("[vary]\ngains.speed = [1e5, 2e5, 3e5]")
    store = Store(tmp_path)
    keys = [sample.data.key(study.fmu_hash) for sample in study.samples]
    fine = Outcome("completed", "", {}, {})
    odd = {
        "completed": fine,
        "passed": replace(fine, passed="the rope passed through its other leg"),
        "warned": replace(fine, warnings=("the motor was at its limit",)),
    }.get(status, replace(fine, status=status, cause="a cause"))

    def run(samples: Sequence[StudyRun]) -> list[str]:
        for key, sample, outcome in zip(keys, samples, [fine, odd, fine], strict=True):
            store.write(key, sample.data, outcome, "w")
        return keys

    result = run_study(study, store, run)
    name = "run 2 (gains.speed = 2e+05)"
    if status in ("stopped", CUT_SHORT, ERROR):
        assert result.exit_code == 1
        assert result.causes == {name: "a cause"}
        assert result.summary.startswith("2 of 3 runs wound to the end")
    else:
        assert result.exit_code == 0
        assert result.causes == {}
        assert result.summary.startswith("3 of 3 runs wound to the end")
    passages = {}
    if status == "passed":
        passages[name] = odd.passed
    assert result.passages == passages
    assert result.warnings == {text: [name] for text in odd.warnings}
    assert ("in 1 the rope struck or passed through something" in result.summary) == bool(
        odd.passed
    )


@pytest.mark.parametrize("content", ["", "{", "[]", '{"outcome": {}}', "null"])
def test_a_broken_record_is_named_and_its_run_alone_is_wound_again(
    read: Read, tmp_path: Path, caplog: pytest.LogCaptureFixture, content: str
) -> None:
    study = read("[vary]\ngains.speed = [1e5, 2e5, 3e5]")
    store = Store(tmp_path)
    ran = list[str]()
    first = run_study(study, store, counting(study, store, ran))
    table = first.table.read_bytes()
    path = tmp_path / "runs" / f"{ran[1]}.json"
    path.write_text(content, encoding="utf-8")
    again = list[str]()
    store = Store(tmp_path)
    run_study(study, store, counting(study, store, again))
    assert again == [ran[1]]
    assert [f"{path} is no whole record of a run" in text for text in caplog.messages] == [True]
    assert first.table.read_bytes() == table


def test_a_value_that_vary_would_replace_is_refused(read: Read) -> None:
    with pytest.raises(FileError, match=r"\[fixed\] gains.speed = 100000.0 is also in \[vary\]"):
        read("[fixed]\ngains.speed = 1e5\n[vary]\ngains.speed = [1e5, 2e5]")


def test_table_opens_in_pandas_with_units_and_the_same_bytes(read: Read, tmp_path: Path) -> None:
    study = read("[vary]\ngains.speed = [1e5, 2e5]")
    stores = Store(tmp_path / "a"), Store(tmp_path / "b")
    tables = [run_study(study, store, counting(study, store, [])).table for store in stores]
    assert tables[0].read_bytes() == tables[1].read_bytes()
    assert pd.read_parquet(tables[0])["cycle_time"].tolist() == [0.5, 0.0]
    units = read_results(tables[0]).units
    assert (units["gains.speed"], units["cycle_time"], units["cause"]) == ("N.s/m", "s", "")


def test_search_is_resumed_without_a_run(read: Read, tmp_path: Path) -> None:
    study = read(
        "study.minimise = 'cycle_time'\n[vary]\ngains.speed = { low = 1e5, high = 4e5, scale = 'log' }\n"
        "[sample]\nmethod = 'tune'\npoints = 4\nsearches = 2\nsteps = 20"
    )
    store = Store(tmp_path / "out")
    ran = list[str]()
    first = run_study(study, store, counting(study, store, ran))
    assert first.best is not None
    assert len(ran) <= 4 + 2 * 20
    table = pd.read_parquet(first.table)
    assert first.best.runs == (table["judged"].idxmin(),)
    assert table["gains.speed"][first.best.runs[0]] == pytest.approx(2e5, rel=0.02)
    ran.clear()
    assert run_study(study, store, counting(study, store, ran)) == first
    assert ran == []


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with cluster(2, None) as client:
        yield client


def test_runs_of_a_killed_worker_are_done_and_none_is_repeated(
    read: Read, tmp_path: Path, client: Client
) -> None:
    study = read(SHORT + "[vary]\ngains.speed = [1e5, 1.2e5, 1.4e5, 1.6e5, 1.8e5, 2e5]")
    store = Store(tmp_path / "out")
    ran = list[str]()
    pids = client.run(os.getpid)

    def kill_one(key: str, _: Outcome) -> None:
        if not ran:
            os.kill(next(iter(pids.values())), signal.SIGKILL)
        ran.append(key)

    keys = run_samples(client, study, study.samples, store, kill_one)
    assert sorted(ran) == sorted(keys)
    assert len(set(keys)) == 6
    assert store.finished_keys(keys) == set(keys)
    # resumed: nothing is left to do
    written = {key: (tmp_path / "out" / "runs" / f"{key}.json").stat().st_mtime_ns for key in keys}
    ran.clear()
    assert run_samples(client, study, study.samples, store, kill_one) == keys
    assert ran == []
    assert written == {
        key: (tmp_path / "out" / "runs" / f"{key}.json").stat().st_mtime_ns for key in keys
    }


def test_failed_run_is_recorded_with_its_cause_and_stops_no_other(
    read: Read, tmp_path: Path, client: Client
) -> None:
    # steps as large as these err by more than this, and may not be shortened
    study = read(SHORT + "solver.step_min = 0.01\n[vary]\nsolver.tolerance = [1e6, 1e-10]")
    store = Store(tmp_path / "out")
    result = run_study(study, store, partial(run_samples, client, study, store=store))
    table = pd.read_parquet(result.table)
    assert table["status"].tolist() == ["completed", "stopped"]
    assert "step" in table["cause"][1]
    assert len(result.causes) == 1


def test_table_holds_what_the_rope_did(read: Read, tmp_path: Path, client: Client) -> None:
    study = read(f"study.signals = ['left.fy', 'right.fy']\n{SHORT}")
    store = Store(tmp_path / "out")
    table = pd.read_parquet(
        run_study(study, store, partial(run_samples, client, study, store=store)).table
    )
    kept = read_results(tmp_path / "out" / "signals" / f"{table['key'][0]}.parquet")
    series = kept.table
    # 120 m of 8 kg/m, hung from ends 90 m apart: 105 m below the upper end, 15 m below the lower one
    assert series["right.fy"][0] == pytest.approx(-105 * 8 * 9.81, rel=0.01)
    assert series["left.fy"][0] == pytest.approx(-15 * 8 * 9.81, rel=0.02)
    # with their instants and units, or they would mean nothing
    assert kept.units == {"time": "s", "left.fy": "N", "right.fy": "N"}
    assert_allclose(np.diff(series["time"]), 0.01, rtol=1e-9)
    # a draft leaves torsion out, and its yaw is not zero but unknown
    assert math.isnan(table["loop_yaw"][0])
    assert table["fidelity"][0] == "planar"
    record = tmp_path / "out" / "runs" / f"{table['key'][0]}.json"
    assert json.loads(record.read_text())["data"]["winding"]["travel"] == 0.2


@pytest.fixture
def read(tmp_path: Path, fmu_of: Callable[[str], Path]) -> Read:
    def read(text: str, rope: Path | None = None) -> Study:
        path = tmp_path / "STUDY.toml"
        path.write_text(f'study.fmu = "{rope or fmu_of("draft")}"\n{text}', encoding="utf-8")
        return read_study(path)

    return read


def test_grid_is_run_for_every_variant(read: Read) -> None:
    study = read(
        "[[variant]]\nname = 'soft'\nvalues = { rope.EI = 50 }\n"
        "[[variant]]\nname = 'stiff'\nvalues = { rope.EI = 500 }\n"
        "[vary]\ncontroller = ['pi', 'pi-feed-forward']\nwinding.jerk = { values = [0.5, 1], unit = 'm/s3' }"
    )
    assert len(study.samples) == 2 * 2 * 2
    assert {(s.variant, s.data.rope_values["rope.EI"]) for s in study.samples} == {
        ("soft", 50.0),
        ("stiff", 500.0),
    }
    both = {*product(("pi", "pi-feed-forward"), (0.5, 1.0))}
    assert {(s.data.controller, s.data.winding.jerk) for s in study.samples} == both


class Wound(NamedTuple):
    """Measures of a winding."""

    cycle_time: float
    slip_safety: float


#: windings without and with load by speed gain
WINDINGS = {
    1e5: (Wound(1.0, 1.5), Wound(9.0, 1.5)),
    2e5: (Wound(4.0, 1.3), Wound(5.0, 1.5)),
    3e5: (Wound(5.5, 2.0), Wound(5.5, 2.0)),
    4e5: (Wound(0.1, 1.5), Wound(0.1, 1.1)),
}
ABOVE = "study.subject_to.slip_safety = { above = 1.2 }\n"
BETWEEN = "study.subject_to.slip_safety = { above = 1.4, below = 1.8 }\n"


def test_a_design_meets_payloads_for_which_it_was_not_made(
    read: Read, monkeypatch: pytest.MonkeyPatch
) -> None:
    designed = list[float]()

    def swing(case: Case, _: float) -> ArrivalSwing:
        designed.append(case.hoist.payload_left)
        return ArrivalSwing(frequency=1e-3 * case.hoist.payload_left, damping=0.1)

    monkeypatch.setattr("hoist_demo.design.arrival_swing.swing_at_arrival", swing)
    controller = "controller = 'input-shaping'\nwinding.travel = 8.25\n"
    vary = "[vary]\nhoist.payload_left = [1000.0, 5000.0, 9000.0]\n"
    met = read(f"[fixed]\n{controller}{vary}").samples
    assert [one.data.hoist.payload_left for one in met] == [1e3, 5e3, 9e3]
    assert {one.data.shaper.frequency for one in met} == {5.0}
    # the design is made once for all that it meets, and anew for each that is chosen
    assert designed == [5e3]
    chosen = read(f"study.over = []\n[fixed]\n{controller}{vary}").samples
    assert [one.data.shaper.frequency for one in chosen] == [1.0, 5.0, 9.0]
    # an optimised trip is for the nominal hoist, too, and a run's key says so
    optimised = read(
        f"[fixed]\n{controller.replace('input-shaping', 'optimised-trajectory')}{vary}"
    ).samples
    first, middle, last = (one.data.nominal for one in optimised)
    assert middle is None
    for nominal in (first, last):
        assert nominal is not None
        assert nominal.payload_left == 5e3
    assert "nominal" in optimised[0].data.record()
    assert "nominal" not in optimised[1].data.record()


def test_a_bound_on_an_error_holds_in_both_directions() -> None:
    bound = Constraint("position_error", 0.01, 1.0)
    broken = [bound.violation({"position_error": x}) > 0.0 for x in (-0.02, -0.005, 0.005, 0.02)]
    assert broken == [True, False, False, True]
    smallest = Objective({"position_error": 1.0}, 1.0)
    costs = [
        smallest.of_run({"metrics": {"position_error": x}, "status": "completed"}).cost
        for x in (-0.5, 0.1)
    ]
    assert costs == [0.5, 0.1]


@pytest.mark.parametrize(
    ("goal", "best"),
    [
        ("study.minimise = 'cycle_time'\n", 4e5),
        (
            "study.minimise = 'cycle_time'\n" + ABOVE,
            2e5,
        ),  # its worst is the least, the luckiest run another's
        ("study.minimise = 'cycle_time'\nstudy.judge = 'mean'\n" + ABOVE, 2e5),
        ("study.maximise = 'slip_safety'\n", 3e5),
        ("study.judge = 'share'\n" + BETWEEN, 1e5),
        ("study.minimise = 'cycle_time'\nstudy.over = []\n" + ABOVE, 4e5),  # single runs, asked for
        (
            "study.minimise = 'cycle_time'\nstudy.subject_to = { slip_safety = { above = 2.2 } }\n",
            None,
        ),
    ],
)
def test_choices_are_compared_over_the_same_payloads_within_bounds(
    read: Read, tmp_path, goal, best
) -> None:
    study = read(
        f"{goal}[vary]\ngains.speed = [1e5, 2e5, 3e5, 4e5]\nhoist.payload_left = [0, 5000]"
    )
    store = Store(tmp_path / "out")
    for sample in study.samples:
        wound, loaded = WINDINGS[sample.data.gains.speed]
        if sample.data.hoist.payload_left > 0.0:
            wound = loaded
        warnings = (f"slip safety {wound.slip_safety}",)
        outcome = Outcome("completed", "", wound._asdict(), {}, warnings=warnings)
        store.write(sample.data.key(study.fmu_hash), sample.data, outcome, "w")
    found = run_study(study, store, lambda samples: [s.data.key(study.fmu_hash) for s in samples])
    assert found.best is not None
    assert found.best.feasible == (best is not None)
    if best:
        assert {study.samples[k].data.gains.speed for k in found.best.runs} == {best}
        # what a run of the best choice warns of is told with it
        windings = WINDINGS[best]
        if "over" in goal:
            windings = windings[:1]
        for wound in windings:
            assert f"slip safety {wound.slip_safety}" in found.best.text
    # slip safety has its largest value at the third of four gains, in both rows
    assert any("slip_safety" in remark and "= 300000" in remark for remark in found.remarks) == (
        "slip" in goal
    )


def test_a_strike_at_the_lowest_speed_only_is_remarked_on(read: Read) -> None:
    study = read("[vary]\nwinding.speed = [5, 6, 7, 8]")
    outcomes = [
        {"status": "completed", "passed": "struck" * (k == 0), "metrics": {}} for k in range(4)
    ]
    remark = "The rope struck or passed through something at winding.speed = 5, not at 6 to 8"
    assert not_monotonic(study, study.samples, outcomes) == [remark]
    assert not_monotonic(study, study.samples, outcomes[::-1]) == []


SHAPED, OPTIMISED = (
    f"[fixed]\ncontroller = '{x}'\n" for x in ("input-shaping", "optimised-trajectory")
)
LOW = "study.minimise = 'cycle_time'\n"
RANGE = "[vary]\nrope.EI = { low = 1, high = 2 }\n"
TUNE = "[sample]\nmethod = 'tune'\n"
FOUR = "sample = { method = 'latin-hypercube', runs = 4 }\n"
PAYLOAD = "hoist.payload_left = { low = 0, high = 9 }"
JAMMED = "study.hoist = 'jammed-conveyance'\n[fixed]\n"
TWO = "name = 'two'\nlike = 'rope-120'\n[[rope]]\n[[rope]]\nz = 1.0\n"

BAD = {
    "unknown table": ("[vry]\nrope.EI = [1]", "vry", "did you mean vary?"),
    "old case": ("study.case = 'rope-120'", "study.case = 'rope-120'", 'write hoist = "NAME"'),
    "old search": ("[tune]\nsearches = 2", "tune", 'write [sample] method = "tune"'),
    "unknown parameter": ("[fixed]\nwinding.sped = 8", "fixed.winding.sped", "winding.speed"),
    "wrong unit": (
        "[fixed]\nrope.EI = { value = 300, unit = 'N.m' }",
        "fixed: rope.EI has unit = 'N.m'",
        "convert",
    ),
    "impossible FMU value": ("[vary]\nrope.EI = [300, -1]", "vary: rope.EI = -1", "at least 1e-15"),
    "outside the choices": (
        "[fixed]\nleft.swivel.mode = 7",
        "left.swivel.mode = 7",
        "1 (free), 2 (coulomb)",
    ),
    "FMU values that do not fit": ("[fixed]\nleft.swivel.mu_static = 1e-4", "0.0001", "mu_kinetic"),
    "text for a number": ("[variant]\nvalues = {}", "variant = {'values': {}}", "must be a list"),
    "trip longer than the shaft": ("[fixed]\nwinding.travel = 900", "900", "shaft_travel"),
    "list where one value belongs": (
        "[fixed]\nrope.EI = [1, 2]",
        "fixed: rope.EI = [1, 2]",
        "finite number",
    ),
    "one value where a list belongs": (
        "[vary]\nrope.EI = 3",
        "vary: rope.EI = 3",
        "fix it in [fixed]",
    ),
    "range in a grid": (RANGE, "sample: rope.EI", "values"),
    "logarithm of zero": (
        "[vary]\nrope.beta_K = { low = 0, high = 1, scale = 'log' }",
        "low = 0.0",
        "linear",
    ),
    "no number of runs": (
        "sample.method = 'latin-hypercube'\n" + RANGE,
        "sample.runs is missing",
        "give it",
    ),
    "unknown method": (
        "sample.method = 'random'",
        "sample: method = 'random'",
        "'grid', 'latin-hypercube', 'tune'",
    ),
    "unknown metric": ("study.minimise = { speed = 1 }", "study.minimise: speed", "cycle_time"),
    "bound on no metric": (
        LOW + "study.subject_to = { swai = { below = 1 } }",
        "study.subject_to.swai",
        "sway",
    ),
    "bound in another unit": (
        LOW + "study.subject_to.sway = { below = 3, unit = 'kg' }",
        "'kg'",
        "convert",
    ),
    "search for nothing": (TUNE + RANGE, "sample: method = 'tune'", "minimise"),
    "more searches than points": (
        LOW + TUNE + "points = 1\n" + RANGE,
        "searches = 2",
        "at most points = 1",
    ),
    "luckiest payload": (
        LOW + FOUR + RANGE + PAYLOAD,
        "over = ['hoist.payload_left']",
        "over = []",
    ),
    "designed trip that stops": (
        SHAPED + "winding.emergency_at = 5",
        "emergency_at = 5",
        "pi-feed-forward",
    ),
    "no cycle of a stop": (
        LOW + "[fixed]\nwinding.emergency_at = 5",
        "emergency_at = 5",
        "judge stop_distance",
    ),
    "optimised trip creeps": (
        OPTIMISED + "winding.creep_distance = 3",
        "creep_distance = 3 m",
        "another controller",
    ),
    "two best runs": (LOW + "study.maximise = 'slip_safety'", "cycle_time", "keep one"),
    "unknown signal": ("study.signals = ['loop.jaw']", "loop.jaw", "loop.yaw"),
    "a jam out of the way": (
        JAMMED + "winding.travel = 10",
        "jam_right.height = 45.0 must be within",
        "wind further",
    ),
    "several ropes": ("study.hoist = 'TWO.toml'", "TWO.toml' must have", "equal ropes"),
}


@pytest.mark.parametrize(("text", "value", "cure"), BAD.values(), ids=BAD.keys())
def test_bad_file_is_refused_with_file_key_value_and_cure(
    read: Read, tmp_path: Path, text, value, cure
) -> None:
    (tmp_path / "TWO.toml").write_text(TWO, encoding="utf-8")
    with pytest.raises(FileError) as refused:
        read(text)
    assert len(refused.value.problems) == 1, refused.value.problems
    assert "STUDY.toml: " in str(refused.value)
    assert value in str(refused.value)
    assert cure in str(refused.value)


def test_all_errors_are_told_at_once_and_need_no_fmu(read: Read, tmp_path: Path) -> None:
    with pytest.raises(FileError) as refused:
        read(
            "study.sene = 3\n[fixed]\nwinding.sped = 8\ncontroller = 'pid'\n[vary]\nrope.EI = [-1]",
            tmp_path / "no",
        )
    told = "\n".join(refused.value.problems)
    assert [name in told for name in ("sene", "winding.sped", "pid", "rope.EI = -1")] == [True] * 4


def test_of_many_starts_some_are_tried_and_a_refusal_of_another_is_its_cause(
    read: Read, monkeypatch
) -> None:
    monkeypatch.setattr(definition, "MAX_CHECKED", 1)
    study = read("[vary]\nrope.length = [80, 120]")
    outcome = execute(study.samples[0].data, study.fmu)
    assert (outcome.status, "the rope of 80 m cannot hang" in outcome.cause) == ("stopped", True), (
        outcome.cause
    )
    with pytest.raises(FileError, match=r"rope\.length = 80"):
        read("[vary]\nrope.length = [120, 80]")


def test_latin_hypercube_has_one_sample_in_each_strip() -> None:
    samples = latin_hypercube(
        {"a": Range(2.0, 4.0), "b": Range(1.0, 1e4, logarithmic=True)}, 50, seed=3
    )
    strips = (
        {int((s["a"] - 2.0) / 2.0 * 50) for s in samples},
        {int(math.log10(s["b"]) / 4 * 50) for s in samples},
    )
    assert strips == (set(range(50)), set(range(50)))


def test_key_changes_with_every_piece_of_data_that_is_used() -> None:
    base = build("rope-120", {"rope.EI": 300.0})
    changes = (
        {"rope.EI": 301.0},
        {"gains.speed": 1e5},
        {"arrival.window": 4.0},
        {"controller": "pi"},
    )
    others = [build("rope-120", {"rope.EI": 300.0} | change) for change in changes]
    others.append(build("rope-120", {"rope.EI": 300.0}, signals=("loop.x",)))
    keys = [base.key("bytes"), base.key("other bytes"), *(run.key("bytes") for run in others)]
    assert len(set(keys)) == len(keys)
    assert build("rope-120", {"rope.EI": 300.0}).key("bytes") == base.key("bytes")
    # what the controller does not use
    plain = build("rope-120", {})
    other = build("rope-120", {"shaper.frequency": 2.0, "trajectory.hold": 2.0})
    assert plain.key("bytes") == other.key("bytes")
    shaped = [
        build("rope-120", {"controller": "input-shaping", "shaper.frequency": f})
        for f in (1.0, 2.0)
    ]
    assert shaped[0].key("bytes") != shaped[1].key("bytes")
