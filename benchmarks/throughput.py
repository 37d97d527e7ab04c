"""Throughput of a study on this machine, and what an interruption costs: ``python -m benchmarks.throughput``.

Three measurements with `docs/studies/throughput.toml`, windings of the 120 m rope:

1. one worker and two, in turns, the same runs, with the rope of either level: runs per minute, the processor time of a
   run, and the efficiency of two workers against one;
2. the whole study by the command, killed in the middle with SIGKILL, cluster and all;
3. the same command again: what was recorded before must be untouched, nothing may be missing.

Takes a quarter of an hour on a quiet machine; ``--runs 8`` is a trial. Times hold for a quiet machine only.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from hoist_demo.study.cluster import cluster, run_samples
from hoist_demo.study.definition import Study, read_study
from hoist_demo.study.store import Store

FMUS = tuple(Path("build") / f"{level}.fmu" for level in ("draft", "standard"))
STUDY = Path("docs") / "studies" / "throughput.toml"
ROUNDS = (1, 2, 2, 1)
SHARE = 10  # of the study's runs are run in each round


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.throughput")
    parser.add_argument("--runs", type=int, default=200, metavar="N", help="runs of the study (%(default)s)")
    runs: int = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "throughput.toml"
        file.write_text(
            re.sub(r"(?m)^runs = .*$", f"runs = {runs}", STUDY.read_text(encoding="utf-8")), encoding="utf-8"
        )
        for fmu in FMUS:
            study = read_study(file, fmu)
            print(f"{fmu.stem}:", flush=True)
            efficiency(study, max(2, len(study.samples) // SHARE), Path(folder) / fmu.stem)
        interruption(file, read_study(file), Path(folder) / "whole")


def efficiency(study: Study, count: int, folder: Path) -> None:
    """Rates of one and of two workers, each after a run that warms every worker."""
    rates: dict[int, list[float]] = {1: [], 2: []}
    for number, workers in enumerate(ROUNDS):
        with cluster(workers, None) as client:
            warm, timed = study.samples[-workers:], study.samples[:count]
            run_samples(client, study, warm, Store(folder / f"warm{number}"))
            begin = time.perf_counter()
            store = Store(folder / f"timed{number}")
            keys = run_samples(client, study, timed, store)
            rates[workers].append(60.0 * count / (time.perf_counter() - begin))
        records = [record for key in keys if (record := store.read(key))]
        worked = statistics.median(record["clock"]["processor"] for record in records)
        print(
            f"{workers} worker{'s' * (workers > 1)}: {rates[workers][-1]:.1f} runs per minute, {count} runs of "
            f"{worked:.2f} s processor time each (median)",
            flush=True,
        )
    one, two = (sum(rates[n]) / len(rates[n]) for n in (1, 2))
    print(f"efficiency of two workers against one: {two / one / 2:.2f}")


def interruption(file: Path, study: Study, out: Path) -> None:
    """Kill the command when half of its runs are recorded, start it again, compare."""
    command = [sys.executable, "-m", "balance_rope", "study", str(file), "--out", str(out), "--workers", "2"]
    keys = [sample.data.key(study.fmu_hash) for sample in study.samples]
    records = out / "runs"
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and _count(records) < len(keys) // 2:
        time.sleep(0.2)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    before = {path.name: path.stat().st_mtime_ns for path in records.glob("*.json")}
    print(f"killed after {len(before)} of {len(keys)} runs", flush=True)

    begin = time.perf_counter()
    subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    seconds = time.perf_counter() - begin
    after = {path.name: path.stat().st_mtime_ns for path in records.glob("*.json")}
    repeated = sum(after.get(name) != stamp for name, stamp in before.items())
    missing = len(set(keys)) - len(Store(out).finished_keys(keys))
    new = len(after) - len(before)
    print(f"resumed: {new} more in {seconds:.0f} s (checks and start included), {repeated} repeated, {missing} missing")


def _count(folder: Path) -> int:
    return len(list(folder.glob("*.json"))) if folder.is_dir() else 0


if __name__ == "__main__":
    main()
