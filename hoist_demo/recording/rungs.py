"""What a rung of the rope's model leaves out. The rope shows it as zero, which looks like a result: here it is NaN.

A rung without torsion has no torque, no twist and no turning swivel, one in the plane nothing out of it, and the rigid
one no bending. On a rope that carries no torque the zeros are the complete model's own, so they stay.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.recording.time_series import Array, Recording

RUNG = "status.rung"
"""Signal with the code of the rung that runs."""

CODES = ("auto", "torsional", "spatial", "planar", "rigid")
"""Choices of the FMU's integer parameter `model.rung`, in the order of its codes."""


def _ends(*names: str) -> frozenset[str]:
    return frozenset(f"{end}.{name}" for end in ("left", "right") for name in names)


_SWIVELS = _ends(*(f"swivel.{name}" for name in ("angle", "rate", "torque", "slipping")))
_TORSION = _ends("my", "twist") | _SWIVELS | {"loop.twist", "stress.torsion_max"}
_OUT_OF_PLANE = _ends("fz", "mx") | {"loop.z", "loop.yaw"}
_BENDING = _ends("fx", "mz")

_ALONG = "shape.torsion["
"""Beginning of the names of the torsional stress along the rope."""

_LEFT_OUT: Mapping[str, frozenset[str]] = {
    "spatial": _TORSION,
    "planar": _TORSION | _OUT_OF_PLANE,
    "rigid": _TORSION | _OUT_OF_PLANE | _BENDING,
}
_WORDS = {
    "spatial": "torque, twist, turning swivels and torsional stress",
    "planar": "yaw, torque, twist, turning swivels, torsional stress and all else out of the plane",
    "rigid": "yaw, torque, twist, turning swivels, torsional stress, side forces and all else out of the plane",
}


def code_of(rung: str) -> float:
    """Code of a rung as a signal; NaN for "", of a rope that does not run."""
    return float(CODES.index(rung)) if rung in CODES else float("nan")


def computed(recording: Recording, torque_free: bool) -> Recording:
    """The recording with NaN for what its rung leaves out, row by row."""
    if RUNG not in recording:
        return recording
    signals = dict(recording.signals)
    for rung, names in _LEFT_OUT.items():
        rows = recording[RUNG] == code_of(rung)
        names = (_BENDING if rung == "rigid" else frozenset()) if torque_free else names
        if "stress.torsion_max" in names:
            names |= {name for name in signals if name.startswith(_ALONG)}
        for name in names & signals.keys() if bool(rows.any()) else ():
            signals[name] = _without(signals[name], rows)
    return replace(recording, signals=signals)


def rungs_of(recording: Recording) -> list[str]:
    """The rungs that ran, from the first row to the last."""
    codes = recording[RUNG] if RUNG in recording else np.array([])
    known = codes[np.isfinite(codes)].astype(int)
    return [CODES[code] for k, code in enumerate(known) if k == 0 or code != known[k - 1]]


def remark(recording: Recording) -> str:
    """What a recording from `computed` does not show because of its rung; "" when nothing is missing."""
    for rung in ("rigid", "planar", "spatial"):
        names = _LEFT_OUT[rung] & recording.signals.keys()
        if rung in rungs_of(recording) and any(bool(np.isnan(recording[name]).any()) for name in names):
            return (
                f"the rope ran on the {rung} rung of its model, which does not compute {_WORDS[rung]}; none of that is "
                "shown. Set model.rung = 1 (torsional), or export at the level standard"
            )
    return ""


def _without(values: Array, rows: NDArray[np.bool_]) -> Array:
    kept = values.copy()
    kept[rows] = np.nan
    return kept
