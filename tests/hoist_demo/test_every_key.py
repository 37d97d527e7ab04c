"""Every key of a hoist's file in every command: it changes what the command hands to the run, or it is refused."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest
from shared import Patch

from hoist_demo.cases import hoist_file
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.participants.breaking_rope import Break
from hoist_demo.design import linearise
from hoist_demo.duty.schedule import Schedule
from hoist_demo.files.reading import read
from hoist_demo.files.registry import SECTIONS, host_parameters, rope_parameters
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.parameters import SIDES
from hoist_demo.parameters.quantity import FileParameter, Value
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.run.data import build_single_trip
from hoist_demo.run.ropes import Ropes, ropes_of
from hoist_demo.uncertainty.definition import UncertaintyFile
from rope_model import Scene
from rope_model.scene_names import named_parameters

BASE = """
name = "two ropes"
like = "rope-120"
level = "draft"
[hoist]
conveyance_mass = 2e4
[hoist.brake]
torque = 2e5
[hoist.guides]
viscous = 10.0
[hoist.lining]
sliding = 0.7
[hoist.drive_shaft]
stiffness = 1e8
[hoist.play]
stiffness = 1e6
[hoist.jam_left]
height = 40.0
[hoist.jam_right]
height = 41.0
[model]
fidelity = "torsional"
[[rope]]
name = "a"
z = -0.3
[[rope]]
name = "b"
z = 0.3
"""
UNCERTAIN = "[uncertain]\nhoist = '{}'\n[rope]\nconstruction = '34x7'\ndiameter = 0.044\n"
DUTY = "[duty]\nhoist = '{}'\n[[trip]]\nwinding.start_delay = 1.0\n"
STUDY = "[study]\nhoist = '{}'\n[vary]\nhoist.payload_left = {{ values = [1e3, 2e3] }}\n"

#: Values of keys for which a small change of the default is no valid one.
_CHOSEN: dict[str, Value] = {
    "winding.travel": 80.0,
    "winding.creep_distance": 2.0,
    "winding.departure_creep_distance": 2.0,
    "winding.emergency_law": "torque",
    "coupling.scheme": "iterative-secant",
    "rope.EI_stick": 400.0,
}
#: Keys that several ropes refuse in every command: the [[rope]] say it, or it is not computed.
_REFUSED = ("hoist.tail_rope_", "guard.", "[[rope]].guard.")
#: Keys that a linear model cannot have: those of a trip and its events, and of how it is wound and judged.
_NOT_LINEAR = (
    *(f"{section}." for section in SECTIONS if section != "hoist"),
    *("controller", "[[rope]].breaks_"),
)


_VARYING = tuple(f"[[rope]].{name}" for name in FOLLOWING if name != "length")


@dataclass(frozen=True)
class Handed:
    """What a command hands to the run: values of the host by name, and those of each rope."""

    host: Mapping[str, Value]
    ropes: Mapping[str, Mapping[str, Value]]


def host_values(data: object) -> dict[str, Value]:
    """Return the values of the host's data by their names in files."""
    values = dict[str, Value]()
    for name in host_parameters():
        part: object = data
        for attribute in name.split("."):
            part = getattr(part, attribute, None)
        if part is not None:
            values[name] = part  # type: ignore[assignment]
    return values


def rope_values(
    scene: Scene, suspension: SuspensionOffset, breaks: Break | None = None
) -> dict[str, Value]:
    values = {p.name: p.value for p in named_parameters(scene)}
    values |= {f"rope.{name}": value for name, value in asdict(suspension).items()}
    if breaks is not None:
        values |= {"rope.breaks_at": breaks.t, "rope.breaks_s": breaks.s}
    return values


def of_ropes(ropes: Ropes) -> Handed:
    each = {
        rope.name: rope_values(rope.scene, rope.suspension, rope.breaks) for rope in ropes.ropes
    }
    return Handed(host_values(replace(ropes.run, hoist=ropes.hoist)), each)


def wound(hoist: str, _: Path) -> Handed:
    return of_ropes(
        ropes_of(find_case(hoist), build_single_trip(hoist, {}), {}, find_case(hoist).level)
    )


