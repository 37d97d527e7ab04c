"""What the commands do: numbers have a status, folders are named that cannot be, values and columns are set by name."""

import argparse
import csv
import logging
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from checkout import EXAMPLES
from pydantic import TypeAdapter
from rope_groups import rope_in_process
from shared import Capture, Patch

from hoist_demo.cases.case import BUILTIN_HOISTS, HOISTS
from hoist_demo.cases.run_values import ParameterValues
from hoist_demo.cases.table import NATIVE_ENDING, find_case, fmu_name
from hoist_demo.command_line import wind
from hoist_demo.command_line.main import main
from hoist_demo.command_line.options import settings
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of, rope_scene
from hoist_demo.files.registry import parameters, rope_parameters
from hoist_demo.files.values import read_value
from hoist_demo.files.values import statuses as file_statuses
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.time_series import match_signals
from hoist_demo.run import probe
from hoist_demo.run.data import build, contradictions
from hoist_demo.run.provenance import (
    STATUSES,
    SourcedValue,
    host_provenance,
    rope_provenance,
    statuses,
)
from rope_model import Level

pytestmark = pytest.mark.usefixtures("plain_figures", "no_figures")

SHORT = "[fixed]\nwinding.travel = 1.0\nwinding.settle = 1.0\nmodel.fidelity = 2\n"


def known(name: str, given: dict[str, str]) -> list[SourcedValue]:
    rope = rope_data_of(rope_scene(find_case(name).rope))
    return [
        *host_provenance(build(name, {}), given),
        *rope_provenance(find_case(name), rope, given),
    ]


@pytest.mark.parametrize("name", BUILTIN_HOISTS)
def test_every_number_of_a_case_has_a_status(name: str) -> None:
    data = known(name, {})
    assert {one.status for one in data} <= {*STATUSES}
    found = statuses(data)
    assert len(found) == len(data)
    # what a hoist's source states are numbers of the hoist
    stated = {
        key for key, status in find_case(name).status_by_name.items() if status == "published"
    }
    assert {key for key, status in found.items() if status == "published"} == stated


def test_the_published_pair_is_published_and_what_is_ours_is_assumed() -> None:
    found = statuses(known("rope-120", {}))
    assert {found[name] for name in ("rope.Qb", "rope.Qc", "rope.length")} == {"published"}
    ours = (
        "rope.EI",
        "hoist.sheave_mass",
        "left.swivel.mu_static",
        "contact.friction",
        "gains.speed",
        "air.drag",
    )
    assert {found[name] for name in ours} == {"assumed"}
    assert {found[name] for name in ("solver.step_max", "coupling.step", "lining.width")} == {
        "setting"
    }
    # of installed size the coupling is ours
    assert statuses(known("kiruna-355", {}))["rope.Qb"] == "assumed"
    assert statuses(known("kiruna-355", {}))["hoist.sheave_radius"] == "published"


def test_what_is_set_is_given_or_what_its_file_says(tmp_path: Path) -> None:
    file = tmp_path / "rope.toml"
    file.write_text(
        '[known]\nbending_stiffness = { low = 1, high = 2, status = "calibrated" }\n[fixed]\nrope.EI = 1\n'
    )
    table = {
        "from": str(file),
        "rope": {"Qd": 900.0},
        "hoist": {"payload_left": {"value": 1e3, "status": "measured"}},
    }
    found = file_statuses(TypeAdapter(ParameterValues).validate_python(table))
    wanted = {"rope.EI": "calibrated", "rope.Qd": "given", "hoist.payload_left": "measured"}
    assert found == wanted
    assert wanted.items() <= statuses(known("rope-120", found)).items()


_FILES = {
    "duty": f"[duty]\nlevel = 'draft'\n{SHORT}[[trip]]\nwinding.travel = 1.0\n[[trip]]\nwinding.travel = -1.0\n",
    "wind": "name = 'two'\nlike = 'rope-120'\nlevel = 'draft'\nwinding.travel = 1.0\nwinding.settle = 0.5\n"
    "[[rope]]\nz = 0.5\n[[rope]]\nz = -0.5\nEI = 80.0\n",
    "uncertain": "[uncertain]\nlevel = 'draft'\nsamples = 8\nmeasures = ['rope_force_ripple']\n"
    "[rope]\nconstruction = '34x7'\ndiameter = 0.044\n[known]\nmass_per_length = 7.7\n"
    f"axial_stiffness = 9e7\ntorsional_stiffness = 40.0\ntorque_factor = 0.0\n{SHORT}",
    "identify": "[rope]\nconstruction = '34x7'\ndiameter = 0.046\nlength = 120.0\n"
    "[[measured]]\nwhat = 'loop width'\nvalue = 3.05\nsigma = 0.05\n",
}
_SAID = {
    "duty": "winding.travel",
    "wind": "rope2.rope.EI",
    "uncertain": "rope.EI",
    "identify": "rope.EI",
}


