"""Scripts of the examples, and code of the README, that tests run."""

import re
import subprocess
import sys
from pathlib import Path

from checkout import ROOT

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
