"""Records of several balance ropes: signals of each begin with its name.

The only one of a hoist has none, "".
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hoist_demo.recording.fidelity import mask_neglected
from hoist_demo.recording.passages import without_absent
from hoist_demo.recording.time_series import TIME, Recording


def rope_signals(recording: Recording, name: str) -> Recording:
    """Return a rope's signals under their own names, until it breaks."""
    rope = _signals_of(recording, name)
    if not name or "loop.y" not in rope:
        return rope
    hangs = np.isfinite(rope["loop.y"])
    return replace(rope, signals={key: values[hangs] for key, values in rope.signals.items()})


def as_only_rope(recording: Recording, name: str) -> Recording:
    """Return the record as if the hoist had this rope alone.

    The rope's signals stand under their plain names beside the hoist's.
    """
    rope = _signals_of(recording, name)
    return replace(
        recording,
        signals={**recording.signals, **rope.signals},
        units={**recording.units, **rope.units},
    )


def computed(recording: Recording, torque_free: Mapping[str, bool]) -> Recording:
    """Return the record with NaN for what was not computed or is absent, and for its sums.

    ``torque_free`` by rope.
    """
    signals = dict(recording.signals)
    for name, free in torque_free.items():
        before = _signals_of(recording, name)
        after = without_absent(mask_neglected(before, free))
        if not name:
            return after
        for key, values in after.signals.items():
            if key == TIME:
                continue
            signals[f"{name}.{key}"] = values
            if key in signals:
                left_out = np.isnan(values) & np.isfinite(before[key])
                signals[key] = np.where(left_out, np.nan, signals[key])
    return replace(recording, signals=signals)


def _signals_of(recording: Recording, name: str) -> Recording:
    """Return a rope's signals under their own names; "" is the only rope."""
    if not name:
        return recording
    signals = {TIME: recording.time}
    units: dict[str, str] = {}
    for whole, values in recording.signals.items():
        if whole.startswith(f"{name}."):
            key = whole.removeprefix(f"{name}.")
            signals[key] = values
            units[key] = recording.units.get(whole, "")
    return Recording(signals, units)
