"""What a run leaves: a report with its rope and its warnings, packed numbers, what each place went through."""

import base64
import hashlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from checkout import ROOT
from exports import FLAVOURS
from numpy.testing import assert_allclose
from shared import Capture, Patch

from hoist_demo.command_line import support
from hoist_demo.command_line.main import main
from hoist_demo.command_line.support import interruption, treat_hangup_as_interrupt
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording import exposure as exposures
from hoist_demo.recording import fidelity as masks
from hoist_demo.recording.incidents import SIDES, Stop, stops
from hoist_demo.recording.spectra import spectra, strongest
from hoist_demo.recording.time_series import TIME, Recording
from hoist_demo.report.html import packing
from hoist_demo.report.rope_record import RopeRecord
from hoist_demo.report.verdict import Verdict, bounds_in_words, broken, instant_to_show, judge
from hoist_demo.report.verdict_row import VerdictRow
from hoist_demo.run.data import build
from rope_model import neglected_text


def recording(*fidelities: str) -> Recording:
    signals = {
        "time": np.arange(float(len(fidelities))),
        masks.FIDELITY: np.array([*map(masks.code_of, fidelities)]),
    }
    names = ("loop.yaw", "loop.y", "left.swivel.torque", "stress.torsion_max", "stress.bending_max")
    return Recording(signals | {name: np.zeros(len(fidelities)) for name in names}, {})


@pytest.mark.parametrize(
    ("fidelity", "missing"),
    [
        ("torsional", set()),
        ("spatial", {"left.swivel.torque", "stress.torsion_max"}),
        ("planar", {"left.swivel.torque", "stress.torsion_max", "loop.yaw"}),
        ("rigid", {"left.swivel.torque", "stress.torsion_max", "loop.yaw"}),
    ],
)
def test_what_a_fidelity_leaves_out_is_not_a_number(fidelity: str, missing: set[str]) -> None:
    shown = masks.mask_neglected(recording(fidelity), torque_free=False)
    assert {name for name, values in shown.signals.items() if np.isnan(values).any()} == missing
    assert bool(masks.remark(shown)) == bool(missing)


def test_a_run_that_goes_on_with_a_higher_fidelity_is_shown_from_there_on() -> None:
    shown = masks.mask_neglected(recording("planar", "planar", "torsional"), torque_free=False)
    assert np.isnan(shown["loop.yaw"]).tolist() == [True, True, False]
    assert masks.fidelities_of(shown) == ["planar", "torsional"]
    assert "ran as its planar model between t = 0 and 1 s, which" in masks.remark(shown)
    assert masks.drop_duplicates_of_remark([neglected_text("planar"), "other"], shown) == ["other"]


NAN = float("nan")
#: what is recorded, parameters of the rope, and the row of the verdict: its value (; where), whether the bound is kept
AT_REST = {"drive.static_tension_ratio": [1.5, 1.6]}
VERDICTS = [
    # three ropes of 1 to 2 kN, known within 2 N each
    (
        {"left.fy": [-1e3, -2e3], "status.end_force_error": [0, 1e-3]},
        {},
        "pull of all 3",
        "3.00 to 6.00 kN",
        True,
    ),
    ({"right.fy": [-1e3, 50.0]}, {}, "pull of all 3", "-0.15 to 3 kN", False),
    ({"right.fy": [-1e3, -50.0]}, {}, "pull of all 3", "0.15 to 3 kN", True),
    ({"loop.turns": [0.1, -0.55]}, {}, "turns", "0.55", False),
    ({"loop.turns": [0.1, -0.2]}, {"guard.turns": 0.15}, "turns", "0.2", False),
    (
        {"loop.sideways": [0.0, 1.234567], "status.loop_error": [0, 5e-3]},
        {},
        "sideways",
        "1.23 m",
        None,
    ),
    ({"drive.pull_left": [9e3, 0.0]}, {}, "smallest pull of the head ropes, left", "0 kN", False),
    ({"loop.sideways": [0.0, 1.2]}, {"guard.window": 1.5}, "sideways", "1.2 m", True),
    (
        {"nearest.divider.clearance": [1.0, 0.2]},
        {"guard.clearance": 0.3},
        "clearance from a divider",
        "0.2 m",
        False,
    ),
    (
        {"status.loop_error": [0, 5e-3]},
        {"accuracy.loop": 0.01},
        "estimated error of the loop",
        "5 mm",
        True,
    ),
    # exp(0.25 pi) = 2.193: (2.193 - 1) / (1.6 - 1) at rest after arrival, 1.193 / 1.2 while it winds
    # at rest counts what hangs there, not what swings at the last instant
    ({"drive.tension_ratio": [1.5, 2.2], **AT_REST}, {}, "slip safety at rest", "1.99", True),
    ({"drive.tension_ratio": [1.5, 2.2], **AT_REST}, {}, "slip safety in normal", "0.99", False),
    ({"drive.torque_limited": [1, 0]}, {}, "remark", "the motor was at its limit for 1.00 s", None),
    # the guard counts from a height of its own; a fall is no rise
    ({"loop.rise": [0.0, 0.3]}, {"guard.rise": 0.2}, "rise of the loop", "0.3 m", False),
    (
        {"loop.rise": [0.0, 0.3]},
        {"guard.rise": 0.2, "guard.rise_y": -14.0},
        "rise of the loop",
        "0.3 m",
        None,
    ),
    ({"loop.rise": [0.0, -0.3]}, {"guard.rise": 0.2}, "rise of the loop", "0 m", True),
    # only what was computed is told, with when and where
    (
        {"loop.sideways": [2, 1], "loop.x": [2, 1], "loop.z": [NAN, 0]},
        {},
        "sideways",
        "2 m; t = 0.00 s, x = 2 m",
        None,
    ),
    (
        {"left.swivel.slipping": [NAN, 1]},
        {},
        "slip of the",
        "left none; computed from t = 1.00 s on",
        None,
    ),
    ({"loop.turns": [NAN, 0.2]}, {}, "turns", "0.2; t = 1.00 s, computed from t = 1.00 s on", True),
]


