"""The console command ``balance-rope``."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence

try:  # Ctrl-C during the slow imports must not print a traceback
    from hoist_demo.command_line.duty import add_duty
    from hoist_demo.command_line.export import DEFAULT_FMU, add_export
    from hoist_demo.command_line.hoist import add_hoist_commands
    from hoist_demo.command_line.identify import add_identify
    from hoist_demo.command_line.linear import add_linear
    from hoist_demo.command_line.study import add_study
    from hoist_demo.command_line.support import (
        INTERRUPTED,
        outlive_readers,
        treat_hangup_as_interrupt,
    )
    from hoist_demo.command_line.uncertain import add_uncertain
    from hoist_demo.command_line.wind import add_wind
    from rope_model import __version__
    from rope_model.files import WriteError
except KeyboardInterrupt:
    print("balance-rope: interrupted", file=sys.stderr)
    sys.exit(130)

DESCRIPTION = """\
The balance rope of a friction (Koepe) hoist, as an FMU and in a winding.

The rope hangs in a U below the two conveyances: tension, torsion and lateral motion, coupled. The drive (motor,
sheave, head ropes, conveyances) is a CasADi model that exchanges end motions and end forces with the FMU."""

EPILOG = """\
first steps:
  balance-rope export                  write the rope to build/balance_rope_native.fmu: C for all platforms
  balance-rope export --fmi 2 3        the same for both versions of FMI
  balance-rope export --python         the published system in plain Python: build/balance_rope.fmu
  balance-rope wind                    wind 90 m with it; figures, CSV and a report in out/wind/rope-120
  balance-rope new NAME --depth 870 --payload 22t --speed 16    the file of your own hoist, NAME.toml
  balance-rope show NAME.toml          its values, and what follows from them
  balance-rope wind NAME.toml          one trip of it, with one balance rope or several that differ
  balance-rope study STUDY.toml        wind many times, with parameters over grids, samples or a search
  balance-rope duty SCHEDULE.toml      wind many trips as one run, each from where the last has left the rope
  balance-rope identify MEASURED.toml  find the rope's properties from measurements
  balance-rope uncertain SCENE.toml    wind with all that is not known of the rope: spread, and what causes it
  balance-rope modes                   frequencies and damping of hoist and rope along the trip
  balance-rope linearise               linear models for controller design
  balance-rope COMMAND --help          what a command can do

Compiled code is kept in the user's cache folder; the environment variable BALANCE_ROPE_CACHE names another.
Exit code 1 also means that a result could not be written; 2 means that nothing was run.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    outlive_readers()
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        "balance-rope", description=DESCRIPTION, epilog=EPILOG, formatter_class=raw
    )
    parser.add_argument("--version", action="version", version=f"balance-rope {__version__}")
    parser.add_argument("-v", "--verbose", action="store_true", help="log what the solver does")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    add_hoist_commands(commands)
    add_export(commands)
    add_wind(commands, DEFAULT_FMU)
    add_study(commands)
    add_duty(commands)
    add_identify(commands)
    add_uncertain(commands)
    add_linear(commands)
    # accept -v after the command too; `wind` and `demo` share one parser
    for command in dict.fromkeys(commands.choices.values()):
        command.add_argument(
            "-v",
            "--verbose",
            action="store_true",
            default=argparse.SUPPRESS,
            help="log what the solver does",
        )
    options = parser.parse_args(arguments)
    treat_hangup_as_interrupt()
    if options.verbose:
        logging.basicConfig(level=logging.INFO, format="%(name)s: %(message)s")
    else:
        logging.basicConfig(level=logging.WARNING, format="balance-rope: %(message)s")
    try:
        code: int = options.run(options)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("balance-rope: interrupted", file=sys.stderr)
        return INTERRUPTED
    except WriteError as error:  # what was computed is not all kept: no wrong arguments
        print(f"balance-rope: {error}", file=sys.stderr)
        return 1
    except (ValueError, RuntimeError, OSError) as error:
        print(f"balance-rope: {error}", file=sys.stderr)
        return 2
