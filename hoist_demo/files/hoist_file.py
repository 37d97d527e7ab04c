"""A hoist's file (TOML): the hoist, its trip, controller, balance ropes and shaft.

    name, source, status, like, level, controller, signals
    [hoist] [winding] [gains] [shaper] [trajectory] [coupling] [arrival]     of the host
    [layout] [air] [lining] [divider_1] [contact] [guard] [mesh] ...         of all ropes
    [[rope]]   name; number of equal ones; construction and lay (catalogue), or from = "FILE" (identified), or numbers;
               swivels = both, left.swivel, right.swivel; z, x_left, x_right; breaks_at, breaks_s

A value is a number in SI, a text with its unit ("22 t"), or { value, unit, status, source, low, high }; without a
status it has the file's. What is left out is that of the hoist that `like` names, or follows by RULES, or is a
documented default.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field, create_model

from hoist_demo.cases.case import FOLDER, HOISTS, SCENARIOS, Case, Tail
from hoist_demo.control.controller import Gains
from hoist_demo.files.catalogue import (
    PLACE_PARAMETERS,
    SECTIONS,
    Catalogue,
    cure_of,
    host_parameters,
    of_run,
    rope_parameters,
    with_values,
)
from hoist_demo.files.reading import FileError, Table, givens, nested, read_toml, table_of, validated
from hoist_demo.files.rope_file import read_rope_file
from hoist_demo.files.values import DERIVED, GIVEN, STATUSES, VALUE_KEYS, Given, Text, given
from hoist_demo.parameters import GRAVITY, Hoist, Winding, hoist_with, require_trip_fits
from hoist_demo.parameters.quantity import Value
from rope_model import Level
from rope_model import rope as catalogue_rope

#: m [assumed]: length of a balance rope beyond the travel: loop, and sump below the lower landing
TAIL_SPARE = 40.0
#: m^2/s^2 [assumed]: EA of a head rope over its mass per length, a modulus of 110 GPa of the steel
HEAD_ROPE_STIFFNESS = 1.3e7
PLACE, BREAK = ("x_left", "x_right", "z"), ("breaks_at", "breaks_s")
#: what decides a rope of the catalogue
_FROM_CATALOGUE = ("construction", "lay")
_NAME = "[A-Za-z][A-Za-z0-9_]{0,39}"


class Rule(NamedTuple):
    """What a parameter is where the file leaves it out."""

    key: str
    words: str
    value: Callable[[Hoist, Winding], Value]


RULES = (
    Rule("winding.travel", "hoist.shaft_travel, from landing to landing", lambda h, _: h.shaft_travel),
    Rule(
        "hoist.head_rope_mass",
        "the balance ropes' mass per length over hoist.head_rope_number: balanced",
        lambda h, _: h.tail_mass / h.head_rope_number,
    ),
    Rule(
        "hoist.head_rope_stiffness",
        f"{HEAD_ROPE_STIFFNESS:g} m2/s2 times hoist.head_rope_mass",
        lambda h, _: HEAD_ROPE_STIFFNESS * h.head_rope_mass,
    ),
    Rule(
        "hoist.torque_limit",
        "1.5 times that of the acceleration with the payload: R (m a + g times the imbalance + losses)",
        lambda h, w: 1.5 * h.sheave_radius * (h.moving_mass * w.acceleration + GRAVITY * _imbalance(h) + _losses(h, w)),
    ),
    Rule("gains.speed", "3 1/s times all moving masses", lambda h, _: 3.0 * h.moving_mass),
    Rule("gains.integral_time", "2 s", lambda *_: 2.0),
    Rule("gains.position", "0.5 1/s", lambda *_: 0.5),
)


def _imbalance(hoist: Hoist) -> float:
    return abs(hoist.mass_left - hoist.mass_right)


def _losses(hoist: Hoist, winding: Winding) -> float:
    coulomb, viscous = hoist.travel_loss
    return coulomb + viscous * winding.speed


@cache
def hoist_model() -> type[Table]:
    """The model of a hoist's file."""
    scene = rope_parameters()
    # what a rope has of its own; it presses another one with the same stiffness
    own = [p for p in scene.values() if not p.name.startswith("contact.")]
    named = [p if p.name.startswith("rope.") else replace(p, name=f"rope.{p.name}") for p in own]
    both = [replace(p, name=p.name.replace("left.swivel", "swivels")) for p in named if ".left.swivel." in p.name]
    rope = create_model(
        "RopeTable",
        __base__=table_of("rope", (*named, *both, *PLACE_PARAMETERS.values())),
        name=(str, Field(default="", pattern=f"^({_NAME})?$")),
        number=(int, Field(default=1, ge=1, le=20, description="equal ropes, of which one is computed")),
        file=(Text, Field(default="", alias="from", description="parameter file that balance-rope identify wrote")),
        construction=(Text, Field(default="", description="one of the catalogue's")),
        lay=(Text, Field(default="right-hand", description="sense of the lay, of the catalogue")),
    )
    fields = {name: field for name, field in of_run(given).items() if name not in ("rope", *_ENDS)}
    made: type[Table] = create_model(
        "HoistFile",
        __base__=Table,
        name=(Text, Field(description="of the hoist, in titles")),
        source=(Text, Field(default="", description="where the data come from")),
        status=(str, Field(default=GIVEN, pattern=f"^({'|'.join(STATUSES)})$", description="of values without one")),
        like=(
            Text,
            Field(default="", description="a hoist, by name or file, whose values count where these leave off"),
        ),
        level=(Level, Field(default="standard", description="accuracy against speed of the rope")),
        signals=(list[Text], Field(default=[], description="time series to record, * for any letters")),
        rope=(list[rope], Field(min_length=1)),  # type: ignore[valid-type]
        **fields,
    )
    return made


