"""`demo --set` and `--signals`: values and columns by name, errors that name them, and every message once."""

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pandas as pd
import pytest

from balance_rope import main
from hoist_demo.cases.table import CASES
from hoist_demo.command_line import wind
from hoist_demo.command_line.options import settings
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.files.catalogue import parameters
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.time_series import match_signals
from hoist_demo.study.run import contradictions

pytestmark = pytest.mark.usefixtures("plain_figures")
ROOT = Path(__file__).parents[1]
KNOWN = parameters()
DEMO = ["demo", "--in-process", "--quick", "--travel", "0.5", "--level", "draft"]


@pytest.mark.parametrize(
    ("given", "name", "value"),
    [
        ("rope.EI = 450", "rope.EI", 450.0),
        ("left.swivel.mode=coulomb", "left.swivel.mode", 2),
        ("right.swivel.mode=Coulomb", "right.swivel.mode", 2),
        ("model.fidelity=1", "model.fidelity", 1),
        ("winding.emergency_law=Two-Stage", "winding.emergency_law", "two-stage"),
        ("hoist.head_rope_number=6", "hoist.head_rope_number", 6),
        ("rope.Qb=-1e4", "rope.Qb", -1e4),
    ],
)
def test_a_value_has_its_parameters_type_and_a_choice_its_word(given: str, name: str, value: object) -> None:
    assert settings([given], KNOWN) == {name: value}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("rope.EI", r"--set rope\.EI must be NAME=VALUE"),
        ("rope.EI=stiff", r"rope\.EI = 'stiff' must be a finite number, with a unit .* N\.m2"),
        ("rope.IE=1", r"rope\.IE is not a parameter: did you mean rope\.EI"),
        ("model.fidelity=7", r"model\.fidelity = 7 must be one of 0 \(auto\), 1 \(torsional\), .*: give code"),
        ("right.swivel.mode=sticky", r"mode = 'sticky' must be one of 0 \(locked\), 1 \(free\), 2 \(coulomb\)"),
        ("winding.emergency_law=brake", r"must be one of drive, deceleration, torque, two-stage: choose one"),
        ("hoist.head_rope_number=2.5", r"hoist\.head_rope_number = 2\.5 must be a whole number"),
        ("inputs_at_step_end=true", "inputs_at_step_end is not a parameter: the host sets it"),
    ],
)
def test_what_cannot_be_set_is_named(given: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        settings([given], KNOWN)


def test_a_hoist_and_a_rope_that_contradict_each_other_are_told_with_both_values() -> None:
    for case in CASES.values():
        assert contradictions(case.hoist, case.rope) == ""
    said = contradictions(Hoist(), {"rope.mass_per_length": 12.0, "rope.length": 120.0})
    assert said.startswith("rope.mass_per_length = 12 kg/m and hoist.tail_rope_mass = 8 kg/m contradict each other")
    assert "rope.length" not in said


def test_signals_are_found_by_name_and_by_star_in_the_order_asked_for() -> None:
    known = ["left.fy", "loop.x", "loop.y", "shape.x[1]", "shape.x[2]"]
    assert match_signals(["loop.*", "left.fy", "loop.x"], known) == ("loop.x", "loop.y", "left.fy")
    assert match_signals(["shape.x[1]"], known) == ("shape.x[1]",)
    with pytest.raises(ValueError, match=r"signals has 'loop\.z', which nothing shows: did you mean loop\.[xy]"):
        match_signals(["loop.z"], known)


def test_a_demo_winds_with_what_is_set_and_writes_the_signals_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = ["--set", "rope.mass_per_length=16", "--set", "hoist.payload_left=4000"]
    assert main([*DEMO, *chosen, "--out", str(tmp_path), "--signals", "*.fy", "drive.torque"]) == 0
    recording = pd.read_csv(tmp_path / "signals.csv")
    assert [*recording] == ["time [s]", "left.fy [N]", "right.fy [N]", "drive.torque [N.m]"]
    # the rope's own is half of it
    assert recording["left.fy [N]"][0] + recording["right.fy [N]"][0] == pytest.approx(-16 * 9.81 * 120.0, rel=1e-3)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "| hoist.payload_left | 4000 | kg | 5000 |" in text
    # a run that stops keeps the report
    monkeypatch.setattr(wind, "interruption", lambda *_: nullcontext(lambda: True))
    assert main([*DEMO, "--out", str(tmp_path)]) == 1
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == text
    assert "Stopped" in (tmp_path / "stopped" / "report.md").read_text(encoding="utf-8")


def test_a_run_is_gone_on_with_whose_hoist_is_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file, asked, out = tmp_path / "own.toml", iter(range(99)), ["--out", str(tmp_path / "out")]
    file.write_text("name = 'own'\nlike = 'rope-120'\nhoist.payload_left = 4321.0\n", encoding="utf-8")
    with monkeypatch.context() as patch:
        patch.setattr(wind, "interruption", lambda *_: nullcontext(lambda: next(asked) > 60))
        assert main([*DEMO, str(file), *out]) == 1
    assert main([*DEMO, "--resume", str(tmp_path / "out" / "last_good.npz"), *out]) == 0
    assert "| hoist.payload_left | 4321 |" in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")


def test_a_level_that_the_fmu_has_not_is_told(
    tmp_path: Path, fmu_of: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "own.toml"
    file.write_text("name = 'own'\nlike = 'rope-120'\nlevel = 'reference'\n", encoding="utf-8")
    short = ["--quick", "--travel", "0.5", "--out", str(tmp_path / "out")]
    assert main(["wind", str(file), "--fmu", str(fmu_of("draft")), *short]) == 0
    assert "level = 'reference' of" in capsys.readouterr().err


def test_a_state_is_not_taken_up_by_a_rope_of_other_parameters(tmp_path: Path) -> None:
    trip = Winding(travel=0.5, settle=0.0, start_delay=0.0)
    ropes = [rope_in_process("rope-120", level="draft", parameters={"rope.EI": EI}) for EI in (300.0, 450.0)]
    stopped = Host(ropes[0], Hoist(), trip).run(lambda fraction, t: t < 0.1, tmp_path / "kept.npz")
    assert stopped.saved is not None
    with pytest.raises(ValueError, match=r"rope\.EI is 300\.0 there, 450\.0 here"):
        Host(ropes[1], Hoist(), trip).run(resume=Checkpoint.read(stopped.saved))
