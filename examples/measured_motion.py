"""Motions of cables that somebody has measured, in the layout of DEFORM (arXiv 2406.05931): fitted, and judged.

`python examples/measured_motion.py FOLDER CABLE.toml`. The user has fetched FOLDER himself. FOLDER/train and
FOLDER/eval have pickled lists: frames at 100 Hz of three axes, the last up, of vertices (m). Grippers hold the
outermost two on either side. The one [[measured]] of CABLE.toml is as that of docs/measurements/swing.toml, its places
those of v2, v3 and so on.
"""

import pickle
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

from hoist_demo.calibration.definition import Measured
from hoist_demo.calibration.identify import identify
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.reading import read

RATE, FITTED, JUDGED = 100.0, 5, 10  #: Hz, and runs


class _Lists(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"asks for {module}.{name}: give pickled lists of numbers alone")


def track(path: Path) -> tuple[str, np.ndarray]:
    """Return the header and columns of a run as a track; the rope leaves its grippers at the last vertex but one."""
    with path.open("rb") as file:
        frames = np.array(_Lists(file).load(), dtype=float)
    if frames.ndim != 3 or frames.shape[1] != 3 or frames.shape[2] < 5:
        raise ValueError(f"{path} has the shape {frames.shape}: it must be frames x 3 axes x 5 or more vertices")
    v = frames.transpose(2, 0, 1)
    named = {"left.": v[1], "left.d": v[1] - v[0], "right.": v[-2], "right.d": v[-2] - v[-1]}
    named |= {f"v{k}.": v[k] for k in range(2, len(v) - 2)}
    names = ["t", *(f"{name}{axis}" for name in named for axis in "xyz")]
    return ",".join(names), np.column_stack((np.arange(len(frames)) / RATE, *named.values()))


def tracks(folder: Path, cable: Path, out: Path, most: int) -> Measured:
    """Write ``most`` runs of a folder as tracks with a file that names them, and read that."""
    text, _, asked = cable.read_text(encoding="utf-8").partition("[[measured]]")
    for path in sorted(folder.glob("*.pkl"))[:most]:
        header, columns = track(path)
        np.savetxt(out / f"{folder.name}-{path.stem}.csv", columns, "%.6g", ",", header=header, comments="")
        text += "[[measured]]" + re.sub('file = ".*"', f'file = "{folder.name}-{path.stem}.csv"', asked) + "\n"
    (out / f"{folder.name}.toml").write_text(text, encoding="utf-8")
    return read(out / f"{folder.name}.toml", Measured)


def main(folder: str, cable: str, out: str = "out/motion") -> None:
    """Fit, and print what is found and the RMS misfit of each run that judges, as the loss of `identify` has it."""
    Path(out).mkdir(parents=True, exist_ok=True)
    judges = tracks(Path(folder, "eval"), Path(cable), Path(out), JUDGED)
    found = identify(tracks(Path(folder, "train"), Path(cable), Path(out), FITTED))
    for name in found.names:
        print(f"{name} = {found.value(name):.4g} ({found.data[name].low:.4g} to {found.data[name].high:.4g})")
    trial = found.measured.bench.trial(found.fit.shares)
    for one in (one for one in judges.measurements if isinstance(one, Markers)):
        misfit = one.predict(trial)[: -one.nuisance]  # without offsets and delay
        print(f"{one.file}: {1e3 * np.sqrt(np.mean(np.square(misfit))):.1f} mm")


if __name__ == "__main__":
    main(*sys.argv[1:])
