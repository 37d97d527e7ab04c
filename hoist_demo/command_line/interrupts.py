"""An interrupt while a command computes or writes."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def interruption(doing: str = "") -> Iterator[Callable[[], bool]]:
    """Yield a function that reports an interrupt heard meanwhile; it stops nothing, and prints ``doing``.

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
