"""The wheel as a user meets it: python -m release.trial WHEEL.

A fresh virtual environment with nothing but the wheel and what it needs, no C compiler on the PATH, no ziglang, an
empty cache, another folder, whose path has blanks and umlauts.  All commands and all Python of the README are run in
their order, then more.  Each step is done and timed; nothing may be compiled, and the FMUs must be those of this
checkout, byte by byte.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from hoist_demo.command_line.main import main as balance_rope

ROOT = Path(__file__).resolve().parent.parent
NAMES = {2: "balance_rope_native.fmu", 3: "balance_rope_native_fmi3.fmu"}
SYSTEM = "balance_rope_native.ssp"

STUDY = """\
[study]
title = "Four windings"
fmu = "build/balance_rope_native.fmu"
hoist = "rope-120"

[fixed]
winding.travel = { value = 10, unit = "m" }

[sample]
method = "grid"

[vary]
rope.EI = { values = [100, 1000], unit = "N.m2" }
winding.jerk = { values = [0.5, 2], unit = "m/s3" }
"""

NATIVE = """\
from pathlib import Path
from rope_model.codegen.build import library
assert library().parent.name == "prebuilt" and Path.cwd() not in library().parents
"""


class Step(NamedTuple):
    """What was done, in how many seconds, and what it printed."""

    what: str
    seconds: float
    said: str


def try_wheel(wheel: Path, told: Callable[[Step], None] = lambda step: None) -> list[Step]:
    """All steps; RuntimeError for the first that fails."""
    with tempfile.TemporaryDirectory(prefix="trial_") as folder:
        trial = _Trial(Path(folder), told)
        trial.install(wheel)
        trial.use()
        trial.compare()
        return trial.steps


class _Trial:
    def __init__(self, folder: Path, told: Callable[[Step], None]) -> None:
        self.folder, self.told, self.steps = folder, told, list[Step]()
        self.bin = folder / "venv" / "bin"
        self.cache = folder / "cache"
        self.work = folder / "Förderung äß ö"
        self.work.mkdir()

    def install(self, wheel: Path) -> None:
        subprocess.run([sys.executable, "-m", "venv", str(self.folder / "venv")], check=True)
        self._do(
            "pip install 'balance_rope-*.whl[study]'",
            "python",
            "-m",
            "pip",
            "install",
            "-q",
            f"{wheel}[study]",
        )
        if found := [
            name for name in ("cc", "gcc", "clang", "zig") if shutil.which(name, path=str(self.bin))
        ]:
            raise RuntimeError(f"the environment has a compiler: {', '.join(found)}")

    def use(self) -> None:
        for step in readme_steps():
            if step.program == "python":
                self._python(f"README: {step.text.splitlines()[0]} ...", step.text)
            else:
                self._command(*shlex.split(step.text, comments=True))
        self._python("is native", NATIVE)
        self._command("export", "--native", "--fmi", "2", "3", "--ssp")
        self._command("export", "--python")
        self._command("demo", "--quick")
        for fmi, name in NAMES.items():
            self._command("demo", "--out", f"out/fmi{fmi}", "--fmu", f"build/{name}")
        self._command("demo", "--quick", "--in-process", "--out", "out/in-process")
        (self.work / "study.toml").write_text(STUDY, encoding="utf-8")
        self._command("study", "study.toml", "--workers", "2")
        if self.cache.exists():
            raise RuntimeError(
                f"compiled at first use: {', '.join(path.name for path in self.cache.iterdir())}"
            )

    def compare(self) -> None:
        """Windings with FMI 2 and 3, which have the same bits, and exports from this checkout, which compiles them."""
        windings = {(self.work / "out" / f"fmi{fmi}" / "signals.csv").read_bytes() for fmi in NAMES}
        if len(windings) > 1:
            raise RuntimeError("the winding with the FMU of FMI 3 differs from that with FMI 2")
        here = self.folder / "here"
        here.mkdir()
        balance_rope(["export", "--native", "--fmi", "2", "3", "--ssp", "--out", str(here)])
        for name in (*NAMES.values(), SYSTEM):
            if (here / name).read_bytes() != (self.work / "build" / name).read_bytes():
                raise RuntimeError(f"{name} of the wheel is not that of the checkout")

    def _command(self, *arguments: str) -> None:
        self._do("balance-rope " + " ".join(arguments), "balance-rope", *arguments)

    def _python(self, what: str, code: str) -> None:
        self._do(what, "python", "-c", code)

    def _do(self, what: str, program: str, *arguments: str) -> None:
        # by which numpy's linear algebra rounds
        environment = {
            name: value for name, value in os.environ.items() if name.startswith("OPENBLAS_")
        }
        environment |= {
            "PATH": str(self.bin),
            "HOME": str(self.folder),
            "BALANCE_ROPE_CACHE": str(self.cache),
        }
        begin = time.monotonic()
        command = [str(self.bin / program), *arguments]
        done = subprocess.run(
            command,
            cwd=self.work,
            env=environment,
            capture_output=True,
            text=True,
            timeout=1800,
            check=False,
        )
        step = Step(what, time.monotonic() - begin, done.stdout + done.stderr)
        if done.returncode:
            raise RuntimeError(f"{what} failed:\n{step.said[-3000:]}")
        self.steps.append(step)
        self.told(step)


class ReadmeStep(NamedTuple):
    """Code of the README: a program of the environment, "balance-rope" or "python", and its command line or code."""

    program: str
    text: str


def readme_steps() -> Iterator[ReadmeStep]:
    """Yield all commands of this project and all Python of the README, in its order."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    command = ".venv/bin/balance-rope "
    for language, block in re.findall(r"^```(\w*)\n(.*?)^```", readme, re.DOTALL | re.MULTILINE):
        if language == "python":
            yield ReadmeStep("python", block)
        else:
            lines = [line for line in block.splitlines() if line.startswith(command)]
            yield from (ReadmeStep("balance-rope", line.removeprefix(command)) for line in lines)


if __name__ == "__main__":
    (path,) = sys.argv[1:]
    print(f"{path}: {Path(path).stat().st_size / 1e6:.2f} MB")
    try_wheel(
        Path(path).resolve(), lambda step: print(f"{step.seconds:7.1f} s  {step.what}", flush=True)
    )
    print("nothing was compiled; native FMUs and system are those of this checkout, byte by byte")
