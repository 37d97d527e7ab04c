"""C text of the tables of signals and parameters: numbers, structures and checks."""

import re
from collections.abc import Iterator
from typing import Any, get_args

from rope_model.boundary.bodies import BODIES
from rope_model.boundary.end_paths import MOTION_BOUNDS
from rope_model.codegen.expressions import texts_of
from rope_model.codegen.state_structures import MESSAGE, structure_code
from rope_model.codegen.structures import (
    GROUP_STRUCTURES,
    EndMotionStructure,
    SceneStructure,
    ShaftStructure,
    members,
)
from rope_model.codegen.symbols import SPELT, code_name, structure_at
from rope_model.fidelity.choice import FIDELITIES
from rope_model.fidelity.neglected_effects import neglected_text
from rope_model.method.stepping import MIN_INTERVAL
from rope_model.parameter_table import CrossCheck, Parameter, check_order, parameters_of
from rope_model.parameters import PARAMETER_GROUPS
from rope_model.physics.elementary import logical_and
from rope_model.physics.expressions import no_simplification
from rope_model.physics.initial_curvature import CURVATURES
from rope_model.physics.node import SIDES
from rope_model.shaft_parameters import PARTS
from rope_model.signals.signal_groups import c_function_of
from rope_model.signals.signal_table import SHAPE_POINTS, SIGNALS
from rope_model.solver_parameters import MAX_ELEMENTS, FidelityChoice
from rope_model.texts import c_string
from rope_model.warnings.result_warnings import WARNINGS

_HEAD = "/* Generated from the parameters of rope_model by rope_model.codegen.tables. */\n"


def signal_numbers() -> str:
    """Return the text of signal_numbers.h: the signals' numbers and groups, and the warning of each simplified model.

    A number is the index in SIGNALS, a group the function of csrc/outputs/signals.c that computes
    the signal.
    """
    numbers = "".join(f"    {constant(name)},\n" for name in SIGNALS)
    functions = list(dict.fromkeys(map(c_function_of, SIGNALS)))
    groups = ", \\\n".join(f"    {functions.index(c_function_of(name))}" for name in SIGNALS)
    names = ", ".join(functions)
    texts = ", \\\n".join(
        f"    {c_string(neglected_text(fidelity) if fidelity in FIDELITIES else '')}"
        for fidelity in get_args(FidelityChoice)
    )
    return (
        "/* Generated from rope_model.signals.signal_groups and neglected_effects "
        "by rope_model.codegen.tables. */\n"
        "#ifndef SIGNAL_NUMBERS_H\n#define SIGNAL_NUMBERS_H\n\n"
        f"enum {{\n{numbers}    SIGNALS,\n    SHAPE_POINTS = {SHAPE_POINTS}\n}};\n\n"
        f"/* functions that compute signals, and the place of its own of each signal */\n"
        f"#define GROUP_FUNCTIONS {{{names}}}\n#define SIGNAL_GROUPS {{ \\\n{groups}}}\n\n"
        f"/* kinds of bodies in words */\n#define BODY_WORDS {{{', '.join(map(c_string, BODIES.values()))}}}\n\n"
        f"/* the warning of each fidelity, by its code */\n#define LEFT_OUT_TEXTS {{ \\\n{texts}}}\n\n#endif\n"
    )


def constant(name: str) -> str:
    """Return the name of a signal's number in C: SIGNAL_SHAPE_X_1 for ``shape.x[1]``."""
    return "SIGNAL_" + re.sub(r"\W+", "_", name).strip("_").upper()


def parameter_structures() -> str:
    """Return the text of parameters.h: bounds of motions, codes of choices, a structure for each group."""
    parts = [
        f"/* bytes for a message, with its terminating zero */\nenum {{ MESSAGE = {MESSAGE} }};\n",
        f"/* number of kinds of warnings */\nenum {{ ROPE_WARNINGS = {len(WARNINGS)} }};\n",
        f"enum {{ MAX_ELEMENTS = {MAX_ELEMENTS} }};\n",
    ]
    names = ", ".join(map(c_string, MOTION_BOUNDS))
    reach = ", ".join(map(repr, MOTION_BOUNDS.values()))
    offsets = ", ".join(f"offsetof(EndMotion, {name})" for name in MOTION_BOUNDS)
    parts.append(
        "/* of the values of an EndMotion: number, names, largest sizes and offsets */\n"
        f"enum {{ END_MOTIONS = {len(MOTION_BOUNDS)} }};\n"
        f"#define END_MOTION_NAMES {{{names}}}\n#define END_MOTION_BOUNDS {{{reach}}}\n"
        f"#define END_MOTION_OFFSETS {{{offsets}}}\n"
    )
    curvatures = ", ".join(f"&(rope).{name}" for name in CURVATURES)
    parts.append(
        f"/* all values of a Rope's permanent curvature */\n#define CURVATURES_OF(rope) {{{curvatures}}}\n"
    )
    parts.append(f"/* s, of rope_advance_to */\n#define ROPE_MIN_INTERVAL {MIN_INTERVAL}\n")
    parts += [
        *(_codes(*choice) for kind in GROUP_STRUCTURES for choice in _choices(kind)),
        *map(_structure, GROUP_STRUCTURES),
    ]
    parts += map(structure_code, (ShaftStructure, SceneStructure, EndMotionStructure))
    text = "\n".join(parts)
    guard = "#ifndef PARAMETERS_H\n#define PARAMETERS_H\n"
    return f"{_HEAD}{guard}\n#include <stddef.h>\n\n{text}\n#endif\n"


