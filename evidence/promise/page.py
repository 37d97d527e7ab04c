"""What docs/promise.md says, computed from the table of scenes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables
from rope_model.physics import accuracy

from .figures import FIGURES
from .judging import claims, completed, near, over_asked
from .scenes import JUDGE, KINDS, TUNE
from .wind import ASKED, BEFORE, FINE

__all__ = ["FIGURES", "page"]
#: quantiles that the page shows
SHOWN = (0.5, 0.9, 1.0)
WORST = 10
ERRORS = {
    "end force, RMS / largest": ("end force", "%"),
    "horizontal part of it": ("horizontal force", "%"),
    "place of the loop, largest": ("loop [m]", "mm"),
    "clamp moment, RMS / largest": ("clamp moment", "%"),
    "swivel angle, largest": ("swivel angle [rad]", "mrad"),
}


def page(tables: Tables) -> str:
    """The whole page."""
    scenes = tables["scenes"]
    t = completed(scenes)
    data = {
        "asked": ASKED,
        "before": BEFORE,
        "fine": FINE,
        "seeds": {"tune": TUNE, "judge": JUDGE},
        "number": len(scenes["kind"]),
        "completed": len(t["kind"]),
        "failures": sorted({str(x) for x in scenes["failure"] if str(x) not in ("", "nan")}),
        "claims": [
            (c.what, number(c.value, ".3g"), f"{c.relation} {c.bound:.3g}", "yes" if c.holds else "**no**")
            for c in claims(scenes)
        ],
        "kinds": [_kind(t, kind) for kind in (*KINDS, "all") if len(_of(t, kind)["kind"])],
        "errors": [
            (what, *(quantity(np.quantile(t[column], q), unit, ".2g") for q in SHOWN))
            for what, (column, unit) in ERRORS.items()
        ],
        "estimates": [
            ("end force", *_ratios(t["end force, estimated"] / t["end force"])),
            ("place of the loop", *_ratios(t["loop, estimated [m]"] / t["loop [m]"])),
        ],
        "fine_run": {
            "force": np.quantile(t["end force, of the fine run"], (0.5, 1)),
            "loop": np.quantile(t["loop, of the fine run [m]"], (0.5, 1)),
        },
        "work": [
            (kind, *(number(np.quantile(ratio, q), ".2f") for q in (0.1, 0.5, 0.9)))
            for kind in (*KINDS, "all")
            if len(_of(t, kind)["kind"])
            for ratio in [_of(t, kind)["work"] / _of(t, kind)["work, before"]]
        ],
        "worst": _worst(t),
        "constants": accuracy,
    }
    return render("promise/promise.md.j2", data)


def _of(t: Table, kind: str) -> Table:
    return t if kind == "all" else {name: column[t["kind"] == kind] for name, column in t.items()}


def _kind(all_kinds: Table, kind: str) -> Sequence[str]:
    """Shares of one kind of scene, now and before."""
    t = _of(all_kinds, kind)
    over = over_asked(t)
    before = np.maximum(t["end force, before"] / ASKED.end_force, t["loop, before [m]"] / ASKED.loop)
    return (
        kind,
        str(len(over)),
        *(quantity(float(np.mean(x <= 1)), "%", ".3g") for x in (before, over)),
        *(number(x.max(), ".2g") for x in (before, over)),
        quantity(np.quantile(t["end force, before"], 0.9), "%", ".2g"),
        quantity(np.quantile(t["end force"], 0.9), "%", ".2g"),
        quantity(np.quantile(t["loop, before [m]"], 0.9), "mm", ".2g"),
        quantity(np.quantile(t["loop [m]"], 0.9), "mm", ".2g"),
    )


def _ratios(ratio: Any) -> tuple[str, ...]:
    """Of estimate over error: shares within 2, quantiles."""
    quantiles = (number(np.quantile(ratio, q), ".2f") for q in (0.05, 0.5, 0.95))
    return quantity(near(ratio, np.ones_like(ratio)), "%", ".3g"), *quantiles


def _worst(t: Table) -> list[tuple[str, ...]]:
    """The scenes with the largest errors over what was asked."""
    over = over_asked(t)
    return [
        (
            f"{t['scene'][i]:.0f}, {t['kind'][i]}",
            quantity(t["length [m]"][i], "m", ".4g"),
            f"{number(t['EI [N m2]'][i])} N m^2",
            str(t["swivel"][i]),
            quantity(t["speed [m/s]"][i], "m/s"),
            quantity(t["interval [s]"][i], "ms", "g"),
            quantity(t["end force"][i], "%", ".2g"),
            quantity(t["end force, estimated"][i], "%", ".2g"),
            quantity(t["loop [m]"][i], "mm", ".2g"),
            quantity(t["loop, estimated [m]"][i], "mm", ".2g"),
        )
        for i in np.argsort(-over)[:WORST]
    ]
