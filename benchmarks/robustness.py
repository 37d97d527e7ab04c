"""Every combination of stiffness, spacing, speed and kind of trip on the 120 m scene: ``make robustness``.

Prints a line per run and the count of valid and failed ones; a failed run shows its cause.  Takes minutes.
"""

from __future__ import annotations

import argparse
import itertools
from collections import Counter
from dataclasses import replace

from hoist_demo.control.trajectory import Trajectory, emergency_stop, s_curve
from hoist_demo.parameters import Winding
from rope_model.parameters import Layout, rope_120

from .kinematic import wind

TRAVEL = 90.0
#: a speed that 90 m do not allow at the usual acceleration gets a larger one
LIMITS = {4.0: (0.75, 0.5), 8.0: (0.75, 0.5), 16.0: (4.0, 8.0)}


class Reversal:
    """Half the trip, and straight back."""

    def __init__(self, half: Trajectory, distance: float) -> None:
        self.half, self.distance, self.duration = half, distance, 2 * half.duration

    def at(self, t: float) -> object:
        if t < self.half.duration:
            return self.half.at(t)
        p = self.half.at(t - self.half.duration)
        return p._replace(position=self.distance - p.position, speed=-p.speed, acceleration=-p.acceleration)


def trip(kind: str, speed: float) -> object:
    """The reference of one kind of trip."""
    acceleration, jerk = LIMITS[speed]
    data = Winding(travel=TRAVEL, speed=speed, acceleration=acceleration, jerk=jerk)
    full = s_curve(data)
    if kind == "reversal":
        half = replace(data, travel=0.5 * TRAVEL)
        return Reversal(s_curve(half), 0.5 * TRAVEL)
    if kind == "emergency stop":
        return emergency_stop(full, 0.4 * full.duration, 5.0, 50.0)
    return full


def main() -> None:
    """Run them all."""
    argparse.ArgumentParser("python -m benchmarks.robustness", description=__doc__).parse_args()
    counts: Counter[tuple[str, bool]] = Counter()
    cases = itertools.product((50.0, 300.0, 1000.0), (1.5, 2.0, 3.0), (4.0, 8.0, 16.0))
    for (EI, spacing, speed), kind in itertools.product(cases, ("full", "reversal", "emergency stop")):
        scene = rope_120().scene
        scene = scene.with_(rope=replace(scene.rope, EI=EI), layout=Layout(spacing=spacing))
        run = wind(scene, trip(kind, speed), TRAVEL)  # type: ignore[arg-type]
        counts[kind, run.status.valid] += 1
        work, energy_balance = run.rope.state.counts, run.rope.state.energy_balance
        print(
            f"EI {EI:6.0f}  spacing {spacing:3.1f} m  {speed:4.0f} m/s  {kind:<15} "
            f"{'valid' if run.status.valid else run.status.message}  {work.steps} steps, {work.rejections} rejected, "
            f"energy unexplained {energy_balance.residual:7.2f} J",
            flush=True,
        )
    for (kind, valid), number in sorted(counts.items()):
        print(f"{kind}: {number} {'valid' if valid else 'failed with a named cause'}")


if __name__ == "__main__":
    main()
