"""Throughput of a study on this machine, and what an interruption costs: ``python -m benchmarks.throughput``.

Four measurements with `docs/studies/throughput.toml`, windings of the 120 m rope:

1. what its communication step of 20 ms errs by in six of them, and 10 ms, against 2.5 ms, all with the same controller;
2. one worker and two, in turns, the same runs, with the rope of either level: runs per minute, the processor time of a
   run, and the efficiency of two workers against one;
3. the whole study by the command, killed in the middle with SIGKILL, cluster and all;
4. the same command again: what was recorded before must be untouched, nothing may be missing.

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
from dataclasses import replace
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.recording.time_series import Recording
from hoist_demo.study.cluster import cluster, run_samples
from hoist_demo.study.definition import Study, read_study
from hoist_demo.study.run import RunData, wind
from hoist_demo.study.store import Store

FMUS = tuple(Path("build") / f"{level}.fmu" for level in ("draft", "standard"))
STUDY = Path("docs") / "studies" / "throughput.toml"
ROUNDS = (1, 2, 2, 1)
STEPS, FINE = (0.02, 0.01), 0.0025  # s
COMPARED = 6  # runs


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
            communication(study)
            efficiency(study, Path(folder) / fmu.stem)
        interruption(file, read_study(file), Path(folder) / "whole")


def communication(study: Study) -> None:
    """The worst errors of the rope's end forces in some runs, of the largest force in each."""
    runs = [sample.data for sample in study.samples[:COMPARED]]
    references = [record(study, run, FINE) for run in runs]
    for step in STEPS:
        found = [force_errors(record(study, run, step), fine) for run, fine in zip(runs, references, strict=True)]
        rms, largest = np.max(found, axis=0)
        print(f"steps of {1e3 * step:g} ms: end forces err by {rms:.2g} RMS and {largest:.2g} at most", flush=True)


def record(study: Study, run: RunData, step: float) -> Recording:
    """A run with another communication step and the same samples of the controller."""
    coupling = replace(run.coupling, step=step, sample=run.coupling.sample_time)
    rope = FmuRope(study.fmu, run.fmu)
    try:
        result, _ = wind(replace(run, coupling=coupling), rope)
    finally:
        rope.close()
    return result.recording


def force_errors(given: Recording, reference: Recording) -> tuple[float, float]:
    """RMS and largest difference of the end forces at the instants that both have, over the largest force."""
    shared = np.isin(np.round(reference.time, 6), np.round(given.time, 6))
    count = int(np.count_nonzero(shared))
    forces = np.array([[given[name][:count], reference[name][shared]] for name in ("left.fy", "right.fy")])
    missed = np.abs(forces[:, 0] - forces[:, 1])
    over = float(np.max(np.abs(forces[:, 1])))
    return float(np.sqrt(np.mean(missed**2, axis=1)).max()) / over, float(np.max(missed)) / over


def efficiency(study: Study, folder: Path) -> None:
    """Rates of one and of two workers over the whole study, each after a run that warms every worker."""
    count = len(study.samples)
    rates: dict[int, list[float]] = {1: [], 2: []}
    for number, workers in enumerate(ROUNDS):
        with cluster(workers, None) as client:
            run_samples(client, study, study.samples[-workers:], Store(folder / f"warm{number}"))
            begin = time.perf_counter()
            store = Store(folder / f"timed{number}")
            keys = run_samples(client, study, study.samples, store)
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
