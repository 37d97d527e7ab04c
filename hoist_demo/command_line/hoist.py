"""The commands ``balance-rope new``, ``show``, ``check`` and ``rope``."""

import argparse
import json
import shlex
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from hoist_demo.cases.case import BUILTIN_HOISTS
from hoist_demo.cases.hoist_file import schema
from hoist_demo.cases.new import WISHES, new_hoist
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.options import SET, settings
from hoist_demo.command_line.support import describe
from hoist_demo.files.registry import parameters, rope_parameters
from hoist_demo.files.rope_file import CATALOGUE_PARAMETERS
from hoist_demo.files.values import read_value
from rope_model.files import write_text

_NEW = """\
Write a complete, commented file of a hoist from a few numbers. What you do not give follows by a rule, which the file
states beside the value. Units may stand behind numbers: 22t, 52mm, 8kN."""
_NEW_EXAMPLES = """\
examples:
  balance-rope new mine --depth 870 --payload 22t --speed 16 --rope 34x7 --diameter 52mm
  balance-rope new mine --depth 870 --payload 22t --speed 16 --conveyance 18t --head-ropes 4 --ropes 2 --lay alternate
then:
  balance-rope show mine.toml      all values, where they come from, and what follows from them
  balance-rope wind mine.toml      one trip
"""
_SHOW = """\
Print the complete file of a hoist, every value with its status, and behind it what follows before anything is wound:
pulls and slip safety at rest and in motion against usual bounds, the rope's shape, yaw and clearances at rest, its
lowest frequencies, the fidelity and the mesh that a run takes."""