def duty(hoist: str, folder: Path) -> Handed:
    (folder / "duty.toml").write_text(DUTY.format(hoist), encoding="utf-8")
    return of_ropes(read(folder / "duty.toml", Schedule).ropes())


def uncertain(hoist: str, folder: Path) -> Handed:
    (folder / "uncertain.toml").write_text(UNCERTAIN.format(hoist), encoding="utf-8")
    file = read(folder / "uncertain.toml", UncertaintyFile)
    return of_ropes(file.ropes({name: datum.middle for name, datum in file.data.items()}))


def linear(hoist: str, _: Path) -> Handed:
    case = find_case(hoist)
    specs = linearise._rope_specs(case, level=case.level)
    return Handed(
        host_values(SimpleNamespace(hoist=case.hoist)),
        {one.name: rope_values(one.rope, one.suspension) for one in specs},
    )  # type: ignore[arg-type]


class Command(NamedTuple):
    """What a command hands to the run, the keys of which it takes no notice, and those that it refuses."""

    read: Callable[[str, Path], Handed]
    without: tuple[str, ...] = ()
    refuses: tuple[str, ...] = _REFUSED


COMMANDS = {
    "wind": Command(wound),
    # a trip ends at a landing; the first trip of this schedule has a delay of its own
    "duty": Command(
        duty, ("winding.start_delay",), (*_REFUSED, "winding.emergency_at", "[[rope]].breaks_")
    ),
    # the properties of the ropes are what varies
    "uncertain": Command(uncertain, _VARYING, (*_REFUSED, "[[rope]].breaks_")),
    "modes": Command(linear, _NOT_LINEAR, ("hoist.tail_rope_",)),
}


def keys() -> Iterator[FileParameter]:
    """Yield the keys of a hoist's file by their names in it, those of a [[rope]] as [[rope]].NAME."""
    yield from host_parameters().values()
    for p in rope_parameters().values():
        if not p.name.startswith(("rope.", "left.", "right.")):
            yield p
    for p in hoist_file._rope_parameters():
        yield replace(p, name=f"[[rope]].{p.name.removeprefix('rope.')}")


def other_value(p: FileParameter) -> Value:
    """Return a valid value that is not the default."""
    if (chosen := _CHOSEN.get(p.name.replace("[[rope]]", "rope"))) is not None:
        return chosen
    if p.choices:
        default = p.start
        if isinstance(default, int):
            default = p.choices[default]
        return next(choice for choice in p.choices if choice != default)
    if p.kind == "Boolean":
        return not p.start
    start = 0.0
    if isinstance(p.start, int | float):
        start = p.start
    if p.kind == "Integer":
        step = 1
        if "counts[" in p.name:
            step = 8
        return round(start) + step
    return next(
        x for x in (1.01 * start, 0.99 * start, 0.01, 1.0) if x != start and p.bounds.contains(x)
    )


def in_toml(key: str) -> str:
    """Return a key with quotes where TOML needs them."""
    parts = []
    for part in key.split("."):
        if "[" in part:
            parts.append(f'"{part}"')
        else:
            parts.append(part)
    return ".".join(parts)


def value_in_toml(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value)


def written(values: Mapping[str, Value], folder: Path) -> str:
    """Write a hoist like the base with these values, of the second [[rope]] for a rope's; return its path."""
    lines = []
    own = []
    for key, value in values.items():
        word = value_in_toml(value)
        if key.startswith("[[rope]]."):
            own.append(f"{in_toml(key.removeprefix('[[rope]].'))} = {word}")
        else:
            lines.append(f"{in_toml(key)} = {word}")
    if own:
        lines += ["[[rope]]", "name = 'a'", "[[rope]]", "name = 'b'", *own]
    path = folder / "other.toml"
    text = "\n".join(["like = 'base.toml'", "name = 'two ropes'", *lines])
    path.write_text(f"{text}\n", encoding="utf-8")
    return str(path)


