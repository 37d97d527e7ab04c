"""The FMI interface: one table, from which XML, documentation and component all read.

Parameters are the fields of rope_model.parameters, outputs the signals of rope_model.simulation.signals.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple

from rope_model.parameters import LEAST, PRESETS, Layout, Level, Mesh, Model, Preset, Rope, Scene, Solver, Swivel
from rope_model.simulation.ends import SIDES, EndMotion
from rope_model.simulation.signals import SIGNALS

Causality = Literal["parameter", "input", "output"]
Kind = Literal["Real", "Integer", "Boolean", "String"]
Value = float | int | bool | str

#: start values by name that are put in place of a preset's
NO_CHANGES: Mapping[str, Value] = {}

#: words for the integer codes of parameters that choose one of a few; the code is the place in the list
CHOICES: dict[str, tuple[str, ...]] = {
    "swivel.mode": ("locked", "free", "coulomb"),
    "mesh.kind": ("tmn", "eem", "auto"),
    "solver.kernels": ("auto", "compiled", "portable"),
    "model.rung": ("auto", "torsional", "spatial", "planar", "rigid"),
}
#: what each of the choices means
MEANINGS: dict[str, tuple[str, ...]] = {
    "swivel.mode": ("the end does not turn", "it turns without friction", "it turns against dry friction"),
    "mesh.kind": (
        "TMN-ETM: segments that follow the loop",
        "EEM: elements of equal length",
        "fitted to the rope: TMN-ETM, or EEM on a short or stiff rope",
    ),
    "solver.kernels": (
        "compiled where there is a compiler",
        "compiled, else an error",
        "interpreted, everywhere the same",
    ),
    "model.rung": (
        "the lowest rung that the scene needs",
        "all: tension, torsion and lateral motion, coupled",
        "lateral motion in space, without torsion",
        "motion in the plane of the loop",
        "end forces of an inextensible rope in closed form, without bending and waves",
    ),
}
#: name of a field -> unit and description; the order is that of the interface
_ROPE = {
    "length": ("m", "length of the rope between its two swivels"),
    "mass_per_length": ("kg/m", "mass per length [assumed]"),
    "Qa": ("N", "axial stiffness, T = Qa e + Qb tau [assumed]"),
    "Qb": ("N.m", "tension per twist; default is the symmetric mean of the published pair"),
    "Qc": ("N.m", "torque per axial strain, M = Qc e + Qd tau; default as Qb"),
    "Qd": ("N.m2", "torsional stiffness [assumed]"),
    "EI": ("N.m2", "bending stiffness [assumed]; 74 with full slip of the wires, 2.4e4 with none"),
    "rhoJ": ("kg.m", "polar mass moment per length [assumed]"),
    "beta_K": ("s", "material damping proportional to stiffness [assumed]"),
    "diameter": ("m", "rope diameter, for nominal stresses and clearance [assumed]"),
    "installed_twist": ("rad", "turns put in at the right end before it was fastened"),
}
_LAYOUT = {
    "spacing": ("m", "horizontal distance of the two suspension points [assumed]"),
    "gravity": ("m/s2", "acceleration of free fall"),
}
_SWIVEL = {
    "mode": ("", "how the {side} end is held: 0 locked, 1 free, 2 Coulomb friction"),
    "mean_diameter": ("m", "mean diameter of the {side} swivel's bearing [assumed]"),
    "mu_static": ("1", "coefficient of static friction of the {side} swivel [assumed]"),
    "mu_kinetic": ("1", "coefficient of kinetic friction of the {side} swivel [assumed]"),
    "seal_moment": ("N.m", "friction of the {side} swivel that does not depend on the tension [assumed]"),
    "inertia": ("kg.m2", "inertia of what turns with the rope's {side} end [assumed]"),
    "release_time": ("s", "the {side} swivel is locked before"),
}
_MESH = {
    "kind": (
        "",
        "0 TMN-ETM, segments that follow the loop; 1 EEM, equal lengths; 2 fitted: 0, or 1 on a short or stiff rope",
    ),
    "elements": ("", "number of elements, kind 1 only"),
    "coarse_length": (
        "m",
        "element length of segments I and VII, kind 0 only; the loop's are 1/8 of it, without III and V 1/4",
    ),
    "end_levels": ("", "how often the outermost elements are halved towards the clamped ends, kind 0 only"),
    "leg_growth": ("m", "largest (element length)^2 in I and VII over distance from the loop, kind 0 only; 0: all l"),
    "loop_error": ("m", "error of the loop's place that the mesh may bring, kind 2 only"),
}
_SOLVER = {
    "step_max": ("s", "largest time step"),
    "step_min": ("s", "smallest time step; below it a step fails"),
    "tolerance": ("1", "largest local error of a step, in m and rad"),
    "newton_tolerance": ("1", "error that Newton's method may leave, in m and rad"),
    "rho_inf": ("1", "spectral radius of generalized-alpha at infinite frequency"),
    "kernels": ("", "0 compiled when possible, 1 compiled, 2 portable"),
}
_MODEL = {
    "rung": ("", "how much of the rope is computed: 0 auto, 1 torsional (all), 2 spatial, 3 planar, 4 rigid"),
    "force_tolerance": ("1", "relative error of the end forces that auto may trade for speed"),
}
_TUNABLE = {"step_max", "step_min", "tolerance", "newton_tolerance", "mu_static", "mu_kinetic", "seal_moment"}
#: least and largest value that the rope takes; FMI knows no bound that is itself refused
_MINIMUM = {
    **dict.fromkeys(("length", "mass_per_length", "Qa", "Qd", "EI", "rhoJ", "diameter", "spacing", "gravity"), LEAST),
    **dict.fromkeys(("mean_diameter", "inertia", "coarse_length", "step_max", "step_min"), LEAST),
    **dict.fromkeys(("tolerance", "newton_tolerance"), LEAST),
    **dict.fromkeys(("beta_K", "mu_static", "mu_kinetic", "seal_moment", "leg_growth", "rho_inf"), 0.0),
    "force_tolerance": 0.0,
    "installed_twist": -1e3,
    "elements": 2,
    "end_levels": 0,
    "loop_error": 1e-5,
}
_MAXIMUM = {
    "length": 1e4,
    "diameter": 1.0,
    "installed_twist": 1e3,
    "elements": 20000,
    "end_levels": 8,
    "leg_growth": 1e4,
    "loop_error": 1.0,
    "step_max": 1.0,
    "step_min": 1.0,
    "tolerance": 1.0,
    "newton_tolerance": 1e-3,
    "rho_inf": 1.0,
    "force_tolerance": 1.0,
}
#: least element counts of the segments II to VI
_COUNTS = (0, 0, 2, 0, 0)
#: inputs beyond are refused: metres or radians, their rates, accelerations (simulation.ends.checked)
_REACH = {"m": 1e4, "rad": 1e4, "m/s": 60.0, "rad/s": 60.0, "m/s2": 100.0}
#: outputs that are never negative
_NOT_NEGATIVE = ("count.", "stress.", "shape.bending", "shape.torsion", "energy.kinetic")
_INPUT_UNIT = {"": "m", "v": "m/s", "a": "m/s2"}
#: names of the inputs of each side in the order of EndMotion
MOTION = {side: tuple(f"{side}.{field.name}" for field in dataclasses.fields(EndMotion)) for side in SIDES}
SEGMENTS = ("II", "III", "IV", "V", "VI")


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
    return CHOICES.get(".".join(name.split(".")[-2:]))


def variables(preset: Preset) -> tuple[Variable, ...]:
    """The table with the start values of ``preset``; a variable's place is its value reference."""
    return (*_parameters(preset.scene), *_inputs(preset.travel), *_outputs())


