"""Signals that a fidelity leaves out.

The rope shows them as zero, which looks like a result; here they are NaN.

On a rope that carries no torque the zeros of what only torque makes are the complete model's own,
so they stay.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from itertools import groupby

import numpy as np

from hoist_demo.recording.time_series import Recording
from rope_model import CHOICES, FIDELITIES, Effect, neglected_effects, neglected_text

FIDELITY = "status.fidelity"  #: Signal with the code of the fidelity that runs.
#: Choices of the FMU's integer parameter ``model.fidelity``, in the order of its codes.
CODES = tuple(CHOICES["model.fidelity"])


def code_of(fidelity: str) -> float:
    """Return the code of a fidelity as a signal; NaN for "", of a rope that does not run."""
    if fidelity in CODES:
        return float(CODES.index(fidelity))
    return float("nan")


def mask_neglected(recording: Recording, torque_free: bool) -> Recording:
    """Return the recording with NaN for what its fidelity leaves out, row by row."""
    if FIDELITY not in recording:
        return recording
    signals = dict(recording.signals)
    for fidelity in FIDELITIES:
        rows = recording[FIDELITY] == code_of(fidelity)
        if not bool(rows.any()):
            continue
        effects = tuple(
            effect
            for effect in neglected_effects(fidelity)
            if not (effect.by_torque and torque_free)
        )
        for name in _names(effects, tuple(recording.signals)):
            signals[name] = np.where(rows, np.nan, signals[name])
    return replace(recording, signals=signals)


def fidelities_of(recording: Recording) -> list[str]:
    """Return the fidelities that ran, from the first row to the last."""
    if FIDELITY not in recording:
        return []
    codes = recording[FIDELITY]
    finite = codes[np.isfinite(codes)].astype(int)
    return [CODES[code] for code, _ in groupby(finite)]


def remark(recording: Recording) -> str:
    """Return the signals that ``mask_neglected`` left out of a recording, in words; "" for none."""
    for fidelity in FIDELITIES:
        names = tuple(recording.signals)
        effects = [
            effect
            for effect in neglected_effects(fidelity)
            if _lacks_values(recording, _names((effect,), names))
        ]
        if effects and fidelity in fidelities_of(recording):
            label = ", ".join(effect.words for effect in effects)
            return (
                f"the rope ran as its {fidelity} model{_when(fidelity, recording)}, which does not "
                f"compute {label}; none of that is shown. Set model.fidelity = 1 (torsional), or "
                "take the level standard"
            )
    return ""


def _lacks_values(recording: Recording, names: Iterable[str]) -> bool:
    """Return True if one of these signals is NaN somewhere."""
    return any(bool(np.isnan(recording[name]).any()) for name in names)


def drop_duplicates_of_remark(warnings: Iterable[str], recording: Recording) -> list[str]:
    """Return the warnings without those that repeat ``remark``, which adds the time."""
    kept = list(warnings)
    if remark(recording):
        for sentence in filter(None, map(neglected_text, FIDELITIES)):
            kept = [text for text in kept if sentence not in text]
    return kept


def _when(fidelity: str, recording: Recording) -> str:
    """Within which time, in words; "" where it ran throughout."""
    rows = recording[FIDELITY] == code_of(fidelity)
    if bool(rows.all()):
        return ""
    first, last = recording.time[np.flatnonzero(rows)[[0, -1]]].tolist()
    return f" between t = {first:.4g} and {last:.4g} s"


@lru_cache(maxsize=16)  # a study's recordings are alike
def _names(effects: tuple[Effect, ...], signals: tuple[str, ...]) -> tuple[str, ...]:
    affected: set[str] = set()
    for effect in effects:
        affected |= {name for name in signals if effect.has(name)}
    return tuple(name for name in signals if name in affected)
