"""Table of the FMI variables, the source of XML, documentation and component.

Parameters are those of rope_model.scene_names, outputs those of rope_model.signals.signal_table.
"""

import dataclasses
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Literal

from rope_model.boundary.end_paths import EndMotion
from rope_model.cases import ROPE_CASES, Level, RopeCase
from rope_model.parameter_table import numeric_bounds, parameters_of
from rope_model.parameters import Scene
from rope_model.physics.node import SIDES
from rope_model.scene_names import Value, named_parameters, scene_with_values
from rope_model.scene_names import Variable as Variable
from rope_model.signals.signal_table import SIGNALS

Kind = Literal["Real", "Integer", "Boolean", "String"]

#: parameter that has the model's accuracy, in place of the tolerance of FMI
ACCURACY = "accuracy.end_force"
#: parameter that is true if the inputs of a step are those at its end
INPUTS_AT_STEP_END = "inputs_at_step_end"
#: start values by name that replace those of a case
NO_CHANGES: Mapping[str, Value] = {}

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
_KINDS: dict[str, Kind] = {"real": "Real", "integer": "Integer", "boolean": "Boolean"}
#: outputs of the component, not of the model
_STATUS: dict[str, tuple[Kind, str]] = {
    "valid": ("Boolean", "whether the last step succeeded"),
    "message": ("String", "cause and cure of a failure; else empty"),
    "fidelity": ("String", "fidelity of the model that is computed"),
    "fidelity_reason": ("String", "reason for this fidelity"),
    "warning": ("String", "warnings about valid results; else empty"),
}
#: names of the inputs of each side in the order of EndMotion
MOTION = {
    side: tuple(f"{side}.{field.name}" for field in dataclasses.fields(EndMotion)) for side in SIDES
}


_RATES = {"yaw": "yaw_rate", "x": "vx", "y": "vy", "z": "vz", "vx": "ax", "vy": "ay", "vz": "az"}
#: input that is the time derivative of an input
RATES = {f"{side}.{name}": f"{side}.{_RATES[name]}" for side, name in product(SIDES, _RATES)}


def variables(case: RopeCase) -> tuple[Variable, ...]:
    """Return the table with the start values of ``case``.

    The index of a variable is its value reference.
    """
    return (*_parameters(case.scene), *_inputs(case), *_outputs())


def case_with(name: str, level: Level, start: Mapping[str, Value]) -> RopeCase:
    """Return the case ``name`` at a level of accuracy, with these start values by name.

    They are parameters, and the heights ``left.y`` and ``right.y``.
    """
    if name not in ROPE_CASES:
        raise ValueError(f"there is no case {name!r}; choose one of {', '.join(ROPE_CASES)}")
    case = ROPE_CASES[name](level)
    parameters = {key: value for key, value in start.items() if key not in ("left.y", "right.y")}
    return dataclasses.replace(
        case,
        scene=scene_with_values(case.scene, parameters),
        start=float(start.get("left.y", case.start)),
        travel=float(start.get("right.y", case.travel)),
    )


def _parameters(scene: Scene) -> Iterator[Variable]:
    for p in named_parameters(scene):
        text = p.facts.description.format(side=p.name.partition(".")[0])
        variability: Literal["fixed", "tunable"] = "tunable" if p.facts.tunable else "fixed"
        yield Variable(
            name=p.name,
            causality="parameter",
            variability=variability,
            kind=p.kind,
            unit=p.facts.unit,
            start=p.value,
            description=text,
            minimum=p.minimum,
            maximum=p.maximum,
        )
    text = (
        "false: inputs are the motion at the start of a step, extrapolated (steps up to 20 ms); "
        "true: at its end, for hosts that step the drive first (recommended, any step)"
    )
    yield Variable(INPUTS_AT_STEP_END, "parameter", "fixed", "Boolean", "", False, text)


def _inputs(case: RopeCase) -> Iterator[Variable]:
    for side, height in zip(SIDES, (case.start, case.travel), strict=True):
        for name, p in parameters_of(EndMotion).items():
            start = height if name == "y" else 0.0
            minimum, maximum = numeric_bounds(EndMotion, name)
            yield Variable(
                name=f"{side}.{name}",
                causality="input",
                variability="continuous",
                kind="Real",
                unit=p.unit,
                start=start,
                description=p.description.format(side=side),
                minimum=minimum,
                maximum=maximum,
            )


def _outputs() -> Iterator[Variable]:
    for name, signal in SIGNALS.items():
        variable = Variable(
            name=name,
            causality="output",
            variability="discrete",
            kind=_KINDS[signal.kind],
            unit="",
            start=None,
            description=signal.description,
        )
        if variable.kind == "Real":
            variable = variable._replace(variability="continuous", unit=signal.unit)
        if name.startswith(_NOT_NEGATIVE):
            variable = variable._replace(minimum=0)
        yield variable
    for name, (kind, text) in _STATUS.items():
        yield Variable(f"status.{name}", "output", "discrete", kind, "", None, text)
