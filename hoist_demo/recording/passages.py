"""What the rope struck or passed through: a run in which it passed shows no real rope after that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hoist_demo.recording.time_series import Recording
from rope_model import BODIES as BODIES
from rope_model import FAR as FAR

PASSAGE_SIGNALS = frozenset(
    {"loop.crossings", "loop.crossed_at", "loop.crossed_y"}
    | {f"nearest.{name}.{key}" for name in BODIES for key in ("clearance", "touched_at", "y")}
    | {f"contact.{name}" for name in BODIES}
)
"""Outputs of the rope that tell it."""


def passages(recording: Recording) -> str:
    """What the rope has struck or passed through by the end of the record, with times and places; "" for nothing."""
    held = any(f"contact.{name}" in recording and bool(np.any(recording[f"contact.{name}"] > 0)) for name in BODIES)
    told = [
        f"{words} (from t = {_last(recording, f'nearest.{name}.touched_at'):.4g} s on, deepest at y = "
        f"{_last(recording, f'nearest.{name}.y'):.4g} m)"
        for name, words in BODIES.items()
        if _last(recording, f"nearest.{name}.clearance", 1.0) <= 0.0
    ]
    struck = [f"struck {' and '.join(told)}"] if told and held else []
    told = [] if held else told
    if _last(recording, "loop.crossings") > 0.0:
        told.append(
            f"its other leg or what hangs above that (t = {_last(recording, 'loop.crossed_at'):.4g} s, around y = "
            f"{_last(recording, 'loop.crossed_y'):.4g} m)"
        )
    passed = [f"passed through {' and '.join(told)}"] if told else []
    return f"the rope {' and '.join(struck + passed)}" if struck or passed else ""


def without_absent(recording: Recording) -> Recording:
    """The recording with NaN for the clearances from bodies that are not there."""
    signals = dict(recording.signals)
    for kind in BODIES:
        names = [n for n in signals if n == f"clearance.{kind}" or n.startswith(f"nearest.{kind}.")]
        if any(bool(np.all(signals[n] == FAR)) for n in names):
            signals |= {n: np.full_like(signals[n], np.nan) for n in names}
    return replace(recording, signals=signals)


def outcome_of(completed: bool, passed: str) -> str:
    """How a run ended, in words."""
    return ("completed" if completed else "stopped") + (f", but {passed}" if passed else "")


def _last(recording: Recording, name: str, absent: float = 0.0) -> float:
    return float(recording[name][-1]) if name in recording else absent
