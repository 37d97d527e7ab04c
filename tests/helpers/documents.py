"""Scripts of the examples, and code of the README, that tests run."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from checkout import ROOT
from exports import FLAVOURS

EXAMPLES = ROOT / "examples"

README = (ROOT / "README.md").read_text(encoding="utf-8")

FMU = "build/balance_rope_native.fmu"


def lines_of(script: Path, folder: Path, *arguments: str) -> list[str]:
    command = [sys.executable, str(script), *arguments]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


def readme_code(section: str, folder: Path) -> Path:
    """The program in a section of README."""
    code = re.search(r"```python\n(.*?)```", README.partition(f"## {section}\n")[2], re.DOTALL)
    script = folder / "readme_code.py"
    script.write_text(code[1], encoding="utf-8")
    return script


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]) -> Path:
    """A folder with the FMU where the documents have it."""
    if "native-2" not in FLAVOURS:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("examples")
    (folder / "build").mkdir()
    shutil.copyfile(fmu_of("native-2"), folder / FMU)
    return folder
