"""The command ``balance-rope uncertain``."""

import argparse
import os
import sys
from functools import partial
from pathlib import Path

from tqdm import tqdm

from hoist_demo.command_line.support import (
    CHECKED,
    HOIST_UNCHECKED,
    add_results,
    describe,
    results_folder,
)
from hoist_demo.report.rows import render

_DESCRIPTION = """\
Wind with ropes from all over the ranges of the catalogue, or of a calibration: what loop clearance, yaw, swivel torque
and end force may be, and which datum causes it."""

_EPILOG = """\
examples:
  balance-rope uncertain examples/uncertain/rope-120.toml
  balance-rope uncertain SCENE.toml --workers 1    in this process

Results in --out: windings.csv, a row per winding, data.csv, where each number comes from, and report.html.
The file is explained in docs/reference/files.md.
A winding whose rope passed through something describes no real rope: it is left out, and counted.
exit code: 0 all windings count, 1 some stopped or were left out, 2 wrong file or arguments, 130 interrupted.
"""


def add_uncertain(uncertain: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``uncertain``."""
    describe(uncertain, _uncertain, _DESCRIPTION, _EPILOG)
    uncertain.add_argument(
        "scene", type=Path, metavar="SCENE.toml", help="what is wound, see docs/reference/files.md"
    )
    uncertain.add_argument("--workers", type=int, metavar="N", help="processes (one per core)")
    add_results(uncertain, "uncertain")


def _uncertain(options: argparse.Namespace) -> int:
    from hoist_demo.files.reading import read
    from hoist_demo.run.provenance import write_data
    from hoist_demo.uncertainty.definition import UncertaintyFile
    from hoist_demo.uncertainty.page import remarks, summary, too_few, write_page, write_table
    from hoist_demo.uncertainty.spread import run_windings

    workers = options.workers
    if workers is None:
        workers = os.cpu_count() or 1
    if workers < 1:
        raise ValueError(f"--workers {workers} must be at least 1: leave it out for one per core")
    file = read(options.scene, UncertaintyFile)
    file.require_hangs()
    if options.check:
        planned = f"{file.header.samples} windings over {', '.join(file.data)}"
        hangs = "the rope of the ranges' middle hangs"
        print(f"{options.scene}: {planned}; {CHECKED}; {hangs}; {HOIST_UNCHECKED}")
        return 0
    out = results_folder(options.out or Path("out") / "uncertain" / options.scene.stem)
    watched = partial(
        tqdm,
        desc="winding",
        unit="winding",
        total=file.header.samples,
        file=sys.stderr,
        disable=None,
    )
    result = run_windings(file, workers, watched)
    print(render(summary(result)))
    written = (
        write_table(result, out / "windings.csv"),
        write_data(file.provenance(), out / "data.csv"),
        write_page(result, out / "report.html"),
    )
    print("\nwritten: " + ", ".join(map(str, written)))
    for text in remarks(result):
        print(f"balance-rope: {text}", file=sys.stderr)
    too_few_windings = too_few(result)
    if too_few_windings:
        print(f"balance-rope: warning: {too_few_windings}", file=sys.stderr)
    return result.exit_code