@pytest.mark.parametrize("command", _FILES)
def test_commands_say_whence_numbers_are(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file.toml"
    out = tmp_path / "out"
    file.write_text(_FILES[command])
    words = [command, str(file), "--out", str(out)]
    if command == "uncertain":
        words += ["--workers", "1"]
    assert main(words) == 0
    said = capsys.readouterr().out
    if command == "wind":
        said = (out / "report.md").read_text(encoding="utf-8")
    assert "Data that this rests on, by status" in said
    with (out / "data.csv").open(encoding="utf-8", newline="") as table:
        rows = {row["name"]: row["status"] for row in csv.DictReader(table)}
    assert rows[_SAID[command]] == {"wind": "given", "identify": "calibrated"}.get(
        command, "varied"
    )
    assert set(rows.values()) <= {*STATUSES}
    if command in ("uncertain", "identify"):
        assert "Data that this rests on, by status" in (out / "report.html").read_text(
            encoding="utf-8"
        )


FILES = EXAMPLES
COMMANDS = {
    "wind": ["wind", "--in-process"],
    "duty": ["duty", str(FILES / "duties" / "day.toml")],
    "several": ["wind", str(FILES / "hoists" / "four_ropes.toml")],
    "identify": ["identify", str(FILES / "measurements" / "example.toml")],
    "uncertain": ["uncertain", str(FILES / "uncertain" / "rope-120.toml")],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere" / "results")
    for below, why in (("file", "Not a directory"), ("link", "No such file or directory")):
        out = tmp_path / below / "results"
        assert main([*COMMANDS[name], "--out", str(out)]) == 2
        last = capsys.readouterr().err.splitlines()[-1]
        assert last == f"balance-rope: {out} cannot be written to ({why}): choose another --out"


@pytest.mark.parametrize("name", [*COMMANDS, "study", "export"])
def test_no_name_is_not_the_folder_one_stands_in(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([*COMMANDS.get(name, [name]), "--out", ""])
    assert "argument --out: '' names nothing" in capsys.readouterr().err


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
def test_a_value_has_its_parameters_type_and_a_choice_its_word(
    given: str, name: str, value: object
) -> None:
    assert settings([given], KNOWN) == {name: value}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("rope.EI", r"--set rope\.EI must be NAME=VALUE"),
        ("rope.EI=stiff", r"rope\.EI = 'stiff' must be a finite number, with a unit .* N\.m2"),
        ("rope.IE=1", r"rope\.IE is not a parameter: did you mean rope\.EI"),
        (
            "model.fidelity=7",
            r"model\.fidelity = 7 must be one of 0 \(auto\), 1 \(torsional\), .*: give code",
        ),
        (
            "right.swivel.mode=sticky",
            r"mode = 'sticky' must be one of 0 \(locked\), 1 \(free\), 2 \(coulomb\)",
        ),
        (
            "winding.emergency_law=brake",
            r"must be one of drive, deceleration, torque, two-stage: choose one",
        ),
        ("hoist.head_rope_number=2.5", r"hoist\.head_rope_number = 2\.5 must be a whole number"),
        ("inputs_at_step_end=true", "inputs_at_step_end is not a parameter: the host sets it"),
    ],
)
def test_what_cannot_be_set_is_named(given: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        settings([given], KNOWN)


def test_a_hoist_and_a_rope_that_contradict_each_other_are_told_with_both_values() -> None:
    for case in map(find_case, HOISTS):
        assert contradictions(case.hoist, case.rope) == ""
    said = contradictions(Hoist(), {"rope.mass_per_length": 12.0, "rope.length": 120.0})
    assert said.startswith(
        "rope.mass_per_length = 12 kg/m and hoist.tail_rope_mass = 8 kg/m contradict each other"
    )
    assert "rope.length" not in said


def test_signals_are_found_by_name_and_by_star_in_the_order_asked_for() -> None:
    known = ["left.fy", "loop.x", "loop.y", "shape.x[1]", "shape.x[2]"]
    assert match_signals(["loop.*", "left.fy", "loop.x"], known) == ("loop.x", "loop.y", "left.fy")
    assert match_signals(["shape.x[1]"], known) == ("shape.x[1]",)
    with pytest.raises(
        ValueError, match=r"signals has 'loop\.z', which nothing shows: did you mean loop\.[xy]"
    ):
        match_signals(["loop.z"], known)


def test_a_demo_winds_with_what_is_set_and_writes_the_signals_asked_for(
    tmp_path: Path, monkeypatch: Patch
) -> None:
    chosen = ["--set", "rope.mass_per_length=16", "--set", "hoist.payload_left=4000"]
    assert main([*DEMO, *chosen, "--out", str(tmp_path), "--signals", "*.fy", "drive.torque"]) == 0
    recording = pd.read_csv(tmp_path / "signals.csv")
    assert [*recording] == ["time [s]", "left.fy [N]", "right.fy [N]", "drive.torque [N.m]"]
    # the rope's own is half of it
    assert recording["left.fy [N]"][0] + recording["right.fy [N]"][0] == pytest.approx(
        -16 * 9.81 * 120.0, rel=1e-3
    )
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "| hoist.payload_left | 4000 | kg | 5000 |" in text
    # a run that stops keeps the report
    monkeypatch.setattr(wind, "interruption", lambda *_: nullcontext(lambda: True))
    assert main([*DEMO, "--out", str(tmp_path)]) == 130
    assert (tmp_path / "report.md").read_text(encoding="utf-8") == text
    assert "Stopped" in (tmp_path / "stopped" / "report.md").read_text(encoding="utf-8")


def test_a_run_is_gone_on_with_whose_hoist_is_a_file(
    tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    file = tmp_path / "own.toml"
    asked = iter(range(99))
    out = ["--out", str(tmp_path / "out")]
    file.write_text(
        "name = 'own'\nlike = 'rope-120'\nhoist.payload_left = 4321.0\n", encoding="utf-8"
    )
    with monkeypatch.context() as patch:
        patch.setattr(wind, "interruption", lambda *_: nullcontext(lambda: next(asked) > 60))
        assert main([*DEMO, str(file), *out]) == 130
    assert (
        f"the same command with --resume {tmp_path / 'out' / 'last_good.npz'} goes on"
        in capsys.readouterr().err
    )
    assert main([*DEMO, "--resume", str(tmp_path / "out" / "last_good.npz"), *out]) == 0
    assert "| hoist.payload_left, payload in the left conveyance | 4321 | kg |" in (
        tmp_path / "out" / "report.md"
    ).read_text(encoding="utf-8")


@pytest.mark.parametrize("heard", ["never", "in the run", "while writing"])
def test_an_interrupt_is_130_whenever_it_comes_and_says_what_is_kept(
    tmp_path: Path, monkeypatch: Patch, capsys: Capture, heard: str
) -> None:
    def interruption(doing: str = "") -> nullcontext[Callable[[], bool]]:
        place = "in the run"
        if doing:
            place = "while writing"
        return nullcontext(lambda: heard == place)

    monkeypatch.setattr(wind, "interruption", interruption)
    code = main([*DEMO, "--out", str(tmp_path)])
    told = capsys.readouterr().err
    assert code == {"never": 0, "in the run": 130, "while writing": 130}[heard]
    assert ("balance-rope: interrupted: t = " in told) == (heard == "in the run")
    words = f"interrupted when the run was over: all its results are in {tmp_path}"
    assert (words in told) == (heard == "while writing")


def test_a_hoist_takes_no_other_s_fmu(tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "build").mkdir()
    # with what a study exported there, the report would lack what that does not show
    (tmp_path / "build" / fmu_name("rope-120", NATIVE_ENDING)).write_bytes(b"no FMU")
    (tmp_path / "mine.toml").write_text('name = "mine"\nlike = "rope-120"\n[[rope]]\n')
    assert [
        main(["wind", hoist, "--check"]) for hoist in ("rope-120", "rope-240", "mine.toml")
    ] == [2, 0, 0]
    assert fmu_name("monopol-1000", NATIVE_ENDING) != fmu_name("rope-120", NATIVE_ENDING)


def test_the_fmu_that_is_wound_is_the_given_one_or_the_default_that_exists(tmp_path: Path) -> None:
    given = tmp_path / "given.fmu"
    default = tmp_path / "default.fmu"
    in_process = argparse.Namespace(fmu=None, in_process=True)
    left_open = argparse.Namespace(fmu=None, in_process=False)
    assert wind._chosen_fmu(argparse.Namespace(fmu=given, in_process=False), default) == given
    assert wind._chosen_fmu(left_open, default) is None
    default.touch()
    assert wind._chosen_fmu(left_open, default) == default
    assert wind._chosen_fmu(in_process, default) is None
    assert left_open == argparse.Namespace(fmu=None, in_process=False)


def test_an_error_shows_its_place_with_verbose_alone(caplog: pytest.LogCaptureFixture) -> None:
    shown = []
    for level in (logging.WARNING, logging.INFO):
        with caplog.at_level(level):
            assert main(["show", "no such hoist"]) == 2
        shown.append("Traceback" in caplog.text)
    assert shown == [False, True]


def test_a_level_that_is_not_wound_is_told(
    tmp_path: Path, fmu_of: Callable[[str], Path], capsys: Capture
) -> None:
    file = tmp_path / "own.toml"
    written = tmp_path / "out" / "hoist.toml"
    file.write_text("name = 'own'\nlike = 'rope-120'\nlevel = 'reference'\n", encoding="utf-8")
    short = ["--quick", "--travel", "0.5", "--out", str(tmp_path / "out")]
    assert main(["wind", str(file), "--fmu", str(fmu_of("draft")), *short]) == 0
    assert "level = 'reference' of" in capsys.readouterr().err
    # what was wound is what the file beside the results says, which leaves nothing to another level
    assert 'level = "draft"' in written.read_text(encoding="utf-8")
    assert main(["wind", str(written), "--level", "standard", *short]) == 0
    assert "--level standard changes nothing" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "told"),
    [
        # fixed: the state has it itself; tunable: the host keeps it beside the state
        ("rope.EI", r"rope\.EI = 300\.0 must be 450\.0"),
        ("left.swivel.mu_static", r"left\.swivel\.mu_static is 300\.0 there, 450\.0 here"),
    ],
)
def test_a_state_is_not_taken_up_by_a_rope_of_other_parameters(
    name: str, told: str, tmp_path: Path
) -> None:
    trip = Winding(travel=0.5, settle=0.0, start_delay=0.0)
    ropes = [
        rope_in_process("rope-120", level="draft", parameters={name: value})
        for value in (300.0, 450.0)
    ]
    stopped = Host(ropes[0], Hoist(), trip).run(lambda fraction, t: t < 0.1, tmp_path / "kept.npz")
    assert stopped.saved is not None
    with pytest.raises(ValueError, match=told):
        Host(ropes[1], Hoist(), trip).run(resume=Checkpoint.read(stopped.saved))


@pytest.mark.parametrize(
    ("name", "level"),
    [("rope-120", "standard"), ("rope-120", "draft"), ("kiruna-355", "reference")],
)
def test_a_hoist_is_not_wound_with_the_fmu_of_another(
    name: str, level: Level, monkeypatch: Patch
) -> None:
    run = build(name, {})
    own = rope_data_of(rope_scene(find_case(name).rope, level)).parameters
    exported = {key: replace(p, start=own[key]) for key, p in rope_parameters().items()}
    # what the hoist states is set in the FMU, and the level is the export's
    stated = {"rope.length": replace(exported["rope.length"], start=77.0)}
    monkeypatch.setattr(probe, "read_parameters", lambda _: exported | stated)
    probe.FmuProbe(Path("own.fmu")).require_hoist(run)
    # values that this hoist leaves at their defaults
    beside = {
        "divider_1.size": replace(exported["divider_1.size"], start=0.2),
        "model.fidelity": replace(exported["model.fidelity"], start=3),
    }
    monkeypatch.setattr(probe, "read_parameters", lambda _: exported | beside)
    with pytest.raises(
        ValueError, match=rf"'other.fmu' must be of this hoist, '{name}', but 2 of its values"
    ) as error:
        probe.FmuProbe(Path("other.fmu")).require_hoist(run)
    assert "divider_1.size is 0.2 there, 0.0 here" in str(error.value)
    assert f"balance-rope export {name}" in str(error.value)


def test_new_remarks_on_values_that_no_hoist_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["new", "x", "--out", str(tmp_path / "x.toml"), "--depth", "1040"]
    assert main([*asked, "--payload", "32", "--speed", "18 m/min"]) == 0
    said = capsys.readouterr().err
    assert (
        "winding.speed = 0.3 m/s is far from what hoists have, 1 to 25 m/s [assumed]: check its unit"
        in said
    )
    assert "hoist.payload_left = 32 kg is far from what hoists have" in said
    file = tmp_path / "wide.toml"
    file.write_text(
        "name = 'w'\nlike = 'rope-120'\nhoist.sheave_radius = 2.75\nlayout.spacing = 2.4\n"
    )
    assert main(["show", str(file)]) == 0
    said = capsys.readouterr().err
    assert (
        "2.4 m apart beside a sheave of 5.5 m diameter; 2.75 m or more is usual without deflection sheaves"
        in said
    )
    # 2.543 (300 / (8 9.81))^(1/3)
    assert "less than the width of its free loop, 2.543 (EI/(rho g))^(1/3) = 3.976 m" in said


def test_numbers_as_they_are_written_elsewhere_are_taken_or_explained() -> None:
    by_name = parameters()
    assert read_value(by_name["hoist.torque_limit"], "2000 kNm") == 2e6
    assert read_value(by_name["hoist.drive_shaft.stiffness"], "53 MNm/rad") == 5.3e7
    assert read_value(by_name["rope.rhoJ"], "2 kgm") == 2.0
    with pytest.raises(
        ValueError,
        match=r"'1040,5' has a comma within its number: write a point .* 1040\.5 or 10405",
    ):
        read_value(by_name["hoist.shaft_travel"], "1040,5")
