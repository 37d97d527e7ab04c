"""The FMI interface: one table, from which XML, documentation and component all read.

Parameters are the fields of rope_model.parameters, outputs the signals of rope_model.simulation.outputs.signals.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple

from rope_model.parameter_table import numeric_bounds, parameters_of
from rope_model.parameters import (
    CHOICES,
    ROPE_CASES,
    SEGMENTS,
    Accuracy,
    Inputs,
    Layout,
    Level,
    Mesh,
    Model,
    Rope,
    RopeCase,
    Scene,
    Solver,
    Stations,
    Swivel,
)
from rope_model.shaft_parameters import PARTS, Shaft
from rope_model.simulation.ends.paths import SIDES, EndMotion
from rope_model.simulation.outputs.signal_table import SIGNALS

Causality = Literal["parameter", "input", "output"]
Kind = Literal["Real", "Integer", "Boolean", "String"]
Value = float | int | bool | str

#: start values by name that are put in place of a case's
NO_CHANGES: Mapping[str, Value] = {}

#: group of the interface -> the data class that has its parameters
_GROUPS: dict[str, type[Any]] = {
    "rope": Rope,
    "layout": Layout,
    "left.swivel": Swivel,
    "right.swivel": Swivel,
    "mesh": Mesh,
    "accuracy": Accuracy,
    "solver": Solver,
    "model": Model,
    "inputs": Inputs,
    "station": Stations,
    **PARTS,
}
#: outputs that are never negative
_NOT_NEGATIVE = (
    "count.",
    "stress.",
    "shape.s",
    "shape.bending",
    "shape.torsion",
    "station.curvature",
    "energy.kinetic",
)
#: names of the inputs of each side in the order of EndMotion
MOTION = {side: tuple(f"{side}.{field.name}" for field in dataclasses.fields(EndMotion)) for side in SIDES}


#: input -> the input that is its time derivative
RATES = {
    f"{side}.{of}": f"{side}.{rate}"
    for side in SIDES
    for of, rate in (("yaw", "yaw_rate"), *((x, f"v{x}") for x in "xyz"), *((f"v{x}", f"a{x}") for x in "xyz"))
}


class Variable(NamedTuple):
    """One FMI variable; ``start`` is None for outputs, ``unit`` empty where there is none."""

    name: str
    causality: Causality
    variability: Literal["fixed", "tunable", "continuous", "discrete"]
    kind: Kind
    unit: str
    start: Value | None
    description: str
    minimum: float | None = None
    maximum: float | None = None


def choices_of(name: str) -> tuple[str, ...] | None:
    """Words for the codes of the variable ``name``; None for one that does not choose."""
    words = CHOICES.get(".".join(name.split(".")[-2:]))
    return None if words is None else tuple(words)


def variables(case: RopeCase) -> tuple[Variable, ...]:
    """The table with the start values of ``case``; a variable's place is its value reference."""
    return (*_parameters(case.scene), *_inputs(case.travel), *_outputs())


def case_with(name: str, level: Level, start: Mapping[str, Value]) -> RopeCase:
    """The case ``name`` at a level of accuracy, but with these parameters and ``right.y``, by name."""
    if name not in ROPE_CASES:
        raise ValueError(f"there is no case {name!r}; choose one of {', '.join(ROPE_CASES)}")
    case = ROPE_CASES[name](level)
    values = {v.name: v.start for v in _parameters(case.scene) if v.start is not None}
    if unknown := set(start) - set(values) - {"right.y"}:
        raise ValueError(
            f"{', '.join(sorted(unknown))} must be parameters of the rope: see docs/reference/variables.md"
        )
    travel = float(start.get("right.y", case.travel))
    return dataclasses.replace(case, scene=scene_of({**values, **start}), travel=travel)


