"""What docs/choice.md says, computed from the tables: choices and errors, estimates, and what each term changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables
from rope_model.physics.estimates import ASSUMED

from .fidelity import ROUNDS
from .terms import SCENES, VARIANTS

#: a fifth of the 0.5 % and all of the 1 cm to which the meshes must agree
NEEDED, NEEDED_PLACE = 1e-3, 0.01
CALM, SUDDEN = ("winding",), ("emergency stop", "release")


def page(tables: Tables) -> str:
    """The whole page."""
    choices, changes = tables["fidelity"], tables["terms"]
    data = {
        "expected": ASSUMED,
        "rounds": ROUNDS,
        "scenes": [_scene(choices, i) for i in range(choices["scene"].size)],
        "raised": [(i, what) for i, cell in enumerate(choices["raised"], start=1) for what in _switches(cell)],
        "estimates": _estimates(tables["estimates"]),
        "changes": _changes(changes, tables["bases"]),
        "needed_force": change(NEEDED, "%"),
        "needed_place": change(NEEDED_PLACE, "mm"),
        "terms": {v.term: _term(changes, tables["bases"], v.term) for v in VARIANTS},
    }
    return render("choice/choice.md.j2", data)


def change(x: float, unit: str) -> str:
    """A difference; what is below 1e-6 % or 1 um is rounding of Newton's method."""
    least, form = {"%": (1e-8, ".2g"), "mm": (1e-6, ".3g")}[unit]
    if x == 0:
        return "0"
    return f"< {quantity(least, unit, 'g')}" if x < least else quantity(x, unit, form)


def _switches(cell: str) -> list[str]:
    """To which fidelity a run was raised, when and why."""
    return cell.split("; ") if cell else []


def _scene(t: Table, i: int) -> tuple[str, ...]:
    """What 'auto' takes, and what that changes and costs."""
    taken, switches = str(t["fidelity"][i]), _switches(t["raised"][i])
    then = "".join(f", then {what.split()[0]}" for what in switches)
    start = (str(i + 1), str(t["scene"][i]), taken + then, str(t["reason"][i]))
    if taken == "torsional":
        return (*start, "same", "same", "same", "1")
    errors = ((t["force_rms"], "%"), (t["force_largest"], "%"), (t["loop_m"], "mm"))
    return (*start, *(change(column[i], unit) for column, unit in errors), number(t["time"][i], ".2f"))


def _estimates(t: Table) -> list[tuple[str, ...]]:
    """Errors and estimates of the windings of one rope at one speed."""
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


def _base(bases: Table, scene: str, column: str) -> Any:
    return bases[column][bases["scene"] == scene][0]


def _changes(t: Table, bases: Table) -> list[tuple[str, ...]]:
    """Every variant in every scene, in the order of VARIANTS."""
    order, rows = [v.change for v in VARIANTS], list[tuple[str, ...]]()
    for i in sorted(range(t["scene"].size), key=lambda i: order.index(str(t["change"][i]))):
        scene = str(t["scene"][i])
        start = (str(t["term"][i]), str(t["change"][i]), SCENES[scene].title)
        if t["message"][i]:
            rows.append((*start, f"fails: {t['message'][i]}", "", "", "", ""))
            continue
        theta, torque = t["theta_rad"][i], t["torque_Nm"][i]
        rows.append(
            (
                *start,
                change(t["force_rms"][i], "%"),
                change(t["loop_m"][i], "mm"),
                f"{quantity(theta, 'mrad')} ({change(theta / _base(bases, scene, 'theta_rad'), '%')})",
                f"{quantity(torque, 'N m')} ({change(torque / _base(bases, scene, 'torque_Nm'), '%')})",
                f"{t['steps'][i]:.0f} ({_base(bases, scene, 'steps'):.0f})",
            )
        )
    return rows


def _term(t: Table, bases: Table, term: str) -> dict[str, Any]:
    """The most that the variants of a term change, in quiet scenes, after a sudden change, and in all."""
    torque = t["torque_Nm"] / np.array([_base(bases, scene, "torque_Nm") for scene in t["scene"]])
    mine = (t["term"] == term) & (t["message"] == "")

    def most(scenes: Sequence[str]) -> dict[str, str]:
        kept = mine & np.isin(t["scene"], scenes)
        return {
            "force": change(t["force_rms"][kept].max(), "%"),
            "loop": change(t["loop_m"][kept].max(), "mm"),
            "torque": change(torque[kept].max(), "%"),
        }

    needed = t["force_rms"][mine].max() > NEEDED or t["loop_m"][mine].max() > NEEDED_PLACE
    return {"needed": needed, "calm": most(CALM), "sudden": most(SUDDEN), "all": most(tuple(SCENES))}
