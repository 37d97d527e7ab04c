"""What docs/guards.md says, computed from the table of windings."""

from __future__ import annotations

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, rows

from .figures import FIGURES
from .jam import COLUMNS as JAM
from .jam import SLACK
from .judging import EARLY, PEAK, guard
from .scenes import JUDGE, SET
from .wind import LEAD, QUANTITIES

__all__ = ["FIGURES", "page"]
UNITS = {"rise": "m", "window": "m", "clearance": "m", "turns": "turns", "torque": "N m"}
#: m, thresholds of the clearance guard that the page shows
CLEARANCES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5)
BOTH = (SET, JUDGE)


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["windings"]
    healthy, fouled = (rows(t, outcome=outcome) for outcome in ("healthy", "fouled"))
    data = {
        "seeds": {"set": SET, "judge": JUDGE},
        "lead": LEAD,
        "number": len(t["seed"]),
        "outcomes": {"healthy": len(healthy["seed"]), "fouled": len(fouled["seed"])},
        "at_rest": len(rows(t, outcome="fouled at rest")["seed"]),
        "failed": len(rows(t, outcome="failed")["seed"]),
        "kinds": _kinds(t),
        "stopped": _share(fouled, "stop"),
        "stopped_healthy": _share(healthy, "stop"),
        "turned": (np.median(fouled["turns, peak"]), fouled["turns, peak"].max()),
        "guards": [_row(t, name) for name in QUANTITIES],
        "apart": [
            (
                name,
                *(f"{guard(t, name, BOTH, when).told_apart:.2f}" for when in (PEAK, EARLY)),
            )
            for name in QUANTITIES
        ],
        "clearances": [_clearance(t, c) for c in CLEARANCES],
        **_jam(tables["jam"]),
    }
    return render("guards/guards.md.j2", data)


def _jam(t: Table) -> dict[str, object]:
    """What saw the jam, and when; and the guards that did so before the slack, and after it."""
    columns = zip(*(t[name] for name in JAM), strict=True)
    found, times = [], {}
    for name, threshold, seconds, peak in columns:
        unit = UNITS.get(name, "")
        shown = [f"{number(x, '.2g')} {unit}" if np.isfinite(x) else "" for x in (threshold, peak)]
        when = quantity(seconds, "s", ".2g") if np.isfinite(seconds) else "never"
        found.append((name, shown[0], when, shown[1]))
        times[name] = seconds
    seen = sorted((name for name in times if np.isfinite(times[name])), key=times.__getitem__)
    at = seen.index(SLACK)
    return {"jam": found, "earlier": seen[:at], "later": seen[at + 1 :]}


def _share(t: Table, column: str) -> float:
    return float(np.mean(t[column]))


def _kinds(t: Table) -> list[tuple[str, ...]]:
    """Windings by swivels and stop: number, and what they fouled."""
    found = []
    for swivels in ("turning", "seized"):
        for stop, words in ((0.0, "no"), (1.0, "yes")):
            mine = rows(t, swivels=swivels, stop=stop)
            fouled = rows(mine, outcome="fouled")
            bodies = [str(int(np.sum(fouled["body"] == body))) for body in ("lining", "divider", "conveyance")]
            found.append((swivels, words, str(len(mine["seed"])), *bodies))
    return found


def _row(t: Table, name: str) -> tuple[str, ...]:
    """Thresholds set on one seed, and how they do on the other."""
    seed, other = guard(t, name, (SET,)), guard(t, name, (JUDGE,))
    cells = []
    for threshold in (seed.highest_without_missed, seed.evenly, seed.lowest_without_false):
        shown = f"{number(abs(threshold), '.2g')} {UNITS[name]}"
        cells += [shown, f"{_percent(other.missed(threshold))} / {_percent(other.false(threshold))}"]
    return (name, *cells)


def _clearance(t: Table, threshold: float) -> tuple[str, ...]:
    by_then, early = (guard(t, "clearance", BOTH, when) for when in (PEAK, EARLY))
    return (
        quantity(threshold, "m", ".2g"),
        _percent(by_then.missed(-threshold)),
        _percent(by_then.false(-threshold)),
        _percent(1.0 - early.missed(-threshold)),
    )


def _percent(share: float) -> str:
    return quantity(share, "%", ".2g")
