"""Share of intervals from synthetic tracks that have the truth.

``python examples/track_coverage.py [SETS [SEED [KIND]]]``; KIND: labelled (default), unlabelled
points, or moving, where the file begins in mid-motion.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import camera_track as camera
import numpy as np

from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.fit import CONFIDENCE
from hoist_demo.calibration.identify import identify
from hoist_demo.files.reading import read

#: keys of [[measured]] and times at which the file begins
KINDS: dict[str, dict[str, Any]] = {
    "labelled": {},
    "unlabelled": {"places": "{}", "unlabelled": str([*camera.PLACES])},
    "moving": {"begin": 1.0, "settle": "0.6", "skip": "0.1"},
}


def intervals_of_sets(
    markers: np.ndarray, seeds: range, kind: str = "labelled"
) -> Iterator[tuple[list[bool], list[float]]]:
    """Yield for each set whether the intervals have the truth, and the errors over the values."""
    for seed in seeds:
        with TemporaryDirectory() as folder:
            path = camera.write(Path(folder), markers, seed, **KINDS[kind])
            found = identify(read(path, MeasurementFile))
        inside = []
        errors = []
        for name, true in camera.TRUTH.items():
            interval = found.data[name]
            inside.append(interval.low <= true <= interval.high)
            errors.append(found.value(name) / true - 1)
        yield inside, errors


def main(sets: str = "100", seed: str = "100", kind: str = "labelled") -> None:
    """Print after each set the share of intervals that have the truth, and RMS errors, so far."""
    camera.GRIPPER = 0.0  # intervals leave out the grippers' errors
    if kind == "unlabelled":
        camera.OFFSET = 0.0  # and points that are off the rope
    inside = []
    errors = []
    for found, off in intervals_of_sets(
        camera.marker_places(), range(int(seed), int(seed) + int(sets)), kind
    ):
        inside.append(found)
        errors.append(off)
        shares = ", ".join(f"{100 * x:.0f} %" for x in np.mean(inside, axis=0))
        rms = ", ".join(f"{100 * x:.2f} %" for x in np.sqrt(np.mean(np.square(errors), axis=0)))
        chance = 100 * math.sqrt(CONFIDENCE * (1 - CONFIDENCE) / np.size(inside))
        share = f"{100 * np.mean(inside):.1f} of {100 * CONFIDENCE:.0f} %"
        print(
            f"{len(inside)} sets: {share} (standard error {chance:.1f}), "
            f"of {', '.join(camera.TRUTH)} {shares}; errors {rms}",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