def judged(signals: dict[str, list[float]], parameters: dict[str, float]) -> Verdict:
    """Return the verdict on a record of two instants, of a hoist with three ropes."""
    columns = {name: np.array(values) for name, values in signals.items()}
    record = Recording({"time": np.array([0.0, 1.0]), **columns}, {})
    ended = SimpleNamespace(
        recording=record, completed=True, cause="", warning="", winding=Winding()
    )
    return judge(ended, Hoist(tail_rope_number=3), [RopeData({}, parameters, {})])


@pytest.mark.parametrize(("signals", "parameters", "row", "value", "kept"), VERDICTS)
def test_the_verdict_has_each_number_with_its_digits_beside_its_bound(
    signals, parameters, row, value, kept
) -> None:
    verdict = judged(signals, parameters)
    remarks = [VerdictRow("remark", text.partition(":")[0]) for text in verdict.remarks]
    (found,) = [one for one in (*verdict.rows, *remarks) if one.quantity.startswith(row)]
    shown = found.value
    if ";" in value:
        shown += f"; {found.where}"
    assert (shown, found.holds) == (value, kept)
    assert (found.quantity in verdict.summary) == (kept is False)


def test_each_row_of_the_verdict_that_fails_is_named_and_is_not_good() -> None:
    rows = list[VerdictRow]()
    for signals, parameters, *_ in VERDICTS:
        rows += judged(signals, parameters).rows
    by_quantity = {row.quantity: row for row in rows}
    kept = [replace(row, holds=True) for row in by_quantity.values()]
    assert len(kept) > 12
    assert "strikes" in {row.quantity for row in kept}
    assert bounds_in_words(kept, completed=True) == f"All {len(kept)} bounds are kept."
    for k, row in enumerate(kept):
        one = [*kept[:k], replace(row, holds=False), *kept[k + 1 :]]
        assert [failing.quantity for failing in broken(one)] == [row.quantity]
        assert bounds_in_words(one, completed=True) == f"Not kept: {row.quantity}."
        assert one[k].cells[3] == "NO"


