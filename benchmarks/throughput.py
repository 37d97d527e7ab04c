"""Windings per minute of a study on this machine: ``make bench``, or ``python -m benchmarks.throughput``.

One worker and two, in turns, with the rope of either level, over `docs/studies/throughput.toml`, windings of the 120 m
rope.  Takes ten minutes on a quiet machine; ``--runs 8`` is a trial.  With ``--forms`` two workers wind trips in C and
in Python in turns.
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.host import Host
from hoist_demo.study.cluster import cluster, run_samples
from hoist_demo.study.definition import Study, read_study
from hoist_demo.study.store import Store

FMUS = tuple(Path("build") / f"{level}.fmu" for level in ("draft", "standard"))
STUDY = Path("docs") / "studies" / "throughput.toml"
ROUNDS = (1, 2, 2, 1)
FORMS = ("C", "Python", "Python", "C", "C", "Python")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.throughput", description=__doc__)
    parser.add_argument("--runs", type=int, default=200, metavar="N", help="runs of the study (%(default)s)")
    parser.add_argument("--forms", action="store_true", help="compare trips in C with those in Python")
    options = parser.parse_args()
    runs: int = options.runs
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "throughput.toml"
        text = re.sub(r"(?m)^runs = .*$", f"runs = {runs}", STUDY.read_text(encoding="utf-8"))
        file.write_text(text, encoding="utf-8")
        for fmu in FMUS:
            if options.forms:
                compare(read_study(file, fmu), Path(folder) / fmu.stem)
                continue
            one, two = rates(read_study(file, fmu), Path(folder) / fmu.stem)
            efficiency = f"{two:.0f} with two, efficiency {two / one / 2:.2f}"
            print(f"{fmu.stem}: {one:.0f} windings a minute with one worker, {efficiency}", flush=True)


def rates(study: Study, folder: Path) -> tuple[float, float]:
    """Return windings per minute with one and with two workers."""
    found: dict[int, list[float]] = {1: [], 2: []}
    for number, workers in enumerate(ROUNDS):
        found[workers].append(wind(study, folder / str(number), workers)[0])
    one, two = (sum(found[n]) / len(found[n]) for n in (1, 2))
    return one, two


def wind(study: Study, folder: Path, workers: int, in_python: bool = False) -> tuple[float, list[Mapping[str, float]]]:
    """Return windings per minute and each one's clocks [s], after a run that warms every worker."""
    with cluster(workers, None) as client:
        if in_python:
            client.run(wind_in_python)
        run_samples(client, study, study.samples[-workers:], Store(folder / "warm"))
        store, begin = Store(folder / "timed"), time.perf_counter()
        keys = run_samples(client, study, study.samples, store)
        rate = 60.0 * len(keys) / (time.perf_counter() - begin)
    return rate, [record["clock"] for key in keys if (record := store.read(key))]


def compare(study: Study, folder: Path) -> None:
    """Print windings per minute of two workers and the processor time of one, of trips in C and in Python."""
    found: dict[str, list[tuple[float, list[Mapping[str, float]]]]] = {form: [] for form in FORMS}
    for number, form in enumerate(FORMS):
        found[form].append(wind(study, folder / str(number), 2, form == "Python"))
    for form, rounds in found.items():
        clocks = [clock for _, each in rounds for clock in each]
        low, middle, high = np.percentile([1e3 * clock["processor"] for clock in clocks], (10, 50, 90))
        rope, drive = (sum(clock[name] for clock in clocks) for name in ("rope", "drive"))
        told = ", ".join(f"{rate:.0f}" for rate, _ in rounds)
        core = f"{low:.0f}, {middle:.0f}, {high:.0f} ms of a core (10, 50, 90 %)"
        both = f"rope and drive take {1.0 + drive / rope:.2f} times the rope"
        print(f"{study.fmu.stem}, {form}: {told} windings a minute; {core}; {both}", flush=True)
    ratios = ", ".join(f"{c / p:.2f}" for (c, _), (p, _) in zip(*found.values(), strict=True))
    print(f"{study.fmu.stem}: {ratios} times as many in C", flush=True)


def wind_in_python() -> None:
    """Wind no trip in C in this process from now on."""
    Host._compiled = lambda self, run: None  # type: ignore[method-assign]


if __name__ == "__main__":
    main()
