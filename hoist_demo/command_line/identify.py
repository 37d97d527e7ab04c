"""The command ``balance-rope identify``."""

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from hoist_demo.command_line.support import CHECKED, add_results, describe, results_folder
from hoist_demo.report.rows import render

_DESCRIPTION = """\
Find a rope's properties from measurements: weighted least squares within the ranges of the catalogue, with intervals,
what the data do not tell, and which measurement would help most."""

_EPILOG = """\
examples:
  balance-rope identify examples/measurements/example.toml
  balance-rope wind --in-process --rope out/identify/MEASURED/rope.toml    wind with what was found

Results in --out: rope.toml, the parameters for other commands, data.csv, where each number comes from, and report.html.
The file is explained in docs/reference/files.md.
exit code: 0 found (what stays undetermined, or lies at an end of its range, is named), 1 a compromise between
measurements that contradict the model or one another: nothing is calibrated, 2 wrong file or arguments, 130
interrupted, with nothing written.
"""


def add_identify(identify: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``identify``."""
    describe(identify, _identify, _DESCRIPTION, _EPILOG)
    text = "what was measured, see docs/reference/files.md"
    identify.add_argument("measured", type=Path, metavar="MEASURED.toml", help=text)
    add_results(identify, "identify")


def _identify(options: argparse.Namespace) -> int:
    from hoist_demo.calibration.definition import MeasurementFile
    from hoist_demo.calibration.identify import identify
    from hoist_demo.calibration.page import (
        complaints,
        summary,
        write_page,
        write_rope_file,
    )
    from hoist_demo.files.reading import read
    from hoist_demo.run.provenance import write_data

    file = read(options.measured, MeasurementFile)
    if options.check:
        file.require_hangs()
        count = sum(len(m.values) for m in file.measurements)
        hangs = "the rope hangs where it is measured"
        print(f"{options.measured}: {count} values; {CHECKED}; {hangs}")
        return 0
    out = results_folder(options.out or Path("out") / "identify" / options.measured.stem)
    windings = 0
    with tqdm(desc="fitting", unit=" ropes", file=sys.stderr, leave=False, disable=None) as bar:

        def computed(of_rope: int) -> None:
            nonlocal windings
            windings += of_rope
            bar.set_postfix_str(f"{windings} windings", refresh=False)
            bar.update()

        result = identify(file, computed)
    print(render(summary(result)))
    written = (
        write_rope_file(result, out / "rope.toml"),
        write_data(result.provenance(), out / "data.csv"),
        write_page(result, out / "report.html"),
    )
    print("\nwritten: " + ", ".join(map(str, written)))
    for text in complaints(result):
        print(f"balance-rope: warning: {text}", file=sys.stderr)
    if result.fit.contradicted:
        return 1
    return 0
