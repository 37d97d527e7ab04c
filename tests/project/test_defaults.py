"""Tests run at the defaults; a test that sets steps, mesh, accuracy, fidelity or inputs away from them says why.

The reason is a comment at the place, above it or above the function, a docstring of that function, or an entry of
``defaults.toml`` for all places of a kind in a file.
"""

from __future__ import annotations

import ast
import re
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
from checkout import TESTS

from rope_model import Scene
from rope_model.scene_names import named_parameters

#: calls that set what a user leaves alone, by the word of defaults.toml for them
CALLS = {
    "fixed_steps": "solver",
    "Solver": "solver",
    "Accuracy": "accuracy",
    "Mesh": "mesh",
    "Model": "model",
}
CALLS |= {"Inputs": "inputs", "tolerant": "model"}
#: groups of parameters by name that are the same
GROUPS = ("solver", "accuracy", "mesh", "model", "inputs")
PARAMETERS = {p.name for p in named_parameters(Scene()) if p.name.startswith(GROUPS)}


@dataclass(frozen=True)
class Place:
    """Where a test leaves a default, and whether words stand there."""

    file: str
    line: int
    kind: str
    explained: bool


def kind_of(node: ast.AST) -> str:
    """The group that a call or a name of a parameter sets; '' if it sets none."""
    if (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and (node.args or node.keywords)
    ):
        kind = CALLS.get(node.func.id, "")
        fitted = [ast.unparse(argument) for argument in node.args] == ["'auto'"]
        if kind == "mesh" and fitted and not node.keywords:
            return ""
        return kind
    if isinstance(node, ast.keyword) and node.arg is not None:
        group, separator, _ = node.arg.partition("__")
        if separator and group in GROUPS:
            return group
    return ""


def named(node: ast.AST) -> Iterator[tuple[int, str]]:
    """Parameters by name that are keys of a dictionary: {"solver.step_max": 0.01}."""
    if isinstance(node, ast.Dict):
        for key in node.keys:
            if isinstance(key, ast.Constant) and key.value in PARAMETERS:
                yield key.lineno, str(key.value).partition(".")[0]


@cache
def places(path: Path) -> tuple[Place, ...]:
    """All places of a file."""
    return tuple(_places(path))


#: a file without one of them has no place
WORDS = re.compile(rf"\b({'|'.join(CALLS)})\(|\b({'|'.join(GROUPS)})(__|\.)")
#: a comment for a tool, which gives no reason
DIRECTIVE = re.compile(r"# (noqa|type|fmt|mypy|ruff)\b")


def _places(path: Path) -> Iterator[Place]:
    text = path.read_text(encoding="utf-8")
    if not WORDS.search(text):
        return
    tree = ast.parse(text)
    found = list[tuple[int, str]]()
    for node in ast.walk(tree):
        found += named(node)
        if kind := kind_of(node):
            found.append((getattr(node, "lineno", 0), kind))
    if not found:
        return
    with path.open("rb") as file:
        comments = {
            token.start[0]
            for token in tokenize.tokenize(file.readline)
            if token.type == tokenize.COMMENT and not DIRECTIVE.match(token.string)
        }
    explained: set[int] = set()
    for node in ast.walk(tree):
        if not isinstance(node, ast.stmt):
            continue
        first = node.lineno - len(getattr(node, "decorator_list", ()))
        last = node.end_lineno or node.lineno
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if ast.get_docstring(node) or first - 1 in comments:
                explained |= set(range(first, last + 1))
        elif not isinstance(
            node, ast.With | ast.For | ast.If | ast.While | ast.Try
        ) and comments & {*range(first - 1, last + 1)}:
            explained |= set(range(first, last + 1))
    for line, kind in found:
        yield Place(str(path.relative_to(TESTS)), line, kind, line in explained)


REASONS = tomllib.loads(Path(__file__).with_name("defaults.toml").read_text(encoding="utf-8"))
FILES = sorted(path for path in TESTS.rglob("*.py") if path != Path(__file__))


def unexplained() -> Iterator[Place]:
    for path in FILES:
        for place in places(path):
            if not place.explained:
                yield place


def test_a_test_that_leaves_a_default_says_why() -> None:
    silent = [x for x in unexplained() if x.kind not in REASONS.get(x.file, {})]
    assert not silent, "\n".join(f"{x.file}:{x.line}: {x.kind}, without a reason" for x in silent)


def test_reasons_are_of_places_that_are_there() -> None:
    there: dict[str, set[str]] = {}
    for place in unexplained():
        there.setdefault(place.file, set()).add(place.kind)
    assert {file: {*kinds} for file, kinds in REASONS.items()} == there


def test_a_default_left_in_silence_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "TESTS", tmp_path)
    text = 'A = Solver(tolerance=1e6)\nB = {"mesh.kind": 1}\nC = Mesh("auto")\n# as the source\nD = Mesh("eem")\n'
    path = tmp_path / "test_x.py"
    path.write_text(text, encoding="utf-8")
    found = {(x.line, x.kind, x.explained) for x in places(path)}
    assert found == {(1, "solver", False), (2, "mesh", False), (5, "mesh", True)}
