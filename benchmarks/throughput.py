"""Windings per minute of a study on this machine: ``make bench``, or ``python -m benchmarks.throughput``.

One worker and two, in turns, with the rope of either level, over
``examples/studies/throughput.toml``, windings of the 120 m rope.  Takes three minutes on a quiet
machine; ``--runs 8`` is a trial.  With ``--python`` the host in Python, as other schemes take it,
winds the same runs in turns with the trip in C.
"""

import argparse
import re
import tempfile
import time
from itertools import product
from pathlib import Path

from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from hoist_demo.study.cluster import cluster, run_samples
from hoist_demo.study.definition import Study, read_study
from hoist_demo.study.store import Store

FMUS = tuple(Path("build") / f"{level}.fmu" for level in ("draft", "standard"))
STUDY = Path("examples") / "studies" / "throughput.toml"
ROUNDS = (1, 2, 2, 1)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.throughput", description=__doc__)
    parser.add_argument(
        "--runs", type=int, default=200, metavar="N", help="runs of the study (%(default)s)"
    )
    parser.add_argument(
        "--python", action="store_true", help="in turns with the host in Python, too"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "throughput.toml"
        text = re.sub(
            r"(?m)^runs = .*$", f"runs = {options.runs}", STUDY.read_text(encoding="utf-8")
        )
        file.write_text(text, encoding="utf-8")
        for fmu in FMUS:
            study = read_study(file, fmu)
            hosts = ("C", "Python") if options.python else ("C",)
            rates: dict[str, dict[int, list[float]]] = {host: {1: [], 2: []} for host in hosts}
            for (number, workers), host in product(enumerate(ROUNDS), hosts):
                to = Path(folder) / fmu.stem / f"{number}{host}"
                rates[host][workers].append(wind(study, to, workers, host == "Python"))
            for host, of_host in rates.items():
                one, two = (sum(each) / len(each) for each in of_host.values())
                efficiency = f"{two:.0f} with two, efficiency {two / one / 2:.2f}"
                print(
                    f"{fmu.stem} in {host}: {one:.0f} windings a minute with one worker, "
                    f"{efficiency}",
                    flush=True,
                )


def wind(study: Study, folder: Path, workers: int, in_python: bool) -> float:
    """Return windings per minute, after a run that warms every worker."""
    with cluster(workers, None) as client:
        if in_python:
            client.run(setattr, CompiledTrip, "for_run", lambda plan, run, max_samples: None)
        run_samples(client, study, study.samples[-workers:], Store(folder / "warm"))
        begin = time.perf_counter()
        keys = run_samples(client, study, study.samples, Store(folder / "timed"))
        return 60.0 * len(keys) / (time.perf_counter() - begin)


if __name__ == "__main__":
    main()
