"""Tables, figures and data of the worked studies: ``python -m evidence.studies``.

Reads what `balance-rope study` has left in out/study, winds with the gains of the search on the complete rope, and
writes docs/study_controllers.md, docs/study_swivel.md, docs/images/study, docs/data/study, and the metrics in
docs/reference/files.md.
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Mapping
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

from evidence.pages import BLOCKS, PAGES, fill, publish
from evidence.rendering import DOCS
from evidence.tables import table, write
from hoist_demo.control.controller import Gains
from hoist_demo.study.definition import read_study
from hoist_demo.study.run import execute
from hoist_demo.study.store import Store, read_results

from . import figures
from .page import with_differences

STUDIES, DATA = Path("out") / "study", DOCS / "data" / "study"
NAMES = ("controllers", "controllers_complete", "swivel", "creep", "tuning")
COMPLETE = Path("build") / "standard.fmu"
LET_OUT = 5.0  # s, after which an installed twist has left the rope where a swivel turns


def main() -> None:
    """Write everything; a study that has not been run stops with the command that runs it."""
    argparse.ArgumentParser("python -m evidence.studies", description=__doc__).parse_args()
    if not COMPLETE.is_file():
        raise SystemExit(f"{COMPLETE} is missing: run `balance-rope export --native --platform host --out {COMPLETE}`")
    for folder in (figures.IMAGES, DATA):
        folder.mkdir(parents=True, exist_ok=True)
    stores, found = {}, {}
    for name in NAMES:
        results = STUDIES / name / "results.parquet"
        if not results.is_file():
            raise SystemExit(f"{results} is missing: run `balance-rope study docs/studies/{name}.toml` first")
        stores[name], found[name] = Store(results.parent), read_results(results)
        shutil.copyfile(results.with_suffix(".csv"), DATA / f"{name}.csv")
    with plt.rc_context(figures.STYLE):
        figures.controllers(found["controllers"])
        figures.save(figures.creep_figure(with_differences(found["creep"].table)), "creep")
        figures.arrivals(stores["controllers_complete"], found["controllers_complete"])
        figures.swivels(stores["swivel"], found["swivel"])
    yaws = [(key, *yaw_of(stores["swivel"].signals(key))) for key in found["swivel"].table["key"]]
    write({"swivel_yaw": table(("key", "yaw_at_end [rad]", "least_yaw [rad]", "largest_yaw [rad]"), yaws)}, DATA)
    best = verify(found["tuning"].table, DOCS / "studies" / "tuning.toml", COMPLETE)
    best.to_csv(DATA / "tuning_complete.csv", index=False, float_format="%.9g", lineterminator="\n")
    for name in ("study_controllers", "study_swivel"):
        publish(PAGES[name])
    fill(BLOCKS["metrics"])


def yaw_of(signals: pd.DataFrame) -> tuple[float, float, float]:
    """Of the loop [rad]: at the end, and the least and the largest once LET_OUT is over."""
    yaw = signals["loop.yaw"]
    after = yaw[signals["time"] > LET_OUT]
    return float(yaw.iloc[-1]), float(after.min()), float(after.max())


def verify(tuning: pd.DataFrame, file: Path, fmu: Path) -> pd.DataFrame:
    """The best run of a search's table, and its gains and the default ones on another rope, with their `cost` [s]."""
    study = read_study(file, fmu)
    assert study.tuning is not None
    weights, variant = study.tuning.minimise, next(iter(study.variants))
    best = tuning.loc[_cost(tuning, weights).idxmin()]
    rows = [{"gains": "tuned", "rope": "draft", **best}]
    for label, gains in (
        ("tuned", {name: float(best[name]) for name in study.ranges}),
        ("default", {name: getattr(Gains(), name.partition(".")[2]) for name in study.ranges}),
    ):
        outcome = execute(study.sample(variant, gains).data, fmu)
        if outcome.status != "completed":
            raise RuntimeError(f"{label} gains on {fmu}: {outcome.cause}")
        rows.append({"gains": label, "rope": "complete", **gains, **outcome.metrics})
    table = pd.DataFrame(rows)
    return table.assign(cost=_cost(table, weights))


def _cost(table: pd.DataFrame, weights: Mapping[str, float]) -> pd.Series:
    return table[list(weights)].mul(pd.Series(weights)).sum(axis=1, skipna=False)


if __name__ == "__main__":
    main()
