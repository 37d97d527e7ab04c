"""What the time step of 10 ms costs by itself, and how the meshes compare at a quarter of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import Winding
from evidence.tables import Table, Tables, table
from rope_model import Mesh, RopeSimulator

from .windings import DEFAULT_MESH, Stresses, follow, scene_of

SHORT_STEP = 2.5e-3  # s
#: TMN-ETM's default mesh, and EEM of about its accuracy
RUNS = {
    "TMN-ETM, 10 ms": (DEFAULT_MESH, 1e-2),
    "TMN-ETM, 2.5 ms": (DEFAULT_MESH, SHORT_STEP),
    "EEM 200, 2.5 ms": (Mesh(kind="eem", elements=200), SHORT_STEP),
}
PAIRS = (("TMN-ETM, 10 ms", "TMN-ETM, 2.5 ms"), ("TMN-ETM, 2.5 ms", "EEM 200, 2.5 ms"))
ERRORS = ("force error [%]", "bottom error [mm]")
TORSION = ("torsion maximum, largest difference [%]", "torsion maximum, 99 % quantile of the difference [%]")
EVEN = "smallest over largest torsional stress, 1 % quantile over time"


def errors(run: Winding, exact: Winding) -> tuple[float, float]:
    """RMS of the end forces' difference over the largest, %; largest difference of the loop's lowest point, mm."""
    force = np.sqrt(np.mean((np.array(run.force) - exact.force) ** 2)) / np.max(np.abs(exact.force))
    return 100 * float(force), 1e3 * float(np.max(np.abs(np.array(run.bottom) - exact.bottom)))


def measure() -> Tables:
    """Coupled windings at both steps: differences in pairs, and how even the torsional stress is."""
    runs, torsion = {}, {}
    for name, (mesh, step) in RUNS.items():
        scene = scene_of("coupled", mesh)
        scene = scene.with_(solver=replace(scene.solver, step_max=step))
        seen = Stresses(RopeSimulator(scene))
        runs[name] = follow(scene, name, seen)
        torsion[name] = [values[1] for values in seen.values]
    pairs = []
    for a, b in PAIRS:
        difference = 100 * np.abs(_largest(torsion[a]) / _largest(torsion[b]) - 1)
        pairs.append((f"{a} against {b}", *errors(runs[a], runs[b]), difference.max(), np.quantile(difference, 0.99)))
    even = [(name, np.quantile([x.min() / x.max() for x in torsion[name]], 0.01)) for name in RUNS]
    return {"time-step": table(("what", *ERRORS, *TORSION), pairs), "evenness": table(("run", EVEN), even)}


def _largest(values: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.array([x.max() for x in values])


def row(t: Table, name: str, value: str) -> int:
    """The row of a table whose column ``name`` begins with ``value``."""
    return next(i for i, cell in enumerate(t[name]) if cell.startswith(value))
