"""The worked scenes of docs/uncertain.md: what their windings may be, and which datum causes it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from evidence.rendering import number, render
from evidence.tables import Table, Tables, rows, table
from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters
from hoist_demo.study.metrics import UNITS
from hoist_demo.uncertainty.definition import read_uncertain
from hoist_demo.uncertainty.spread import QUANTILES, spread

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "uncertain"
SCENES = ("rope-120", "kiruna-355")
RESULTS = ("scene", "measure", "unit", "low", "middle", "high", "wound", "samples")
#: causes below are not shown
SHOWN = 0.03


def measure() -> Tables:
    """Quantiles and causes of each scene."""
    results, causes, seconds = [], [], []
    for scene in SCENES:
        begun = time.perf_counter()
        found = spread(read_uncertain(FOLDER / f"{scene}.toml", rope_parameters()), os.cpu_count() or 1)
        seconds.append((scene, time.perf_counter() - begun))
        for name in found.asked.measures:
            wound = int(np.sum(found.wound(name)))
            results.append((scene, name, UNITS[name], *found.quantiles(name), wound, found.asked.samples))
            causes += [(scene, name, key, share) for key, share in found.causes(name).items()]
    return {
        "results": table(RESULTS, results),
        "causes": table(("scene", "measure", "datum", "share"), causes),
        "seconds": table(("scene", "seconds"), seconds),
    }


def page(tables: Tables) -> str:
    """The whole page."""
    results, causes = tables["results"], tables["causes"]
    scenes = {scene: _rows(rows(results, scene=scene), rows(causes, scene=scene)) for scene in SCENES}
    counts = {
        scene: (int(min(rows(results, scene=scene)["wound"])), int(max(rows(results, scene=scene)["samples"])))
        for scene in SCENES
    }
    low, _, high = QUANTILES
    wide = rows(results, measure=("loop_yaw", "left_swivel_torque"))
    factors = wide["high"] / wide["low"]
    data = {"scenes": scenes, "counts": counts, "low": 100 * low, "high": 100 * high}
    return render("knowledge/uncertain.md.j2", {**data, "least": min(factors), "most": max(factors)})


def _rows(results: Table, causes: Table) -> list[tuple[str, ...]]:
    """Per measure: its range, and the data that cause it, the largest first."""
    found = []
    for k, name in enumerate(results["measure"]):
        own = rows(causes, measure=str(name))
        order = np.argsort(-own["share"])
        named = [
            f"{str(own['datum'][i]).replace('_', ' ')} {100 * own['share'][i]:.0f} %"
            for i in order
            if own["share"][i] > SHOWN
        ]
        values = (number(results[column][k]) for column in ("low", "middle", "high"))
        unit = "" if results["unit"][k] == "1" else str(results["unit"][k]).replace(".", " ")
        found.append((f"`{name}`", unit, *values, ", ".join(named)))
    return found
