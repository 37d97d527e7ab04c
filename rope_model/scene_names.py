"""Parameters of a scene by the names of the FMI interface, such as ``rope.EI``, with choices as codes."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, Literal, NamedTuple

from rope_model.parameter_table import Parameter, numeric_bounds, parameters_of
from rope_model.parameters import CHOICES, PARAMETER_GROUPS, Scene
from rope_model.shaft_parameters import PARTS
from rope_model.solver_parameters import INNER_SEGMENTS, Mesh

Value = float | int | bool | str


class Variable(NamedTuple):
    """FMI variable; ``start`` is None for outputs, ``unit`` is empty without unit."""

    name: str
    causality: Literal["parameter", "input", "output"]
    variability: Literal["fixed", "tunable", "continuous", "discrete"]
    kind: Literal["Real", "Integer", "Boolean", "String"]
    unit: str
    start: Value | None
    description: str
    minimum: float | None = None
    maximum: float | None = None


class NamedParameter(NamedTuple):
    """Parameter with its value in a scene, as a code if it is a choice."""

    name: str
    value: float | int
    facts: Parameter
    minimum: float | None
    maximum: float | None

    @property
    def kind(self) -> Literal["Integer", "Real"]:
        """FMI's word for the type."""
        return "Integer" if isinstance(self.value, int) else "Real"


def choices_of(name: str) -> tuple[str, ...]:
    """Return the words for the codes of the variable ``name``; none if it has no choices."""
    return tuple(CHOICES.get(".".join(name.split(".")[-2:]), ()))


class _Field(NamedTuple):
    """Place of a parameter in the data classes, and what is the same in all scenes."""

    name: str
    group: str
    field: str
    facts: Parameter
    words: tuple[str, ...]  # choices
    kind: type[float | int]  # a number may be given as one of the other type
    minimum: float | None
    maximum: float | None


@cache
def _fields() -> tuple[_Field, ...]:
    """Return the fields of all groups but the mesh's counts, in the order of the interface."""
    found: list[_Field] = []
    for group, data in PARAMETER_GROUPS.items():
        for field, p in parameters_of(data).items():
            name = f"{group}.{field}"
            words = tuple(p.choices)
            if words:
                found.append(_Field(name, group, field, p, words, int, 0, len(words) - 1))
            elif field != "counts":
                kind = type(getattr(data, field))
                found.append(_Field(name, group, field, p, (), kind, *numeric_bounds(data, field)))
    return tuple(found)


@cache
def _counts() -> tuple[tuple[str, Parameter, int], ...]:
    """Return name, facts and least value of the number of elements of each segment of the mesh."""
    p = parameters_of(Mesh)["counts"]
    found: list[tuple[str, Parameter, int]] = []
    for i, (segment, min_count) in enumerate(INNER_SEGMENTS.items(), 1):
        facts = p._replace(description=p.description.format(segment=segment))
        found.append((f"mesh.counts[{i}]", facts, min_count))
    return tuple(found)


@cache
def _kinds() -> dict[str, str]:
    """Return FMI's word for the type of each parameter by name."""
    return {p.name: p.kind for p in named_parameters(Scene())}


def named_parameters(scene: Scene) -> Iterator[NamedParameter]:
    """Yield the parameters in the order of the interface."""
    parts = {group: _part(scene, group) for group in PARAMETER_GROUPS}
    for name, group, field, facts, words, kind, minimum, maximum in _fields():
        value = getattr(parts[group], field)
        code = words.index(value) if words else kind(value)
        yield NamedParameter(name, code, facts, minimum, maximum)
    for value, (name, facts, min_count) in zip(scene.mesh.counts, _counts(), strict=True):
        yield NamedParameter(name, value, facts, min_count, None)


def scene_with_values(scene: Scene, values: Mapping[str, Value]) -> Scene:
    """Return the scene with other parameters by name; ValueError for unknown ones and values out of range."""
    chosen: dict[str, dict[str, Any]] = {}
    counts = [*scene.mesh.counts]
    known = _kinds()
    value: Any
    for name, value in values.items():
        if name not in known:
            raise ValueError(
                f"{name} = {value!r} must be a parameter of the rope: see docs/reference/variables.md"
            )
        if (
            known[name] == "Integer"
            and isinstance(value, float)
            and not (value.is_integer() or choices_of(name))
        ):
            raise ValueError(f"{name} = {value!r} must be a whole number: leave out the fraction")
        group, _, field = name.rpartition(".")
        if field.startswith("counts["):
            counts[int(field[len("counts[") : -1]) - 1] = int(value)
            field = "counts"
            value = tuple(counts)
        chosen.setdefault(group, {})[field] = _decode(name, value)
    parts = {}
    for group, fields in chosen.items():
        try:
            parts[group] = replace(_part(scene, group), **fields)
        except ValueError as error:
            raise ValueError(f"{group}: {error}") from error
    shaft = replace(scene.shaft, **{name: parts.pop(name) for name in PARTS if name in parts})
    return scene.with_(
        **{group.removesuffix(".swivel"): part for group, part in parts.items()}, shaft=shaft
    )


def _part(scene: Scene, group: str) -> Any:
    """Return the part of the scene with the parameters of a group."""
    return getattr(scene.shaft if group in PARTS else scene, group.removesuffix(".swivel"))


def _decode(name: str, value: Any) -> Any:
    """Return the value as its field takes it: a word for the code of a choice."""
    words = choices_of(name)
    if not words:
        return value
    if value not in range(len(words)):
        codes = ", ".join(f"{i} {word}" for i, word in enumerate(words))
        raise ValueError(f"{name} = {value!r} is none of the choices: {codes}")
    return words[int(value)]
