"""The table of cases in docs/howto/hoist.md: what each trip asks of the drive, and how safe it is against slip."""

from __future__ import annotations

import numpy as np

from evidence.rendering import markdown, number
from evidence.tables import Tables

from .winding import Run

#: columns of the table ``cases``, and those of them that docs/howto/hoist.md shows
SUMMARY = (
    "case", "winding time [s]", "final error [mm]", "peak torque [kN m]", "peak power [MW]", "peak tension [kN]",
    "tension ratio", "static tension ratio", "slip safety", "static slip safety", "energy residual [J]",
)  # fmt: skip
SHOWN = (*SUMMARY[:2], *SUMMARY[3:7], *SUMMARY[8:10])


def summary(name: str, run: Run) -> tuple[str, ...]:
    """A case's row."""
    moving = np.flatnonzero(np.abs(run["speed"]) > 0.01)
    values = (
        run["time"][moving[-1]] - run["time"][moving[0]],
        1e3 * (run["position"][-1] - run.hoist.shaft_travel),
        1e-3 * np.max(np.abs(run["torque"])),
        1e-6 * np.max(np.abs(run["power"])),
        1e-3 * np.max(run["tension_left"]),
        np.max(run["tension_ratio"]),
        np.max(run["static_tension_ratio"]),
        np.min(run["slip_safety"]),
        np.min(run["static_slip_safety"]),
        np.max(np.abs(run["energy_residual"])),
    )
    return name, *(f"{value:.4g}" for value in values)


def cases(tables: Tables) -> str:
    """What stands between the marks."""
    t = tables["cases"]
    rows = [(f"`{t['case'][i]}`", *(number(t[name][i], ".4g") for name in SHOWN[1:])) for i in range(t["case"].size)]
    return markdown(rows, *SHOWN)
