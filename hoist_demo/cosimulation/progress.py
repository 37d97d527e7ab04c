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
    """Yield a progress callback for ``Host.run``: a bar on stderr where that is a terminal."""
    with tqdm(total=100.0, bar_format=_LAYOUT, file=sys.stderr, leave=False, disable=None) as bar:

        def advance(fraction: float, t: float) -> bool:
            bar.set_description_str(f"t = {t:6.2f} s", refresh=False)
            bar.update(100.0 * fraction - bar.n)
            return True

        yield advance


@contextmanager
def warnings_of(logger: str) -> Iterator[list[str]]:
    """Yield a list that holds, afterwards, each warning of a logger and those below it once.

    No other handler gets them.
    """
    warnings: list[str] = []
    log = logging.getLogger(logger)
    collector = BufferingHandler(sys.maxsize)
    collector.setLevel(logging.WARNING)
    handlers = log.handlers
    propagates = log.propagate
    log.handlers = [collector]
    log.propagate = False
    try:
        yield warnings
    finally:
        log.handlers = handlers
        log.propagate = propagates
        warnings += dict.fromkeys(record.getMessage() for record in collector.buffer)