def test_a_stop_is_told_by_each_conveyance_s_own_way_and_by_the_sheave_that_holds_it() -> None:
    y = [0.0, 8.0, 12.0, 13.0, 12.0, 10.0, 4.0]
    vy = [8.0, 6.0, 2.0, -0.1, -2.0, -3.0, -6.0]
    signals = {f"conveyance.{side}.y": y for side in SIDES}
    signals |= {f"conveyance.{side}.vy": vy for side in SIDES}
    # ropes that slid before the stop go on sliding, at the ratio of sliding friction
    signals |= {"drive.tension_ratio": [1.5] + [1.9] * 6, "drive.slip": [0, 1, 3, 5, 7, 9, 9]}
    signals |= {"drive.static_tension_ratio": [1.5] * 7, "drive.slip_speed": [0.0] * 7}
    # on its way, swinging back on a sheave that stands, and with one that runs back, for 3 s or as the record ends
    standing = [2.0, 1.5, 0.5] + [0.0] * 4
    running = [0.5 * v for v in vy]
    slipping = [0.0] * 5 + [-3.0, -6.0]
    for n, rates, slip, course in (
        (3, standing, None, (4, None, 0, False, 2, 4)),
        (4, standing, None, (5, 2, 0, True, -0.1, 5)),
        (7, standing, None, (5, 2, -9, True, -6, 5)),
        (7, running, None, (5, 2, -9, False, -6, 5)),
        (6, running, None, (5, 2, -3, False, -3, 5)),
        (7, standing, slipping, (5, 2, -9, False, -6, 5)),
    ):
        signals["drive.rate"] = rates
        if slip is not None:
            signals["drive.slip_speed"] = slip
        record = Recording(
            {"time": np.arange(10.0, 10.0 + n), **{k: np.array(x[:n]) for k, x in signals.items()}},
            {},
        )
        assert stops(record, 1.0, radius=2.0) == [Stop(side, *course) for side in SIDES]
    ended = SimpleNamespace(
        recording=record, completed=True, cause="", warning="", winding=Winding(emergency_at=2.0)
    )
    rows = {row.quantity: row for row in judge(ended, Hoist(), [RopeData({}, {}, {})]).rows}
    told = rows["way of the left conveyance in the emergency stop"]
    assert (told.value, told.holds) == (
        "1.00 m in 1.00 s, then 9.00 m down, at 6 m/s in the end",
        False,
    )
    assert [
        rows[f"slip safety {part}"].holds for part in ("at rest", "from the emergency stop on")
    ] == [True, False]


@pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
@pytest.mark.parametrize("fmi", ["2", pytest.param("3", marks=pytest.mark.slow)])
def test_a_demo_s_reports_state_rope_file_version_level_and_fidelity(
    fmi: str, fmu_of: Callable[[str], Path], tmp_path: Path
) -> None:
    fmu = fmu_of("draft")
    out = tmp_path / "out"
    (scratch := tmp_path / "scratch").mkdir()
    if fmi == "3":
        fmu = tmp_path / "mine.fmu"
        export = [
            "export",
            "--native",
            "--fmi",
            fmi,
            "--platform",
            "host",
            "--level",
            "draft",
            "--out",
            str(fmu),
        ]
        assert main(export) == 0
    demo = ["demo", "--fmu", str(fmu), "--travel", "0.5", "--quick", "--out", str(out)]
    # without its figures, nor the library that draws them
    figures = "types.ModuleType('hoist_demo.report.figures')"
    without_figures = (
        f"import sys, types; figures = sys.modules['hoist_demo.report.figures'] = {figures}; "
        "figures.write_figures = lambda *_: []"
    )
    run = f"from hoist_demo.command_line.main import main; raise SystemExit(main({demo!r}))"
    command = [sys.executable, "-c", f"{without_figures}; {run}"]
    where = os.environ | {"TMPDIR": str(scratch)}
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False, env=where
    )
    assert done.returncode == 0, done.stderr
    title = "Published rope of 120 m: the left conveyance 0.5 m up at up to 8 m/s"
    assert done.stdout.startswith(f"{title}\n")
    for name in ("report.md", "report.html"):
        text = (out / name).read_text(encoding="utf-8")
        assert hashlib.sha256(fmu.read_bytes()).hexdigest() in text
        assert [
            word
            for word in (title, "draft", "planar", "rope.EI", "hoist.sheave_mass")
            if word not in text
        ] == []
    assert not any(scratch.iterdir()), "what is unpacked goes with the process"
    # the table holds the rope's own fidelity, and no zero where nothing was computed
    header, first = (out / "signals.csv").read_text(encoding="utf-8").splitlines()[:2]
    assert dict(zip(header.split(","), first.split(","), strict=True))["loop.yaw [rad]"] == "nan"


@contextmanager
def default_hangup() -> Iterator[None]:
    """A closed terminal ends the process, also where nohup runs these tests; later tests find what was there before."""
    if not hasattr(signal, "SIGHUP"):
        yield
        return
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    "name",
    ["SIGINT", pytest.param("SIGHUP", marks=pytest.mark.skipif(os.name == "nt", reason="none"))],
)
def test_an_interrupt_and_a_closed_terminal_let_the_writing_finish(
    name, capsys: Capture, monkeypatch: Patch
) -> None:
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(support, "silence", lambda: None)
    with default_hangup():
        treat_hangup_as_interrupt()
        with interruption("writing") as interrupted:
            os.kill(os.getpid(), getattr(signal, name))
            finished = True
    assert finished
    assert interrupted()
    assert "writing" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is before


