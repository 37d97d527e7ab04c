"""Wind trips with the motions that tables, sensors and slower parts send; write the table in docs/howto/motion.md.

Five minutes on two cores.  Exits with 1 where a target is missed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from evidence.options import add_out
from evidence.pages import BLOCKS, fill
from evidence.tables import table, write
from fmu_src.export import export_fmu
from fmu_src.native.build import host_platform
from fmu_src.native.export import export_native
from fmu_src.profile import FULL

from .block import claims
from .multirate import MULTIRATE_COLUMNS, multirate
from .sources import SIGNALS
from .wind import COLUMNS, STEP, TRIPS, row, rows, run, through_fmu

BLOCK = BLOCKS["signals"]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; 1 where a target is missed."""
    parser = argparse.ArgumentParser("python -m evidence.signals", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    jobs = [(trip, step) for trip in TRIPS for step in trip.steps]
    with ProcessPoolExecutor() as pool:
        found = [x for part in pool.map(_rows, jobs) for x in part]
    with tempfile.TemporaryDirectory() as folder:
        found += _through_fmus(Path(folder))
        slower = list(multirate(Path(folder)))
    tables = {"signals": table(COLUMNS, found), "multirate": table(MULTIRATE_COLUMNS, slower)}
    write(tables, options.out / "data" / BLOCK.data)
    print(fill(BLOCK, options.out))
    missed = [claim for claim in claims(tables) if not claim.holds]
    for claim in missed:
        print(f"missed: {claim.what} is {claim.value:.3g}, wanted {claim.relation} {claim.bound:.3g}", file=sys.stderr)
    return int(bool(missed))


def _rows(job: tuple[Any, float]) -> list[tuple[Any, ...]]:
    return list(rows(*job))


def _through_fmus(folder: Path) -> Iterator[tuple[Any, ...]]:
    """Both flavours through FMPy, which reads inputs at a step's start."""
    trip = TRIPS[0]
    exact = run(trip, trip.scene("reference"), SIGNALS[0].make(trip.motion, STEP), STEP, "end").values
    native = export_native(folder / "native.fmu", platforms=(host_platform(),), profile=FULL)
    python = export_fmu(folder / "python.fmu", profile=FULL)
    for name, path in (("native FMU", native), ("Python FMU", python)):
        for signal in SIGNALS:
            found = row(trip, signal, STEP, "start", exact, through_fmu(path, signal, STEP))
            yield (f"{trip.name}, {name}", *found[1:])


if __name__ == "__main__":
    sys.exit(main())
