"""What is written by hand in Python and in C is control flow: formulas have one text (rope_model.native.formulas).

Counted: products and quotients of real numbers, and calls of libm, in each hand-written C function.  A function that
is not listed has few; a formula added by hand has more.  A listed number may only fall.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from rope_model.native.formulas import FORMULAS

ROPE = Path(__file__).resolve().parent.parent / "rope_model"
NATIVE = ROPE / "native"
#: the method in C; in Python it is CasADi text, numerics.block_chain and newton, that is generated for each mesh size
CHAIN = ("chain.", "chain_avx2", "chain_f", "chain_wide", "lanes")
#: what Python does not write at all: it has memory, and its own numbers as text, and looks at no processor
C_ALONE = ("memory.c", "text.c", "text.h", "processor.c")
#: products and quotients that a function of control flow may have; libm's functions none
FEW = 3
#: function: products and quotients of real numbers, calls of libm; and what they are
ARITHMETIC = {
    # places of arrays in memory
    "with_memory": (10, 0),
    # places and sums along the rope where it touches something
    "own_contact_bytes": (5, 0),
    "place_on": (4, 0),
    "length_between": (0, 1),
    "add_rope_balance": (4, 0),
    # sums over nodes, and what is held at the ends
    "trial_step": (14, 0),
    "system_of": (2, 0),
    "restart": (5, 0),
    "commit": (4, 0),
    "flexible_start": (4, 0),
    "added_mass_signals": (5, 0),
    "rope_derivative": (6, 0),
    "find_equilibrium": (10, 1),
    "solve_equilibrium": (0, 1),
    "turn_in": (4, 0),
    # assembly and solution of the transfer's equations
    "transfer_fields": (7, 0),
    "solve_banded": (6, 0),
    # numbers of elements and their places
    "mesh_fit": (0, 1),
    "mesh_partition": (4, 0),
    "mesh_elements": (4, 0),
    # choice of steps
    "accepted_step": (5, 0),
    # searches along the rope, and lengths and angles of one vector
    "shape_nearest_turn": (4, 0),
    "shape_interpolate_midpoints": (4, 0),
    "with_loop_yaw": (0, 1),
    "shape_loop_bottom": (6, 1),
    "shape_tension": (5, 1),
    "shape_leg_clearance": (0, 1),
    "shape_hanging_guess": (1, 1),
}
#: lines of code, without comments and blank lines, that each side may have: they shall fall to 1300
MOST_LINES = {"Python": 2382, "C": 2892}
#: modules that C has again; of parameters.py, from which its C is generated, it has two checks, of paths.py nothing
TWICE = (
    *(
        f"simulation/{name}.py"
        for name in (
            "adaptation",
            "result_warnings",
            "diagnostics",
            "ends",
            "events",
            "guards",
            "mesh",
            "model",
            "point_forces",
            "rigid",
            "self_contact",
            "shaft",
        )
    ),
    *(
        f"simulation/{name}.py"
        for name in (
            "fidelity",
            "hang",
            "stepping",
            "sensitivity",
            "signals",
            "simulator",
            "state",
            "statics",
            "switching",
            "surroundings",
            "wires",
            "curvature",
        )
    ),
    *(
        "simulation/transfer.py",
        "numerics/banded.py",
        "numerics/coupled_newton.py",
        "numerics/generalized_alpha.py",
    ),
)
LIBM = {"sqrt", "cbrt", "hypot", "pow", "exp", "log", "log2", "log10", "sin", "cos", "tan", "asin", "acos", "atan"}
LIBM |= {"atan2", "sinh", "cosh", "tanh", "expm1", "log1p", "fma"}
_HEAD = re.compile(r"^[A-Za-z][\w\s*]*?\b(\w+)\([^;{}]*?\)\s*\{", re.MULTILINE)


def c_files() -> list[Path]:
    return [path for path in sorted(NATIVE.iterdir()) if path.suffix in (".c", ".h", ".inc")]


def without_comments(text: str) -> str:
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    return re.sub(r'"(\\.|[^"\\])*"', '""', text)


def functions(text: str) -> Iterator[tuple[str, str]]:
    """Names and bodies of the functions in a C file."""
    text = re.sub(r"^\s*#.*$", "", without_comments(text), flags=re.MULTILINE)
    for match in _HEAD.finditer(text):
        end, depth = match.end(), 1
        while depth:
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        yield match[1], text[match.end() : end]


def arithmetic(body: str) -> tuple[int, int]:
    """Products and quotients but for indices and sizes, and calls of libm."""
    calls = sum(name in LIBM for name in re.findall(r"\b(\w+)\(", body))
    for _ in range(3):  # brackets within brackets
        body = re.sub(r"\[[^\[\]]*\]", "", body)
    body = re.sub(r"\((?:size_t|ptrdiff_t)\)[^,;)]*|sizeof[^,;)]*", "", body)
    products = re.findall(r"([\w)]+) [*/]=? (?=([\w(.\-&]+))", body)
    integer = re.compile(r"[A-Z]{3,}[A-Z_]*|stride|width|row")
    return sum(not any(integer.fullmatch(operand) for operand in pair) for pair in products), calls


def count_arithmetic() -> dict[str, tuple[int, int]]:
    """The arithmetic of every function outside of the chain."""
    files = [path for path in c_files() if not path.name.startswith(CHAIN)]
    return {name: arithmetic(body) for path in files for name, body in functions(path.read_text(encoding="utf-8"))}


def test_functions_by_hand_hold_no_formulas() -> None:
    more = {
        name: found
        for name, found in count_arithmetic().items()
        if found[0] > ARITHMETIC.get(name, (FEW, 0))[0] or found[1] > ARITHMETIC.get(name, (FEW, 0))[1]
    }
    assert not more, "write the formula in rope_model.physics and list it in rope_model.native.formulas"


def test_listed_numbers_are_not_higher_than_need_be() -> None:
    found = count_arithmetic()
    assert {name: found.get(name) for name in ARITHMETIC} == ARITHMETIC


@pytest.mark.parametrize(
    "body",
    [
        "return 0.5 * mu * d * tension + seal * (1 + mu);",
        "x = a * b + c * d; y = a / b; z = c / d;",
        "double length = sqrt(x[0] * x[0] + x[1] * x[1]);",
    ],
)
def test_a_formula_by_hand_would_be_found(body: str) -> None:
    products, calls = arithmetic(body)
    assert products > FEW or calls


def test_no_formula_is_defined_by_hand_as_well() -> None:
    generated = {re.sub(r".*?(\w+)\(.*", r"\1", prototype) for prototype in FORMULAS}
    assert not generated & set(count_arithmetic())


def lines_of_c() -> dict[str, int]:
    """Of code, by hand, that Python has too, by file."""
    files = [path for path in c_files() if not path.name.startswith(CHAIN) and path.name not in C_ALONE]
    texts = {path.name: without_comments(path.read_text("utf-8")) for path in files}
    return {name: sum(bool(line.strip()) for line in text.splitlines()) for name, text in texts.items()}


def lines_of_python() -> dict[str, int]:
    """Of code, by hand, that C has too, by module."""
    return {Path(name).name: code_lines((ROPE / name).read_text(encoding="utf-8")) for name in TWICE}


def c_lines() -> int:
    return sum(lines_of_c().values())


def python_lines() -> int:
    return sum(lines_of_python().values())


def code_lines(text: str) -> int:
    """Lines without comments and docstrings."""
    described: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            described |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    skipped = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = [x for x in tokenize.generate_tokens(io.StringIO(text).readline) if x.type not in skipped]
    return len({line for x in tokens for line in range(x.start[0], x.end[0] + 1)} - described)


def test_neither_side_grows() -> None:
    lines = {"Python": python_lines(), "C": c_lines()}
    assert all(lines[side] <= MOST_LINES[side] for side in lines), lines
