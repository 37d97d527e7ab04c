"""Options that the measuring commands share."""

from __future__ import annotations

import argparse
from pathlib import Path

from evidence.rendering import DOCS
from hoist_demo.command_line.results import named, writable


def add_out(parser: argparse.ArgumentParser, default: Path | None = DOCS, words: str = "docs") -> None:
    """Add --out, the folder to write to; one that cannot be written to is refused before anything is measured."""
    parser.add_argument("--out", type=_folder, default=default, metavar="DIR", help=f"where to ({words})")


def _folder(text: str) -> Path:
    try:
        return writable(named(text))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
