"""Messages of a running winding: a bar on stderr on request, and its warnings for a collector."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

_LAYOUT = "winding {percentage:3.0f}% |{bar}| {desc} [{elapsed} < {remaining}]"


@contextmanager
def progress_bar() -> Iterator[Callable[[float, float], bool]]:
    """Yield a progress callback for `Host.run`: a bar on stderr where that is a terminal."""
    with tqdm(total=100.0, bar_format=_LAYOUT, file=sys.stderr, leave=False, disable=None) as bar:

        def advance(fraction: float, t: float) -> bool:
            bar.set_description_str(f"t = {t:6.2f} s", refresh=False)
            bar.update(100.0 * fraction - bar.n)
            return True

        yield advance


@contextmanager
def warnings_of(logger: str) -> Iterator[list[str]]:
    """The warnings that a logger and those below it get meanwhile, in a list and nowhere else."""
    heard: list[str] = []
    log = logging.getLogger(logger)
    handlers, propagates = log.handlers, log.propagate
    log.handlers, log.propagate = [_Ear(heard)], False
    try:
        yield heard
    finally:
        log.handlers, log.propagate = handlers, propagates


class _Ear(logging.Handler):
    """Keeps each text once."""

    def __init__(self, heard: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._heard = heard

    def emit(self, record: logging.LogRecord) -> None:
        if (text := record.getMessage()) not in self._heard:
            self._heard.append(text)
