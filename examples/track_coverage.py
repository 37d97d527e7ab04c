"""How often intervals from synthetic tracks have the truth: `python examples/track_coverage.py [SETS [SEED [KIND]]]`.

KIND: labelled (default), unlabelled points, or moving, where the file begins in mid-motion.
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


def tried(
    markers: np.ndarray, seeds: range, kind: str = "labelled"
) -> Iterator[tuple[list[bool], list[float]]]:
    """Yield for each set whether the intervals have the truth, and the errors over the values."""
    for seed in seeds:
        with TemporaryDirectory() as folder:
            found = identify(
                read(camera.write(Path(folder), markers, seed, **KINDS[kind]), MeasurementFile)
            )
        told = [(found.data[name], found.value(name), true) for name, true in camera.TRUTH.items()]
        yield (
            [one.low <= true <= one.high for one, _, true in told],
            [value / true - 1 for _, value, true in told],
        )


def main(sets: str = "100", seed: str = "100", kind: str = "labelled") -> None:
    """Print after each set the share of intervals so far that have the truth, and the errors' root mean squares."""
    camera.GRIPPER = 0.0  # intervals know nothing of the grippers' errors
    if kind == "unlabelled":
        camera.OFFSET = 0.0  # nor of points that are off the rope
    inside, errors = [], []
    for found, off in tried(camera.seen(), range(int(seed), int(seed) + int(sets)), kind):
        inside.append(found)
        errors.append(off)
        shares = ", ".join(f"{100 * x:.0f} %" for x in np.mean(inside, axis=0))
        rms = ", ".join(f"{100 * x:.2f} %" for x in np.sqrt(np.mean(np.square(errors), axis=0)))
        chance = 100 * math.sqrt(CONFIDENCE * (1 - CONFIDENCE) / np.size(inside))
        share = (
            f"{100 * np.mean(inside):.1f} of {100 * CONFIDENCE:.0f} % (standard error {chance:.1f})"
        )
        print(
            f"{len(inside)} sets: {share}, of {', '.join(camera.TRUTH)} {shares}; errors {rms}",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
