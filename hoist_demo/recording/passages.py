"""Bodies that the rope struck or passed through: a run shows no real rope after it passed."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.recording.time_series import Recording
from rope_model import BODIES, FAR

_DISSIPATED = "energy.dissipated_contact"

#: Outputs of the rope from which `passages` follow.
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
    met = [
        _met(recording, label, f"nearest.{name}.touched_at", f"nearest.{name}.y")
        if _last(recording, f"nearest.{name}.clearance", 1.0) <= 0.0
        else _briefly(recording, label, [f"contact.{name}"])
        for name, label in BODIES.items()
        if _last(recording, f"nearest.{name}.clearance", 1.0) <= 0.0 or _pressed(recording, name)
    ]
    # contact for a moment between two rows leaves its dissipated energy
    itself = _pressed(recording, "rope")
    dissipated = _DISSIPATED in recording and bool(np.any(_shows(recording, _DISSIPATED)))
    held = any(_pressed(recording, name) for name in BODIES) or (
        dissipated and not itself and bool(met)
    )
    itself |= dissipated and not held
    struck, into, through = (met, [], []) if held else ([], met, [])
    if _last(recording, "loop.crossings") > 0.0:
        through.append(
            "its other leg or what hangs above that (t = "
            f"{_last(recording, 'loop.crossed_at'):.4g} s, around y = "
            f"{_last(recording, 'loop.crossed_y'):.4g} m)"
        )
    if _last(recording, "loop.overlap") > 0.0:
        legs = _met(recording, "its other leg", "loop.touched_at", "loop.touched_y")
        (struck if itself else into).append(legs)
    elif itself:
        struck.append(
            _briefly(recording, "itself", ["contact.rope", *([] if held else [_DISSIPATED])])
        )
    sentences = [f"struck {' and '.join(struck)}"] if struck else []
    sentences += [f"passed into {' and '.join(into)}"] if into else []
    sentences += [f"passed through {' and '.join(through)}"] if through else []
    return f"{rope} {' and '.join(sentences)}" if sentences else ""


def without_passages(warnings: Iterable[str]) -> list[str]:
    """Return the rope's warnings but those of which `passages` tells all."""
    return [text for text in warnings if not any(phrase in text for phrase in _PASSAGE_WARNINGS)]


#: Phrases in warnings that have no cure, which `passages` says, too.
_PASSAGE_WARNINGS = ("the rope has struck", "the rope has passed into")


def _met(recording: Recording, label: str, since: str, y: str) -> str:
    return (
        f"{label} (from t = {_last(recording, since):.4g} s on, deepest at y = "
        f"{_last(recording, y):.4g} m)"
    )


def _briefly(recording: Recording, label: str, names: Sequence[str]) -> str:
    """Return ``label`` with the time of the first row that shows contact in ``names``."""
    shown = [_shows(recording, name) for name in names if name in recording]
    return f"{label} (from t = {recording.time[np.argmax(np.any(shown, axis=0))]:.4g} s on)"


def _shows(recording: Recording, name: str) -> NDArray[np.bool_]:
    """Return the mask (rows,) of contact, without what was dissipated before the record."""
    values = recording[name]
    return values > (values[:1] if name == _DISSIPATED else 0.0)


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
    return float(recording[name][-1]) if name in recording else absent
