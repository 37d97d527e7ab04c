"""Lines read like prose: densities that a formatter does not see stay low, in the product and in its tests."""

import ast
import re
from collections import Counter

import pytest
from checkout import ROOT

TREES = {
    "product": ("rope_model", "fmu_src", "hoist_demo"),
    "evidence": ("evidence",),
    "tests": ("tests",),
}
LONGEST_LINE = 100
MANY_ARGUMENTS = 6
COMPREHENSIONS = (ast.ListComp, ast.GeneratorExp, ast.SetComp, ast.DictComp)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
#: most of each kind: a fraction of assignments or lines, a number in 1000 lines, or a number
BOUNDS = {
    "product": {
        "packed assignments": 0.01,
        "long lines": 0.02,
        "conditional expressions": 8.0,
        "nested comprehensions": 2.0,
        "functions of many arguments": 12,
        "functions of Any alone": 30,
    },
    "evidence": {
        "packed assignments": 0.005,
        "long lines": 0.05,
        "conditional expressions": 11.0,
        "nested comprehensions": 8.5,
        "functions of many arguments": 1,
        "functions of Any alone": 10,
    },
    "tests": {
        "packed assignments": 0.005,
        "long lines": 0.02,
        "conditional expressions": 1.5,
        "nested comprehensions": 0.5,
        "functions of many arguments": 2,
        "functions of Any alone": 20,
    },
}


def is_packed(node: ast.Assign) -> bool:
    """Whether it is ``a, b = x, y``, which is neither a swap nor the unpacking of one value."""
    target, value = node.targets[0], node.value
    if not isinstance(target, ast.Tuple) or not isinstance(value, ast.Tuple):
        return False
    left = {ast.unparse(element) for element in target.elts}
    return left != {ast.unparse(element) for element in value.elts}


def is_nested(node: ast.ListComp | ast.GeneratorExp | ast.SetComp | ast.DictComp) -> bool:
    """Whether it is a comprehension of two loops, or around another."""
    inner = sum(isinstance(child, COMPREHENSIONS) for child in ast.walk(node)) - 1
    return inner > 0 or len(node.generators) > 1


def kinds_of_function(node: ast.FunctionDef | ast.AsyncFunctionDef) -> Counter[str]:
    arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    if arguments and arguments[0].arg in ("self", "cls"):
        arguments = arguments[1:]
    notes = [x.annotation for x in arguments if x.annotation is not None]
    is_any = [isinstance(note, ast.Name) and note.id == "Any" for note in notes]
    found = Counter[str]()
    found["functions of many arguments"] += len(arguments) > MANY_ARGUMENTS
    found["functions of Any alone"] += bool(is_any) and all(is_any)
    return found


def counts(text: str) -> Counter[str]:
    """Numbers of lines, assignments, and each kind of BOUNDS in a module."""
    lines = [line for line in text.splitlines() if line.strip()]
    found = Counter(lines=len(lines))
    found["long lines"] = sum(len(line) > LONGEST_LINE for line in lines)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Assign):
            found["assignments"] += 1
            found["packed assignments"] += is_packed(node)
        elif isinstance(node, ast.IfExp):
            found["conditional expressions"] += 1
        elif isinstance(node, COMPREHENSIONS):
            found["nested comprehensions"] += is_nested(node)
        elif isinstance(node, FUNCTIONS):
            found += kinds_of_function(node)
    return found


def densities(tree: str) -> dict[str, float]:
    total = Counter[str]()
    for package in TREES[tree]:
        for path in sorted((ROOT / package).rglob("*.py")):
            total += counts(path.read_text(encoding="utf-8"))
    per_1000 = 1000 / total["lines"]
    return {
        "packed assignments": total["packed assignments"] / total["assignments"],
        "long lines": total["long lines"] / total["lines"],
        "conditional expressions": total["conditional expressions"] * per_1000,
        "nested comprehensions": total["nested comprehensions"] * per_1000,
        "functions of many arguments": total["functions of many arguments"],
        "functions of Any alone": total["functions of Any alone"],
    }


