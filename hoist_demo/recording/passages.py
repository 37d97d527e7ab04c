"""Bodies that the rope struck or passed through: a run shows no real rope after it passed."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.recording.time_series import Recording
from rope_model import BODIES, FAR

_DISSIPATED = "energy.dissipated_contact"

#: Outputs of the rope from which ``passages`` follow.
PASSAGE_SIGNALS = frozenset(
    {
        "loop.crossings",
        "loop.crossed_at",
        "loop.crossed_y",
        "loop.overlap",
        "loop.touched_at",
        "loop.touched_y",
    }
    | {f"nearest.{name}.{key}" for name in BODIES for key in ("clearance", "touched_at", "y")}
    | {f"contact.{name}" for name in (*BODIES, "rope")}
    | {_DISSIPATED}
)

#: Word of ``passages`` for bodies that did not hold the rope: later results describe no real rope.
PASSED = "passed"


def passages(recording: Recording, rope: str = "the rope") -> str:
    """Return what ``rope`` has struck or passed through so far, with times and places.

    "" for nothing.
    """
    met = _met(recording)
    sentences = []
    if met.struck:
        sentences.append(f"struck {' and '.join(met.struck)}")
    if met.passed_into:
        sentences.append(f"passed into {' and '.join(met.passed_into)}")
    if _last(recording, "loop.crossings") > 0.0:
        t = _last(recording, "loop.crossed_at")
        y = _last(recording, "loop.crossed_y")
        sentences.append(
            "passed through its other leg or what hangs above that "
            f"(t = {t:.4g} s, around y = {y:.4g} m)"
        )
    if sentences:
        return f"{rope} {' and '.join(sentences)}"
    return ""


class _Met(NamedTuple):
    """Bodies and legs that a rope has met, each with time and place."""

    struck: list[str]  # those that held the rope by contact forces
    passed_into: list[str]  # those that did not


def _met(recording: Recording) -> _Met:
    """Return what the rope has met; a body holds it if the record has forces or losses of contact."""
    touched = _touched_bodies(recording)
    # contact for a moment between two rows leaves its dissipated energy
    dissipated = _DISSIPATED in recording and bool(np.any(_in_contact(recording, _DISSIPATED)))
    presses_itself = _pressed(recording, "rope")
    held = any(_pressed(recording, name) for name in BODIES)
    held |= dissipated and not presses_itself and bool(touched)
    presses_itself |= dissipated and not held
    met = _Met(struck=[], passed_into=[])
    if held:
        met.struck.extend(touched)
    else:
        met.passed_into.extend(touched)
    if _last(recording, "loop.overlap") > 0.0:
        legs = _deepest(recording, "its other leg", "loop.touched_at", "loop.touched_y")
        if presses_itself:
            met.struck.append(legs)
        else:
            met.passed_into.append(legs)
    elif presses_itself:
        signs = ["contact.rope"]
        if not held:
            signs.append(_DISSIPATED)
        met.struck.append(_first_contact(recording, "itself", signs))
    return met


def _touched_bodies(recording: Recording) -> list[str]:
    """Return the bodies that the rope has touched, each with time and place."""
    touched: list[str] = []
    for name, label in BODIES.items():
        if _last(recording, f"nearest.{name}.clearance", 1.0) <= 0.0:
            since = f"nearest.{name}.touched_at"
            touched.append(_deepest(recording, label, since, f"nearest.{name}.y"))
        elif _pressed(recording, name):
            touched.append(_first_contact(recording, label, [f"contact.{name}"]))
    return touched


def without_passages(warnings: Iterable[str]) -> list[str]:
    """Return the rope's warnings but those that ``passages`` repeats in full."""
    kept = list(warnings)
    for phrase in _PASSAGE_WARNINGS:
        kept = [text for text in kept if phrase not in text]
    return kept


#: Phrases in warnings that have no cure, which ``passages`` says, too.
_PASSAGE_WARNINGS = ("the rope has struck", "the rope has passed into")


def _deepest(recording: Recording, label: str, since: str, y: str) -> str:
    """Return ``label`` with the values of the signals ``since`` and ``y`` of a touched body."""
    return (
        f"{label} (from t = {_last(recording, since):.4g} s on, deepest at y = "
        f"{_last(recording, y):.4g} m)"
    )


def _first_contact(recording: Recording, label: str, names: Sequence[str]) -> str:
    """Return ``label`` with the time of the first row that shows contact in ``names``."""
    in_contact = [_in_contact(recording, name) for name in names if name in recording]
    first = np.argmax(np.any(in_contact, axis=0))
    return f"{label} (from t = {recording.time[first]:.4g} s on)"


def _in_contact(recording: Recording, name: str) -> NDArray[np.bool_]:
    """Return the mask (rows,) of contact, without what was dissipated before the record."""
    values = recording[name]
    if name == _DISSIPATED:
        return values > values[:1]
    return values > 0.0


def _pressed(recording: Recording, name: str) -> bool:
    return f"contact.{name}" in recording and bool(np.any(recording[f"contact.{name}"] > 0))


def without_absent(recording: Recording) -> Recording:
    """Return the recording with NaN for the clearances from bodies that are not there."""
    signals = dict(recording.signals)
    for kind in BODIES:
        names = [n for n in signals if n == f"clearance.{kind}" or n.startswith(f"nearest.{kind}.")]
        if any(bool(np.all((signals[n] == FAR) | np.isnan(signals[n]))) for n in names):
            signals |= {n: np.full_like(signals[n], np.nan) for n in names}
    return replace(recording, signals=signals)


def _last(recording: Recording, name: str, absent: float = 0.0) -> float:
    if name not in recording:
        return absent
    return float(recording[name][-1])
