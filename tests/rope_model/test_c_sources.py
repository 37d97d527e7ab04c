"""The engine's C files before they are compiled, and the compiler that the tests take."""

import os
import subprocess
from pathlib import Path

import pytest
from checkout import QUICK

from fmu_src.shell.sources import model_sources
from rope_model.codegen.build import written
from rope_model.compiler import find_compiler


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
