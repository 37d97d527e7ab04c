"""The C of rope_model/csrc has the rooms, the modules and the function names of the Python that it mirrors."""

import ast
import json
import re
import subprocess
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import rope_model
from release.editor import lay_out
from rope_model.numerics.kernels import find_compiler

PACKAGE = Path(rope_model.__file__).parent
CSRC = PACKAGE / "csrc"
FILES = {path.name: path for path in sorted(CSRC.rglob("*")) if path.suffix in (".c", ".h", ".inc")}
#: files without a Python module: a communication step and its derivatives, matrices for analysis,
#: what the files declare to each other and to hosts, memory that is taken before the
#: first step, numbers written as Python does, vectors of several elements and the processor's
ENGINE = {
    "host_step.c",
    "sensitivity.c",
    "linearisation.c",
    "core.h",
    "rope.h",
    "memory.c",
    "text.c",
    "text.h",
    "lanes.h",
    "processor.c",
    "processor.h",
    "rope_kernels_form.inc",
    "rope_kernels_plain.c",
    "rope_kernels_wide.c",
    "rope_kernels_widest.c",
}
#: functions without a Python one in the module of their file: other names there, types, numpy, room for memory
C_ONLY = {
    "rope_create",
    "rope_message",
    "rope_is_initialized",
    "rope_state_bytes",
    "rope_save",
    "rope_time",
    "rope_fidelity",
    "rope_fidelity_reason",
    "rope_warning",
    "state_plausible",
    "state_copy",
    "record_event",
    "partition_elements",
    "middle_before",
    "fidelity_name",
    "bodies_group",
    "find_near_bodies",
    "add_near_bodies",
    "remember_configuration",
    "clearance_exceeds",
    "carry_director",
    "phases_of",
    "set_phases",
    "repeat_step",
    "newton_repeated",
    "host_step_plausible",
    "point_forces_push",
    "chain_work_bytes",
    "chain_frames_bytes",
    "fastest_chains",
    "rope_advance_to_event",
    "rope_let_turn",
    "arc_lengths",
    "let_turn",
}


def text_of(path: Path) -> str:
    return re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def functions(path: Path) -> list[str]:
    """Names of the functions that other files may call."""
    return re.findall(
        r"^(?!static|typedef|enum)\w[\w *]*?\b(\w+)\([^;{}]*\)\s*\{", text_of(path), re.MULTILINE
    )


def module_of(path: Path) -> Path | None:
    below = path.relative_to(CSRC).with_suffix(".py")
    return next(
        (found for room in ("simulation", ".") if (found := PACKAGE / room / below).exists()), None
    )


def names_in(module: Path) -> set[str]:
    """Names of functions, methods and classes, and of CasADi functions, which are words."""
    nodes = list(ast.walk(ast.parse(module.read_text(encoding="utf-8"))))
    defined = {node.name.lstrip("_") for node in nodes if isinstance(node, ast.FunctionDef)}
    classes = {
        re.sub(r"\B([A-Z])", r"_\1", node.name).lower()
        for node in nodes
        if isinstance(node, ast.ClassDef)
    }
    return defined | classes | {str(node.value) for node in nodes if isinstance(node, ast.Constant)}


@pytest.mark.parametrize("name", [name for name in FILES if name not in ENGINE])
def test_c_functions_have_the_names_of_the_python_module_in_their_room(name: str) -> None:
    module = module_of(FILES[name])
    assert module is not None, name
    names, prefixes = names_in(module), ("", f"{module.stem}_", "rope_")
    found = [f for f in functions(FILES[name]) if f not in C_ONLY]
    assert [f for f in found if not any(f.removeprefix(p) in names for p in prefixes)] == []


def test_exceptions_are_those_that_there_are() -> None:
    assert set(FILES) >= ENGINE
    assert {f for path in FILES.values() for f in functions(path)} >= C_ONLY
    assert [name for name in sorted(ENGINE) if module_of(FILES[name])] == []


def test_neither_calls_nor_includes_go_round() -> None:
    home = {f: name for name, path in FILES.items() for f in functions(path)}
    graph = {}
    for name, path in FILES.items():
        text = text_of(path)
        calls = re.findall(r"(?<![\w.>])(\w+)\(", text) if path.suffix != ".h" else []
        called = {home[f] for f in calls if f in home}
        graph[name] = (called | set(re.findall(r'#include "(\w+\.\w+)"', text)) & set(FILES)) - {
            name
        }
    assert len(list(TopologicalSorter(graph).static_order())) == len(FILES)


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
    checks += ["-fsyntax-only", "-Wall", "-Wextra", "-Werror"]
    command = [*compiler, *checks, *(entry["file"] for entry in entries[:files])]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "model.c").resolve() == FILES["model.c"]
