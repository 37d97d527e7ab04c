"""A conveyance that jams: when would a guard of the balance rope's loop see it, and when does the head ropes' slack?

A guard is set as low as it may be: to the most that its quantity reaches in the same trip without the jam, wound to its
end or stopped where the jam stopped it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.recording.guards import AFTER
from hoist_demo.recording.jams import jams
from hoist_demo.recording.time_series import Recording

CASE = "jammed-conveyance"
SIGNALS = {
    "rise": ("loop.rise",),
    "window": ("loop.sideways",),
    "turns": ("loop.turns",),
    "torque": ("left.swivel.torque", "right.swivel.torque"),
}
"""What the guards that need no body of the shaft watch."""
SLACK = "slack head ropes"
COLUMNS = ("guard", "set to", "trips after the catch [s]", "peak in 10 s after it")


def wind_jam() -> list[tuple[str, float, float, float]]:
    """Rows of COLUMNS; NaN for a guard that does not trip within 10 s, and for what the slack is not set to."""
    case = find_case(CASE)
    free = replace(case.hoist, jam_right=None)
    run, stopped_at = _wind(case.hoist, case.winding)
    healthy = [_wind(free, replace(case.winding, emergency_at=at))[0] for at in (None, stopped_at)]
    (jam,) = jams(run)
    after = (run.time >= jam.t) & (run.time <= jam.t + AFTER)
    found = []
    for name, signals in SIGNALS.items():
        threshold = max(float(np.max(_watched(recording, signals))) for recording in healthy)
        values = _watched(run, signals)[after]
        found.append((name, threshold, _first(values > threshold), float(np.max(values))))
    pulls = np.minimum(run["drive.pull_left"], run["drive.pull_right"])[after]
    assert case.hoist.slack_tension is not None
    return [*found, (SLACK, np.nan, _first(pulls < case.hoist.slack_tension), np.nan)]


def _wind(hoist: Hoist, winding: Winding) -> tuple[Recording, float | None]:
    """The run, and when the safety circuit or the winding stopped it [s]."""
    case, rope = find_case(CASE), rope_in_process(CASE)
    result = Host(rope, hoist, winding, Coupling(), case.gains).run()
    assert result.completed, result.cause
    return result.recording, result.winding.emergency_at


def _watched(recording: Recording, signals: tuple[str, ...]) -> NDArray[np.float64]:
    largest: NDArray[np.float64] = np.max([np.abs(recording[name]) for name in signals], axis=0)
    return largest


def _first(beyond: NDArray[np.bool_]) -> float:
    """Time of the first sample that is beyond [s], counted from the first one."""
    return float(np.argmax(beyond)) * Coupling().step if bool(beyond.any()) else np.nan