def _parameters(scene: Scene) -> Iterator[Variable]:
    for group, kind in _GROUPS.items():
        data = _part(scene, group)
        names = (name for name in parameters_of(kind) if name != "counts")
        yield from (_parameter(f"{group}.{name}", kind, getattr(data, name)) for name in names)
    for i, (segment, least) in enumerate(SEGMENTS.items()):
        text = parameters_of(Mesh)["counts"].description.format(segment=segment)
        name, start = f"mesh.counts[{i + 1}]", scene.mesh.counts[i]
        yield Variable(name, "parameter", "fixed", "Integer", "", start, text, least)
    yield Variable(
        "inputs_at_step_end",
        "parameter",
        "fixed",
        "Boolean",
        "",
        False,
        "false: inputs are the motion at the start of a step, extrapolated (steps up to 20 ms); "
        "true: at its end, for hosts that step the drive first (recommended, any step)",
    )


def _parameter(name: str, kind: type[Any], value: Any) -> Variable:
    group, _, field = name.rpartition(".")
    p = parameters_of(kind)[field]
    words = tuple(p.choices)
    minimum, maximum = (0, len(words) - 1) if words else numeric_bounds(kind, field)
    return Variable(
        name=name,
        causality="parameter",
        variability="tunable" if p.tunable else "fixed",
        kind="Integer" if words or isinstance(value, int) else "Real",
        unit=p.unit,
        start=words.index(value) if words else value,
        description=p.description.format(side=group.split(".")[0]),
        minimum=minimum,
        maximum=maximum,
    )


def _inputs(travel: float) -> Iterator[Variable]:
    for side in SIDES:
        for name, p in parameters_of(EndMotion).items():
            start = travel if (side, name) == ("right", "y") else 0.0
            text = p.description.format(side=side)
            bounds = numeric_bounds(EndMotion, name)
            yield Variable(f"{side}.{name}", "input", "continuous", "Real", p.unit, start, text, *bounds)


def _outputs() -> Iterator[Variable]:
    kinds: dict[str, Kind] = {"real": "Real", "integer": "Integer", "boolean": "Boolean"}
    for name, signal in SIGNALS.items():
        kind = kinds[signal.kind]
        variability: Literal["continuous", "discrete"] = "continuous" if kind == "Real" else "discrete"
        unit = signal.unit if kind == "Real" else ""
        least = 0 if name.startswith(_NOT_NEGATIVE) else None
        yield Variable(name, "output", variability, kind, unit, None, signal.description, least)
    yield Variable("status.valid", "output", "discrete", "Boolean", "", None, "whether the last step succeeded")
    yield Variable(
        "status.message", "output", "discrete", "String", "", None, "cause and cure of a failure; else empty"
    )
    yield Variable(
        "status.fidelity", "output", "discrete", "String", "", None, "fidelity of the model that is computed"
    )
    yield Variable("status.fidelity_reason", "output", "discrete", "String", "", None, "reason for this fidelity")
    yield Variable(
        "status.warning", "output", "discrete", "String", "", None, "warnings about valid results; else empty"
    )


def _part(scene: Scene, group: str) -> Any:
    """The part of the scene that has the parameters of a group."""
    return getattr(scene.shaft if group in PARTS else scene, group.removesuffix(".swivel"))


def scene_of(values: Mapping[str, Value]) -> Scene:
    """The scene with the parameters in ``values``; ValueError when one is out of range."""
    counts = tuple(int(values[f"mesh.counts[{i + 1}]"]) for i in range(len(SEGMENTS)))
    parts = {}
    for group, kind in _GROUPS.items():
        names = parameters_of(kind)
        given: dict[str, Any] = {
            n: _decode(f"{group}.{n}", values[f"{group}.{n}"]) for n in names if f"{group}.{n}" in values
        }
        if kind is Mesh:
            given["counts"] = counts
        try:
            parts[group.removesuffix(".swivel")] = kind(**given)
        except ValueError as error:
            raise ValueError(f"{group}: {error}") from error
    shaft = Shaft(**{name: parts.pop(name) for name in PARTS})
    return Scene(**parts, shaft=shaft)


def _decode(name: str, value: Value) -> Value:
    """The value as its field takes it: the word for the code of one that chooses."""
    if (words := choices_of(name)) is None:
        return value
    if not 0 <= int(value) < len(words):
        codes = ", ".join(f"{i} {word}" for i, word in enumerate(words))
        raise ValueError(f"{name} = {value} is none of the choices: {codes}")
    return words[int(value)]