def batches(
    every: Iterable[FileParameter], refuses: tuple[str, ...]
) -> Iterator[list[FileParameter]]:
    """Yield the keys group by group, for one reading of a file each; those that may be refused are apart."""
    groups = dict[tuple[str, bool], list[FileParameter]]()
    for p in every:
        groups.setdefault((p.name.rpartition(".")[0], p.name.startswith(refuses)), []).append(p)
    yield from groups.values()


def holds(handed: Handed, p: FileParameter, value: Value) -> bool:
    """Return True if what is handed to the run holds a key's value, a choice by its word or its code."""
    wanted = [value]
    if isinstance(value, str) and value in p.choices:
        wanted.append(p.choices.index(value))
    if not p.name.startswith("[[rope]]."):
        of_all = handed.host.get(p.name) in wanted and p.name in handed.host
        return of_all or all(rope.get(p.name) in wanted for rope in handed.ropes.values())
    name = p.name.removeprefix("[[rope]].")
    other = handed.ropes["b"]
    if name.startswith("swivels."):
        own = [f"{side}.swivel.{name.removeprefix('swivels.')}" for side in SIDES]
    else:
        own = [name]
    return all(other.get(one, other.get(f"rope.{one}")) in wanted for one in own)


def outcome(command: Command, batch: list[FileParameter], folder: Path) -> dict[str, str]:
    """Return by key "" or what became of its value; keys that are refused together are tried one by one."""
    values = {p.name: other_value(p) for p in batch}
    if any("breaks_" in name for name in values):
        values |= {"[[rope]].breaks_at": 5.0, "[[rope]].breaks_s": 20.0}
    try:
        handed = command.read(written(values, folder), folder)
    except ValueError as error:
        if len(batch) == 1:
            return {batch[0].name: f"refused: {error}"}
        found: dict[str, str] = {}
        for p in batch:
            found |= outcome(command, [p], folder)
        return found
    found = {p.name: "no effect" for p in batch}
    for p in batch:
        if holds(handed, p, values[p.name]):
            found[p.name] = ""
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    (folder / "base.toml").write_text(BASE, encoding="utf-8")
    return folder


@pytest.mark.parametrize("name", COMMANDS)
def test_every_key_is_handed_to_the_run_or_refused(
    name: str, folder: Path, monkeypatch: Patch
) -> None:
    monkeypatch.setattr(linearise, "_rope", lambda scene: scene)
    command = COMMANDS[name]
    found = dict[str, str]()
    for batch in batches(keys(), command.refuses):
        found |= outcome(command, batch, folder)
    refused = {key: text for key, text in found.items() if text.startswith("refused")}
    assert {key: text for key, text in refused.items() if not key.startswith(command.refuses)} == {}
    # the message names the key, or the pair that stands together
    assert all(key.rpartition(".")[2].partition("_s")[0] in text for key, text in refused.items())
    without = {key for key, text in found.items() if text == "no effect"}
    assert {key for key in without if not key.startswith(command.without)} == set()
    # an exception that is none any more is taken off the list
    for one in command.without:
        assert any(key.startswith(one) for key in without | {"hoist."}), one


def test_a_study_refuses_several_ropes_before_it_looks_for_an_fmu(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "study.toml").write_text(STUDY.format(folder / "base.toml"), encoding="utf-8")
    assert main(["study", str(folder / "study.toml"), "--fmu", str(folder / "none.fmu")]) == 2
    said = capsys.readouterr().err
    assert "must have equal ropes ([[rope]] with number = N), not the [[rope]] a, b" in said
    assert "none.fmu" not in said


def test_ropes_of_opposite_lay_stay_so_where_the_rope_varies(folder: Path) -> None:
    path = folder / "lays.toml"
    path.write_text(f"{BASE}Qb = -1e5\nQc = -1e5\nlength = 119.0\n", encoding="utf-8")
    ropes = uncertain(str(path), folder).ropes
    assert ropes["a"]["rope.Qb"] == -ropes["b"]["rope.Qb"] != 0.0  # type: ignore[operator]
    assert ropes["a"]["rope.EI"] == ropes["b"]["rope.EI"]
    assert (ropes["a"]["rope.length"], ropes["b"]["rope.length"]) == (120.0, 119.0)
