"""Both flavours of the FMU on one trip: ``make demo``.

``python -m benchmarks.flavours PYTHON.fmu NATIVE.fmu`` winds the trip of the 120 m rope's hoist with
each, without reports, and prints by how much end forces and loops differ.  Both compute torsion, on
the mesh and with the tolerance of the level LEVEL: the reference rope takes milliseconds for a
step.
"""

import argparse
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.progress import progress_bar
from hoist_demo.design.controllers import design_drive
from hoist_demo.recording.time_series import Recording
from hoist_demo.run.data import build_single_trip
from hoist_demo.run.wind import wind_run
from rope_model.cases import ROPE_CASES, Level
from rope_model.scene_names import Value, choices_of, named_parameters

HOIST = "rope-120"
LEVEL: Level = "draft"
#: signals that are compared, and the words for each
COMPARED = {
    "left.fy": "vertical force, left end",
    "right.fy": "vertical force, right end",
    "left.my": "torque, left end",
    "right.my": "torque, right end",
    "loop.x": "loop, in the plane",
    "loop.y": "loop, height",
    "loop.z": "loop, out of the plane",
    "loop.yaw": "loop, yaw",
}


def settings() -> Mapping[str, Value]:
    """Return the parameters of both ropes: those of LEVEL, and the complete model."""
    scene = ROPE_CASES[HOIST](LEVEL).scene
    groups = ("mesh.", "solver.", "accuracy.")
    chosen = {p.name: p.value for p in named_parameters(scene) if p.name.startswith(groups)}
    return chosen | {"model.fidelity": choices_of("model.fidelity").index("torsional")}


def wound(fmu: Path) -> tuple[Recording, float]:
    """Return the record of the trip with this FMU, and the time that it took (s)."""
    run = build_single_trip(HOIST, {})
    drive = design_drive(run)
    rope = FmuRope(fmu, {**run.rope_values, **settings()}, COMPARED)
    start = time.perf_counter()
    try:
        with progress_bar() as progress:
            result = wind_run(run, rope, progress, drive)
    finally:
        rope.close()
    if not result.completed:
        raise RuntimeError(f"the trip with {fmu} stopped: {result.cause}")
    return result.recording, time.perf_counter() - start


def differences(one: Recording, other: Recording) -> list[tuple[str, str, float, float]]:
    """Return words, unit, largest value and largest difference of each signal."""
    rows = []
    for name, words in COMPARED.items():
        theirs = other[name]
        difference = np.abs(one[name] - theirs)
        rows.append((words, one.units[name], float(np.abs(theirs).max()), float(difference.max())))
    return rows


def main() -> None:
    """Wind with both and print the differences."""
    parser = argparse.ArgumentParser("python -m benchmarks.flavours", description=__doc__)
    parser.add_argument("python", type=Path, help="FMU of the Python flavour")
    parser.add_argument("native", type=Path, help="FMU of the native flavour")
    options = parser.parse_args()
    native, native_time = wound(options.native)
    python, python_time = wound(options.python)
    print(
        f"the same trip with both flavours: {python_time:.0f} s with the reference rope in Python, "
        f"{native_time:.1f} s with the engine"
    )
    print(f"{f'level {LEVEL}':<28}{'largest':>12}{'difference':>12}")
    for words, unit, largest, difference in differences(python, native):
        print(f"{words:<28}{largest:>12.6g}{difference:>12.2g} {unit}")


if __name__ == "__main__":
    main()
