"""Run the comparison and write docs/peer.md, docs/data/peer and docs/images/peer.

``--again`` writes them from the results of the last run, kept in out/.
"""

from __future__ import annotations

import pickle
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from tqdm import tqdm

from .cases import OPTIONS, OPTIONS_AT, REFERENCE_OURS, REFERENCE_PEER, SPACE, planar_cases, space_cases
from .exudyn_rope import Method
from .figures import work_precision
from .page import Results, page, write_data
from .precision import LEVELS, Measured
from .runs import UNCOUPLED, Error, Run, error, exudyn, measure_times, ours
from .statics import frequencies, yaws

ROOT = Path(__file__).resolve().parents[2]
DOCS, KEPT = ROOT / "docs", ROOT / "out" / "peer.pickle"
ROUNDS, SHORT = 3, 3.0  # s


def main(again: bool) -> None:
    """Compute or load, and write."""
    if not again:
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_bytes(pickle.dumps(compute()))
    results: Results = pickle.loads(KEPT.read_bytes())
    write_data(results, DOCS / "data" / "peer")
    shown = [m for m in results.measured if np.isfinite(m.run.cpu)]
    for metric in LEVELS:
        work_precision(shown, metric, DOCS / "images" / "peer" / f"{metric}.png")
    (DOCS / "peer.md").write_text(page(results), encoding="utf-8")
    print(f"written: docs/peer.md, {len(results.measured)} runs of the planar winding")


def compute() -> Results:
    """Everything; takes some ten minutes on a free machine."""
    with tqdm(desc="runs", unit="run", leave=False) as bar:

        def tell(key: str) -> None:
            bar.set_postfix_str(key)
            bar.update()

        mine = ours(REFERENCE_OURS.group, REFERENCE_OURS.label, REFERENCE_OURS.scene)
        theirs = exudyn(*REFERENCE_PEER)

        def measured(run: Run) -> Measured:
            return Measured(run, error(run, mine), error(run, theirs))

        element, count = OPTIONS_AT
        cases = {
            f"{1e3 * m.step:g} ms, {m.newton} Newton, radius {m.spectral_radius:g}": partial(exudyn, element, count, m)
            for m in OPTIONS
        }
        options = measure_times(cases, ROUNDS, SHORT, tell)
        method = Method(0.01, "full")
        forms = {f"symbolic: {x}": partial(exudyn, element, count, method, symbolic=x) for x in (True, False)}
        functions = measure_times(forms, ROUNDS, SHORT, tell)
        damping = difference_without_damping(element, count, method)
        damping_3d = difference_without_damping("beam-3d", 120, Method(0.02, "full"))
        planar = measure_times(planar_cases(), ROUNDS, SHORT, tell)
        space: list[tuple[str, list[tuple[str, Run, Error]]]] = []
        for scene in SPACE:
            runs = measure_times(space_cases(scene), ROUNDS, SHORT, tell)
            reference = next(iter(runs.values()))
            space.append((scene.title, [(label, run, error(run, reference)) for label, run in runs.items()]))
    return Results(
        frequencies=frequencies(),
        yaws=yaws(),
        references=error(mine, theirs),
        measured=[measured(run) for run in (mine, *planar.values())],
        options=[(name, measured(run)) for name, run in options.items()],
        damping=damping,
        damping_3d=damping_3d,
        functions=(functions["symbolic: True"], functions["symbolic: False"]),
        space=space,
    )


def difference_without_damping(element: str, count: int, method: Method) -> Error:
    """What beta_K changes in Exudyn."""
    undamped = UNCOUPLED.with_(rope=replace(UNCOUPLED.rope, beta_K=0.0))
    return error(exudyn(element, count, method), exudyn(element, count, method, undamped))


if __name__ == "__main__":
    main("--again" in sys.argv[1:])
