"""Modules of this project as they travel in the Python FMU: those of a script, in a named package.

A host's process has one module of a name.  So the copies are in a package whose name has the
build's hash, and import each other from there: neither an installed version of the project nor
another FMU can take their place.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
#: packages of the project whose modules travel
PACKAGES = ("rope_model", "fmu_src")


def modules_needed(script: Path) -> list[Path]:
    """Return the files of PACKAGES that ``script`` imports, directly or through other modules."""
    needed: dict[Path, None] = {}
    waiting = [script]
    while waiting:
        for name in _imported(waiting.pop().read_text(encoding="utf-8")):
            new = [path for path in _files(name) if path not in needed]
            needed |= dict.fromkeys(new)
            waiting += new
    return sorted(needed)


def import_from(package: str, text: str, roots: tuple[str, ...] = PACKAGES) -> str:
    """Return the Python ``text`` with all imports from ``roots`` made from below ``package``.

    Raises ValueError for ``import rope_model.x``, which binds the name ``rope_model``.
    """
    lines = text.split("\n")
    for node, _ in _import_statements(text):
        if isinstance(node, ast.Import) and any(_root(alias.name) in roots for alias in node.names):
            raise ValueError(
                f"line {node.lineno}, '{ast.unparse(node)}', cannot be moved: "
                "write 'from ... import ...'"
            )
        if isinstance(node, ast.ImportFrom) and node.level == 0 and _root(node.module) in roots:
            line = lines[node.lineno - 1]
            moved = line[node.col_offset :].replace(
                f"from {node.module}", f"from {package}.{node.module}", 1
            )
            lines[node.lineno - 1] = line[: node.col_offset] + moved
    return "\n".join(lines)


def _root(module: str | None) -> str:
    return (module or "").partition(".")[0]


class _ImportStatement(NamedTuple):
    node: ast.Import | ast.ImportFrom
    runs: bool  # False for one of type checkers


@cache
def _import_statements(text: str) -> tuple[_ImportStatement, ...]:
    """Return all imports of a Python text, those inside of functions, too."""
    return tuple(_imports_in(ast.parse(text), runs=True))


def _imports_in(node: ast.AST, runs: bool) -> Iterator[_ImportStatement]:
    for_checkers: list[ast.stmt] = []
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        for_checkers = node.body
    for child in ast.iter_child_nodes(node):
        child_runs = runs and child not in for_checkers
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield _ImportStatement(child, child_runs)
        # expressions import nothing
        elif isinstance(child, ast.stmt | ast.ExceptHandler | ast.match_case):
            yield from _imports_in(child, child_runs)


def _imported(text: str) -> Iterator[str]:
    """Yield the names of modules and of their members that are imported at run time."""
    for node, runs in _import_statements(text):
        if runs and isinstance(node, ast.ImportFrom) and node.level == 0:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _files(name: str) -> Iterator[Path]:
    """Yield the files that Python runs to import ``name``, packages first.

    The name is that of a module of PACKAGES or of a member of one.
    """
    parts = name.split(".")
    if parts[0] not in PACKAGES:
        return
    for count in range(1, len(parts) + 1):
        at = ROOT.joinpath(*parts[:count])
        yield from (path for path in (at / "__init__.py", at.with_suffix(".py")) if path.exists())
