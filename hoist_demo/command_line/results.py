"""Where a command writes its results."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path


def results_folder(out: Path) -> Path:
    """``out``, made where it is not there; ValueError, before anything is computed, where it cannot be written to."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise ValueError(f"{out} cannot be written to ({error.strerror}): choose another --out") from error
    return out


def named(text: str) -> Path:
    """What --out names, for argparse: Path('') would be the folder one stands in."""
    if not text:
        raise argparse.ArgumentTypeError("'' names nothing: give a name, or leave --out away")
    return Path(text)