def unpack(packed: dict) -> np.ndarray:
    raw = base64.b64decode(packed["data"])
    if packed["kind"] == "f32":
        return np.frombuffer(raw, "<f4").astype(float)
    codes = np.frombuffer(raw, {"u8": "<u1", "u16": "<u2"}[packed["kind"]]).astype(float)
    top = packing.CODES[packed["kind"]]
    return np.where(codes > top, np.nan, packed["lo"] + (packed["hi"] - packed["lo"]) * codes / top)


@pytest.mark.parametrize("kind", ["u8", "u16"])
def test_packing_errs_by_half_a_quantum_at_most_and_keeps_what_is_missing(kind: str) -> None:
    values = np.random.default_rng(1).normal(3.0, 40.0, 500)
    values[[7, 100]] = np.nan, np.inf
    there = np.isfinite(values)
    back = unpack(packing.pack(values, kind))
    assert np.isnan(back[~there]).all()
    # 1e-9: rounding of the few operations themselves
    allowed = np.ptp(values[there]) / packing.CODES[kind] / 2.0 * (1.0 + 1e-9)
    assert np.max(np.abs(back[there] - values[there])) <= allowed


def test_numbers_that_16_bits_do_not_resolve_are_packed_as_floats() -> None:
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-2)["kind"] == "u16"
    assert packing.pack_to(np.linspace(0.0, 100.0, 9), 1e-4)["kind"] == "f32"


def test_thinning_keeps_a_peak_of_one_row_near_its_instant() -> None:
    t = np.linspace(0.0, 10.0, 5001)
    values = np.zeros(5001)
    values[3217] = 5.0
    thin = packing.thin(values, 400)
    times = packing.thin_times(t, 400)
    assert len(thin) == len(times) <= 400
    # two points per interval: at most an interval away
    assert abs(times[np.argmax(thin)] - t[3217]) < packing.interval(5001, 400) * 0.002
    assert np.max(thin) == 5.0
    assert np.all(np.diff(times) > 0.0)


def test_each_part_of_the_length_shows_the_largest_value_in_it() -> None:
    # a peak of one point, 0.1 m wide, in parts of 1 m; the rope moves on by 40 m between the frames
    place = np.linspace(0.0, packing.ROPE_ROWS, 10 * packing.ROPE_ROWS + 1)
    values = np.zeros((2, place.size))
    values[0, 404] = values[1, 804] = 7.0
    picture = packing.over_length(values, [place, place], float(packing.ROPE_ROWS))
    assert picture[40, 0] == picture[80, 1] == 7.0
    assert np.count_nonzero(picture) == 2


WHERE = {"station.first": 0.0, "station.last": 1.0, "rope.length": 120.0}


def record(*columns: list[float]) -> Recording:
    """A record of stations with these values, one per second, of all quantities alike."""
    signals = {TIME: np.arange(float(len(columns[0])))}
    for k, column in enumerate(columns):
        for name in exposures.QUANTITIES:
            signals[f"station.{name}[{k + 1}]"] = np.array(column)
    return Recording(signals, dict.fromkeys(signals, "1"))


@cache
def winding() -> tuple[Recording, Recording]:
    """The 120 m rope wound by 90 m: what was recorded, and its table."""
    run = build("rope-120", {})
    read = {*exposures.STATION_SIGNALS, "left.fy", "right.fy", "loop.y"}
    rope = InProcessRope(rope_scene(run.rope_values, "draft"), read)
    recording = Host(rope, run.hoist, run.winding, run.coupling, run.gains).run().recording
    found = exposures.exposure(recording, rope.data().parameters)
    return recording, found


