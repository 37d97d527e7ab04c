"""What docs/howto/motion.md says of signals, and what is claimed of them."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from evidence.claims import Measurement
from evidence.rendering import markdown, quantity
from evidence.signals.measure import STEP, TRIPS
from evidence.signals.sources import SIGNALS
from evidence.tables import Tables, records, rows

#: targets: deviation of the end force over its largest, RMS and at an instant, and estimate over deviation
RMS = 3e-3
LARGEST = 2e-2
FACTOR = 3.0
#: deviations below it are a tenth of what is asked for, and too small for an estimate to matter
SMALL = 1e-4
#: m: misfits up to here are rounding
FITS = 1e-9
#: s: communication steps up to here are what the targets are for
LONGEST = 0.02


def block(tables: Tables) -> str:
    """Return the tables of signals and of tools with two steps."""
    shown = rows(
        tables["signals"],
        **{"step [s]": STEP},
        reading="start",
        rope=tuple(trip.name for trip in TRIPS),
    )
    lines = []
    for signal in SIGNALS:
        found = records(rows(shown, signal=signal.name))
        cells = [
            " / ".join(quantity(r[name], "%", ".2g") for name in ("RMS", "largest", "told"))
            for r in found
        ]
        said = next(filter(None, (r["warning"] for r in found)), "")
        lines.append((signal.name, *cells, said.partition(":")[0]))
    head = ("motion", *(f"{trip.name} rope" for trip in TRIPS), "warning of the rope")
    tools = [
        (
            r["tool"],
            *(quantity(r[name], "ms") for name in ("drive [s]", "rope [s]")),
            *(quantity(r[name], "%", ".2g") for name in ("RMS", "largest")),
            f"{r['repeated']:.0f}",
        )
        for r in records(tables["multirate"])
    ]
    return "\n\n".join(
        (
            markdown(lines, *head),
            "The columns give the deviation of the end forces relative to the largest: RMS / largest / estimate by\n"
            f"`status.end_force_error`. Communication steps are {quantity(STEP, 'ms')}; inputs are those at the start "
            "of a step.\nAll runs: [signals.csv](../data/signals/signals.csv).",
            markdown(
                tools,
                "tool",
                "steps of the drive",
                "of the rope",
                "RMS",
                "largest",
                "samples repeated",
            ),
        )
    )


def claims(tables: Tables) -> Iterator[Measurement]:
    """The targets, over all ropes and readings: of the estimate for all steps, others for steps up to LONGEST."""
    t = tables["signals"]
    judged = {signal.name for signal in SIGNALS if signal.judged}
    told = {signal.name for signal in SIGNALS if signal.told}
    short = t["step [s]"] <= LONGEST
    kept = short & np.isin(t["signal"], sorted(judged))
    yield Measurement("end force, RMS", _worst(t["RMS"][kept]), "1", "<", RMS)
    yield Measurement("end force, largest", _worst(t["largest"][kept]), "1", "<", LARGEST)
    estimated = {signal.name for signal in SIGNALS if signal.estimated}
    ratio = (t["told"] / t["RMS"])[(t["RMS"] > SMALL) & np.isin(t["signal"], sorted(estimated))]
    yield Measurement("estimate over deviation, largest", _worst(ratio), "1", "<", FACTOR)
    yield Measurement(
        "estimate over deviation, least", float(np.min(ratio)), "1", ">", 1.0 / FACTOR
    )
    # a table as fine as the steps fits
    unfit = short & np.isin(t["signal"], sorted(told)) & (t["misfit [m]"] > FITS)
    silent = int(np.sum(t["warning"][unfit] == ""))
    yield Measurement("signals that no warning names", silent, "1", "<", 0.5)
    failed = sum(map(bool, (*t["failure"], *tables["multirate"]["failure"])))
    yield Measurement("runs that fail", failed, "1", "<", 0.5)
    yield Measurement(
        "drive and rope with two steps, RMS", _worst(tables["multirate"]["RMS"]), "1", "<", RMS
    )


def _worst(x: Any) -> float:
    return float(np.max(x)) if len(x) else float("nan")
