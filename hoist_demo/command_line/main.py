"""The console command ``balance-rope``."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Sequence
from pkgutil import resolve_name
from typing import NamedTuple

try:  # Ctrl-C during the slow imports must not print a traceback
    from hoist_demo.command_line.support import (
        INTERRUPTED,
        outlive_readers,
        treat_hangup_as_interrupt,
    )
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


_log = logging.getLogger(__name__)
_VERBOSE = "log what the solver does, and where an error arises"
_LINEARISE = "linear models for controller design"
_UNCERTAIN = "what a winding may be, with all that is not known of its rope"
_DUTY = "wind many trips as one run, each from where the last has left the rope"


class _Command(NamedTuple):
    """Command of ``balance-rope``, whose module is imported only when the command is asked for."""

    name: str
    describe: str  # module:function, which adds description and options to the command's parser
    text: str
    others: tuple[str, ...] = ()  # other names

    def add_options(self, command: argparse.ArgumentParser) -> None:
        """Add description and options, by the command's own module, and what all commands have."""
        describe: Callable[[argparse.ArgumentParser], None] = resolve_name(
            f"hoist_demo.command_line.{self.describe}"
        )
        describe(command)
        # accept -v after the command too
        command.add_argument(
            "-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help=_VERBOSE
        )


COMMANDS = (
    _Command("new", "hoist:add_new", "write the file of your hoist"),
    _Command("show", "hoist:add_show", "print a hoist and what follows from it"),
    _Command("check", "hoist:add_check", "only what is wrong with it"),
    _Command("rope", "hoist:add_rope", "the catalogue's ropes, or one as [[rope]] of a file"),
    _Command("export", "export:add_export", "write the rope as an FMU"),
    _Command("wind", "wind:add_wind", "wind once and write figures, CSV and a report", ("demo",)),
    _Command("study", "study:add_study", "wind many times over chosen parameters"),
    _Command("duty", "duty:add_duty", _DUTY),
    _Command("identify", "identify:add_identify", "find a rope's properties from measurements"),
    _Command("uncertain", "uncertain:add_uncertain", _UNCERTAIN),
    _Command("linearise", "linear:add_linearise", _LINEARISE),
    _Command("modes", "linear:add_modes", "frequencies and damping along the trip"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    outlive_readers()
    try:
        options = _parsed(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:  # in the slow imports of a command
        print("balance-rope: interrupted", file=sys.stderr)
        return INTERRUPTED
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
        _log.info("place of the error:", exc_info=True)
        print(f"balance-rope: {error}", file=sys.stderr)
        return 2


def _parsed(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options. Of the commands only the one that is asked for is imported."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        "balance-rope", description=DESCRIPTION, epilog=EPILOG, formatter_class=raw
    )
    parser.add_argument("--version", action="version", version=f"balance-rope {__version__}")
    parser.add_argument("-v", "--verbose", action="store_true", help=_VERBOSE)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    # the options before a command have no values
    asked = next((word for word in arguments if not word.startswith("-")), "")
    for one in COMMANDS:
        command = commands.add_parser(one.name, help=one.text, aliases=one.others)
        if asked in (one.name, *one.others):
            one.add_options(command)
    return parser.parse_args(arguments)