def test_cycles_are_those_of_the_example_of_astm_e1049() -> None:
    # figure 6 of the standard: cycles of 3 (a half), 4 (one and a half), 6 (a half), 8 (one) and 9 (a half), of which
    # those below a quarter of 9 are left out: none
    found = exposures.exposure(record([-2, 1, -3, 5, -1, 3, -4, 4, -2], [0.0] * 9), WHERE)
    assert_allclose(found["tension.range"], [9.0, 0.0])
    assert_allclose(found["tension.cycles"], [4.0, 0.0])
    extremes = [
        found[f"tension.{name}"][0] for name in ("least", "largest", "least_at", "largest_at")
    ]
    assert_allclose(extremes, [-4.0, 5.0, 6.0, 3.0])
    # by bins of their range: 3 and 4 from 2 on; 6, 8 and 9 from 5 on
    binned = {name: found[name][0] for name in exposures.bin_columns("torque") if found[name][0]}
    assert binned == {"torque.from_2": 2.0, "torque.from_5": 2.0}


def test_time_in_the_bend_is_that_above_half_the_sharpest() -> None:
    found = exposures.exposure(record([0, 0.6, 1, 0.4, 0], [0, 0, 0.4, 0, 0]), WHERE)
    assert_allclose(found["bent"], [2.0, 0.0])


def test_trips_to_and_fro_add_up_to_whole_cycles() -> None:
    up, down = (
        exposures.exposure(record(values, [0, 0, 0]), WHERE) for values in ([0, 2, 4], [4, 2, 0])
    )
    assert_allclose(up["torque.cycles"], [0.5, 0.0])
    both = exposures.joined_exposure([up, down, up, down])
    names = "torque.cycles", "torque.range", "s", "torque.from_2"
    assert_allclose(
        [both[name] for name in names], [[2.0, 0.0], [4.0, 0.0], [0.0, 120.0], [2.0, 0.0]]
    )


def test_a_vibration_in_a_trip_has_its_frequency_and_amplitude() -> None:
    t = np.arange(0.0, 40.0, 0.01)
    trip = 5000.0 * np.sin(np.pi * t / 40.0) ** 2
    columns = np.column_stack((trip + 7.0 * np.sin(2 * np.pi * 1.85 * t), trip, 0.0 * t))
    frequency, amplitude = strongest(spectra(t, columns))
    assert_allclose(frequency, [1.85, np.nan, np.nan])  # the line lies on one of the spectrum
    assert_allclose(amplitude, [7.0, 0.0, 0.0], rtol=1e-3)


def test_places_that_the_loop_passes_bend_once_in_a_winding_and_others_never() -> None:
    _, found = winding()
    # the loop's lowest point lies at (L - H) / 2 of the left end, H from 90 m to -90 m, and bends 1.5 m to either side
    s = found["s"]
    cycles = found["curvature.cycles"]
    assert_allclose(cycles[(s > 17.5) & (s < 102.5)], 1.0)
    assert_allclose(cycles[(s < 11.0) | (s > 109.0)], 0.0)


@pytest.mark.parametrize("station", [21, 41, 61])
def test_ranges_at_a_place_are_those_counted_by_hand(station: int) -> None:
    recording, found = winding()
    curvature = recording[f"station.curvature[{station}]"]
    k = station - 1
    # straight, bent once, straight again: the cycle is all that there is between its least and largest value
    assert_allclose(found["curvature.range"][k], curvature.max() - curvature.min(), rtol=1e-3)
    # the time above half the sharpest of all, sample by sample
    sharpest = max(
        float(recording[name].max()) for name in recording.signals if "curvature" in name
    )
    assert_allclose(
        found["bent"][k], 0.01 * np.count_nonzero(curvature > 0.5 * sharpest), rtol=1e-9
    )
    # the bend, of some 2.4 m above half its curvature, passes at the speed of the conveyances: more than half of 8 m/s
    assert 2.0 / 8.0 < found["bent"][k] < 3.0 / 4.0 + 0.2


@pytest.mark.parametrize("touched_at", [-0.5, 0.0, 0.5])
def test_a_touch_before_or_at_the_instant_0_matters_like_a_later_one(touched_at: float) -> None:
    """Of the time alone 0 could mean none: the clearance says whether there was a touch."""
    signals = {
        TIME: np.array([-1.0, 0.0, 1.0]),
        "loop.sideways": np.array([0.0, 0.0, 1.0]),
        "nearest.lining.clearance": np.array([0.3, -0.1, -0.1]),
        "nearest.lining.touched_at": np.array([0.0, touched_at, touched_at]),
        "nearest.floor.clearance": np.array([0.2, 0.1, 0.1]),
        "nearest.floor.touched_at": np.zeros(3),
    }
    assert (
        instant_to_show([RopeRecord(Recording(signals, {}), RopeData({}, {}, {}))], [])
        == touched_at
    )