def preset_with(name: str, level: Level, start: Mapping[str, Value]) -> Preset:
    """The preset ``name`` at a level of accuracy, but with these parameters and ``right.y``, by name."""
    if name not in PRESETS:
        raise ValueError(f"there is no scene {name!r}; choose one of {', '.join(PRESETS)}")
    preset = PRESETS[name](level)
    values = {v.name: v.start for v in _parameters(preset.scene) if v.start is not None}
    if unknown := set(start) - set(values) - {"right.y"}:
        raise ValueError(f"{', '.join(sorted(unknown))} must be parameters of the rope: see docs/interface.md")
    travel = float(start.get("right.y", preset.travel))
    return dataclasses.replace(preset, scene=scene_of({**values, **start}), travel=travel)


def _parameters(scene: Scene) -> Iterator[Variable]:
    groups: list[tuple[str, Any, dict[str, tuple[str, str]]]] = [
        ("rope", scene.rope, _ROPE),
        ("layout", scene.layout, _LAYOUT),
        *((f"{side}.swivel", getattr(scene, side), _SWIVEL) for side in SIDES),
        ("mesh", scene.mesh, _MESH),
        ("solver", scene.solver, _SOLVER),
        ("model", scene.model, _MODEL),
    ]
    for group, data, fields in groups:
        for field, (unit, description) in fields.items():
            value = getattr(data, field)
            words = choices_of(f"{group}.{field}")
            integer = words is not None or isinstance(value, int)
            yield Variable(
                name=f"{group}.{field}",
                causality="parameter",
                variability="tunable" if field in _TUNABLE else "fixed",
                kind="Integer" if integer else "Real",
                unit=unit,
                start=words.index(value) if words else value,
                description=description.format(side=group.split(".")[0]),
                minimum=0 if words else _MINIMUM.get(field),
                maximum=len(words) - 1 if words else _MAXIMUM.get(field),
            )
    for i, segment in enumerate(SEGMENTS):
        text = f"number of elements of segment {segment}, kind 0 only"
        name, start = f"mesh.counts[{i + 1}]", scene.mesh.counts[i]
        yield Variable(name, "parameter", "fixed", "Integer", "", start, text, _COUNTS[i])
    yield Variable(
        "inputs_at_step_end",
        "parameter",
        "fixed",
        "Boolean",
        "",
        False,
        "false: inputs are the motion at the start of a step and are extrapolated (FMI's reading; steps up to 20 ms); "
        "true: at its end, for hosts that step the drive first (recommended, any step)",
    )


