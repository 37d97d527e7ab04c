"""Fuzzing of the native FMU's C entry points: ``python -m benchmarks.fuzz --minutes 30``.

Builds tests/native/fuzz_fmi2.c and fuzz_fmi3.c with all sources of the FMU by clang, libFuzzer, the address and the
undefined-behaviour sanitizer, lets both run side by side, and prints what was executed and found, and how
many lines of the sources the kept inputs run (llvm-cov; the elements' generated arithmetic does not count).
The corpus is kept beside the build and goes on growing.  Debian: apt-get install clang llvm libclang-rt-14-dev.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from fmu_src.native.export import native_table, rope_sources, shell_sources
from fmu_src.native.start import Start, c_start
from fmu_src.native.table import start_values
from rope_model.cases import rope_120

ROOT = Path(__file__).resolve().parent.parent
TARGETS = ROOT / "tests" / "native"
#: the sources' own calls of calloc and free go to the target
FLAGS = (
    "-std=gnu99",
    "-g",
    "-O1",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-Dcalloc=fuzz_take",
    "-Dfree=fuzz_give_back",
)
SANITIZED = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
MEASURED = ("-fprofile-instr-generate", "-fcoverage-mapping")
#: what the fuzzer follows; the elements' arithmetic has no branches of interest and would be slow
FOLLOWED = "-fsanitize=fuzzer"


class Outcome(NamedTuple):
    """``covered`` of ``lines``, by ``inputs`` that are kept; ``findings`` are files that reproduce a failure.

    An execution is two ropes of a drawn mesh in shafts of drawn bodies, through up to 64 calls.
    """

    fmi: int
    minutes: float
    executions: int
    inputs: int
    covered: int
    lines: int
    findings: int
    commit: str


def build(fmi: int, folder: Path, name: str, flags: Sequence[str]) -> None:
    """The fuzz target as ``name`` in ``folder``, compiled with more ``flags``."""
    table = native_table(rope_120())
    files = rope_sources() | shell_sources(table, fmi)
    files["start.c"] = c_start(Start("fuzz", start_values(table, fmi)))
    files |= {
        path: (TARGETS / path).read_text(encoding="utf-8")
        for path in ("fuzz.h", f"fuzz_fmi{fmi}.c")
    }
    folder.mkdir(parents=True, exist_ok=True)
    for path, text in files.items():
        (folder / path).write_text(text, encoding="utf-8")
    sources = sorted(path for path in files if path.endswith(".c"))
    for path in sources:
        followed = () if path.startswith("rope_kernels") else (FOLLOWED,)
        _done([_tool("clang"), *FLAGS, *flags, *followed, "-c", path], folder)
    objects = [f"{Path(path).stem}.o" for path in sources]
    _done([_tool("clang"), *FLAGS, *flags, FOLLOWED, *objects, "-o", name, "-lm"], folder)


def run(fmi: int, folder: Path, minutes: float) -> Outcome:
    """libFuzzer for so long in one process; it stops at the first finding."""
    build(fmi, folder, "fuzz", SANITIZED)
    (folder / "corpus").mkdir(exist_ok=True)
    command = [
        "./fuzz",
        "corpus",
        f"-max_total_time={round(60 * minutes)}",
        "-max_len=1024",
        "-timeout=600",
        "-rss_limit_mb=2048",
        "-len_control=0",
        "-seed=2",
    ]
    log = folder / "log.txt"
    with log.open("w", encoding="utf-8") as told:
        subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=told, check=False)
    found = [
        path for kind in ("crash", "timeout", "oom", "leak") for path in folder.glob(f"{kind}-*")
    ]
    last = re.findall(r"Done (\d+) runs in (\d+) second", log.read_text(encoding="utf-8"))
    executions, seconds = map(int, last[-1]) if last else (0, 0)
    inputs = len(list((folder / "corpus").iterdir()))
    lines = coverage(fmi, folder)
    return Outcome(fmi, round(seconds / 60, 1), executions, inputs, *lines, len(found), commit())


def commit() -> str:
    """The commit of the sources, with a + where files differ from it; "" outside of a checkout."""
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty=+"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return told.stdout.strip()


def coverage(fmi: int, folder: Path) -> tuple[int, int]:
    """Lines that the kept inputs run, and all lines."""
    build(fmi, folder, "measured", MEASURED)
    environment = {**os.environ, "LLVM_PROFILE_FILE": "raw"}
    _done(["./measured", "corpus", "-runs=0", "-rss_limit_mb=2048"], folder, env=environment)
    _done([_tool("llvm-profdata"), "merge", "raw", "-o", "profile"], folder)
    told = _done(
        [_tool("llvm-cov"), "export", "-summary-only", "-instr-profile=profile", "./measured"],
        folder,
    )
    files = json.loads(told)["data"][0]["files"]
    ours = [
        f["summary"]["lines"]
        for f in files
        if not re.search(r"(rope_kernels|fuzz)[^/]*$|\.inc$", f["filename"])
    ]
    return sum(lines["covered"] for lines in ours), sum(lines["count"] for lines in ours)


def _tool(name: str) -> str:
    found = shutil.which(name) or shutil.which(f"{name}-14")
    if found is None:
        raise SystemExit(f"fuzzing needs {name}: apt-get install clang llvm libclang-rt-14-dev")
    return found


def _done(command: Sequence[str], folder: Path, env: Mapping[str, str] | None = None) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=env)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)} failed: {done.stderr[-2000:]}")
    return done.stdout


def main() -> None:
    parser = argparse.ArgumentParser(description="fuzz the native FMU's C entry points")
    parser.add_argument("--minutes", type=float, default=30.0, help="of each version")
    parser.add_argument("--csv", type=Path, help="write the table there")
    options = parser.parse_args()
    folder = ROOT / "build" / "fuzz"  # of build, corpus and findings
    with ThreadPoolExecutor() as pool:
        outcomes = list(
            pool.map(lambda fmi: run(fmi, folder / f"fmi{fmi}", options.minutes), (2, 3))
        )
    for outcome in outcomes:
        print(
            f"FMI {outcome.fmi}, {outcome.commit}: {outcome.minutes:.1f} min, {outcome.executions} executions, "
            f"{outcome.inputs} inputs kept, which run {outcome.covered} of {outcome.lines} lines; "
            f"{outcome.findings} findings"
        )
    if options.csv:
        with options.csv.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(Outcome._fields)
            table.writerows(outcomes)
    if any(outcome.findings for outcome in outcomes):
        raise SystemExit(f"findings are in {folder}")


if __name__ == "__main__":
    main()
