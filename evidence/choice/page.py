"""How much model: what 'auto' takes, estimates of the errors, and the effect of single terms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from evidence.rendering import number, quantity
from evidence.tables import Table, Tables, records
from rope_model.physics.estimates import ASSUMED

from .measure import ROUNDS, SCENES


def choices(tables: Tables) -> dict[str, Any]:
    """Return the section's tables, from docs/data/choice."""
    return {
        "expected": ASSUMED,
        "rounds": ROUNDS,
        "scenes": [_scene(r) for r in records(tables["choice/fidelity"])],
        "estimates": _estimates(tables["choice/estimates"]),
        "terms": [_term(r) for r in records(tables["choice/terms"])],
    }


def change(x: float, unit: str) -> str:
    """Return a difference as text; below 1e-6 % or 1 um it is rounding of Newton's method."""
    least, form = {"%": (1e-8, ".2g"), "mm": (1e-6, ".3g")}[unit]
    if x == 0:
        return "0"
    return f"< {quantity(least, unit, 'g')}" if x < least else quantity(x, unit, form)


def _scene(r: dict[str, Any]) -> tuple[str, ...]:
    """Return what 'auto' takes, and what that changes and costs."""
    raised = r["raised"].split("; ") if r["raised"] else []
    taken = r["fidelity"] + "".join(f", then {what.split()[0]}" for what in raised)
    errors = (change(r[name], unit) for name, unit in (("force_rms", "%"), ("force_largest", "%"), ("loop_m", "mm")))
    return r["scene"], taken, "; ".join((r["reason"], *raised)), *errors, number(r["time"], ".2g")


def _estimates(t: Table) -> list[tuple[str, ...]]:
    """Return errors and estimates of the windings of one rope at one speed."""
    rows = []
    for length, swivels, speed in sorted(set(zip(t["length"], t["swivels"], t["speed"], strict=True))):
        mine = (t["length"] == length) & (t["swivels"] == swivels) & (t["speed"] == speed)
        cells = [quantity(length, "m", "g"), str(swivels), quantity(speed, "m/s", "g")]
        for fidelity in ("planar", "rigid"):
            errors, estimates = t[fidelity][mine], t[f"{fidelity}_estimate"][mine]
            cells.append(_span([change(x, "%") for x in (errors.min(), errors.max())]))
            factors = estimates / errors
            cells.append(_span([number(x, ".1f") for x in (factors.min(), factors.max())]))
        rows.append(tuple(cells))
    return rows


def _span(ends: Sequence[str]) -> str:
    return " to ".join(dict.fromkeys(ends))


def _term(r: dict[str, Any]) -> tuple[str, ...]:
    """Return what a changed term changes in a scene."""
    shares = (change(r[name], "%") for name in ("theta", "torque"))
    steps = f"{r['steps']:.0f} ({r['steps_default']:.0f})"
    errors = change(r["force_rms"], "%"), change(r["loop_m"], "mm")
    return r["term"], r["change"], SCENES[r["scene"]].title, *errors, *shares, steps
