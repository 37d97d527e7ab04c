"""Remarks of the verdict: what the run warns of, with cures."""

from collections.abc import Sequence

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Hoist
from hoist_demo.recording.fidelity import remark
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.rope_record import RopeRecord, rope_text, swinging
from hoist_demo.run.slip import slip_warnings

#: Part of its largest swing with which a loop counts as still swinging.
STILL_SWINGING = 0.5


def run_remarks(
    result: Result, hoist: Hoist, ropes: Sequence[RopeRecord], window: float
) -> list[str]:
    """List warnings on coupling, slip of the head ropes, the ropes' fidelity and breaks."""
    texts = [result.warning, *slip_warnings(result, hoist)]
    if limited := result.recording.seconds("drive.torque_limited"):
        cure = "raise hoist.torque_limit and power_limit, or accelerate and stop more gently"
        texts.append(f"the motor was at its limit for {limited:.2f} s: {cure}")
    for rope in ropes:
        name = rope.data.name
        texts.append(remark(rope.recording).replace("the rope", rope_text(name), 1))
        whole = len(rope.recording.time) == len(result.recording.time)
        if rope.data.breaks is not None and result.completed and whole:
            breaks_at, _ = rope.data.breaks
            texts.append(
                f"rope {name} was to break at breaks_at = {breaks_at:g} s, and did not: the run "
                f"ended at {rope.recording.time[-1]:.4g} s; break it earlier"
            )
    if result.completed and len(ropes) > 1:
        texts.append(_still_swinging(swinging(ropes), window))
    return [text for text in texts if text]


def _still_swinging(recordings: Sequence[Recording], window: float) -> str:
    """Return a remark where neighbours end with more than half of their swing: they may yet strike.

    "" for none.
    """
    for recording in recordings:
        time = recording.time
        sideways = np.abs(recording["loop.sideways"])
        last = np.nanmax(sideways[time >= time[-1] - window])
        if last > STILL_SWINGING * np.nanmax(sideways):
            return (
                f"the loops still swing by {last:.2g} m where the record ends, and may strike each "
                "other later: wind on with a longer winding.settle"
            )
    return ""
