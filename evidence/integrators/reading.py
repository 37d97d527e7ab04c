"""What the table says of a method: its errors, and its work against that of others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Table, rows

from .measure import ERRORS, EVEN

STOP = "emergency stop"


@dataclass(frozen=True)
class Verdict:
    """A method with one largest step: medians over scenes."""

    name: str
    step: float  # s
    errors: dict[str, float]  # ERRORS
    worst: float  # error of the end force
    cost: float  # work over that of the baseline
    ratio: float  # error of the end force over that of the baseline
    gain: float  # work of even steps of generalized-alpha at the same error of the end force over this one's
    failures: int


def kinds(t: Table) -> tuple[Table, Table]:
    """The trips without a stop, and those with one."""
    stopped = t["kind"] == STOP
    return {name: x[~stopped] for name, x in t.items()}, {name: x[stopped] for name, x in t.items()}


def judge(t: Table, name: str, step: float, baseline: str) -> Verdict:
    """Over the scenes of ``t``."""
    mine, base = rows(t, method=name, **{"step [s]": step}), rows(t, method=baseline)
    force, work = mine["end force"], mine["work"]
    return Verdict(
        name,
        step,
        {error: float(np.median(mine[error])) for error in ERRORS},
        float(force.max()),
        float(np.median(work / base["work"])),
        float(np.median(force / base["end force"])),
        float(np.median([work_of_even(t, *one) for one in zip(mine["scene"], force, strict=True)] / work)),
        int(np.isnan(force).sum()),
    )


def verdicts(t: Table, baseline: str) -> list[Verdict]:
    """All methods with all steps, in the order of the table."""
    pairs = dict.fromkeys(zip(t["method"].tolist(), t["step [s]"].tolist(), strict=True))
    return [judge(t, name, step, baseline) for name, step in pairs]


def work_of_even(t: Table, scene: float, error: float) -> float:
    """Of generalized-alpha with even steps at this error of the end force, between its steps; NaN outside of them."""
    curve = rows(t, scene=scene, method=EVEN)
    order = np.argsort(curve["end force"])
    errors, work = (np.log(curve[name][order]) for name in ("end force", "work"))
    return float(np.exp(np.interp(np.log(error), errors, work, left=np.nan, right=np.nan)))


def reference_error(t: Table) -> NDArray[np.float64]:
    """Largest of ERRORS, over the scenes, between the reference and the same method with four times its step."""
    finest = rows(t, method="ESDIRK 4", **{"step [s]": t["step [s]"][t["method"] == "ESDIRK 4"].min()})
    return np.array([finest[error].max() for error in ERRORS])
