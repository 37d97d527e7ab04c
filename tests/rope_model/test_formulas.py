"""C computes what Python does, to the bit: formulas and messages are written once."""

import ctypes as ct
import math
import random
from dataclasses import replace
from enum import Enum
from functools import cache
from itertools import chain
from typing import Any, get_args, get_type_hints

import casadi as ca
import numpy as np
import pytest
from native_parts import compiled, message
from numpy.testing import assert_allclose

from rope_model.codegen import build
from rope_model.codegen.expressions import texts_of
from rope_model.codegen.formula_functions import function_code
from rope_model.codegen.formulas import FORMULAS
from rope_model.codegen.messages import texts
from rope_model.codegen.rules import TABLES, table_code
from rope_model.codegen.signatures import Argument, Formula, constant_in_c, function_in_c, shape_of
from rope_model.codegen.state_structures import PARTS, PatternStructure, StateStructure
from rope_model.codegen.structures import (
    GROUP_STRUCTURES,
    SceneStructure,
    ShaftStructure,
    scene_structure,
)
from rope_model.codegen.symbols import Word, symbols_of
from rope_model.engine import declare
from rope_model.messages import fidelity_messages
from rope_model.method.mesh_pattern import InnerCounts, Pattern
from rope_model.parameters import Scene, Swivel
from rope_model.physics import contact, guard
from rope_model.physics.air import AirCoefficients
from rope_model.physics.air_element import COEFFICIENTS_SIZE
from rope_model.physics.elementary import Scalar, where
from rope_model.shaft_parameters import Shaft
from rope_model.signals.signal_groups import c_function_of
from rope_model.signals.signal_table import SIGNALS
from rope_model.signals.state_signals import STATE_SIGNALS
from rope_model.solver_parameters import FidelityChoice, Inputs
from rope_model.state import RopeState

