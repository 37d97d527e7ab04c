"""A hoist's file: the hoist, its trip, controller, balance ropes and shaft.

Tables are [hoist] [winding] [gains] [shaper] [trajectory] [coupling] [arrival] of the host;
[layout] [air] [contact] [mesh] and others of all ropes; and a [[rope]] for each, with ``swivels``
for both of its own. What is left out is that of the hoist that ``like`` names, or follows by a
rule, or is a default.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache, cached_property
from typing import Annotated, Any, Self

from pydantic import (
    BeforeValidator,
    Field,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    model_validator,
)
from pydantic.json_schema import GenerateJsonSchema

from hoist_demo.cases.case import BUILTIN_HOISTS, FOLDER, BalanceRopeData, Case
from hoist_demo.cases.rules import apply_rules
from hoist_demo.files.reading import (
    File,
    Flat,
    contents,
    path_from_file,
    read,
    reading_chain,
    table_of,
)
from hoist_demo.files.registry import (
    at_both_ends,
    host_parameters,
    rope_parameters,
    run_fields,
    swivel_parameters,
)
from hoist_demo.files.rope_file import RopeValues
from hoist_demo.files.values import (
    GIVEN,
    ParameterValue,
    ParameterValues,
    Text,
    ValueStatus,
    read_text,
    value_type,
    with_status,
)
from hoist_demo.parameters import SIDES
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import FileParameter, leaves
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import Level

SUSPENSION_KEYS = ("x_left", "x_right", "z")
BREAK = ("breaks_at", "breaks_s")
_BREAKS = (
    FileParameter(
        "rope.breaks_at", "s", "Real", meaning="time of the rope's break; none without it"
    ),
    FileParameter(
        "rope.breaks_s", "m", "Real", meaning="place of the break, from the left end along the rope"
    ),
)
#: Parameters of the suspension and break of one of several ropes, by name.
SUSPENSION_PARAMETERS = {p.name: p for p in (*leaves(SuspensionOffset, "rope."), *_BREAKS)}
_DECIDES = ("construction", "from")  #: Keys that decide for another rope.
#: Parameters that the catalogue does not know.
_CATALOGUE_INPUTS = ("rope.length", "rope.diameter")


def _rope_parameters() -> list[FileParameter]:
    """Return what a rope has of its own; it presses another one with the same stiffness."""
    parameters = []
    for p in (*rope_parameters().values(), *swivel_parameters()):
        if p.name.startswith("rope."):
            parameters.append(p)
        elif not p.name.startswith("contact."):
            parameters.append(replace(p, name=f"rope.{p.name}"))
    return [*parameters, *SUSPENSION_PARAMETERS.values()]


class RopeTable(table_of("rope", _rope_parameters())):  # type: ignore[misc]
    """One balance rope, or several equal ones."""

    name: str = Field("", pattern="^([A-Za-z][A-Za-z0-9_]{0,39})?$")
    number: int = Field(1, ge=1, le=20, description="equal ropes, of which one is computed")
    file: RopeValues = Field({}, alias="from")
    construction: Text = Field("", description="one of the catalogue's")
    lay: Text = Field("right-hand", description="sense of the lay, of the catalogue")


def _rope_values(table: RopeTable) -> dict[str, Any]:
    """Return all that a [[rope]] sets; values by FMI name."""
    values: dict[str, Any] = {}
    for key, value in at_both_ends(contents(table)).items():
        of_rope = isinstance(value, ParameterValue) and "." not in key
        values[f"rope.{key}" if of_rope else key] = value
    return values


def _base(content: Any, info: ValidationInfo) -> HoistFile:
    """Return the hoist that ``like`` names."""
    name = read_text(content)
    if name in BUILTIN_HOISTS:
        return read_builtin(name)
    return read(path_from_file(info, name), HoistFile, reading_chain(info))


@cache
def read_builtin(name: str) -> HoistFile:
    """Return the file of a hoist that comes with the project, read once."""
    return read(FOLDER / f"{name}.toml", HoistFile)


_HOIST_FIELDS = {
    name: field for name, field in run_fields(value_type).items() if name not in ("rope", *SIDES)
}


class HoistFile(create_model("Tables", __base__=File, **_HOIST_FIELDS)):  # type: ignore[misc]
    """Schema of a hoist's TOML file."""

    name: Text = Field(description="of the hoist, in titles")
    source: Text = Field("", description="where the data come from")
    status: ValueStatus = Field(GIVEN, description="of values without one")
    like: Annotated[Any, BeforeValidator(_base), WithJsonSchema({"type": "string"})] = Field(
        None, description="a hoist, by name or file, whose values count where these leave off"
    )
    level: Level = Field("standard", description="accuracy against speed of the rope")
    signals: list[Text] = Field([], description="time series to record, * for any letters")
    rope: list[Annotated[dict[str, Any], Flat(RopeTable, _rope_values)]] = Field([])

    def settings(self) -> dict[str, Any]:
        """Return all values that the file sets, over those of the hoist that it is like.

        Each has its status.
        """
        settings: dict[str, Any] = self.like.settings() if self.like else {}
        here = {
            key: entry for key, entry in contents(self) if key not in ("like", "status", "rope")
        }
        ropes = [rope | with_status(rope.items(), self.status) for rope in self.rope]
        if ropes and "rope" in settings:
            bases = settings["rope"]
            if len(bases) != len(ropes):  # ropes of another number go on from the first
                bases = bases[:1] * len(ropes)
            ropes = [_inherited(base, rope) | rope for base, rope in zip(bases, ropes, strict=True)]
        settings |= here | with_status(here.items(), self.status)
        if ropes:
            settings["rope"] = ropes
        return settings

    @cached_property
    def case(self) -> Case:
        """Hoist of the file; a ValueError lists all that is wrong."""
        settings = self.settings()
        values = with_status(settings.items())
        host = {key: entry for key, entry in values.items() if key in host_parameters()}
        shared = {key: entry for key, entry in values.items() if key not in host}
        with Problems() as problems:
            if "rope" not in settings:
                problems.append("rope is missing: write [[rope]] above what it has")
            ropes = [
                _balance_rope(k, rope, shared, problems)
                for k, rope in enumerate(settings.get("rope", ()), 1)
            ]
            names = [rope.name for rope in ropes]
            for name in names:
                if names.count(name) > 1:
                    problems.append(f"rope name = {name!r} must be given once: name each rope")
        header = {name: settings[name] for name in ("source", "level") if name in settings}
        return apply_rules(
            host, ropes, name=self.name, signals=tuple(settings.get("signals", ())), **header
        )

    @model_validator(mode="after")
    def _is_a_hoist(self) -> Self:
        _ = self.case
        return self


