"""Hoists' files: what they say, what follows, what is refused where, their JSON Schema, the complete file of a run."""

import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pandas as pd
import pytest
from checkout import ROOT
from numpy.testing import assert_allclose

from hoist_demo.cases.case import BUILTIN_HOISTS, FOLDER, Case
from hoist_demo.cases.hoist_file import HoistFile, schema
from hoist_demo.cases.rules import LENGTH, RULES, TAIL_SPARE, RuleInputs, case_with_values
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.main import main
from hoist_demo.design.hoist_checks import HoistCheck, checks
from hoist_demo.duty.schedule import read_schedule
from hoist_demo.files.reading import FileError, read
from hoist_demo.files.values import statuses as file_statuses
from hoist_demo.parameters import GRAVITY
from hoist_demo.report.hoist import check_in_words, consequences_text
from hoist_demo.run.complete_file import as_file, hoist_provenance
from hoist_demo.run.data import build, build_single_trip
from hoist_demo.run.ropes import ropes_of
from rope_model.scene_names import named_parameters

SHIPPED = [
    *(FOLDER / f"{n}.toml" for n in BUILTIN_HOISTS),
    *sorted((ROOT / "examples" / "hoists").glob("*.toml")),
]
OWN = """
name = "Own"
status = "data sheet"
[hoist]
shaft_travel = 870
payload_left = "22 t"
head_rope_number = 4
wrap_angle = "180 deg"
conveyance_mass = { value = 18.2, unit = "t", status = "measured", source = "scale", low = 18, high = 19 }
brake.torque = "1180 kN m"
[winding]
speed = "16 m/s"
start_delay = "500 ms"
[[rope]]
construction = "34x7"
diameter = "52 mm"
number = 2
swivels.mode = "coulomb"
right.swivel.mode = "locked"
"""


@cache
def checked() -> jsonschema.Draft202012Validator:
    """Checks files by the schema."""
    return jsonschema.Draft202012Validator(schema())


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_units_are_converted_to_the_last_bit_and_what_is_left_out_follows_by_rules(
    tmp_path: Path,
) -> None:
    case = read(
        written(tmp_path / "own.toml", f"\ufeff{OWN}"), HoistFile
    ).case  # with the mark of some editors
    hoist = case.hoist
    m = case.rope["rope.mass_per_length"]
    assert (hoist.payload_left, hoist.conveyance_mass, hoist.wrap_angle) == (
        22e3,
        18.2e3,
        3.141592653589793,
    )
    assert hoist.brake is not None
    assert (hoist.brake.torque, case.winding.start_delay, case.rope["rope.diameter"]) == (
        1.18e6,
        0.5,
        0.052,
    )
    assert (hoist.tail_rope_number, hoist.tail_rope_mass, hoist.tail_rope_length) == (
        2,
        m,
        870.0 + TAIL_SPARE,
    )
    assert (case.winding.travel, hoist.play) == (870.0, None)
    assert_allclose(hoist.rope_mass, 2.0 * float(m))
    assert_allclose(case.gains.speed, 3.0 * hoist.moving_mass)
    assert [case.rope[f"{side}.swivel.mode"] for side in ("left", "right")] == [2, 0]
    wanted = {
        "hoist.payload_left": "data sheet",
        "hoist.conveyance_mass": "measured",
        "gains.speed": "derived",
    }
    assert {key: case.status_by_name[key] for key in wanted} == wanted
    assert case.values["hoist.conveyance_mass"].source == "scale"
    assert case.remarks == ()


@pytest.mark.slow
def test_the_schema_of_files_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())


