"""The runs behind the published evaluation: some ten minutes."""

from __future__ import annotations

from collections.abc import Callable

from evidence.reproduction import costs, frequencies, release, windings
from evidence.tables import Tables

MEASURES: dict[str, Callable[[], Tables]] = {
    "frequencies": frequencies.measure,
    "windings": windings.measure,
    "costs": costs.measure,
    "release": release.measure,
}