def parameter_bounds() -> str:
    """Return the text of parameters.inc: a function for each group that checks its parameters in their order."""
    return _HEAD + "".join(map(_bounds, GROUP_STRUCTURES)) + _scene_check()


def _choices(kind: type[Any]) -> Iterator[tuple[str, tuple[str, ...]]]:
    for name, p in parameters_of(kind).items():
        if p.choices:
            yield name, tuple(p.choices)


def _codes(name: str, words: tuple[str, ...]) -> str:
    """Return the codes of a choice, and a macro with its words to initialise an array."""
    codes = ", ".join(code_name(name, word) for word in words)
    quoted = ", ".join(c_string(word) for word in words)
    return f"enum {{ {codes} }};\n#define {SPELT.get(name, name.upper())}_WORDS {{{quoted}}}\n"


def _structure(kind: type[Any]) -> str:
    table = parameters_of(kind)
    lines = []
    for m in members(kind):
        unit = table[m.name].unit
        text = table[m.name].description
        array = f"[{m.length}]" if m.length else ""
        lines.append(
            f"    {'double' if m.real else 'int'} {m.name}{array}; /* {unit}{', ' * bool(unit)}{text} */\n"
        )
    return f"typedef struct {{\n{''.join(lines)}}} {kind.__name__};\n"


def _bounds(kind: type[Any]) -> str:
    """Return check_rope and so on, which check in the order of ParameterGroup.require_in_bounds."""
    known = {m.name: m for m in members(kind)}
    table = [(name, p) for name, p in check_order(kind) if name in known and not known[name].length]
    calls = [f'require_finite(check, "{name}", x->{name})' for name, _ in table if known[name].real]
    calls += [_choice(name, p) for name, p in table if p.choices]
    calls += [_range(name, p, known[name].real) for name, p in table if p.bound and not p.choices]
    with no_simplification():
        body = "".join(
            [f"    {call};\n" for call in calls]
            + [_cross_check(kind, x) for x in kind.cross_checks]
        )
    head = (
        f"static void check_{kind.__name__.lower()}(const Check *check, const {kind.__name__} *x)"
    )
    return f"\n{head} {{\n{body}}}\n"


def _scene_check() -> str:
    """Return check_scene, which checks every group under its name for hosts."""
    names = {f"{side}.swivel": f"swivels[{k}]" for k, side in enumerate(SIDES)}
    names |= {part: f"shaft.{part}" for part in PARTS}
    calls = [
        f'    check_{kind.__name__.lower()}(&(Check){{"{name}", message}}, &scene->{names.get(name, name)});\n'
        for name, kind in PARAMETER_GROUPS.items()
    ]
    return (
        "\nRopeStatus check_scene(const Scene *scene, char *message) {\n    message[0] = '\\0';\n"
        f"{''.join(calls)}    return message[0] ? ROPE_FAILED : ROPE_DONE;\n}}\n"
    )


def _cross_check(kind: type[Any], check: CrossCheck) -> str:
    """Return a block that refuses values which violate a cross-check; numbers from integers are printed as such."""
    x = structure_at(kind, "x->")
    holds, value, *number = check.formula(x)
    values = value if isinstance(value, tuple) else (value,)
    lines, (condition, *numbers) = texts_of([logical_and(*holds), *values, *number])
    used = set(re.findall(r"x->(\w+)", "".join((*lines, condition, *numbers))))
    whole = not any(m.real for m in members(kind) if m.name in used)
    written = [f"ROUNDED({x}, 10)" if whole else f"EXACT({x})" for x in numbers]
    value_text = written[0]
    bound = c_string(check.bound)
    if isinstance(value, tuple):
        form = ", ".join("%s" for _ in value)
        lines += [
            "char given[96];",
            f'snprintf(given, sizeof given, "({form})", {", ".join(written)});',
        ]
        value_text = "given"
    if placeholder := re.search(r"\{(?::\.(\d)g|!r)\}", check.bound):
        if placeholder[1]:
            text = f"ROUNDED({numbers[-1]}, {placeholder[1]})"
        else:
            text = written[-1]
        before = c_string(check.bound[: placeholder.start()])
        behind = c_string(check.bound[placeholder.end() :])
        bound = f"JOINED({before}, {text}, {behind})"
    refused = (
        f"refuse(check, {c_string(check.what)}, {value_text}, {bound}, {c_string(check.cure)})"
    )
    body = "".join(f"        {line}\n" for line in (*lines, f"if (!({condition})) {refused};"))
    return f"    {{\n{body}    }}\n"


def _choice(name: str, p: Parameter) -> str:
    words = ", ".join(f"{code} {word}" for code, word in enumerate(p.choices))
    return f'choice(check, "{name}", x->{name}, {len(p.choices) - 1}, {c_string(words)})'


def _range(name: str, p: Parameter, real: bool) -> str:
    """Return the check of one parameter; a bound is a number, another parameter or none."""

    def limit(bound: float | str | None, without: str) -> str:
        if isinstance(bound, str):
            return f"x->{bound}"
        return without if bound is None else repr(float(bound))

    limits = f"{limit(p.lower, '-INFINITY')}, {limit(p.upper, 'INFINITY')}"
    before, _, behind = p.bound.partition("{}")
    bound = c_string(before)
    if p.other:
        bound = f"JOINED({bound}, EXACT(x->{p.other}), {c_string(behind)})"
    return f'{"real" if real else "whole"}(check, "{name}", x->{name}, {limits}, {bound}, {c_string(p.cure)})'
