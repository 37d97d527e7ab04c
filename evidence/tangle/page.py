"""What docs/tangle.md says, from the recorded trips."""

from __future__ import annotations

import math
from typing import Any

from evidence.rendering import number, render
from evidence.tables import Table, Tables, rows

from .figures import FIGURES
from .scenes import DIVIDER, LAYOUT, MESHES, ROPE, SEIZED, SHAFT, TRIP, TRIP_TIME, TURNED, VARIANTS
from .wind import BEYOND, END, INTERVAL, MEAN

__all__ = ["FIGURES", "page"]

_WORDS = {"lining": "lining", "conveyance": "conveyance", "head_ropes": "head ropes", "divider": "divider"}


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["trips"]
    trips = {str(name): _trip(t, str(name)) for name in t["variant"]}
    seized, exact = trips[SEIZED.name], trips[MESHES[-1].name]
    data = {
        "rope": ROPE,
        "layout": LAYOUT,
        "shaft": SHAFT,
        "trip": TRIP,
        "time": TRIP_TIME,
        "end": END,
        "interval": INTERVAL,
        "mean": MEAN,
        "turned": TURNED,
        "divider": DIVIDER,
        "variants": [_row(trips[v.name]) for v in VARIANTS],
        "meshes": [_mesh(trips[m.name], exact, "default" if m is SEIZED else m.name) for m in MESHES],
        "equal": _apart(seized, trips[MESHES[3].name]),
        "finest": _apart(seized, exact),
        "fine": _apart(trips[MESHES[1].name], exact),
        "common": _apart(trips[MESHES[2].name], exact),
        "seized": seized,
        "exact": exact,
        "guard": trips[VARIANTS[-1].name],
        "divided": trips[VARIANTS[-2].name],
        "healthy": trips[VARIANTS[1].name],
        "free": trips[VARIANTS[0].name],
        "residual": max(abs(trip["residual / work"]) for trip in trips.values()),
    }
    return render("tangle/tangle.md.j2", data)


def _trip(t: Table, name: str) -> dict[str, Any]:
    return {key: column[0].item() for key, column in rows(t, variant=name).items()}


def _apart(trip: dict[str, Any], other: dict[str, Any]) -> tuple[float, float]:
    """By how many seconds head ropes are struck later, and what part of the force is missing."""
    times, forces = ([x[f"head_ropes, {key}"] for x in (trip, other)] for key in ("first at [s]", "mean [N]"))
    return times[0] - times[1], 1.0 - forces[0] / forces[1]


def _row(trip: dict[str, Any]) -> tuple[str, ...]:
    struck = [
        f"{_WORDS[kind]} at {number(trip[f'{kind}, first at [s]'], '.4g')} s, {number(trip[f'{kind}, mean [N]'])} N"
        for kind in BEYOND
        if not math.isnan(trip[f"{kind}, first at [s]"])
    ]
    return trip["variant"], number(trip["turned by [turns]"]), "; ".join(struck) or "nothing"


def _mesh(trip: dict[str, Any], exact: dict[str, Any], name: str) -> tuple[str, ...]:
    at, force = trip["head_ropes, first at [s]"], trip["head_ropes, mean [N]"]
    return (
        *(name, number(trip["elements"]), f"{at:.2f} s", f"{at - exact['head_ropes, first at [s]']:+.2f} s"),
        *(f"{number(force)} N", f"{trip['conveyance, first at [s]']:.2f} s", number(trip["turned by [turns]"])),
    )
