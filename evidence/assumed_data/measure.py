"""Coverage of the intervals that ``identify`` states, and spread by ``uncertain`` (20 minutes).

Coverage: each of SETS ropes has properties drawn evenly from the middle 70 % of their ranges, is measured by PLAN with
normal errors of its sigma, and looked for again.  Counted is how often the true value lies within the interval of 90 %
that the fit states, and, to tell the interval from the luck of the draw, in how many sets an exact interval would hold
it: those in which the best linear estimate about the truth, J^+ e, is off by at most 1.645 standard errors.
"""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tqdm import tqdm

from evidence.rendering import DOCS
from evidence.tables import Measures, Tables, table
from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.findings import OPEN
from hoist_demo.calibration.fit import REACH, fit, intervals, sensitivities
from hoist_demo.calibration.identify import residuals_of, stacked
from hoist_demo.files.reading import read
from hoist_demo.run.metrics import UNITS
from hoist_demo.uncertainty.definition import UncertaintyFile
from hoist_demo.uncertainty.spread import run_windings
from rope_model.arrays import Array

#: what is measured, with sigma
EXAMPLES = DOCS.parent / "examples"
PLAN: Path = EXAMPLES / "measurements" / "example.toml"
#: sets of ropes; of those measurements alone that have closed forms, which cost nothing
SETS = 100
MORE_SETS = 600
#: of the sets by which the method was judged while it was made, and of sets that were drawn once it stood
SEED = 20261122
UNSEEN = 7
#: shares of the ranges from which the true ropes are drawn
DRAWN = (0.15, 0.85)
HANGING = ("at rest", "swing")
SCENES = ("rope-120", "kiruna-355")


def cover(plan: MeasurementFile, which: str, sets: int, seed: int) -> Iterator[tuple[object, ...]]:
    """Yield per property: sets in which it is told, held within, held by an exact interval, and the mean half width."""
    problem = plan.problem
    _, sigmas = stacked(plan.measurements)
    rng = np.random.default_rng(seed)
    low, high = DRAWN
    truths: Array = low + (high - low) * rng.random((sets, len(problem.names)))
    held = []
    for truth in tqdm(truths, desc=which, unit="rope", leave=False):
        errors = rng.standard_normal(sigmas.size)
        values = problem.predict(truth, plan.measurements) + sigmas * errors
        residuals = residuals_of(problem, plan.measurements, values, sigmas)
        ends = intervals(residuals, fit(residuals, truth.size))
        estimate = np.linalg.pinv(sensitivities(residuals, truth))
        off = estimate @ errors / np.linalg.norm(estimate, axis=1)
        reach = 0.5 * (ends[:, 1] - ends[:, 0])
        within = (ends[:, 0] <= truth) & (truth <= ends[:, 1])
        held.append(
            (reach < OPEN, within & (reach < OPEN), (np.abs(off) <= REACH) & (reach < OPEN), reach)
        )
    told, within, exact, reach = np.array(held).transpose(1, 2, 0)
    for k, name in enumerate(problem.names):
        yield which, name, told[k].sum(), within[k].sum(), exact[k].sum(), reach[k].mean()


def coverage() -> Tables:
    """Measure the coverage of judged and unseen sets, and without the measurements of a hanging rope."""
    plan = read(PLAN, MeasurementFile)
    kept = tuple(m for m in plan.measurements if m.what not in HANGING)
    samples = plan.model_copy(update={"measurements": kept})
    rows = [*cover(plan, "judged", SETS, SEED), *cover(plan, "unseen", SETS, UNSEEN)]
    rows += cover(samples, "without a hanging rope", MORE_SETS, SEED)
    return {"coverage": table(("sets", "property", "told", "inside", "exact", "reach"), rows)}


def worked() -> Tables:
    """Wind SCENES with ropes from the catalogue's ranges: quantiles of the results, and their causes."""
    results = []
    causes = []
    for scene in SCENES:
        found = run_windings(
            read(EXAMPLES / "uncertain" / f"{scene}.toml", UncertaintyFile), os.cpu_count() or 1
        )
        for name in found.file.header.measures:
            results.append((scene, name, UNITS[name], *found.quantiles(name)))
            causes += [(scene, name, key, share) for key, share in found.causes(name).items()]
    head = ("scene", "measure", "unit", "low", "middle", "high")
    return {
        "results": table(head, results),
        "causes": table(("scene", "measure", "datum", "share"), causes),
    }


MEASURES: Measures = {"coverage": coverage, "uncertain": worked}