_ENDS = ("left", "right")


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a hoist's file."""
    made: dict[str, Any] = _without_null(hoist_model().model_json_schema(by_alias=True))
    return made


def _without_null(part: Any) -> Any:
    """Return the schema without null, which TOML has not: an error is then told at its own place."""
    if isinstance(part, list):
        return [_without_null(one) for one in part]
    if not isinstance(part, dict):
        return part
    found = {key: _without_null(one) for key, one in part.items() if not (key == "default" and one is None)}
    kinds = [one for one in found.get("anyOf", ()) if one != {"type": "null"}]
    rest: dict[str, Any] = {key: one for key, one in found.items() if key != "anyOf"}
    return rest | (kinds[0] if len(kinds) == 1 else {"anyOf": kinds} if kinds else {})


def read_hoist(path: Path) -> Case:
    """Return the hoist of a file; raise FileError with all problems."""
    file: Any = validated(path, hoist_model(), _with_base(path, read_toml(path)), _cure)
    host: dict[str, Given] = {} if file.controller is None else {"controller": file.controller}
    shared: dict[str, Given] = {}
    for name in file.model_fields_set - _HEAD:
        (host if name in SECTIONS else shared).update(givens(getattr(file, name), f"{name}."))
    problems: list[str] = []
    ropes = [_rope(path, k, table, problems) for k, table in enumerate(file.rope, 1)]
    names = [tail.name for tail, _, _ in ropes]
    problems += [
        f"rope name = {n!r} must be given once: name each rope" for n in sorted(set(names)) if names.count(n) > 1
    ]
    if problems:
        raise FileError(path, problems)
    try:
        return _case(file, host, shared, ropes)
    except ValueError as error:
        raise FileError(path, [str(error)]) from error


def _cure(place: str) -> str:
    """Return what may have been meant by an unknown key, of a rope, too: `rope 2.EJ`."""
    table, _, key = place.rpartition(" ")
    return cure_of(f"rope.{key}" if table and "." not in key else key)


def _with_base(path: Path, raw: dict[str, Any], depth: int = 0) -> dict[str, Any]:
    """Return the tables over those of the hoist that ``like`` names."""
    raw = _stamped(nested(raw))
    for rope in raw["rope"] if isinstance(raw.get("rope"), list) else ():
        if isinstance(rope, dict) and isinstance(rope.get("from"), str):  # beside the file that says so
            rope["from"] = str(path.parent / rope["from"])
    if "like" not in raw:
        return raw
    like = str(raw.pop("like"))
    base = FOLDER / f"{like}.toml" if like in (*HOISTS, *SCENARIOS) else path.parent / like
    if depth > 5:
        raise FileError(path, [f"like = {like!r} must lead to a file without like: break the circle"])
    return _over(_with_base(base, read_toml(base), depth + 1), raw)


def _stamped(raw: dict[str, Any]) -> dict[str, Any]:
    """Return the tables with the file's status at each value that states none: those of another file have theirs."""
    status = raw.get("status", GIVEN)
    if status == GIVEN or status not in STATUSES:
        return raw
    known = {*host_parameters(), *rope_parameters(), *PLACE_PARAMETERS}

    def stamped(content: Any, name: str) -> Any:
        if name.replace("swivels.", "left.swivel.") in known:
            table = content if isinstance(content, dict) else {"value": content}
            return table if "status" in table else {**table, "status": status}
        if isinstance(content, dict):
            return {key: stamped(one, f"{name}.{key}") for key, one in content.items()}
        return content

    found = {key: stamped(content, key) for key, content in raw.items() if key != "rope"}
    if "rope" in raw:
        ropes = raw["rope"] if isinstance(raw["rope"], list) else []
        own = {name.partition(".")[0] for name in rope_parameters()} | {"swivels"}
        found["rope"] = [
            {key: stamped(one, key if key in own - {"rope", "contact"} else f"rope.{key}") for key, one in rope.items()}
            if isinstance(rope, dict)
            else rope
            for rope in ropes
        ] or raw["rope"]
    return found


