"""A file of several balance ropes in one hoist (TOML), read and checked before anything runs.

    [ropes]    title, case, level
    [fixed]    values of hoist, trip and all ropes
    [[rope]]   name; z, x_left, x_right = where it hangs; breaks_at, breaks_s = when and where it breaks; and its values

Keys and values are those of a study's [fixed]. All errors of a file are told at once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.breaking_rope import Break, BreakingRope
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_data, scene_parameters
from hoist_demo.cosimulation.participants.rope_group import CONTACT_ENERGIES, SUMS, Member, RopeGroup, hoist_with
from hoist_demo.cosimulation.participants.touching_ropes import TouchingRopes, WholeRope
from hoist_demo.cosimulation.schemes.interface import ENDS
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.place import Place
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.ropes.table import READ
from hoist_demo.study.catalogue import SECTIONS, Catalogue
from hoist_demo.study.provenance import Known, of_host, of_rope
from hoist_demo.study.reading import (
    LONGEST_TEXT,
    Problems,
    StudyError,
    flat,
    read_head,
    read_statuses,
    read_tables,
    read_values,
)
from hoist_demo.study.run import RunData, build_trip
from rope_model import Level, Neighbours, Scene

_TABLES = {"ropes": dict, "fixed": dict, "rope": list}
_PLACE = ("x_left", "x_right", "z")
_BREAK = ("breaks_at", "breaks_s")
_NAME = "[A-Za-z][A-Za-z0-9_]{0,39}"
_PRESSED = "contact.rope_stiffness"
#: With what other signals begin, as a rope's begin with its name.
_TAKEN = tuple(dict.fromkeys(signal.partition(".")[0] for signal in (*SUMS, *CONTACT_ENERGIES, *DRIVE_UNITS)))


@dataclass(frozen=True)
class OneRope:
    """One of the ropes: its data, its place, and whether it breaks."""

    name: str
    parameters: Mapping[str, Value]  # by FMI name; the rest is the level's
    scene: Scene
    place: Place
    breaks: Break | None
    given: Mapping[str, str]  # where each value that is set comes from, by name

    @property
    def torque_free(self) -> bool:
        """True if it carries no torque."""
        return scene_parameters(self.scene).torque_free

    def plant(self) -> WholeRope:
        """The rope to be wound."""
        rope, data = InProcessRope(self.scene, READ), self.scene.rope
        if self.breaks is None:
            return rope
        breaks = replace(self.breaks, gravity=self.scene.layout.gravity)
        return BreakingRope(rope, data.mass_per_length, data.length, breaks)


@dataclass(frozen=True)
class Ropes:
    """Several ropes, and the trip on which they are wound."""

    title: str
    case: str
    level: Level
    run: RunData
    ropes: tuple[OneRope, ...]
    given: Mapping[str, str]  # where each value that is set for all comes from, by name

    def group(self) -> RopeGroup:
        """All ropes as one."""
        members = [(rope, rope.plant()) for rope in self.ropes]
        group = [Member(rope.name, plant, rope.place) for rope, plant in members]
        if not self.touching:
            return RopeGroup(group)
        neighbours = Neighbours([rope.scene for rope in self.ropes], [rope.place.origin for rope in self.ropes])
        return RopeGroup(group, TouchingRopes([plant for _, plant in members], neighbours))

    @property
    def touching(self) -> bool:
        """True if the ropes press each other."""
        return self.ropes[0].scene.shaft.contact.rope_stiffness > 0.0

    @property
    def hoist(self) -> Hoist:
        """The case's, with these ropes."""
        data = [rope.scene.rope for rope in self.ropes]
        return hoist_with(self.run.hoist, [(rope.mass_per_length, rope.length) for rope in data])

    def provenance(self) -> list[Known]:
        """Sources of the numbers: those of the hoist, and those of each rope under its name."""
        ropes = [
            one._replace(name=f"{rope.name}.{one.name}")
            for rope in self.ropes
            for one in of_rope(find_case(self.case), scene_parameters(rope.scene), rope.given)
        ]
        shared = dict.fromkeys(("hoist.tail_rope_mass", "hoist.tail_rope_length", "hoist.tail_rope_number"), "derived")
        return [*of_host(replace(self.run, hoist=self.hoist), {**self.given, **shared}), *ropes]