def add_new(new: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``new``."""
    describe(new, _new, _NEW, _NEW_EXAMPLES)
    new.add_argument("name", metavar="NAME", help="of the hoist, and of the file NAME.toml")
    for p in WISHES:
        text = p.help_text
        if p.start:
            if isinstance(p.start, float):
                start = f"{p.start:g}"
            else:
                start = str(p.start)
            text += f" ({start})"
        new.add_argument(f"--{p.name}", required=p.start == "", metavar="X", help=text)
    new.add_argument("--out", type=Path, metavar="FILE", help="(NAME.toml)")
    new.add_argument(
        "--schema", action="store_true", help="also a JSON Schema beside it, for editors"
    )
    new.add_argument("--force", action="store_true", help="write over a file that is there")


def add_show(show: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``show``."""
    _add(show, everything=True)


def add_check(check: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``check``."""
    _add(check, everything=False)


def _add(show: argparse.ArgumentParser, *, everything: bool) -> None:
    """Add description and options that ``show`` and ``check`` have."""
    describe(show, partial(_show, everything=everything), _SHOW, "")
    show.add_argument(
        "hoist", metavar="HOIST", help=f"a file, or one of {', '.join(BUILTIN_HOISTS)}"
    )
    show.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=SET)


def add_rope(rope: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``rope``."""
    text = "Print the catalogue's ropes, or one as [[rope]] of a file."
    describe(rope, _rope, text, "example: balance-rope rope 34x7 --diameter 52mm")
    rope.add_argument(
        "construction", nargs="?", metavar="KIND", help="one of the catalogue; all without it"
    )
    rope.add_argument("--diameter", default="44mm", metavar="D", help="[m] (%(default)s)")
    rope.add_argument("--length", default="120", metavar="L", help="[m] (%(default)s)")
    rope.add_argument(
        "--lay", choices=("right-hand", "left-hand"), default="right-hand", help="(%(default)s)"
    )


def _new(options: argparse.Namespace) -> int:
    """Write the file of a hoist, and print which bounds the hoist does not keep."""
    # slow imports
    from hoist_demo.design.hoist_checks import HoistCheck, checks
    from hoist_demo.report.hoist import check_in_words

    texts = {p: getattr(options, p.name.replace("-", "_")) for p in WISHES}
    chosen = {p.name: read_value(p, text) for p, text in texts.items() if text is not None}
    name = options.name.removesuffix(".toml")
    path = options.out or Path(f"{name}.toml")
    if path.exists() and not options.force:
        raise ValueError(f"{path} is there already: choose another name, or --force")
    text = new_hoist(name, chosen)
    path.parent.mkdir(parents=True, exist_ok=True)
    if options.schema:
        schema_path = path.with_name("hoist.schema.json")
        write_text(schema_path, json.dumps(schema()))
        text = f"#:schema ./{schema_path.name}\n{text}"
    write_text(path, text)
    quoted = shlex.quote(str(path))
    print(f"written: {path}\nnow: balance-rope show {quoted}; balance-rope wind {quoted}")
    case = find_case(str(path))
    check = HoistCheck(tuple(checks(case)), case.remarks)
    for line in (*check.problems, *_noted([*check.notes, *case.notes])):
        print(f"balance-rope: {line}", file=sys.stderr)
    print(f"# {path}: {check_in_words(check)}; `balance-rope check {quoted}` also hangs the ropes")
    return 0


def _rope(options: argparse.Namespace) -> int:
    from rope_model import CONSTRUCTIONS
    from rope_model import rope as catalogue_rope

    p = rope_parameters()
    diameter, length = (
        read_value(p[f"rope.{name}"], getattr(options, name)) for name in ("diameter", "length")
    )
    if options.construction is None:
        print(
            f"{'KIND':<12} {'kg/m':>18} {'EI, N m2':>20} {'torque factor':>20}     at {diameter:g} "
            "m"
        )
        for kind in CONSTRUCTIONS:
            data = catalogue_rope(kind, float(diameter)).data
            cells = (
                data[name] for name in ("mass_per_length", "bending_stiffness", "torque_factor")
            )
            print(
                f"{kind:<12} " + " ".join(f"{one.low:>9.3g} to {one.high:<8.3g}" for one in cells)
            )
        return 0
    rope = catalogue_rope(options.construction, float(diameter), float(length), options.lay)
    print(f'[[rope]]\nconstruction = "{options.construction}"\nlay = "{options.lay}"')
    print(f"diameter = {rope.diameter!r}  # m\nlength = {rope.length!r}  # m")
    for name in CATALOGUE_PARAMETERS:
        unit = p[f"rope.{name}"].unit
        print(
            f"# {name} = {getattr(rope.middle, name):.6g}  # {unit}, the middle of the catalogue's "
            "range"
        )
    for name, datum in rope.data.items():
        print(
            f"# {name}: {datum.low:.4g} to {datum.high:.4g} {datum.unit}, {datum.status}: "
            f"{datum.source}"
        )
    return 0


def _noted(notes: Iterable[str]) -> list[str]:
    """Return the notes on a hoist, marked as such: they do not count as remarks."""
    return [f"note: {line}" for line in notes]


def _show(options: argparse.Namespace, everything: bool) -> int:
    """Print a hoist's check; with ``everything`` also its file, and what follows from it."""
    # slow imports
    from hoist_demo.design.hoist_checks import HoistCheck, checks
    from hoist_demo.report.hoist import check_in_words, consequences_text
    from hoist_demo.run.at_rest import remarks_at_rest, ropes_at_rest
    from hoist_demo.run.complete_file import as_file

    values = settings(options.set, parameters())
    case = case_with_values(find_case(options.hoist), values)
    if everything:
        print(as_file(case, options.hoist, values))
    bounds = checks(case)
    ropes = ropes_at_rest(case, options.hoist, values)
    if everything:
        text = consequences_text(case.hoist, bounds, ropes)
        print("\n".join(f"# {line}".rstrip() for line in text.splitlines()) + "\n")
    check = HoistCheck(tuple(bounds), (*case.remarks, *remarks_at_rest(ropes)))
    notes = [*check.notes, *case.notes]
    for line in (*check.problems, *_noted(notes)):
        print(f"balance-rope: {line}", file=sys.stderr)
    print(f"# {options.hoist}: {check_in_words(check)}")
    if check.problems and not everything:
        return 1
    return 0
