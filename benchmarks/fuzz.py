"""Fuzzing of the native FMU's C entry points: ``python -m benchmarks.fuzz --minutes 30``.

Builds tests/native/fuzz_fmi2.c and fuzz_fmi3.c with all sources of the FMU by clang, libFuzzer, the
address and the undefined-behaviour sanitizer, runs both at the same time, and prints numbers of
executions and findings, and of source lines that the kept inputs run (llvm-cov; the elements'
generated arithmetic does not count). The corpus is kept in the folder of the build and goes on
growing. Debian: apt-get install clang llvm libclang-rt-14-dev.
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

from fmu_src.interface import variables
from fmu_src.native.export import rope_sources, shell_sources
from fmu_src.shell.start import Start, c_start
from fmu_src.shell.table import start_values
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
#: of files whose branches the fuzzer follows; the elements' arithmetic has none of interest, and
#: would be slow
FOLLOWED = "-fsanitize=fuzzer"
#: beginnings of the names of files that reproduce a failure
FAILURES = ("crash", "timeout", "oom", "leak")


class Outcome(NamedTuple):
    """Outcome of a run.

    An execution is two ropes of a drawn mesh in shafts of drawn bodies, through up to 64 calls.
    """

    fmi: int
    minutes: float
    executions: int
    inputs: int  # that are kept
    covered: int  # lines that these inputs run
    lines: int  # of all sources
    findings: int  # files that reproduce a failure
    commit: str


def build(fmi: int, folder: Path, name: str, flags: Sequence[str]) -> None:
    """The fuzz target as ``name`` in ``folder``, compiled with more ``flags``."""
    table = variables(rope_120())
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
        command = [_tool("clang"), *FLAGS, *flags]
        if not path.startswith("chains_"):
            command.append(FOLLOWED)
        _run([*command, "-c", path], folder)
    objects = [f"{Path(path).stem}.o" for path in sources]
    _run([_tool("clang"), *FLAGS, *flags, FOLLOWED, *objects, "-o", name, "-lm"], folder)


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
    with log.open("w", encoding="utf-8") as output:
        subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=output, check=False)
    executions = 0
    seconds = 0
    for runs, duration in re.findall(
        r"Done (\d+) runs in (\d+) second", log.read_text(encoding="utf-8")
    ):
        executions = int(runs)
        seconds = int(duration)
    covered, lines = coverage(fmi, folder)
    return Outcome(
        fmi=fmi,
        minutes=round(seconds / 60, 1),
        executions=executions,
        inputs=len(list((folder / "corpus").iterdir())),
        covered=covered,
        lines=lines,
        findings=sum(len(list(folder.glob(f"{kind}-*"))) for kind in FAILURES),
        commit=commit(),
    )


def commit() -> str:
    """The commit of the sources, with a + where files differ from it; "" outside of a checkout."""
    described = subprocess.run(
        ["git", "describe", "--always", "--dirty=+"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    return described.stdout.strip()


def coverage(fmi: int, folder: Path) -> tuple[int, int]:
    """Lines that the kept inputs run, and all lines."""
    build(fmi, folder, "measured", MEASURED)
    environment = {**os.environ, "LLVM_PROFILE_FILE": "raw"}
    _run(["./measured", "corpus", "-runs=0", "-rss_limit_mb=2048"], folder, env=environment)
    _run([_tool("llvm-profdata"), "merge", "raw", "-o", "profile"], folder)
    summary = _run(
        [_tool("llvm-cov"), "export", "-summary-only", "-instr-profile=profile", "./measured"],
        folder,
    )
    files = json.loads(summary)["data"][0]["files"]
    ours = [
        f["summary"]["lines"]
        for f in files
        if not re.search(r"(chains_|fuzz)[^/]*$|\.inc$", f["filename"])
    ]
    return sum(lines["covered"] for lines in ours), sum(lines["count"] for lines in ours)


def _tool(name: str) -> str:
    found = shutil.which(name) or shutil.which(f"{name}-14")
    if found is None:
        raise SystemExit(f"fuzzing needs {name}: apt-get install clang llvm libclang-rt-14-dev")
    return found


def _run(command: Sequence[str], folder: Path, env: Mapping[str, str] | None = None) -> str:
    """Return the output of a command in ``folder``; SystemExit if it fails."""
    result = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=env
    )
    if result.returncode:
        raise SystemExit(f"{' '.join(command)} failed: {result.stderr[-2000:]}")
    return result.stdout


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
            f"FMI {outcome.fmi}, {outcome.commit}: {outcome.minutes:.1f} min, "
            f"{outcome.executions} executions, {outcome.inputs} inputs kept, "
            f"which run {outcome.covered} of {outcome.lines} lines; {outcome.findings} findings"
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