def read_ropes(path: Path, rope: Mapping[str, Parameter]) -> Ropes:
    """The ropes of a file, which may have these parameters; raises StudyError with all problems."""
    catalogue, problems = Catalogue(rope), Problems()
    raw = read_tables(path, "ropes", _TABLES, problems)
    head = read_head(path, "ropes", raw.get("ropes", {}), {}, problems)
    fixed = read_values(catalogue, "[fixed]", raw.get("fixed", {}), problems)
    tables = raw.get("rope", [])
    problems += [
        f"{key} = {value!r} must be left out: guards of several ropes are not computed"
        for table in [raw.get("fixed", {}), *tables]
        for key, value in flat(table)
        if key.startswith("guard.")
    ]
    if not tables:
        problems.append("there must be ropes: give at least one [[rope]]")
    if problems:
        raise StudyError(path, problems)
    try:
        run = build_trip(head["case"], fixed)
    except ValueError as error:
        raise StudyError(path, [str(error)]) from error
    given = read_statuses(raw.get("fixed", {}))
    ropes = [_read_rope(k, table, catalogue, run, head["level"], given, problems) for k, table in enumerate(tables, 1)]
    found = tuple(rope for rope in ropes if rope is not None)
    names = [rope.name for rope in found]
    problems += [f"name = {name!r} must be given once: name each rope" for name in {*names} if names.count(name) > 1]
    problems += [
        f"name = {name!r} must be another: signals of the rope begin with its name, and {', '.join(_TAKEN)} are taken"
        for name in names
        if name in _TAKEN
    ]
    if found and found[0].scene.shaft.contact.rope_stiffness > 0.0:
        whose = "" if _PRESSED in fixed else f", of the case {head['case']}"
        problems += _obstacles_to_contact(found, f"{_PRESSED} = {found[0].scene.shaft.contact.rope_stiffness:g}{whose}")
    if problems:
        raise StudyError(path, problems)
    return Ropes(run=run, ropes=found, given=given, **head)


def _obstacles_to_contact(ropes: Sequence[OneRope], pressed: str) -> list[str]:
    """Return why ropes cannot press each other; `pressed` is the stiffness that asks for it."""
    alone = f"or set {_PRESSED} = 0 in [fixed]: each rope is then alone"
    found = [
        f"{rope.name}: model.fidelity = {rope.scene.model.fidelity!r} must be torsional or spatial with {pressed}, for "
        f"ropes press each other out of plane: choose one, {alone}"
        for rope in ropes
        if rope.scene.model.fidelity not in ("torsional", "spatial")
    ]
    for one, other in combinations(ropes, 2):
        apart = min(math.dist(one.place.at(end), other.place.at(end)) for end in ENDS)
        if apart < (least := 0.5 * (one.scene.rope.diameter + other.scene.rope.diameter)):
            found.append(
                f"{other.name}: an end that is {apart:g} m from that of {one.name} must be at least {least:g} m away "
                f"with {pressed}, or they touch where they hang: move it by z or x_left and x_right, {alone}"
            )
    return found


def _read_rope(
    number: int,
    table: Mapping[str, Any],
    catalogue: Catalogue,
    run: RunData,
    level: Level,
    given: Mapping[str, str],
    problems: Problems,
) -> OneRope | None:
    """A rope; None where something is wrong with it, which is added to the problems."""
    before, name = len(problems), table.get("name", f"rope{number}")
    if not isinstance(name, str) or not re.fullmatch(_NAME, name):
        problems.append(
            f"name = {str(name)[:LONGEST_TEXT]!r} must be of letters from A to z, digits and _, a letter first, at "
            "most 40: signals of the rope begin with it, and a file of the system; name it anew"
        )
        return None
    own = {key: value for key, value in table.items() if key not in ("name", *_PLACE, *_BREAK)}
    values = read_values(catalogue, name, own, problems)
    numbers = {key: table[key] for key in (*_PLACE, *_BREAK) if key in table}
    for key, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            problems.append(
                f"{name}: {key} = {value!r} must be a number: give it in {'s' if key == 'breaks_at' else 'm'}"
            )
    for key in values:
        if key.partition(".")[0] in (*SECTIONS, "controller", "contact"):
            problems.append(f"{name}: {key} must be the same for all ropes: set it in [fixed]")
    if len(numbers.keys() & set(_BREAK)) == 1:
        problems.append(f"{name}: breaks_at and breaks_s must stand together: give both or none")
    if len(problems) > before:
        return None
    with problems.collect(name):
        return _rope(name, numbers, {**run.fmu, **values}, level, {**given, **read_statuses(own)})
    return None


def _rope(
    name: str, numbers: Mapping[str, float], parameters: Mapping[str, Value], level: Level, given: Mapping[str, str]
) -> OneRope:
    """The rope between its own points of the conveyances, the centres of which are layout.spacing apart."""
    place = Place(**{key: float(numbers.get(key, 0.0)) for key in _PLACE})
    spacing = rope_data(parameters, level).layout.spacing + place.x_right - place.x_left
    own = {**parameters, "layout.spacing": spacing}
    breaks = Break(float(numbers["breaks_at"]), float(numbers["breaks_s"])) if "breaks_at" in numbers else None
    return OneRope(name, own, rope_data(own, level), place, breaks, {"layout.spacing": "derived"} | dict(given))