def _kept(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Return what a rope keeps of the one that it goes on from: not what decides another rope, nor its swivels."""
    gone = {"left", "right"} if "swivels" in own else set()
    if own.keys() & {"construction", "from"}:
        gone |= {"construction", "from", "lay", *(f for f in _OF_ROPE if f not in ("length", "diameter"))}
    return {key: one for key, one in base.items() if key not in gone}


def _over(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    found = dict(base)
    for key, content in own.items():
        below = base.get(key)
        if isinstance(below, dict) and isinstance(content, dict) and not content.keys() & set(VALUE_KEYS):
            found[key] = _over(below, content)
        elif key == "rope" and isinstance(below, list) and isinstance(content, list):
            tables = below and all(isinstance(one, dict) for one in (*below, *content))
            # ropes of another number go on from the first
            bases = below if len(below) == len(content) else below[:1] * len(content)
            pairs = zip(bases, content, strict=True) if tables else ()
            found[key] = [_over(_kept(one, own_rope), own_rope) for one, own_rope in pairs] if tables else content
        else:
            found[key] = content
    return found


_HEAD = {"name", "like", "source", "status", "level", "controller", "signals", "rope"}


def _rope(path: Path, k: int, table: Any, problems: list[str]) -> tuple[Tail, int, dict[str, Given]]:
    """Return a rope, the number of equal ones, and its values by FMI name; add what is wrong to the problems."""
    where, found = f"rope {k}", dict[str, Given]()
    own = dict(givens(table, "rope."))
    place = {key: float(own.pop(f"rope.{key}").value) for key in (*PLACE, *BREAK) if f"rope.{key}" in own}
    if table.construction:
        try:
            diameter = own["rope.diameter"].value if "rope.diameter" in own else 0.0
            known = catalogue_rope(table.construction, float(diameter), lay=table.lay)
            source = f"catalogue, {table.construction}, middle of its range"
            for name, p in vars(known.middle).items():
                if name in _OF_CATALOGUE:
                    found[f"rope.{name}"] = Given(p, DERIVED, source)
        except ValueError as error:
            problems.append(f"{where}: {error}")
    if table.file:
        try:
            found |= read_rope_file(Path(table.file), Catalogue())
        except FileError as error:
            problems += [f"{where}: {line}" for line in str(error).splitlines()]
    # those of both swivels first, for one of them may differ
    for key, one in sorted(own.items(), key=lambda item: ".swivel." in item[0]):
        section, _, rest = key.removeprefix("rope.").partition(".")
        if section == "swivels":
            found |= {f"{side}.swivel.{rest}": one for side in _ENDS}
        elif rest:
            found[key.removeprefix("rope.")] = one
        else:
            found[key] = one
    breaks = {key: place.pop(key) for key in BREAK if key in place}
    if len(breaks) == 1:
        problems.append(f"{where}: breaks_at and breaks_s must stand together: give both or none")
    if breaks and table.number > 1:
        problems.append(
            f"{where}: number = {table.number} must be 1 for a rope that breaks: give each its own [[rope]]"
        )
    values, statuses = ({key: getattr(one, what) for key, one in found.items()} for what in ("value", "status"))
    tail = Tail(table.name or f"rope{k}", values, place, breaks, statuses)
    return tail, table.number, found


_OF_ROPE = tuple(name.removeprefix("rope.") for name in rope_parameters() if name.startswith("rope."))
_OF_CATALOGUE = ("mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ")


def _case(
    file: Any, host: dict[str, Given], shared: dict[str, Given], ropes: list[tuple[Tail, int, dict[str, Given]]]
) -> Case:
    derived: dict[str, Given] = {}
    values = {key: one.value for key, one in host.items()}
    travel = float(values.get("hoist.shaft_travel", values.get("winding.travel", Hoist.shaft_travel)))
    if "hoist.shaft_travel" not in values and "winding.travel" in values:
        derived["hoist.shaft_travel"] = Given(abs(travel), DERIVED, "winding.travel")
    tails, masses = [], []
    for tail, number, found in ropes:
        if "rope.length" not in found:
            words = f"hoist.shaft_travel + {TAIL_SPARE:g} m"
            found["rope.length"] = Given(abs(travel) + TAIL_SPARE, DERIVED, words)
            tail = replace(
                tail,
                parameters={**tail.parameters, "rope.length": abs(travel) + TAIL_SPARE},
                given={**tail.given, "rope.length": DERIVED},
            )
        mass = found.get("rope.mass_per_length", Given(rope_parameters()["rope.mass_per_length"].start))
        tails.append(tail)
        masses += [(float(mass.value), float(found["rope.length"].value))] * number
    several = len(tails) > 1 or bool(tails[0].place or tails[0].breaks)
    if several and len(masses) > len(tails):
        raise ValueError("number must be 1 where ropes hang at places of their own: give each its own [[rope]]")
    whole = hoist_with(Hoist(), masses) if several else None
    for key, value in {
        "hoist.tail_rope_number": len(masses) if whole is None else whole.tail_rope_number,
        "hoist.tail_rope_mass": masses[0][0] if whole is None else whole.tail_rope_mass,
        "hoist.tail_rope_length": masses[0][1] if whole is None else whole.tail_rope_length,
    }.items():
        if key not in values:
            derived[key] = Given(value, DERIVED, "the balance ropes")
    if not several and values.get("hoist.tail_rope_number", len(masses)) != len(masses):
        raise ValueError(
            f"hoist.tail_rope_number = {values['hoist.tail_rope_number']} must be {len(masses)}, as number of the "
            "[[rope]] says: leave it out"
        )
    values |= {key: one.value for key, one in derived.items()}
    for rule in RULES:
        if rule.key not in values:
            hoist, winding, _ = _data(values)
            derived[rule.key] = Given(rule.value(hoist, winding), DERIVED, rule.words)
            values[rule.key] = derived[rule.key].value
    hoist, winding, gains = _data(values)
    require_trip_fits(hoist, winding)
    everything = {**host, **shared, **derived, **({} if several else ropes[0][2])}
    far = dict.fromkeys(line for _, _, found in ropes for line in remarks(_values({**everything, **found})))
    of_ropes = {key: one.value for key, one in shared.items()}
    return Case(
        hoist,
        winding,
        gains,
        rope={**of_ropes, **tails[0].parameters},
        settings={key: v for key, v in values.items() if key.partition(".")[0] not in ("hoist", "winding", "gains")},
        ropes=tuple(tails) if several else (),
        shared=of_ropes,
        given={key: one.status for key, one in everything.items()},
        sources={key: one.source for key, one in everything.items() if one.source},
        name=file.name,
        source=file.source,
        level=file.level,
        signals=tuple(file.signals),
        remarks=tuple(far),
    )


def _values(found: Mapping[str, Given]) -> dict[str, Value]:
    return {key: one.value for key, one in found.items()}


def _data(values: Mapping[str, Value]) -> tuple[Hoist, Winding, Gains]:
    parts = {}
    for section, kind in {"hoist": Hoist, "winding": Winding, "gains": Gains}.items():
        own = {key.removeprefix(f"{section}."): v for key, v in values.items() if key.startswith(f"{section}.")}
        try:
            parts[section] = with_values(kind(), own)
        except ValueError as error:
            raise ValueError(f"{section}: {error}") from error
    return parts["hoist"], parts["winding"], parts["gains"]


#: what hoists have: beyond it a value is remarked on, as one whose unit may be another
USUAL = {
    "hoist.payload_left": (200.0, 6e4),
    "hoist.payload_right": (200.0, 6e4),
    "hoist.conveyance_mass": (500.0, 8e4),
    "hoist.conveyance_mass_right": (500.0, 8e4),
    "hoist.sheave_mass": (500.0, 2e5),
    "hoist.sheave_radius": (0.4, 5.0),
    "hoist.torque_limit": (1e3, 5e6),
    "hoist.power_limit": (1e4, 2e7),
    "hoist.head_rope_mass": (0.3, 30.0),
    "hoist.head_rope_stiffness": (3e6, 5e8),
    "hoist.head_rope_length_up": (2.0, 200.0),
    "hoist.shaft_travel": (20.0, 3500.0),
    "winding.speed": (0.2, 25.0),
    "winding.acceleration": (0.05, 2.0),
    "winding.jerk": (0.05, 5.0),
    "winding.emergency_deceleration": (0.5, 10.0),
    "rope.length": (20.0, 3600.0),
    "rope.mass_per_length": (0.3, 40.0),
    "rope.diameter": (0.008, 0.12),
    "rope.Qa": (1e6, 1e9),
    "layout.spacing": (0.3, 8.0),
}


def remarks(values: Mapping[str, Value]) -> Iterable[str]:
    """Yield a line on each value that is far from what hoists have."""
    units = {**rope_parameters(), **host_parameters()}
    for key, (low, high) in USUAL.items():
        value = values.get(key)
        if isinstance(value, float) and value != 0.0 and math.isfinite(value) and not low <= abs(value) <= high:
            unit = units[key].unit
            yield f"{key} = {value:g} {unit} is far from what hoists have, {low:g} to {high:g} {unit}: check its unit"