def test_a_new_hoist_reads_back_and_shows_what_statics_say(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my mine.toml"
    asked = [
        "--depth",
        "300m",
        "--payload",
        "8t",
        "--speed",
        "10",
        "--conveyance",
        "9 t",
        "--ropes",
        "2",
    ]
    assert main(["new", "mine", *asked, "--lay", "alternate", "--schema", "--out", str(path)]) == 0
    assert main(["new", "mine", *asked, "--out", str(path)]) == 2  # it is there
    assert main(["new", "equal", *asked, "--out", str(tmp_path / "equal.toml")]) == 0
    assert read(tmp_path / "equal.toml", HoistFile).case.hoist.tail_rope_number == 2
    case = read(path, HoistFile).case
    checked().validate(tomllib.loads(path.read_text(encoding="utf-8")))
    assert [case.status_by_name[f"hoist.{key}"] for key in ("payload_left", "brake.torque")] == [
        "given",
        "derived",
    ]
    torques = [rope.parameters["rope.Qc"] for rope in case.distinct_ropes]
    assert torques[0] == -torques[1] > 0.0
    assert f"balance-rope show '{path}'; balance-rope wind '{path}'" in capsys.readouterr().out
    assert main(["wind", str(path), "--check"]) == 0
    assert "`balance-rope check` judges the hoist" in capsys.readouterr().out
    assert main(["show", str(path)]) == 0
    said, warned = capsys.readouterr()
    assert "may touch" not in warned
    # the light side holds conveyance, head ropes or balance ropes: the same weight at either landing
    ropes = case.hoist.rope_mass * (300.0 + 40.0) + case.hoist.tail_mass * 20.0
    assert (
        f"{(17e3 + ropes) * GRAVITY / 1e3:.4g} and {(9e3 + ropes) * GRAVITY / 1e3:.4g} kN" in said
    )
    close = written(
        path, path.read_text(encoding="utf-8").replace("value = 0.3,", "value = -0.15,")
    )
    assert main(["show", str(close), "--set", "hoist.payload_left=5t"]) == 0
    said, warned = capsys.readouterr()
    assert all(
        text in said + warned
        for text in ("rope2, 0.15 m apart in z, may touch", "{ value = 5000.0")
    )
    # light payloads in heavy conveyances: these are what the motor moves
    asked = [
        "--depth",
        "600",
        "--payload",
        "1t",
        "--speed",
        "12",
        "--conveyance",
        "15t",
        "--out",
        str(path),
        "--force",
    ]
    assert main(["new", "man.toml", *asked]) == main(["check", str(path)]) == 0
    assert read(path, HoistFile).case.name == "man"
    limits = {"torque_limit": 4e4, "power_limit": 3e5, "brake.torque": 1e3}
    assert (
        main(
            ["check", str(path), *(f"--set=hoist.{name}={value}" for name, value in limits.items())]
        )
        == 1
    )
    told = capsys.readouterr().err
    assert all(f"hoist.{name} = {value:g} " in told for name, value in limits.items())
    assert main(["rope"]) == main(["rope", "34x7", "--diameter", "52mm"]) == 0


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_file_that_is_shipped_is_read_and_fits_the_schema(path: Path) -> None:
    assert read(path, HoistFile).case.name
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    # what a hoist is like may have the ropes
    checked().validate({"rope": [{}], **tables})


#: what is put behind a line of OWN, or instead of it; the message's beginning, and the path in the schema's error
WRONG: list[tuple[str, str, str, str]] = [
    ('name = "Own"', "", "name is missing: give it", ""),
    ('"data sheet"', '"sheet"', "status = 'sheet' must", "status"),
    (
        "[hoist]",
        "[hoist]\npaylaod_left = 3",
        "hoist.paylaod_left = 3 is not a key: did you mean",
        "hoist",
    ),
    (
        '"22 t"',
        '"22 kN"',
        "hoist.payload_left has unit = 'kN', which must measure the same as kg",
        "",
    ),
    (
        '"22 t"',
        '"22,1 t"',
        "hoist.payload_left = '22,1 t' has a comma within its number: write a point",
        "",
    ),
    ('"22 t"', "1" + "0" * 400, "must be a finite number", ""),
    (
        "brake.torque",
        "tail_rope_number = 3\nbrake.torque",
        "hoist.tail_rope_number = 3 must be 2",
        "",
    ),
    (
        '"22 t"',
        '"t 22"',
        "hoist.payload_left = 't 22' must be a finite number",
        "hoist/payload_left",
    ),
    ('"22 t"', "true", "hoist.payload_left = True must be a finite number", "hoist/payload_left"),
    ('"22 t"', "{ unit = 't' }", "has no value: write { value", ""),
    (
        "value = 18.2",
        "value = 17.9",
        "conveyance_mass = 17900 must be within low and high, 18000 to 19000",
        "",
    ),
    (
        '"22 t"',
        "{ value = 1, unti = 't' }",
        "is not a key: did you mean hoist.payload_left.unit",
        "hoist/payload_left",
    ),
    (
        '"22 t"',
        "{ value = 1, status = 'x' }",
        "payload_left.status = 'x' must be 'measured'",
        "hoist/payload_left",
    ),
    (
        '"22 t"',
        "{ value = 1, unit = 3 }",
        "payload_left.unit = 3 must be a text",
        "hoist/payload_left",
    ),
    (
        '"22 t"',
        "-5",
        "hoist.payload_left = -5 must be at least 0: give it in kg",
        "hoist/payload_left",
    ),
    (
        "head_rope_number = 4",
        "head_rope_number = 4.5",
        "rope_number = 4.5 must be a whole",
        "hoist/head_rope_number",
    ),
    ("brake.torque", "brake = 3 #", "hoist.brake = 3 must be one table", "hoist/brake"),
    ("brake.torque", "brake.torqe", "not a key: did you mean hoist.brake.torque", "hoist/brake"),
    ("shaft_travel = 870", "shaft_travel = nan", "hoist.shaft_travel = nan must be a finite", ""),
    (
        '"180 deg"',
        "190.0",
        "hoist.wrap_angle = 190.0 must be within 0.1 and 12.5664: give",
        "hoist/wrap_angle",
    ),
    ("[winding]", "[winding]\ntravel = 900", "travel = 900.0 must be within", ""),
    (
        "[winding]",
        "[winding]\nemergency_law = 'brake'",
        "'brake' must be one of drive",
        "winding/emergency_law",
    ),
    (
        "[winding]",
        "[wending]",
        "wending = {'speed': '16 m/s', 'start_delay': '500 ms'} is not a key",
        "",
    ),
    ("[[rope]]", "[rope]", "rope = {", "rope"),
    ('"34x7"', '"34x8"', "rope 1: construction = '34x8' is out of range", ""),
    (
        '"52 mm"',
        '"52 kg"',
        "rope 1: rope.diameter has unit = 'kg', which must measure the same as m",
        "",
    ),
    ('"52 mm"', "0.0", "rope 1: rope.diameter = 0.0 must be within", "rope/0/diameter"),
    ("number = 2", "number = 0", "rope 1 number = 0 must be greater", "rope/0/number"),
    ("number = 2", "name = 'a b'", "rope 1 name = 'a b' must match", "rope/0/name"),
    ("number = 2", "breaks_at = 3", "rope 1: breaks_at and breaks_s must stand together", ""),
    ("number = 2", "z = 'left'", "rope 1: rope.z = 'left' must be a finite number", "rope/0/z"),
    ("number = 2", "EJ = 3", "rope 1 EJ = 3 is not a key: did you mean rope.EI", "rope/0"),
    (
        "number = 2",
        "contact.friction = 1",
        "rope 1 contact = {'friction': 1} is not a key",
        "rope/0",
    ),
    ("number = 2", "from = 'none.toml'", "rope 1 from: ", ""),
    (
        '"coulomb"',
        '"kulomb"',
        "rope 1: rope.swivels.mode = 'kulomb' must be one of 0 (locked)",
        "rope/0/swivels/mode",
    ),
    (
        '"coulomb"',
        "7",
        "rope 1: rope.swivels.mode = 7 must be one of 0 (locked)",
        "rope/0/swivels/mode",
    ),
    (
        "[winding]",
        "[mesh]\nkind = 'fine'\n[winding]",
        "mesh.kind = 'fine' must be one of 0 (tmn)",
        "mesh/kind",
    ),
    (
        "[winding]",
        "[accuracy]\nloop = 5.0\n[winding]",
        "accuracy.loop = 5.0 must be within",
        "accuracy/loop",
    ),
    ('name = "Own"', 'name = "Own"\nlevel = "quick"', "level = 'quick' must be 'draft'", "level"),
    (
        'name = "Own"',
        'name = "Own"\ncontroller = "fuzzy"',
        "controller = 'fuzzy' must be one of pi,",
        "controller",
    ),
    (
        'name = "Own"',
        'name = "Own"\nsignals = ["a" "b"]',
        "is not TOML: a comma is missing at line 3, column 16",
        "",
    ),
    (
        'name = "Own"',
        'name = "Own"\nsignals = "loop.y"',
        "signals = 'loop.y' must be a list",
        "signals",
    ),
    ('name = "Own"', 'name = "Own"\nlike = "nowhere"', "cannot be read", ""),
    ('name = "Own"', 'name = "Own"\nname = "b"', "is not TOML: Cannot overwrite a value", ""),
    (
        'name = "Own"',
        'name = "Own"\n"hoist.payload_left" = 3',
        "payload_left = 3 is not a key: leave out the",
        "",
    ),
    (
        'name = "Own"',
        'name = "Own"\nlike = "a\\u0000b"',
        "like: 'a\\x00b' must be a line of printable",
        "",
    ),
    (
        'name = "Own"',
        'name = "Own"\nx = ' + "[" * 2000 + "]" * 2000,
        "is nested too deeply: write [table]s",
        "",
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "place"), WRONG)
def test_a_wrong_file_is_refused_with_its_place(
    old: str, new: str, message: str, place: str, tmp_path: Path
) -> None:
    assert old in OWN
    text = OWN.replace(old, new, 1)
    with pytest.raises(FileError) as told:
        read(written(tmp_path / "own.toml", text), HoistFile)
    assert any(message in one for one in told.value.problems), told.value.problems
    if place:
        found = checked().iter_errors(tomllib.loads(text))
        assert place in ["/".join(map(str, error.absolute_path)) for error in found]


def test_a_value_that_is_set_counts_as_if_it_stood_in_the_file_and_one_that_varies_does_not(
    tmp_path: Path,
) -> None:
    own = str(written(tmp_path / "own.toml", OWN))
    run = build(own, {"rope.mass_per_length": 20.0, "hoist.shaft_travel": 600.0})
    text = OWN.replace("shaft_travel = 870", "shaft_travel = 600")
    text = text.replace("number = 2\n", "number = 2\nmass_per_length = 20.0\n")
    there = build(str(written(tmp_path / "there.toml", text)), {})
    fields = ("hoist", "winding", "gains", "rope_values")
    assert [getattr(run, name) for name in fields] == [getattr(there, name) for name in fields]
    assert_allclose(run.hoist.rope_mass, 2.0 * 20.0)
    assert run.status_by_name["hoist.head_rope_mass"] == "derived"
    # a rope of the catalogue, with a tenth more of diameter
    other = build(own, {"rope.diameter": 1.1 * 0.052}).hoist
    assert_allclose(other.tail_mass / find_case(own).hoist.tail_mass, 1.1**2)
    # nothing follows from what differs between runs of one hoist
    varied = build(own, {}, varied={"hoist.payload_left": 0.0})
    case = find_case(own)
    assert (varied.hoist.payload_left, varied.hoist.torque_limit) == (0.0, case.hoist.torque_limit)
    assert varied.gains == case.gains


def test_files_that_a_file_names_are_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "mine"
    folder.mkdir()
    written(folder / "own.toml", OWN)
    written(folder / "rope.toml", "[fixed]\nrope.EI = 77.0\n")
    both = 'swivels.mode = "free"\nright.swivel.mode = 0\n'
    text = f'[duty]\nhoist = "own.toml"\n[fixed]\nfrom = "rope.toml"\n{both}[[trip]]\nwinding.travel = 870.0\n'
    schedule = read_schedule(written(folder / "duty.toml", text))
    assert (schedule.trip(1).hoist.shaft_travel, schedule.trip(1).rope_values["rope.EI"]) == (
        870.0,
        77.0,
    )
    assert [schedule.trip(1).rope_values[f"{end}.swivel.mode"] for end in ("left", "right")] == [
        1,
        0,
    ]


def test_a_rope_of_several_has_the_statuses_of_its_own_numbers(tmp_path: Path) -> None:
    text = "name = 'two'\nlike = 'rope-120'\nstatus = 'measured'\n[[rope]]\nEI = 90.0\n[[rope]]\nz = 1.0\nQc = 0.0\n"
    path = written(tmp_path / "two.toml", text)
    case = read(path, HoistFile).case
    status = {one.name: one.status for one in hoist_provenance(case, str(path))}
    assert "exported" not in status.values()
    assert [status[f"rope{k}.rope.EI"] for k in (1, 2)] == ["measured", "assumed"]
    assert [status[f"rope{k}.rope.Qc"] for k in (1, 2)] == ["published", "measured"]


def test_all_errors_come_at_once_and_far_values_are_remarked_on(tmp_path: Path) -> None:
    text = OWN.replace('"22 t"', '"22 kg"').replace(
        "[winding]", "sheave_radius = 'big'\n[winding]\njerk = 'soft'"
    )
    with pytest.raises(FileError) as told:
        read(written(tmp_path / "own.toml", text), HoistFile)
    assert len(told.value.problems) == 2
    case = read(written(tmp_path / "far.toml", OWN.replace('"22 t"', '"22 kg"')), HoistFile).case
    assert [line.split(" is far")[0] for line in case.remarks] == ["hoist.payload_left = 22 kg"]


def test_a_hoist_like_another_has_its_values_but_those_it_names(tmp_path: Path) -> None:
    text = 'name = "b"\nlike = "own.toml"\nhoist.payload_left = 5000.0\n[[rope]]\nlength = 930\n'
    own = read(written(tmp_path / "own.toml", OWN), HoistFile).case
    case = find_case(str(written(tmp_path / "b.toml", text)))
    assert (case.hoist.payload_left, case.rope["rope.length"], case.hoist.tail_rope_number) == (
        5e3,
        930.0,
        2,
    )
    assert case.rope["rope.EI"] == own.rope["rope.EI"]
    # each file's status is that of its own values
    keys = ("hoist.payload_left", "rope.length", "winding.speed", "rope.diameter")
    assert [case.status_by_name[key] for key in keys] == [
        "given",
        "given",
        "data sheet",
        "data sheet",
    ]
    case = find_case(
        str(written(tmp_path / "d.toml", text.replace("length = 930", 'construction = "18x7"')))
    )
    assert case.rope["rope.mass_per_length"] != own.rope["rope.mass_per_length"]
    with pytest.raises(FileError, match="break the circle"):
        find_case(str(written(tmp_path / "c.toml", 'name = "c"\nlike = "c.toml"\n')))


def test_a_rule_prints_the_number_that_it_uses() -> None:
    case = find_case("kiruna-355")
    inputs = RuleInputs(case.hoist, case.winding, case.hoist)
    rules = {rule.key: rule for rule in (LENGTH, *RULES)}

    def printed(key: str) -> float:
        """The only number in the words of a rule."""
        words = rules[key].expression.replace("m2/s2", "").replace("1/s", "").split()
        (found,) = (
            float(word) for word in words if word.replace("e+", "").replace(".", "").isdigit()
        )
        return found

    values = {key: float(rule.value(inputs)) for key, rule in rules.items()}
    hoist = case.hoist
    assert values["rope.length"] == hoist.shaft_travel + printed("rope.length")
    key = "hoist.head_rope_stiffness"
    assert values[key] == printed(key) * hoist.head_rope_mass
    assert values["hoist.torque_limit"] == printed("hoist.torque_limit") * inputs.torque()
    assert values["gains.speed"] == printed("gains.speed") * hoist.moving_mass
    assert values["gains.integral_time"] == printed("gains.integral_time")
    assert values["gains.position"] == printed("gains.position")


def problems(case: Case) -> list[str]:
    return HoistCheck(tuple(checks(case))).problems


def test_each_broken_bound_of_a_hoist_is_named() -> None:
    case = find_case("kiruna-355")
    kept = [replace(row, holds=True) for row in checks(case)]
    assert len(kept) == 8  # five of slip, motor twice, brake
    assert HoistCheck(tuple(kept)).problems == []
    assert check_in_words(HoistCheck(tuple(kept))) == "no problems found"
    for k, row in enumerate(kept):
        broken = [*kept[:k], replace(row, holds=False), *kept[k + 1 :]]
        check = HoistCheck(tuple(broken))
        if row.in_trip:
            assert check.problems == [row.problem]
            assert check_in_words(check) == "1 problem found"
        else:
            assert check.notes == [row.problem]
            assert check_in_words(check) == "no problems found"
        table = " ".join(consequences_text(case.hoist, broken, ()).split())
        assert table.count("NOT KEPT") == 1
        assert f"{row.value}, at least {row.bound}: NOT KEPT" in table
    assert HoistCheck(tuple(kept), ("a remark",)).problems == ["a remark"]


def test_a_new_hoist_says_which_bounds_it_does_not_keep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    asked = ["--depth", "870", "--payload", "22t", "--speed", "16", "--diameter", "52mm"]
    assert main(["new", "mine", *asked, "--out", str(path)]) == 0
    said, warned = capsys.readouterr()
    broken = problems(find_case(str(path)))
    assert f"{len(broken)} problems found" in said
    assert all(f"balance-rope: {line}\n" in warned for line in broken)
    assert "balance-rope: slip safety at rest is 1.61 " in warned


def test_the_complete_file_has_the_statuses_of_the_hoist(tmp_path: Path) -> None:
    # of settings, of words and of the spacing of several ropes too
    text = """name = "x"
like = "kiruna-355"
status = "measured"
winding.emergency_law = { value = "drive", status = "derived" }
coupling.step = { value = 0.01, status = "published" }
layout.spacing = 2.0
"""
    rope = (
        '[[rope]]\nnumber = 1\nname = "{}"\ndiameter = 0.044\nconstruction = "34x7"\n'
        'EI = {{ value = 200.0, status = "derived" }}\n'
    )
    path = str(
        written(tmp_path / "own.toml", text + rope.format("a") + rope.format("b") + "z = 0.9\n")
    )
    case = find_case(path)
    shown = find_case(str(written(tmp_path / "shown.toml", as_file(case, path, {}))))
    assert case.status_by_name.items() <= shown.status_by_name.items()
    assert shown.status_by_name["winding.emergency_law"] == "derived"
    for one, again in zip(case.balance_ropes, shown.balance_ropes, strict=True):
        assert file_statuses(one.values).items() <= file_statuses(again.values).items()


def test_a_trip_that_slips_or_asks_too_much_of_the_motor_is_told() -> None:
    case = find_case("kiruna-355")
    stopped = replace(case.winding, emergency_at=10.0, emergency_deceleration=6.0)
    in_stop = "slip safety in an emergency stop (drive) of this trip"
    assert not any(in_stop in line for line in problems(case))
    assert any(in_stop in line for line in problems(replace(case, winding=stopped)))
    # a stop of another trip is told, and is no problem of this one
    of_trip_back = "slip safety in an emergency stop (drive) of a trip back with the same payloads"
    assert not any(of_trip_back in line for line in problems(case))
    (note,) = HoistCheck(tuple(checks(case))).notes
    assert note.startswith(of_trip_back)
    # a short trip reaches less of its speed, and asks for less power
    weak = replace(case.hoist, power_limit=5e5)
    short = replace(case.winding, travel=5.0)
    told = problems(replace(case, hoist=weak))
    assert sum("power_limit" in line for line in told) == 1
    told = problems(replace(case, hoist=weak, winding=short))
    assert sum("power_limit" in line for line in told) == 0
    # head ropes heavier than the balance rope ask for more: of the second stage to hold, of the first not to run on
    uneven = {
        "hoist.torque_limit": 8e5,
        "hoist.brake.torque": 1.2e6,
        "winding.emergency_law": "two-stage",
    }
    light = uneven | {"hoist.head_rope_mass": case.hoist.head_rope_mass}
    heavy = uneven | {"hoist.head_rope_mass": 2 * case.hoist.head_rope_mass}
    words = (
        "torque_limit =",
        "brake.torque =",
        "brake.first_stage = 0.5 of brake.torque must be at least 0.",
    )
    for values, expected in (
        (light, [False, False, False]),
        (heavy, [True, False, True]),
        (heavy | {"hoist.brake.torque": 5e5}, [True, True, False]),
    ):
        found = " ".join(problems(case_with_values(case, values)))
        assert [x in found for x in words] == expected


@pytest.mark.parametrize("file", SHIPPED, ids=lambda path: path.stem)
def test_the_complete_file_has_every_value_of_the_hoist_and_leads_back_to_it(
    file: Path, tmp_path: Path
) -> None:
    name = str(file)
    if file.stem in BUILTIN_HOISTS:
        name = file.stem
    text = as_file(find_case(name), name, {})
    path = written(tmp_path / "hoist.toml", text)
    one = build_single_trip(name, {})
    again = build_single_trip(str(path), {})
    cases = [find_case(name), find_case(str(path))]
    ropes = [
        ropes_of(case, run, {}, case.level).ropes
        for case, run in zip(cases, (one, again), strict=True)
    ]
    for first, second in zip(*ropes, strict=True):
        assert first.name == second.name
        assert first.scene == second.scene
        assert first.suspension == second.suspension
        assert first.breaks == second.breaks
    same: dict[str, Any] = {"case": "", "rope_values": {}}
    if cases[0].distinct_ropes:
        same["hoist"] = None  # the drive of several ropes takes their sum from these
    assert replace(one, **same) == replace(again, **same)
    tables = tomllib.loads(text)
    for parameter in named_parameters(ropes[0][0].scene):
        table = tables
        if parameter.name.startswith(("rope.", "left.", "right.")):
            table = tables["rope"][0]
        group, _, _ = parameter.name.partition(".")
        for part in parameter.name.removeprefix("rope.").split("."):
            if part not in table:
                table = tables["rope"][0][group]
            table = table[part]
        assert isinstance(table, str | bool) or table["status"], parameter.name


@pytest.mark.slow
def test_the_file_beside_the_results_winds_them_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--in-process", "--level", "draft", "--signals", "left.fy", "loop.y", "drive.torque"]
    changed = ["--travel", "3", "--set", "rope.EI=200.1", "--set", "hoist.payload_left=1234.5"]
    assert main(["wind", "rope-120", *options, *changed, "--out", str(tmp_path / "one")]) == 0
    file = tmp_path / "one" / "hoist.toml"
    assert (
        main(["wind", str(file), *options[:1], *options[3:], "--out", str(tmp_path / "two")]) == 0
    )
    one, two = (pd.read_csv(tmp_path / name / "signals.csv") for name in ("one", "two"))
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    text = file.read_text(encoding="utf-8")
    assert 'payload_left = { value = 1234.5, unit = "kg", status = "given" }' in text
    capsys.readouterr()
    assert main(["show", str(file)]) == 0
    assert tomllib.loads(capsys.readouterr().out) == tomllib.loads(text)
