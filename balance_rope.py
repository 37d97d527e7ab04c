"""The console command ``balance-rope``: joins the FMU's export and the hoist, which know nothing of each other."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from fmu_src.export import export_fmu
from hoist_demo.cli import add_demo
from rope_model.parameters import LEVELS, PRESETS

DEFAULT_FMU = Path("build") / "balance_rope.fmu"
DOCS, QUICK = Path("docs"), Path("out") / "chart"

DESCRIPTION = """\
The balance rope of a friction (Koepe) hoist, as an FMU and in a winding.

The rope hangs in a U below the two conveyances: tension, torsion and lateral motion, coupled. The drive (motor,
sheave, head ropes, conveyances) is a CasADi model that exchanges end motions and end forces with the FMU."""

EPILOG = """\
first steps:
  balance-rope export                  write the rope to build/balance_rope.fmu
  balance-rope demo                    wind 90 m with it; figures, CSV and a report in out/demo
  balance-rope demo --quick            wind 10 m only, to see that all is in place
  balance-rope demo --in-process       the same rope without the FMU
  balance-rope chart                   measure accuracy against speed; page, figures and data in docs
  balance-rope COMMAND --help          what a command can do
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("balance-rope", description=DESCRIPTION, epilog=EPILOG, formatter_class=raw)
    parser.add_argument("--version", action="version", version=f"balance-rope {version('balance-rope')}")
    parser.add_argument("-v", "--verbose", action="store_true", help="log what the solver does")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    export = commands.add_parser(
        "export",
        help="write the rope as an FMU",
        description="Export the balance rope as an FMI 2.0 co-simulation FMU. The importing host needs Python with "
        "numpy and casadi; every parameter can still be set before initialisation.",
    )
    export.add_argument("--scene", choices=sorted(PRESETS), default="rope-120", help="start values (%(default)s)")
    export.add_argument(
        "--level",
        choices=tuple(LEVELS),
        default="standard",
        help="accuracy against speed, see docs/chart.md (%(default)s)",
    )
    export.add_argument("--out", type=Path, default=DEFAULT_FMU, help="the .fmu to write (%(default)s)")
    export.set_defaults(run=_export)
    add_demo(commands, DEFAULT_FMU)
    chart = commands.add_parser(
        "chart",
        help="measure accuracy against speed",
        description="Wind the 120 m rope with many meshes, steps and models, and chart error over processor time: "
        "chart.md, images/chart and data/chart in --out, and the table of levels in the README beside it. Some ten "
        "minutes.",
    )
    chart.add_argument("--out", type=Path, metavar="DIR", help=f"where to ({DOCS}; with --quick {QUICK})")
    chart.add_argument("--quick", action="store_true", help="a few points on 1 m of travel: a check, not a result")
    chart.add_argument("--only", metavar="FAMILY", help="measure one family anew and keep the rest; draw: none")
    chart.set_defaults(run=_chart)
    options = parser.parse_args(arguments)
    level = logging.INFO if options.verbose else logging.WARNING
    logging.basicConfig(level=level, format="%(name)s: %(message)s")
    try:
        code: int = options.run(options)
        return code
    except (ValueError, RuntimeError, OSError) as error:
        print(f"balance-rope: {error}", file=sys.stderr)
        return 2


def _export(options: argparse.Namespace) -> int:
    path = export_fmu(options.out, options.scene, options.level)
    what = f"FMI 2.0 co-simulation, scene {options.scene}, level {options.level}"
    print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, {what}")
    return 0


def _chart(options: argparse.Namespace) -> int:
    # the benchmarks are needed here only, and bring matplotlib
    from benchmarks.chart.command import run

    for path in run(options.out or (QUICK if options.quick else DOCS), options.only, options.quick):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
