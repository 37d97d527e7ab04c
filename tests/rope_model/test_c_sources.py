"""The engine's C files before they are compiled, and the compiler that the tests take."""

import ctypes as ct
import os
import re
import subprocess
from collections import defaultdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from checkout import QUICK

from fmu_src.shell.sources import model_sources
from rope_model.codegen.build import written
from rope_model.compiler import find_compiler
from rope_model.engine import declare


def write(file: Path, text: str = "") -> None:
    file.parent.mkdir(exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_two_c_files_of_one_name_are_refused_with_both_places(tmp_path: Path) -> None:
    write(tmp_path / "mesh" / "transfer.c")
    write(tmp_path / "contact" / "other.c")
    assert [path.name for path in written(tmp_path)] == ["other.c", "transfer.c"]
    write(tmp_path / "contact" / "transfer.c")
    with pytest.raises(
        ValueError, match=r"called transfer\.c, contact/transfer\.c and mesh/transfer\.c: rename"
    ):
        written(tmp_path)


def test_a_c_file_with_the_name_of_a_generated_one_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "mesh" / "rules.h")
    with pytest.raises(ValueError, match=r"rules\.h, the generated one and mesh/rules\.h: rename"):
        written(tmp_path)


def test_a_models_c_file_with_the_name_of_one_of_the_fmus_shell_is_refused() -> None:
    with pytest.raises(ValueError, match=r"two C files are called component\.c, .* rename"):
        model_sources([], {"component.c": ""}, 2)


@pytest.mark.skipif(os.name != "posix" or find_compiler() is None, reason="needs a C compiler")
@pytest.mark.parametrize(
    "text",
    [
        "int f(int *x);\nint g(double *x) {\n    return f(x);\n}\n",
        "int f(int x) {\n    { int x = 2; return x; }\n}\n",
        "int f(void) {\n    return g();\n}\n",
        "int f(void) {\n    int *x = 1;\n    return *x;\n}\n",
    ],
    ids=["incompatible pointer", "shadowing", "undeclared function", "pointer from a number"],
)
def test_no_test_compiles_a_wrong_call_or_a_name_that_hides_another(
    text: str, tmp_path: Path
) -> None:
    write(tmp_path / "wrong.c", text)
    command = [str(QUICK / "cc"), "-std=c99", "-O3", "-c", "wrong.c", "-o", "wrong.o"]
    environment = {"OPTIMISING_CC": "cc"} | os.environ
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode != 0
    assert "[-Werror" in done.stderr


class Library(defaultdict[str, SimpleNamespace]):
    """Library whose functions note the types that they are given."""

    def __getattr__(self, name: str) -> SimpleNamespace:
        return self[name]


def kind_of_ctypes(of: Any) -> str:
    """Return what a type of ctypes holds, as ``kind_in_c``."""
    kinds = {None: "void", ct.c_double: "double", ct.c_int: "int", ct.c_size_t: "size_t"}
    return kinds.get(of, "address")


def kind_in_c(declared: str) -> str:
    """Return what a declaration of rope.h holds: an address, a number, an int for an enumeration, or nothing."""
    if re.search(r"[*\[]", declared):
        return "address"
    return declared.split()[0].replace("RopeStatus", "int")


def test_each_function_that_python_calls_has_the_types_of_its_prototype() -> None:
    library: Any = Library(SimpleNamespace)
    declare(library)
    text = next(path for path in written() if path.name == "rope.h").read_text(encoding="utf-8")
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    prototypes = re.findall(r"^(\w[\w ]*[ *]+)(rope_\w+)\(([^;]*)\);", text, flags=re.M)
    in_c = {
        name: [kind_in_c(result), *map(kind_in_c, re.sub(r"\s+", " ", taken).split(", "))]
        for result, name, taken in prototypes
    }
    for name, function in library.items():
        types = [function.restype, *function.argtypes]
        assert [*map(kind_of_ctypes, types)] == in_c[name], name
