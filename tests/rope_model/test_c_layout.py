"""The layout of the C of engine and FMUs: no cycles, and files that an editor compiles one by one."""

import json
import re
import subprocess
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from checkout import ROOT
from native_parts import WARNINGS

import rope_model
from release.editor import lay_out
from rope_model.compiler import find_compiler

PACKAGE = Path(rope_model.__file__).parent
CSRC = PACKAGE / "csrc"


def c_files(*folders: Path) -> dict[str, Path]:
    paths = [path for folder in folders for path in sorted(folder.rglob("*"))]
    return {path.name: path for path in paths if path.suffix in (".c", ".h", ".inc")}


FILES = c_files(CSRC)
SHELL = ROOT / "fmu_src" / "shell"
PROGRAMS = {
    "engine": FILES,
    "native FMU": c_files(CSRC, SHELL, ROOT / "fmu_src" / "native"),
    "Python FMU": c_files(SHELL, ROOT / "fmu_src" / "python"),
    "drive's FMU": c_files(SHELL, ROOT / "hoist_demo" / "drive_fmu"),
}


def text_of(path: Path) -> str:
    return re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def functions(path: Path) -> list[str]:
    """Names of the functions that other files may call."""
    return re.findall(
        r"^(?!static|typedef|enum)\w[\w *]*?\b(\w+)\([^;{}]*\)\s*\{", text_of(path), re.MULTILINE
    )


@pytest.mark.parametrize("files", PROGRAMS.values(), ids=PROGRAMS)
def test_neither_calls_nor_includes_go_round(files: dict[str, Path]) -> None:
    home = {}
    for name, path in files.items():
        home |= dict.fromkeys(functions(path), name)
    graph = {}
    for name, path in files.items():
        text = text_of(path)
        calls: list[str] = []
        if path.suffix != ".h":
            calls = re.findall(r"(?<![\w.>])(\w+)\(", text)
        called = {home[f] for f in calls if f in home}
        graph[name] = (called | set(re.findall(r'#include "(\w+\.\w+)"', text)) & set(files)) - {
            name
        }
    assert len(list(TopologicalSorter(graph).static_order())) == len(files)


@pytest.mark.parametrize("files", [2, pytest.param(None, marks=pytest.mark.slow)])
def test_laid_out_for_an_editor_files_compile_by_their_entries_without_a_warning(
    files: int | None, tmp_path: Path
) -> None:
    """The first two of them, or all."""
    if (compiler := find_compiler()) is None:
        pytest.skip("no C compiler")
    lay_out(tmp_path)
    lay_out(tmp_path)  # anew over what is there
    entries = json.loads((tmp_path / "compile_commands.json").read_text(encoding="utf-8"))
    assert {entry["file"] for entry in entries} == {name for name in FILES if name.endswith(".c")}
    checks = [flag for flag in entries[0]["arguments"][1:] if flag.startswith(("-std", "-O", "-f"))]
    checks += ["-fsyntax-only", *WARNINGS]
    command = [*compiler, *checks, *(entry["file"] for entry in entries[:files])]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "trial_step.c").resolve() == FILES["trial_step.c"]
