"""The FMU adapter against a rope of known weight, built here with pythonfmu and run in a process of its own.

A process of its own, because a loaded FMU shares Python with the test otherwise and cannot be unloaded cleanly.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("pythonfmu")

SLAVE = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String


class HangingWeight(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.inputs_at_step_end = False
        self.label = ""
        self.number = 0
        self.weight = 78.48
        self.fails_at = 1e9
        self.steps = 0
        self.valid = True
        self.message = ""
        self.values = {}
        fixed = dict(causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)
        self.register_variable(Boolean("inputs_at_step_end", start=False, **fixed))
        self.register_variable(String("label", start="", **fixed))
        self.register_variable(Integer("number", start=0, **fixed))
        self.register_variable(Real("weight", start=78.48, **fixed))
        self.register_variable(Real("fails_at", start=1e9, **fixed))
        for end in ("left", "right"):
            for name in "x y z vx vy vz ax ay az yaw yaw_rate".split():
                self._real(f"{end}.{name}", Fmi2Causality.input)
            for name in ("fy", "fy_mean", "added_mass"):
                self._real(f"{end}.{name}", Fmi2Causality.output)
        # what a scene gives its rope
        for name in ("rope.length", "left.swivel.release_time", "right.swivel.release_time"):
            self._real(name, Fmi2Causality.parameter)
        for name in ("left.swivel.mode", "right.swivel.mode"):
            self.values[name] = 0
            get, put = (lambda n=name: self.values[n]), (lambda value, n=name: self.values.__setitem__(n, value))
            self.register_variable(Integer(name, start=0, getter=get, setter=put, **fixed))
        out = dict(causality=Fmi2Causality.output, variability=Fmi2Variability.discrete)
        self.register_variable(Integer("count.steps", getter=lambda: self.steps, **out))
        self.register_variable(Boolean("status.valid", getter=lambda: self.valid, **out))
        self.register_variable(String("status.message", getter=lambda: self.message, **out))

    def _real(self, name, causality):
        self.values[name] = 0.0
        start = {} if causality == Fmi2Causality.output else {"start": 0.0}
        fixed = causality == Fmi2Causality.parameter
        variability = Fmi2Variability.fixed if fixed else Fmi2Variability.continuous
        self.register_variable(
            Real(
                name,
                causality=causality,
                variability=variability,
                getter=lambda: self.values[name],
                setter=lambda value: self.values.__setitem__(name, value),
                **start,
            )
        )

    def _hang(self):
        bottom = (self.values["left.y"] + self.values["right.y"] - 120.0) / 2.0
        for end in ("left", "right"):
            force = -self.weight * (self.values[end + ".y"] - bottom)
            self.values[end + ".fy"] = self.values[end + ".fy_mean"] = force

    def exit_initialization_mode(self):
        self._hang()
        self.message = f"{self.inputs_at_step_end} {self.label} {self.number}"

    def do_step(self, t, h):
        self.steps += 1
        self._hang()
        if t > self.fails_at:
            self.valid, self.message = False, "the loop has turned over"
        return True
"""

HEAD = """
import sys
from pathlib import Path
import numpy as np
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.host import Host
from hoist_demo.parameters import Winding
from hoist_demo.cosimulation.participants.rope_plant import EndMotion
path = Path(sys.argv[1])
"""


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmu")
    (folder / "hanging_weight.py").write_text(SLAVE, encoding="utf-8")
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", "hanging_weight.py"]
    subprocess.run(build, cwd=folder, check=True, capture_output=True, timeout=60)
    return folder / "HangingWeight.fmu"


def _in_process_of_its_own(code: str, fmu: Path) -> None:
    scratch = fmu.parent / "scratch"
    scratch.mkdir(exist_ok=True)
    done = subprocess.run(
        [sys.executable, "-c", HEAD + code, str(fmu)],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "TMPDIR": str(scratch), "TMP": str(scratch)},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == "", "library code must not print"
    assert not any(scratch.iterdir()), "what is unpacked goes with the process"


def test_forces_counts_and_status_come_back_by_name(fmu: Path) -> None:
    _in_process_of_its_own(
        """
rope = FmuRope(path, {"label": "ours", "number": 7, "weight": 10.0})
status = rope.initialize(2.0, EndMotion(y=0.0), EndMotion(y=90.0))
assert status.valid, status
assert status.message == "", status
assert rope.signals()["right.fy"] == -1050.0
assert rope.step(2.0, 0.01, EndMotion(y=1.0), EndMotion(y=89.0)).valid
signals = rope.signals()
assert (signals["left.fy"], signals["count.steps"], signals["status.valid"]) == (-160.0, 1.0, 1.0), signals
assert set(rope.units()) == set(signals)
assert "left.added_mass" not in signals, "costly outputs are not read"
rope.close()
rope.close()
""",
        fmu,
    )


def test_a_whole_winding_runs_with_the_fmu_and_stops_when_status_valid_falls(fmu: Path) -> None:
    _in_process_of_its_own(
        """
rope = FmuRope(path)
result = Host(rope, winding=Winding(travel=2.0)).run()
rope.close()
assert result.completed, result.cause
np.testing.assert_allclose(result.recording["conveyance.left.y"][-1], 2.0, rtol=0, atol=1e-3)
rope = FmuRope(path, {"fails_at": 1.505})
result = Host(rope, winding=Winding(travel=2.0)).run()
rope.close()
assert not result.completed
assert "the loop has turned over" in result.cause, result.cause
assert result.steps == 151, result.steps
""",
        fmu,
    )


def test_an_unknown_parameter_is_named(fmu: Path) -> None:
    _in_process_of_its_own(
        """
try:
    FmuRope(path, {"weigth": 1.0})
except ValueError as error:
    assert "weigth" in str(error), error
else:
    raise AssertionError("accepted")
""",
        fmu,
    )


def test_a_missing_fmu_is_an_error_that_names_the_cure(tmp_path: Path) -> None:
    from balance_rope import main

    assert main(["demo", "--fmu", str(tmp_path / "none.fmu")]) == 2


def test_the_command_writes_its_files_and_says_how_it_went(fmu: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "balance_rope", "demo", "--quick", "--travel", "1", "--fmu", str(fmu)]
    done = subprocess.run(
        [*command, "--out", str(tmp_path)],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "real-time factor" in done.stdout
    assert "assumed" in done.stdout
    assert done.stdout.splitlines()[-1] == f"open in a browser: {tmp_path / 'report.html'}"
    names = {path.name for path in tmp_path.iterdir()}
    assert {"signals.csv", "report.md", "report.html", "tracking.png", "forces.png"} <= names
    # this FMU has forces and no shape
    assert "exported without the outputs shape.*, station.*, loop.*" in done.stderr
    assert "shapes.csv" not in names