#: formulas that Python evaluates on numbers; derivatives are for C alone
CALLABLE = [
    Formula(function)
    for function in FORMULAS
    if function.__module__ != "rope_model.codegen.derivatives"
]
#: structures that have members of their own in C
STRUCTURES: dict[Any, type[ct.Structure]] = {
    **GROUP_STRUCTURES,
    **PARTS,
    Scene: SceneStructure,
    Shaft: ShaftStructure,
    RopeState: StateStructure,
    Pattern: PatternStructure,
}
#: where a formula asks for more than a number between 0.5 and 1
VALUES = {"number": 800.0}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A library with every formula as a function of its own: ``name``_ calls ``name``."""
    code = ['#include "formulas.h"', ""]
    for formula in CALLABLE:
        arguments = formula.arguments
        if formula.result is not None:
            arguments.append(formula.result)
        call = f"{formula.name}({', '.join(argument.name for argument in arguments)});"
        if formula.result is None:
            call = f"return {call}"
        prototype = formula.prototype().replace(f"{formula.name}(", f"{formula.name}_(")
        code += [f"{prototype};", f"{prototype} {{ {call} }}"]
    return compiled(tmp_path_factory.mktemp("formulas"), {"all.c": "\n".join(code) + "\n"})


def test_a_sum_of_two_conditional_terms_keeps_both_conditions() -> None:
    x, y, z = (ca.SX.sym(name) for name in "xyz")
    _, (alternative, total) = texts_of(
        [where(x < 1, y, z), where(x < 1, y, 0.0) + where(x < 1, z, 0.0)]
    )
    assert alternative == "x < 1.0 ? y : z"
    assert total == "(x < 1.0 ? y : 0.0) + (x < 1.0 ? z : 0.0)"


def c_structure(kind: type[Any]) -> type[ct.Structure]:
    if kind in STRUCTURES:
        return STRUCTURES[kind]
    fields = [
        (name, c_structure(hint) if hasattr(hint, "_fields") else c_numbers(shape_of(hint)))
        for name, hint in hints_of(kind).items()
    ]
    return type(kind.__name__, (ct.Structure,), {"_fields_": fields})


def c_numbers(shape: tuple[int, ...]) -> Any:
    if not shape:
        return ct.c_double
    return c_numbers(shape[1:]) * shape[0]


def with_numbers(symbolic: Any, chance: random.Random) -> Any:
    """The same with a number in place of each symbol."""
    if isinstance(symbolic, Word):
        return chance.choice(symbolic.words)
    if isinstance(symbolic, ca.SX) and symbolic.name().startswith("(double)"):
        return float(chance.randrange(10))
    if isinstance(symbolic, ca.SX):
        return VALUES.get(symbolic.name(), chance.uniform(0.5, 1.0))
    if isinstance(symbolic, tuple):
        parts = [with_numbers(part, chance) for part in symbolic]
        if hasattr(symbolic, "_fields"):
            return type(symbolic)(*parts)
        return tuple(parts)
    kind = type(symbolic)
    made = kind.__new__(kind)
    vars(made).update({name: with_numbers(part, chance) for name, part in vars(symbolic).items()})
    return made


def in_c(value: Any, argument: Argument) -> Any:
    if argument.structure is not None:
        return ct.byref(fill(c_structure(argument.structure)(), value, argument.structure))
    if argument.words:
        return argument.words.index(value)
    if isinstance(value, float):
        return ct.c_double(value)
    if argument.whole:
        return np.array(value, dtype=np.intc).ctypes.data_as(ct.c_void_p)
    return np.array(value).ctypes.data_as(ct.c_void_p)


@cache
def hints_of(kind: type[Any]) -> dict[str, Any]:
    """Return the types of the fields of a kind, which take most of the time of a call."""
    return get_type_hints(kind)


def fill(structure: ct.Structure, value: Any, kind: type[Any]) -> ct.Structure:
    """Give the members of a structure in C the values of an object of ``kind``."""
    hints = hints_of(kind)
    parts = value._asdict() if hasattr(value, "_asdict") else vars(value)
    for name, part in parts.items():
        if name in ("left", "right") and kind is Scene:
            fill(structure.swivels[name == "right"], part, hints[name])
        elif not hasattr(structure, name):
            continue  # C has it in another form, or not: what an object has computed, a state's motion
        elif isinstance(part, float):
            whole = not isinstance(getattr(structure, name), float)
            setattr(structure, name, int(part) if whole else part)
        elif isinstance(part, Enum):
            setattr(structure, name, part.value)
        elif isinstance(part, str):
            setattr(structure, name, get_args(hints[name]).index(part))
        elif isinstance(part, tuple) and not hasattr(part, "_fields"):
            member = getattr(structure, name)
            whole = get_args(hints.get(name)) and int in get_args(hints[name])
            np.frombuffer(member, np.intc if whole or kind is Pattern else float)[:] = flat(part)
        else:
            fill(getattr(structure, name), part, hints[name])
    return structure


def flat(value: Any) -> list[float]:
    if isinstance(value, float | int):
        return [float(value)]
    parts = value if isinstance(value, tuple) else vars(value).values()
    return [*chain.from_iterable(map(flat, parts))]


@pytest.mark.parametrize("formula", CALLABLE, ids=lambda formula: formula.name)
def test_c_computes_the_formula_to_the_bit(library: Any, formula: Formula) -> None:
    function = getattr(library, f"{formula.name}_")
    chance = random.Random(formula.name)
    result = formula.result
    if formula.returned is not None:
        function.restype = c_structure(formula.returned)
    elif result is None:
        function.restype = ct.c_double
    own_hypot = "hypot" in function_code(formula)
    symbols = [symbols_of(argument) for argument in formula.arguments]
    for _ in range(100):
        values = [with_numbers(symbol, chance) for symbol in symbols]
        expected = flat(formula.function(*values))
        given = [
            in_c(value, argument) for value, argument in zip(values, formula.arguments, strict=True)
        ]
        if result is not None:
            made = np.full(result.shape, np.nan)
            function(*given, made.ctypes.data_as(ct.c_void_p))
            ours = made.ravel()
        else:
            back = function(*given)
            ours = np.frombuffer(back) if formula.returned else np.atleast_1d(back)
        if own_hypot:  # Python has a hypot of its own, rounded better than libm's
            assert_allclose(ours, expected, rtol=1e-14, atol=1e-14)
        else:
            assert ours.tolist() == expected


TEXTS = texts()
TYPES = {
    "float": ("double", ct.c_double),
    "int": ("int", ct.c_int),
    "str": ("const char *", ct.c_char_p),
}
#: numbers that are written in full, rounded, with an exponent, and not at all
SAMPLES = {
    "float": (0.1, -1234567.891, 1e-9, 2.5e17, 100.0, float("inf"), float("nan")),
    "int": (0, 57, 20000),
    "str": ("left", "100 %", "x" * 600),
}


def kinds(name: str) -> list[str]:
    return [kind.__name__ for kind in TEXTS[name].kinds.values()]


@pytest.fixture(scope="module")
def spoken(tmp_path_factory: pytest.TempPathFactory) -> ct.CDLL:
    code = ['#include "messages.h"']
    for name in TEXTS:
        declared = "".join(f", {TYPES[kind][0]} x{k}" for k, kind in enumerate(kinds(name)))
        arguments = "".join(f", x{k}" for k in range(len(kinds(name))))
        code.append(
            f"int of_{name}(char *room{declared}) {{ return say_{name}(room{arguments}); }}"
        )
    return compiled(tmp_path_factory.mktemp("messages"), {"all.c": "\n".join(code) + "\n"})


def as_c_text(value: float | str) -> float | bytes:
    if isinstance(value, str):
        return value.encode()
    return value


@pytest.mark.parametrize("name", TEXTS)
def test_c_says_what_python_says(spoken: ct.CDLL, name: str) -> None:
    say = getattr(spoken, f"of_{name}")
    room = ct.create_string_buffer(512)
    say.argtypes = (ct.c_char_p, *(TYPES[kind][1] for kind in kinds(name)))
    for k in range(7):
        values = [SAMPLES[kind][k % len(SAMPLES[kind])] for kind in kinds(name)]
        assert say(room, *map(as_c_text, values)) == 0
        assert room.value.decode() == TEXTS[name](*values)[:511]


def test_the_type_of_a_rules_argument_in_c_follows_from_its_annotation() -> None:
    def reach(
        rope_data: Scene, friend: Swivel, how: FidelityChoice, parts: InnerCounts, x: Scalar
    ) -> Scalar:
        return where(how == "rigid", parts[4] * rope_data.left.inertia, x * friend.inertia)

    facts = "const Scene *rope_data, const Swivel *friend, int how, const int parts[5], double x"
    assert f"double test_formulas_reach({facts})" in function_code(Formula(reach))


def test_a_rules_argument_without_a_type_in_c_is_refused() -> None:
    def scaled(scene: Scene, x: dict[str, float]) -> Scalar:
        return scene.rope.length * x["factor"]

    with pytest.raises(TypeError, match=r"x has the annotation .* no type in C: annotate it"):
        function_code(Formula(scaled))


def test_a_table_whose_formula_takes_other_facts_is_refused() -> None:
    def applies(scene: Scene, left: float) -> tuple[Scalar, ...]:
        return (scene.rope.length > left,)

    with pytest.raises(TypeError, match=r"applies of the table torque takes .* it must take"):
        table_code("torque", {fidelity_messages.coupled: applies}, TABLES["torque"].facts)


def test_a_choice_compared_with_a_word_it_does_not_have_is_refused() -> None:
    def is_free(swivel: Swivel) -> Scalar:
        return swivel.mode == "fre"

    with pytest.raises(ValueError, match="swivel->mode is never 'fre': compare it with one of"):
        function_code(Formula(is_free))


def test_every_output_that_is_stored_in_the_state_is_in_the_table_of_outputs() -> None:
    assert set(STATE_SIGNALS) <= set(SIGNALS)


def test_an_output_of_an_unknown_group_is_refused() -> None:
    with pytest.raises(KeyError, match="sheave"):
        c_function_of("sheave.force")


def test_numbers_of_the_air_law_return_to_their_coefficients() -> None:
    numbers = [*range(COEFFICIENTS_SIZE)]
    assert AirCoefficients.from_numbers(numbers).numbers() == numbers


def guard_reset(t: Scalar) -> Scalar:
    return t


def test_a_name_in_c_tells_the_module_or_the_class_unless_it_has_a_word_of_it() -> None:
    names = {function_in_c(function): function for function in FORMULAS}
    assert len(names) == len(FORMULAS)
    assert names["guard_watch"] is guard.watch
    assert names["contact_law"] is contact.contact_law
    assert "end_path_at" in names
    assert function_in_c(guard_reset) == "test_formulas_guard_reset"
    assert constant_in_c(guard, "NEVER") == "GUARD_NEVER"


def test_both_languages_ask_whether_numbers_are_finite_before_they_look_at_choices() -> None:
    nowhere: Any = "nowhere"
    with pytest.raises(ValueError, match="finite") as refused:
        replace(Inputs(), given=nowhere, acceleration_max=math.nan)
    structure = scene_structure(Scene())
    structure.inputs.given = 99
    structure.inputs.acceleration_max = math.nan
    text = message()
    functions: Any = declare(ct.CDLL(str(build.library())))
    assert not functions.rope_create(ct.byref(structure), None, text)
    name, _, reason = str(refused.value).partition(" = ")
    assert name in text.value.decode()
    assert reason.partition("must be ")[2] in text.value.decode()
