"""What a report says of a run: the rope it was made with, what its fidelity leaves out, and what to be warned of."""

import hashlib
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from exports import FLAVOURS

from balance_rope import main
from hoist_demo.command_line import results
from hoist_demo.command_line.results import hear_hang_ups, interruption
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.fidelity import FIDELITY, code_of, fidelities_of, mask_neglected, remark, without_remarked
from hoist_demo.recording.incidents import SIDES, Stop, stops
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.verdict import judge
from rope_model import neglected_text

ROOT = Path(__file__).parents[1]


def recording(*fidelities: str) -> Recording:
    signals = {"time": np.arange(float(len(fidelities))), FIDELITY: np.array([code_of(one) for one in fidelities])}
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
    shown = mask_neglected(recording(fidelity), torque_free=False)
    assert {name for name, values in shown.signals.items() if np.isnan(values).any()} == missing
    assert bool(remark(shown)) == bool(missing)


def test_a_run_that_goes_on_with_a_higher_fidelity_is_shown_from_there_on() -> None:
    shown = mask_neglected(recording("planar", "planar", "torsional"), torque_free=False)
    assert np.isnan(shown["loop.yaw"]).tolist() == [True, True, False]
    assert fidelities_of(shown) == ["planar", "torsional"]
    assert "ran as its planar model between t = 0 and 1 s, which" in remark(shown)
    assert without_remarked([neglected_text("planar"), "other"], shown) == ["other"]


#: what is recorded, parameters of the rope, and the row of the verdict: its value and whether the bound is kept
VERDICTS = [
    # three ropes of 1 to 2 kN, known within 2 N each
    ({"left.fy": [-1e3, -2e3], "status.end_force_error": [0, 1e-3]}, {}, "pull of all 3", "3.00 to 6.00 kN", True),
    ({"right.fy": [-1e3, 50.0]}, {}, "pull of all 3", "-0.15 to 3 kN", False),
    ({"loop.turns": [0.1, -0.55]}, {}, "turns", "0.55", False),
    ({"loop.turns": [0.1, -0.2]}, {"guard.turns": 0.15}, "turns", "0.2", False),
    ({"loop.sideways": [0.0, 1.234567], "status.loop_error": [0, 5e-3]}, {}, "sideways", "1.23 m", None),
    ({"drive.pull_left": [9e3, 0.0]}, {}, "smallest pull of the head ropes, left", "0 kN", False),
    ({"loop.sideways": [0.0, 1.2]}, {"guard.window": 1.5}, "sideways", "1.2 m", True),
    ({"nearest.divider.clearance": [1.0, 0.2]}, {"guard.clearance": 0.3}, "clearance from a divider", "0.2 m", False),
    ({"status.loop_error": [0, 5e-3]}, {"accuracy.loop": 0.01}, "estimated error of the loop", "5 mm", True),
    # exp(0.25 pi) = 2.193: (2.193 - 1) / (1.5 - 1) at rest, 1.193 / 1.2 while it winds
    ({"drive.tension_ratio": [1.5, 2.2]}, {}, "slip safety at rest", "2.39", True),
    ({"drive.tension_ratio": [1.5, 2.2]}, {}, "slip safety in normal", "0.99", False),
]


@pytest.mark.parametrize(("signals", "parameters", "row", "value", "kept"), VERDICTS)
def test_the_verdict_has_each_number_with_its_digits_beside_its_bound(signals, parameters, row, value, kept) -> None:
    record = Recording({"time": np.array([0.0, 1.0])} | {name: np.array(x) for name, x in signals.items()}, {})
    ended = SimpleNamespace(recording=record, completed=True, cause="", warning="", winding=Winding())
    verdict = judge(ended, Hoist(tail_rope_number=3), [RopeData({}, parameters, {})])
    (found,) = [one for one in verdict.rows if one.quantity.startswith(row)]
    assert (found.value, found.holds) == (value, kept)
    assert (found.quantity in verdict.words) == (kept is False)


def test_an_emergency_stop_is_told_by_each_conveyance_s_own_way() -> None:
    left = np.array([[0.0, 8.0, 12.0, 13.0], [8.0, 6.0, 2.0, -0.1]])
    record = {f"conveyance.{side}.{name}": x for side in SIDES for name, x in zip(("y", "vy"), left, strict=True)}
    assert stops(Recording({"time": np.arange(10.0, 14.0), **record}, {}), 1.0) == [Stop(s, 5.0, 2.0) for s in SIDES]
    record["conveyance.right.vy"] = -np.ones(4)
    assert stops(Recording({"time": np.arange(4.0), **record}, {}), 1.0)[1].time is None


@pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
@pytest.mark.parametrize("fmi", [pytest.param("2", marks=pytest.mark.slow), "3"])
def test_a_demo_s_reports_state_rope_file_version_level_and_fidelity(fmi: str, tmp_path: Path) -> None:
    fmu, out = tmp_path / "mine.fmu", tmp_path / "out"
    (scratch := tmp_path / "scratch").mkdir()
    export = ["export", "--native", "--fmi", fmi, "--platform", "host", "--level", "draft", "--out", str(fmu)]
    assert main(export) == 0
    demo = ["demo", "--fmu", str(fmu), "--travel", "0.5", "--quick", "--out", str(out)]
    command, where = [sys.executable, "-m", "balance_rope", *demo], os.environ | {"TMPDIR": str(scratch)}
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False, env=where)
    assert done.returncode == 0, done.stderr
    title = "Published rope of 120 m: the left conveyance 0.5 m up at up to 8 m/s"
    assert done.stdout.startswith(f"{title}\n")
    for name in ("report.md", "report.html"):
        text = (out / name).read_text(encoding="utf-8")
        assert hashlib.sha256(fmu.read_bytes()).hexdigest() in text
        assert [word for word in (title, "draft", "planar", "rope.EI", "hoist.sheave_mass") if word not in text] == []
    assert not any(scratch.iterdir()), "what is unpacked goes with the process"
    # the table holds the rope's own fidelity, and no zero where nothing was computed
    header, first = (out / "signals.csv").read_text(encoding="utf-8").splitlines()[:2]
    assert dict(zip(header.split(","), first.split(","), strict=True))["loop.yaw [rad]"] == "nan"


@pytest.mark.parametrize(
    "name", ["SIGINT", pytest.param("SIGHUP", marks=pytest.mark.skipif(os.name == "nt", reason="none"))]
)
def test_an_interrupt_and_a_closed_terminal_let_the_writing_finish(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(results, "silence", lambda: None)
    hear_hang_ups()
    with interruption("writing") as interrupted:
        os.kill(os.getpid(), getattr(signal, name))
        finished = True
    assert finished
    assert interrupted()
    assert "writing" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is before
