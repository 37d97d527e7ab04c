"""What each place in the rope went through: ranges and cycles of tension, curvature and torque, and the time in a bend.

The places are the rope's stations, which stay in it while it flows through the loop. Cycles are counted by the rainflow
method (ASTM E1049); what a record leaves open counts one half, so that trips to and fro add up to whole cycles. Counted
are cycles of at least COUNTED of the largest range of that quantity in the rope: less is ripple.
These are ranges, not lives: how many of them a rope bears is for its maker to say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rainflow

from hoist_demo.recording.time_series import Array, Recording
from rope_model import SIGNALS

QUANTITIES = ("tension", "curvature", "torque")

STATION_SIGNALS = tuple(name for name in SIGNALS if name.startswith("station."))
"""Outputs of the rope that are read for it."""

COUNTED = 0.25
"""Part of the largest range from which on a cycle is counted [assumed]."""

BENT = 0.5
"""Part of the sharpest curvature from which on a place is in a bend [assumed]."""

_COLUMNS = {"least": np.minimum, "largest": np.maximum, "range": np.maximum, "cycles": np.add}
"""What is known of each quantity, and how that of several records comes together."""

UNITS = {"station": "1", "s": "m", "bent": "s"} | {
    f"{name}.{key}": "1" if key == "cycles" else SIGNALS[f"station.{name}[1]"].unit
    for name in QUANTITIES
    for key in _COLUMNS
}
"""Unit of each column of the table."""

_PLACES = ("station", "s")


def exposure(recording: Recording, parameters: Mapping[str, Any]) -> Recording | None:
    """One row per station, from the left end on; None where stations were not recorded.

    `parameters` of the rope by FMI name tell where the stations are. What the fidelity leaves out is NaN.
    """
    rows = {name: _at_stations(recording, name) for name in QUANTITIES}
    if any(values.size == 0 for values in rows.values()):
        return None
    count = rows["tension"].shape[1]
    first, last, length = (float(parameters[name]) for name in ("station.first", "station.last", "rope.length"))
    columns = {"station": np.arange(1.0, count + 1.0), "s": length * np.linspace(first, last, count)}
    for name, values in rows.items():
        found = dict(zip(("range", "cycles"), _counted(values), strict=True))
        columns |= {f"{name}.least": values.min(axis=0), f"{name}.largest": values.max(axis=0)}
        columns |= {f"{name}.{key}": column for key, column in found.items()}
    bent = rows["curvature"][:-1] > BENT * np.max(rows["curvature"])
    columns["bent"] = np.sum(bent * np.diff(recording.time)[:, None], axis=0)
    return Recording(columns, UNITS)


def together(parts: Sequence[Recording]) -> Recording:
    """What several records one after the other did to the same stations: cycles and times add up."""
    names = [name for name in parts[0].signals if name not in _PLACES]
    joint = {name: _COLUMNS.get(name.rpartition(".")[2], np.add) for name in names}
    columns = {name: join.reduce([part[name] for part in parts]) for name, join in joint.items()}
    return Recording({name: parts[0][name] for name in _PLACES} | columns, parts[0].units)


def spread(exposed: Recording) -> dict[str, float]:
    """The table as one row: `station.bent[1]` and so on."""
    return {
        f"station.{name}[{k + 1}]": float(value)
        for name, column in exposed.signals.items()
        for k, value in enumerate(column)
    }


def gather(row: Mapping[str, float]) -> Recording:
    """The table that `spread` was given."""
    columns: dict[str, list[float]] = {name: [] for name in UNITS}
    for key, value in row.items():
        if key.startswith("station."):
            columns[key.removeprefix("station.").rpartition("[")[0]].append(value)
    return Recording({name: np.array(column) for name, column in columns.items()}, UNITS)


def _at_stations(recording: Recording, name: str) -> Array:
    columns = [values for key, values in recording.signals.items() if key.startswith(f"station.{name}[")]
    return np.array(columns, dtype=np.float64).T


def _counted(values: Array) -> tuple[Array, Array]:
    """Largest range and number of counted cycles at each station, of a record (rows, stations)."""
    if not np.isfinite(values).all():
        nothing = np.full(values.shape[1], np.nan)
        return nothing, nothing
    cycles = [[(size, count) for size, _, count, _, _ in rainflow.extract_cycles(column)] for column in values.T]
    ranges = np.array([max((size for size, _ in found), default=0.0) for found in cycles])
    least = COUNTED * float(np.max(ranges))
    return ranges, np.array([sum(count for size, count in found if size >= least > 0.0) for found in cycles])
