"""Torsional stress at a quarter of the time step of 10 ms: of both meshes, and how even it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

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
PAIR = ("TMN-ETM, 2.5 ms", "EEM 200, 2.5 ms")
TORSION = ("torsion maximum, largest difference [%]", "torsion maximum, 99 % quantile of the difference [%]")
EVEN = "smallest over largest torsional stress, 1 % quantile over time"


def measure() -> Tables:
    """Wind at both steps: difference of the meshes, and how even the torsional stress is."""
    torsion = {}
    for name, (mesh, step) in RUNS.items():
        scene = scene_of("coupled", mesh)
        scene = scene.with_(solver=replace(scene.solver, step_max=step))
        seen = Stresses(RopeSimulator(scene))
        follow(scene, name, seen)
        torsion[name] = [values[1] for values in seen.values]
    tmn, eem = (_largest(torsion[name]) for name in PAIR)
    difference = 100 * np.abs(tmn / eem - 1)
    pair = (" against ".join(PAIR), difference.max(), np.quantile(difference, 0.99))
    even = [(name, np.quantile([x.min() / x.max() for x in torsion[name]], 0.01)) for name in RUNS]
    return {"time-step": table(("what", *TORSION), [pair]), "evenness": table(("run", EVEN), even)}


def _largest(values: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.array([x.max() for x in values])


def row(t: Table, name: str, value: str) -> int:
    """The row of a table whose column ``name`` begins with ``value``."""
    return next(i for i, cell in enumerate(t[name]) if cell.startswith(value))