def _inherited(base: dict[str, Any], rope: dict[str, Any]) -> dict[str, Any]:
    """Return what a rope inherits from the one of ``like``: nothing that decides another rope."""
    if not rope.keys() & {*_DECIDES}:
        return base
    inherited: dict[str, Any] = {}
    for key, entry in base.items():
        of_catalogue = key.startswith("rope.") and key not in _CATALOGUE_INPUTS
        if key not in (*_DECIDES, "lay") and (not of_catalogue or key in SUSPENSION_PARAMETERS):
            inherited[key] = entry
    return inherited


def _balance_rope(
    k: int, settings: dict[str, Any], shared: ParameterValues, problems: list[str]
) -> BalanceRopeData:
    """Return a rope; add what is wrong to the problems."""
    number = settings.get("number", 1)
    suspension = _numbers(settings, SUSPENSION_KEYS)
    breaks = _numbers(settings, BREAK)
    if len(breaks) == 1:
        problems.append(f"rope {k}: breaks_at and breaks_s must stand together: give both or none")
    if breaks and number > 1:
        problems.append(
            f"rope {k}: number = {number} must be 1 for a rope that breaks: give each its own "
            "[[rope]]"
        )
    values = {**shared, **settings.get("from", {})}
    for key, entry in with_status(settings.items()).items():
        if key not in SUSPENSION_PARAMETERS:
            values[key] = entry
    kind = {name: settings[name] for name in ("construction", "lay") if name in settings}
    name = settings.get("name") or f"rope{k}"
    return BalanceRopeData(name, values, number, suspension, breaks, **kind)


def _numbers(settings: Mapping[str, Any], keys: Iterable[str]) -> dict[str, float]:
    """Return those of the rope's numbers that are set."""
    names = {key: f"rope.{key}" for key in keys}
    return {key: float(settings[name].value) for key, name in names.items() if name in settings}


class _WithoutDefaults(GenerateJsonSchema):
    """Schema of a file: its tables state what is left out, and TOML has no null."""

    def default_schema(self, schema: Any) -> dict[str, Any]:
        return self.generate_inner(schema["schema"])


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a hoist's file."""
    json_schema: dict[str, Any] = HoistFile.model_json_schema(schema_generator=_WithoutDefaults)
    return json_schema