@pytest.mark.parametrize("tree", TREES)
def test_lines_do_not_become_denser(tree: str) -> None:
    found = densities(tree)
    assert {kind: found[kind] for kind, most in BOUNDS[tree].items() if found[kind] > most} == {}


def test_each_kind_is_found() -> None:
    text = (
        "from typing import Any\n"
        "a, b = 1, 'x'\n"
        "a, b = b, a\n"
        "a, b = f()\n"
        "c = [x for row in a for x in row]\n"
        "d = 1 if c else 2  #" + " long" * 20 + "\n"
        "def f(x: Any, y: Any): ...\n"
        "def g(self, a, b, c, d, e, f, g): ...\n"
    )
    found = counts(text)
    assert found["packed assignments"] == 1
    assert found["nested comprehensions"] == 1
    assert found["conditional expressions"] == 1
    assert found["long lines"] == 1
    assert found["functions of many arguments"] == 1
    assert found["functions of Any alone"] == 1


#: ``code`` between single marks; numpydoc has two on either side
_ONE_MARK = re.compile(r"(?<![`:\w])`[^`\n]+`(?!`)")


def single_marks(text: str) -> list[str]:
    """Return what docstrings have between single marks."""
    found: list[str] = []
    if not _ONE_MARK.search(text):
        return found  # without parsing
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, *FUNCTIONS)):
            found += _ONE_MARK.findall(ast.get_docstring(node) or "")
    return found


def test_docstrings_have_the_marks_of_numpydoc() -> None:
    assert single_marks('"""Return ``a``, :func:`b` and `c`."""') == ["`c`"]
    found = {}
    for package in (*TREES["product"], *TREES["evidence"], *TREES["tests"]):
        for path in sorted((ROOT / package).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            found[name] = single_marks(path.read_text(encoding="utf-8"))
    assert len(found) > 300
    assert {name: marks for name, marks in found.items() if marks} == {}


#: what is left out of a C text: comments, texts, directives
_NO_CODE = re.compile(
    r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE
)
#: what a declarator has in parentheses, brackets or an initialiser
_INSIDE = re.compile(r"\([^()]*\)|\[[^\[\]]*\]|(?:(?<== )|(?<=@))\{[^{}]*\}")
_DECLARATION = re.compile(r"(?:(?:static|const|struct|unsigned|signed) )*\w+@? \*?\w")


def pointers_among_others(text: str) -> list[str]:
    """Return the declarations of C that declare a pointer and something else, without values."""
    code = _NO_CODE.sub("", text)
    while (shorter := _INSIDE.sub("@", code)) != code:
        code = shorter
    found = []
    for statement in re.split("[;{}]", code):
        names = " ".join(re.sub("=[^,]*", "", statement).split())
        if "," in names and "*" in names and _DECLARATION.match(names):
            found.append(names)
    return found


def test_a_declaration_of_c_that_has_a_pointer_declares_no_more() -> None:
    text = (
        "void f(const double *q, double h) {\n"
        "    const Vec x[2 * N], y = {0};\n"
        "    for (int k = 0; k < n; k++) g(k, *q);\n"
        "    FN(Step) *one = (T *){a, b};\n"
        "    double *const both[] = {a,\n        b}, *x = f(b), h = 1; /* mixed */\n"
        "}\n"
    )
    assert pointers_among_others(text) == ["double *const both@ , *x , h"]
    paths = [
        *(ROOT / "rope_model" / "csrc").rglob("*.[ch]"),
        *(ROOT / "rope_model" / "csrc").rglob("*.inc"),
    ]
    assert len(paths) > 60
    found = {path.name: pointers_among_others(path.read_text(encoding="utf-8")) for path in paths}
    assert {name: names for name, names in found.items() if names} == {}
