"""Load history of each place in the rope: extremes, cycles, vibrations, and the time in a bend.

The places are the rope's stations, which stay in it while it flows through the loop. Cycles are
counted by the rainflow method (ASTM E1049); what a record leaves open counts one half, so that
trips to and fro add up to whole cycles. Counted are cycles of at least COUNTED of the largest range
of that quantity in the rope: less is ripple. These are ranges, not lives: how many of them a rope
bears is for its maker to say.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import rainflow

from hoist_demo.recording.spectra import spectra, strongest
from hoist_demo.recording.time_series import Array, Recording
from rope_model import SIGNALS

QUANTITIES = ("tension", "curvature", "torque")
#: Outputs of the rope from which the exposure follows.
STATION_SIGNALS = tuple(
    name for of in QUANTITIES for name in SIGNALS if name.startswith(f"station.{of}[")
)
COUNTED = 0.25  #: Part of the largest range from which on a cycle is counted [assumed].
BENT = 0.5  #: Part of the sharpest curvature from which on a place is in a bend [assumed].
#: Quantities with spectra: what bends as it passes the loop does so once.
VIBRATING = ("tension", "torque")
#: First and last power of ten at which bins of ranges begin, in N, 1/m and N m.
_DECADES = {"tension": (1, 5), "curvature": (-3, 0), "torque": (-1, 2)}


def _one_two_five(first: int, last: int) -> tuple[float, ...]:
    """Return 1, 2 and 5 times each power of ten."""
    edges: list[float] = []
    for power in range(first, last + 1):
        edges += [float(f"1e{power}"), float(f"2e{power}"), float(f"5e{power}")]
    return tuple(edges)


#: Where the bins of the ranges of each quantity begin; each ends at the next one, the last has no
#: end. The same for all ropes, so that what several records have adds up.
BINS = {name: _one_two_five(first, last) for name, (first, last) in _DECADES.items()}

#: How columns of several records come together that do not add up.
_JOINED = {"least": np.minimum} | dict.fromkeys(("largest", "range", "amplitude"), np.maximum)

#: Columns that are those of the record in which another one is least or largest.
_COMPANIONS = {
    "least_at": ("least", np.argmin),
    "largest_at": ("largest", np.argmax),
    "frequency": ("amplitude", np.argmax),
}


def bin_columns(name: str) -> list[str]:
    """Return the columns with the number of cycles in each bin of ranges."""
    return [f"{name}.from_{edge:g}" for edge in BINS[name]]


def _units() -> dict[str, str]:
    units = {"station": "1", "s": "m", "bent": "s"}
    for name in QUANTITIES:
        unit = SIGNALS[f"station.{name}[1]"].unit
        units |= dict.fromkeys((f"{name}.{key}" for key in ("least", "largest", "range")), unit)
        units |= {f"{name}.least_at": "s", f"{name}.largest_at": "s", f"{name}.cycles": "1"}
        units |= dict.fromkeys(bin_columns(name), "1")
        if name in VIBRATING:
            units |= {f"{name}.frequency": "Hz", f"{name}.amplitude": unit}
    return units


UNITS = _units()  #: Unit of each column of the table.
_PLACES = ("station", "s")


def exposure(recording: Recording, parameters: Mapping[str, Any]) -> Recording | None:
    """Return a row per station from the left end on, at places by the rope's ``parameters``.

    None without stations.
    """
    rows = {name: at_stations(recording, name) for name in QUANTITIES}
    if any(values.size == 0 for values in rows.values()):
        return None
    count = rows["tension"].shape[1]
    first = float(parameters["station.first"])
    last = float(parameters["station.last"])
    length = float(parameters["rope.length"])
    columns = {
        "station": np.arange(1.0, count + 1.0),
        "s": length * np.linspace(first, last, count),
    }
    for name, values in rows.items():
        columns |= _extremes(name, recording.time, values) | _counted(name, values)
        if name in VIBRATING:
            frequency, amplitude = strongest(spectra(recording.time, values))
            columns |= {f"{name}.frequency": frequency, f"{name}.amplitude": amplitude}
    bent = rows["curvature"][:-1] > BENT * np.max(rows["curvature"])
    columns["bent"] = np.sum(bent * np.diff(recording.time)[:, None], axis=0)
    return Recording(columns, UNITS)


def spectra_table(recording: Recording) -> Recording:
    """Return the amplitudes over frequency at each station, ``tension[1]`` and so on."""
    columns: dict[str, Array] = {}
    units = {"frequency": "Hz"}
    for name in VIBRATING:
        of_stations = spectra(recording.time, at_stations(recording, name))
        amplitudes = {
            f"{name}[{k + 1}]": column for k, column in enumerate(of_stations.amplitude.T)
        }
        columns |= {"frequency": of_stations.frequency} | amplitudes
        units |= dict.fromkeys(amplitudes, UNITS[f"{name}.amplitude"])
    return Recording(columns, units)


def joined_exposure(parts: Sequence[Recording]) -> Recording:
    """Join the records of the same stations, one after the other: cycles and times add up."""
    columns = {name: _joint(parts, name) for name in parts[0].signals if name not in _PLACES}
    return Recording({name: parts[0][name] for name in _PLACES} | columns, parts[0].units)


def _joint(parts: Sequence[Recording], name: str) -> Array:
    quantity, _, key = name.rpartition(".")
    rows = np.array([part[name] for part in parts])
    if key not in _COMPANIONS:
        return np.asarray(_JOINED.get(key, np.add).reduce(rows))
    leading, choose = _COMPANIONS[key]
    chosen = choose([part[f"{quantity}.{leading}"] for part in parts], axis=0)
    return np.asarray(np.take_along_axis(rows, chosen[None], axis=0)[0])


def flatten(exposed: Recording) -> dict[str, float]:
    """Return the table as one row: ``station.bent[1]`` and so on."""
    row: dict[str, float] = {}
    for name, column in exposed.signals.items():
        for station, value in enumerate(column, 1):
            row[f"station.{name}[{station}]"] = float(value)
    return row


def gather(row: Mapping[str, float]) -> Recording:
    """Return the table that ``flatten`` was given."""
    columns: dict[str, list[float]] = {name: [] for name in UNITS}
    for key, value in row.items():
        if key.startswith("station."):
            columns[key.removeprefix("station.").rpartition("[")[0]].append(value)
    return Recording({name: np.array(column) for name, column in columns.items()}, UNITS)


def at_stations(recording: Recording, name: str) -> Array:
    """Return one of QUANTITIES, shape (rows, stations); empty if it was not recorded."""
    columns = [
        values for key, values in recording.signals.items() if key.startswith(f"station.{name}[")
    ]
    return np.array(columns, dtype=np.float64).T


def _extremes(name: str, time: Array, values: Array) -> dict[str, Array]:
    return {
        f"{name}.least": values.min(axis=0),
        f"{name}.least_at": time[values.argmin(axis=0)],
        f"{name}.largest": values.max(axis=0),
        f"{name}.largest_at": time[values.argmax(axis=0)],
    }


def _counted(name: str, values: Array) -> dict[str, Array]:
    """Return the largest range, the counted cycles, and cycles by range at each station.

    The record ``values`` has the shape (rows, stations).
    """
    keys = [f"{name}.range", f"{name}.cycles", *bin_columns(name)]
    if not np.isfinite(values).all():
        return dict.fromkeys(keys, np.full(values.shape[1], np.nan))
    cycles = [_cycles(column) for column in values.T]
    ranges = np.array([max(station.ranges, default=0.0) for station in cycles])
    threshold = COUNTED * float(np.max(ranges))
    counted = np.array([station.number_above(threshold) for station in cycles])
    edges = (*BINS[name], np.inf)
    binned = [np.histogram(station.ranges, edges, weights=station.counts)[0] for station in cycles]
    return dict(zip(keys, (ranges, counted, *np.transpose(binned)), strict=True))


class _Cycles(NamedTuple):
    """Cycles of a quantity at one station."""

    ranges: list[float]
    counts: list[float]  # 1, or 0.5 for a half cycle

    def number_above(self, threshold: float) -> float:
        """Return the number of cycles of at least this range; 0 if it is 0."""
        pairs = zip(self.ranges, self.counts, strict=True)
        return sum(count for size, count in pairs if size >= threshold > 0.0)


def _cycles(column: Array) -> _Cycles:
    cycles = _Cycles([], [])
    for size, _, count, _, _ in rainflow.extract_cycles(column):
        cycles.ranges.append(size)
        cycles.counts.append(count)
    return cycles
