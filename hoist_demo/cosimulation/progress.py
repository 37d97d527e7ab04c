"""Messages of a running winding: a bar on stderr on request, and its warnings for a collector."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from logging.handlers import BufferingHandler

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
    """Yield a list that has, afterwards, each warning once that a logger and those below it got; nobody else hears."""
    heard: list[str] = []
    log, ear = logging.getLogger(logger), BufferingHandler(sys.maxsize)
    ear.setLevel(logging.WARNING)
    handlers, propagates = log.handlers, log.propagate
    log.handlers, log.propagate = [ear], False
    try:
        yield heard
    finally:
        log.handlers, log.propagate = handlers, propagates
        heard += dict.fromkeys(record.getMessage() for record in ear.buffer)
