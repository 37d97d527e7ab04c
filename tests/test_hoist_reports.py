"""What a report says of a run: the rope it was made with, what its fidelity leaves out, and what to be warned of."""

import hashlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from exports import FLAVOURS

from hoist_demo.command_line.results import interruption
from hoist_demo.recording.fidelity import FIDELITY, code_of, fidelities_of, mask_neglected, remark, without_remarked
from hoist_demo.recording.time_series import Recording
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


@pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
@pytest.mark.parametrize("fmi", [pytest.param("2", marks=pytest.mark.slow), "3"])
def test_a_demo_s_reports_state_rope_file_version_level_and_fidelity(fmi: str, tmp_path: Path) -> None:
    export, demo = ([sys.executable, "-m", "balance_rope", name] for name in ("export", "demo"))
    fmu, out = tmp_path / "mine.fmu", tmp_path / "out"

    (scratch := tmp_path / "scratch").mkdir()

    def run(command: list[str]) -> str:
        where = os.environ | {"TMPDIR": str(scratch)}
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False, env=where)
        assert done.returncode == 0, done.stderr
        return done.stdout

    run([*export, "--native", "--fmi", fmi, "--platform", "host", "--level", "draft", "--out", str(fmu)])
    said = run([*demo, "--fmu", str(fmu), "--travel", "0.5", "--quick", "--out", str(out)])
    title = f"Winding 0.5 m: case rope-120, balance rope in the FMU mine.fmu, FMI {fmi}.0"
    assert said.startswith(f"{title}\n")
    for name in ("report.md", "report.html"):
        text = (out / name).read_text(encoding="utf-8")
        assert hashlib.sha256(fmu.read_bytes()).hexdigest() in text
        assert [word for word in (title, "draft", "planar", "rope.EI", "hoist.sheave_mass") if word not in text] == []
    assert not any(scratch.iterdir()), "what is unpacked goes with the process"
    # the table holds the rope's own fidelity, and no zero where nothing was computed
    header, first = (out / "signals.csv").read_text(encoding="utf-8").splitlines()[:2]
    assert dict(zip(header.split(","), first.split(","), strict=True))["loop.yaw [rad]"] == "nan"


def test_an_interrupt_lets_the_writing_finish(capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruption("writing") as interrupted:
        os.kill(os.getpid(), signal.SIGINT)
        finished = True
    assert finished
    assert interrupted()
    assert "writing" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is before