def _inputs(travel: float) -> Iterator[Variable]:
    def one(name: str, unit: str, start: float, text: str) -> Variable:
        return Variable(name, "input", "continuous", "Real", unit, start, text, -_REACH[unit], _REACH[unit])

    for side in SIDES:
        for derivative, what in (("", "position"), ("v", "speed"), ("a", "acceleration")):
            for axis in "xyz":
                start = travel if (side, derivative + axis) == ("right", "y") else 0.0
                where = {"x": "in plane, from the nominal point", "y": "up", "z": "out of plane"}[axis]
                text = f"{what} of the {side} suspension point, {where}"
                yield one(f"{side}.{derivative}{axis}", _INPUT_UNIT[derivative], start, text)
        yield one(f"{side}.yaw", "rad", 0.0, f"yaw of the {side} conveyance about Y")
        yield one(f"{side}.yaw_rate", "rad/s", 0.0, f"rate of {side}.yaw")


def _outputs() -> Iterator[Variable]:
    kinds: dict[str, Kind] = {"real": "Real", "integer": "Integer", "boolean": "Boolean"}
    for name, signal in SIGNALS.items():
        kind = kinds[signal.kind]
        variability: Literal["continuous", "discrete"] = "continuous" if kind == "Real" else "discrete"
        unit = signal.unit if kind == "Real" else ""
        least = 0 if name.startswith(_NOT_NEGATIVE) else None
        yield Variable(name, "output", variability, kind, unit, None, signal.description, least)
    yield Variable("status.valid", "output", "discrete", "Boolean", "", None, "whether the last step succeeded")
    yield Variable("status.message", "output", "discrete", "String", "", None, "why not, and what to do; else empty")
    yield Variable("status.rung", "output", "discrete", "String", "", None, "rung of the model that is computed")
    yield Variable("status.rung_reason", "output", "discrete", "String", "", None, "why this rung")
    yield Variable(
        "status.warning", "output", "discrete", "String", "", None, "what to mind in valid results; else empty"
    )


def scene_of(values: dict[str, Value]) -> Scene:
    """The scene with the parameters in ``values``; ValueError when one is out of range."""

    def part(group: str, kind: type[Any], **more: Any) -> Any:
        out: dict[str, Any] = {}
        for field in dataclasses.fields(kind):
            if (value := values.get(f"{group}.{field.name}")) is None:
                continue
            name = f"{group.split('.')[-1]}.{field.name}"
            if (words := CHOICES.get(name)) is not None:
                if not 0 <= int(value) < len(words):
                    codes = ", ".join(f"{i} {word}" for i, word in enumerate(words))
                    raise ValueError(f"{group}.{field.name} = {value} is none of the choices: {codes}")
                value = words[int(value)]
            out[field.name] = value
        try:
            return kind(**out, **more)
        except ValueError as error:
            raise ValueError(f"{group}: {error}") from error

    counts = tuple(int(values[f"mesh.counts[{i + 1}]"]) for i in range(len(SEGMENTS)))
    return Scene(
        rope=part("rope", Rope),
        layout=part("layout", Layout),
        left=part("left.swivel", Swivel),
        right=part("right.swivel", Swivel),
        mesh=part("mesh", Mesh, counts=counts),
        solver=part("solver", Solver),
        model=part("model", Model),
    )
