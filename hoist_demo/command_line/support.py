"""Folders of results, and interrupts while a command computes or writes."""

import argparse
import io
import os
import signal
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

#: Exit code of every command that an interrupt (Ctrl-C) has stopped: 128 + SIGINT.
INTERRUPTED = 130
#: Result of --check, of every command that has it.
CHECKED = "the file can be read, and its values keep their bounds"
#: Behind CHECKED where a hoist is wound.
HOIST_UNCHECKED = "`balance-rope check` judges the hoist"
RunCommand = Callable[[argparse.Namespace], int]


def describe(
    command: argparse.ArgumentParser, run: RunCommand, description: str, epilog: str
) -> None:
    """Describe a command as it stands here, line by line; its options hold the function to run."""
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.description = description
    command.epilog = epilog
    command.set_defaults(run=run)


def add_results(command: argparse.ArgumentParser, name: str) -> None:
    """Add --out and --check to a command that reads a file."""
    command.add_argument(
        "--out",
        type=nonempty_path,
        metavar="DIR",
        help=f"results (out/{name}/ and the file's name)",
    )
    text = "check the file and its values, compute nothing; `balance-rope check` judges a hoist"
    command.add_argument("--check", action="store_true", help=text)


def results_folder(out: Path) -> Path:
    """Make the folder ``out`` and return it; ValueError as by ``writable``."""
    writable(out).mkdir(parents=True, exist_ok=True)
    return out


def writable(out: Path) -> Path:
    """Return ``out``.

    ValueError, before anything is computed, if it cannot be made or written to.
    """
    try:
        # a broken link counts as existing: no folder can be made of it
        there = next(
            path for path in (out, *out.absolute().parents) if path.exists() or path.is_symlink()
        )
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise ValueError(
            f"{out} cannot be written to ({error.strerror}): choose another --out"
        ) from error
    return out


def nonempty_path(text: str) -> Path:
    """Return the path that --out names, for argparse: Path('') would be the working directory."""
    if not text:
        raise argparse.ArgumentTypeError("'' names nothing: give a name, or leave --out away")
    return Path(text)


class _Output(io.FileIO):
    """Output that is dropped once its reader is gone, as in ``| head``.

    The command goes on to its exit code.
    """

    def write(self, text: Any) -> int:
        try:
            return super().write(text)
        except BrokenPipeError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            return super().write(text)


def outlive_readers() -> None:
    """Let a command go on when the reader of its output or of its messages closes the pipe."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        # a test's or a notebook's stream is its own affair, and a terminal is no pipe
        if stream is None or stream is not getattr(sys, f"__{name}__") or stream.isatty():
            continue
        raw = _Output(stream.fileno(), "wb", closefd=False)
        stream.flush()
        outlives = io.TextIOWrapper(
            io.BufferedWriter(raw),
            encoding=stream.encoding,
            errors=stream.errors,
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )
        setattr(sys, name, outlives)


def treat_hangup_as_interrupt() -> None:
    """Make a closed terminal an interrupt (Ctrl-C), unless it is ignored, as under nohup."""
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:
        signal.signal(signal.SIGHUP, _interrupt)


def _interrupt(*_: object) -> None:
    silence()
    signal.raise_signal(signal.SIGINT)


def silence() -> None:
    """Let what is printed to the terminal go nowhere: one that is gone takes no words."""
    for stream in (1, 2):
        if stat.S_ISCHR(os.fstat(stream).st_mode):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)


@contextmanager
def interruption(doing: str = "") -> Iterator[Callable[[], bool]]:
    """Yield a function that reports an interrupt heard meanwhile.

    It stops nothing, and prints ``doing``.

    A run that asks between two steps never stops within the rope, and what does not ask finishes.
    """
    heard = False

    def hear(*_: object) -> None:
        nonlocal heard
        heard = True
        if doing:
            print(f"\nbalance-rope: {doing}; a moment", file=sys.stderr)

    before = signal.signal(signal.SIGINT, hear)
    try:
        yield lambda: heard
    finally:
        signal.signal(signal.SIGINT, before)
