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
    own = _own(recording, name)
    if not name or "loop.y" not in own:
        return own
    hangs = np.isfinite(own["loop.y"])
    return replace(own, signals={key: values[hangs] for key, values in own.signals.items()})


def as_only_rope(recording: Recording, name: str) -> Recording:
    """Return the record as if the hoist had this rope alone.

    The rope's signals stand under their plain names beside the hoist's.
    """
    own = _own(recording, name)
    return replace(
        recording,
        signals={**recording.signals, **own.signals},
        units={**recording.units, **own.units},
    )


def computed(recording: Recording, torque_free: Mapping[str, bool]) -> Recording:
    """Return the record with NaN for what was not computed or is absent, and for its sums.

    `torque_free` by rope.
    """
    signals = dict(recording.signals)
    for name, free in torque_free.items():
        before = _own(recording, name)
        after = without_absent(mask_neglected(before, free))
        if not name:
            return after
        for key, values in after.signals.items():
            if key != TIME:
                signals[f"{name}.{key}"] = values
            if key != TIME and key in signals:
                signals[key] = np.where(
                    np.isnan(values) & np.isfinite(before[key]), np.nan, signals[key]
                )
    return replace(recording, signals=signals)


def _own(recording: Recording, name: str) -> Recording:
    if not name:
        return recording
    own = {
        key.removeprefix(f"{name}."): key for key in recording.signals if key.startswith(f"{name}.")
    }
    units = {key: recording.units.get(whole, "") for key, whole in own.items()}
    return Recording(
        {TIME: recording.time, **{key: recording[whole] for key, whole in own.items()}}, units
    )
