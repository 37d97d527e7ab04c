"""Fuzzing of the native FMU's C entry points: ``python -m benchmarks.fuzz --minutes 30``.

Builds tests/native/fuzz_fmi2.c and fuzz_fmi3.c with all sources of the FMU by clang, libFuzzer, the address and the
undefined-behaviour sanitizer, lets each run for half of the time, and prints what was executed, covered and found.
The corpus is kept beside the build and goes on growing.  Debian: apt-get install clang libclang-rt-14-dev.
"""

from __future__ import annotations

import argparse
import csv
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

from fmu_src.native.export import native_table, rope_sources, shell_sources
from fmu_src.native.table import c_table
from rope_model.parameters import rope_120

ROOT = Path(__file__).resolve().parent.parent
TARGETS = ROOT / "tests" / "native"
#: the sources' own calls of calloc and free go to the target
FLAGS = (
    "-std=gnu99", "-g", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-sanitize-recover=all",
    "-fsanitize=address,undefined,float-cast-overflow", "-Dcalloc=fuzz_take", "-Dfree=fuzz_give_back",
)  # fmt: skip
#: what the fuzzer follows; the elements' arithmetic has no branches of interest and would be slow
FOLLOWED = "-fsanitize=fuzzer"


class Outcome(NamedTuple):
    """``covered`` and ``edges`` of the sources' branches; ``findings`` are files that reproduce a failure."""

    fmi: int
    minutes: float
    executions: int
    covered: int
    edges: int
    corpus: int
    findings: int


def build(fmi: int, folder: Path) -> Path:
    """The fuzz target with sanitizers."""
    compiler = shutil.which("clang")
    if compiler is None:
        raise SystemExit("fuzzing needs clang and its libFuzzer: apt-get install clang libclang-rt-14-dev")
    table = native_table(rope_120())
    files = rope_sources() | shell_sources(table, fmi) | {"variables.c": c_table(table, "fuzz", fmi)}
    files |= {name: (TARGETS / name).read_text(encoding="utf-8") for name in ("fuzz.h", f"fuzz_fmi{fmi}.c")}
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = sorted(name for name in files if name.endswith(".c"))
    for name in sources:
        followed = () if name.startswith("chain") else (FOLLOWED,)
        subprocess.run([compiler, *FLAGS, *followed, "-c", name], cwd=folder, check=True)
    objects = [f"{Path(name).stem}.o" for name in sources]
    subprocess.run([compiler, *FLAGS, FOLLOWED, *objects, "-o", "fuzz", "-lm"], cwd=folder, check=True)
    return folder / "fuzz"


def run(fmi: int, folder: Path, minutes: float) -> Outcome:
    """libFuzzer for so long in one process; it stops at the first finding."""
    target, corpus = build(fmi, folder), folder / "corpus"
    corpus.mkdir(exist_ok=True)
    command = [
        str(target), "corpus", f"-max_total_time={round(60 * minutes)}", "-max_len=1024", "-timeout=120",
        "-rss_limit_mb=2048", "-print_final_stats=1", "-len_control=0", "-seed=1",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    (folder / "log.txt").write_text(done.stderr, encoding="utf-8")
    last = re.findall(r"#(\d+)\s.*cov: (\d+) .*corp: (\d+)/", done.stderr)
    edges = re.search(r"\((\d+) inline 8-bit counters\)", done.stderr)
    seconds = re.search(r"Done \d+ runs in (\d+) second", done.stderr)
    executions, covered, number = map(int, last[-1]) if last else (0, 0, 0)
    found = [path for kind in ("crash", "timeout", "oom", "leak") for path in folder.glob(f"{kind}-*")]
    return Outcome(
        fmi, int(seconds[1]) / 60 if seconds else 0.0, executions, covered, int(edges[1]) if edges else 0, number,
        len(found),
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description="fuzz the native FMU's C entry points")
    parser.add_argument("--minutes", type=float, default=30.0, help="in total")
    parser.add_argument("--fmi", type=int, choices=(2, 3), help="one version only")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "fuzz", help="of build, corpus and findings")
    parser.add_argument("--csv", type=Path, help="write the table there")
    options = parser.parse_args()
    versions = (options.fmi,) if options.fmi else (2, 3)
    outcomes = [run(fmi, options.folder / f"fmi{fmi}", options.minutes / len(versions)) for fmi in versions]
    for outcome in outcomes:
        print(
            f"FMI {outcome.fmi}: {outcome.minutes:.1f} min, {outcome.executions} executions, "
            f"{outcome.covered} of {outcome.edges} branches, {outcome.corpus} inputs kept, {outcome.findings} findings"
        )
    if options.csv:
        with options.csv.open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(Outcome._fields)
            table.writerows(outcomes)
    if any(outcome.findings for outcome in outcomes):
        raise SystemExit(f"findings are in {options.folder}")


if __name__ == "__main__":
    main()
