"""What docs/study_controllers.md and docs/study_swivel.md say, computed from the studies' tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from evidence.rendering import number, render
from evidence.tables import Table, Tables
from hoist_demo.study.metrics import METRICS

NAMES = {"pi": "PI", "pi-feed-forward": "PI with feed-forward", "input-shaping": "input shaping, ZVD"}
NO_CREEP, SEIZED = "none", "both seized"
#: column -> head, factor, format; text without a format
Columns = Mapping[str, tuple[str, float, str]]
CONTROLLER_COLUMNS: Columns = {
    "variant": ("controller", 1.0, ""),
    "winding.jerk": ("jerk, m/s^3", 1.0, "g"),
    "cycle_time": ("winding time, s", 1.0, ".2f"),
    "trajectory_time": ("reference, s", 1.0, ".2f"),
    "swing_left": ("swing left, mm", 1e3, ".2f"),
    "swing_right": ("swing right, mm", 1e3, ".2f"),
    "torque_rms": ("torque RMS, kN m", 1e-3, ".2f"),
    "torque_peak": ("peak, kN m", 1e-3, ".1f"),
    "tracking_error": ("tracking, mm", 1e3, ".0f"),
    "rope_force_ripple": ("rope force ripple, N", 1.0, ".1f"),
    "slip_safety": ("slip safety", 1.0, ".3f"),
}
CREEP_COLUMNS: Columns = {
    "variant": ("creep", 1.0, ""),
    "name": ("controller", 1.0, ""),
    "winding.jerk": ("jerk, m/s^3", 1.0, "g"),
    "cycle_time": ("winding time, s", 1.0, ".2f"),
    "added": ("of it by creep, s", 1.0, ".2f"),
    **{
        name: CONTROLLER_COLUMNS[name]
        for name in ("trajectory_time", "swing_left", "swing_right", "torque_rms", "rope_force_ripple", "slip_safety")
    },
}
TUNING_COLUMNS: Columns = {
    "gains": ("gains", 1.0, ""),
    "rope": ("rope", 1.0, ""),
    "gains.speed": ("speed, kN s/m", 1e-3, ".1f"),
    "gains.integral_time": ("integral time, s", 1.0, ".2f"),
    "gains.position": ("position, 1/s", 1.0, ".2f"),
    "cost": ("minimised, s", 1.0, ".3f"),
    **{
        name: CONTROLLER_COLUMNS[name]
        for name in ("cycle_time", "swing_left", "swing_right", "torque_rms", "torque_peak", "tracking_error")
    },
}
SWIVEL_COLUMNS: Columns = {
    "variant": ("swivels", 1.0, ""),
    "rope.installed_twist": ("installed twist, turns", 0.5 / np.pi, "g"),
    "left_starting_torque": ("starts to slip at, left, N m", 1.0, ".2f"),
    "right_starting_torque": ("right", 1.0, ".2f"),
    "left_slip": ("slip path, left, turns", 0.5 / np.pi, ".2f"),
    "right_slip": ("right", 0.5 / np.pi, ".2f"),
    "left_slip_time": ("slipping, left, s", 1.0, ".1f"),
    "right_slip_time": ("right", 1.0, ".1f"),
    "left_swivel_torque": ("largest torque, left, N m", 1.0, ".1f"),
    "right_swivel_torque": ("right", 1.0, ".1f"),
    "loop_yaw": ("largest yaw of the loop, deg", 180.0 / np.pi, ".1f"),
    "yaw_at_end": ("at the end", 180.0 / np.pi, ".1f"),
    "clearance": ("clearance, m", 1.0, ".3f"),
}


def controllers_page(tables: Tables) -> str:
    """docs/study_controllers.md."""
    draft, complete, creep, tuning, verified = (
        frame(tables[name]) for name in ("controllers", "controllers_complete", "creep", "tuning", "tuning_complete")
    )
    creep = with_differences(creep)
    data = {
        "winner": winner(complete),
        "draft_error": draft_error(draft, complete),
        "creep": creep_pays(creep),
        "tuning": tuning_pays(tuning, verified),
        "complete_head": heads(CONTROLLER_COLUMNS),
        "complete": cells(complete, CONTROLLER_COLUMNS),
        "draft_head": heads(CONTROLLER_COLUMNS),
        "draft": cells(draft, CONTROLLER_COLUMNS),
        "creep_head": heads(CREEP_COLUMNS),
        "creep_rows": cells(creep, CREEP_COLUMNS),
        "verified_head": heads(TUNING_COLUMNS),
        "verified": cells(verified, TUNING_COLUMNS),
    }
    return render("studies/study_controllers.md.j2", data)


def swivel_page(tables: Tables) -> str:
    """docs/study_swivel.md."""
    found = frame(tables["swivel"]).merge(frame(tables["swivel_yaw"]), on="key", validate="1:1")
    data = {"head": heads(SWIVEL_COLUMNS), "rows": cells(found, SWIVEL_COLUMNS), **let_out(found)}
    return render("studies/study_swivel.md.j2", data)


def let_out(found: pd.DataFrame) -> dict[str, Any]:
    """Of a rope with installed twist: pulls [kN] that are kept and let out, yaw [deg] to either side once it is out."""
    twisted = found[found["rope.installed_twist"] > 0].set_index("variant")
    free = twisted.drop(index=SEIZED)
    yaws = {name: np.degrees([free[f"{name}_yaw"].min(), free[f"{name}_yaw"].max()]) for name in ("least", "largest")}
    pulls = 1e-3 * twisted["rope_force_peak"]
    return {
        "pulls": (pulls[SEIZED], pulls.max()),
        "yaws": yaws,
        "clearances": (found.clearance.min(), found.clearance.max()),
    }


def metrics(tables: Tables) -> str:
    """The table of docs/reference/files.md: what a study can ask of a run; no data are needed."""
    return "\n".join(f"| `{name}` | {unit} | {text} |" for name, (unit, text) in METRICS.items())


def frame(t: Table) -> pd.DataFrame:
    """A study's table by the names of its columns, without their units."""
    return pd.DataFrame({name.split(" [")[0]: column for name, column in t.items()})


def heads(columns: Columns) -> list[str]:
    """Of a table on the page."""
    return [head for head, _, _ in columns.values()]


def cells(t: pd.DataFrame, columns: Columns) -> list[list[str]]:
    """The table in the units of its heads; - where there is no number."""
    return [
        [_cell(row[name], factor, form) for name, (_, factor, form) in columns.items()] for row in t.to_dict("records")
    ]


def _cell(value: Any, factor: float, form: str) -> str:
    if not form:
        return str(value)
    return "-" if math.isnan(value) else number(factor * value, form)


def winner(table: pd.DataFrame) -> dict[str, Any]:
    """Who is first on the complete rope, by how much, and who is gentlest with the same limit of jerk."""
    ranked = table.sort_values("cycle_time")
    first = ranked.iloc[0]
    gentle = table.loc[table.loc[table["winding.jerk"] == first["winding.jerk"], "rope_force_ripple"].idxmin()]
    rest = [{"variant": row.variant, "behind": row.cycle_time - first.cycle_time} for row in ranked[1:].itertuples()]
    torques = 1e-3 * table.torque_rms.min(), 1e-3 * table.torque_rms.max()
    return {"first": _numbers(first), "others": rest, "torques": torques, "gentle": _numbers(gentle)}


def _numbers(row: pd.Series) -> dict[str, Any]:
    """Winding time [s], swing [mm], ripple [N] and slip safety [1] of a run."""
    return {
        "variant": row["variant"],
        "time": row["cycle_time"],
        "swing": 1e3 * row["swing_right"],
        "ripple": row["rope_force_ripple"],
        "safety": row["slip_safety"],
    }


def draft_error(draft: pd.DataFrame, complete: pd.DataFrame) -> dict[str, Any]:
    """How far the draft rope is from the complete one in the windings that both have: time [s] and swing [mm]."""
    # variants of the complete study append the jerk to the name, or name one of the shapers
    complete = complete.assign(variant=complete["variant"].str.replace(r", jerk \d+$", "", regex=True))
    both = draft.merge(complete, on=["variant", "winding.jerk"], suffixes=("", "_complete"))
    assert len(both) == len(complete)
    time, swing = (
        max((both[n] - both[f"{n}_complete"]).abs().max() for n in names)
        for names in (("cycle_time",), ("swing_left", "swing_right"))
    )
    return {"time": _at_most(time), "swing": _at_most(1e3 * swing), "count": len(both)}


def _at_most(value: float) -> str:
    """Rounded up to hundredths, by which the times of a winding are recorded."""
    return f"{max(1, math.ceil(100.0 * value - 1e-6)) / 100.0:.2f}"


def with_differences(creep: pd.DataFrame) -> pd.DataFrame:
    """The creep study with each run's winding time over that without creep, `added` [s], and such ratios [1]."""
    base = creep[creep["variant"] == NO_CREEP].set_index(["controller", "winding.jerk"])
    same = base.loc[list(zip(creep["controller"], creep["winding.jerk"], strict=True))]
    ratios = {
        f"{name}_ratio": creep[name].to_numpy() / same[name].to_numpy()
        for name in ("swing_right", "rope_force_ripple", "torque_rms")
    }
    named = creep["controller"].map(NAMES)
    return creep.assign(added=creep["cycle_time"].to_numpy() - same["cycle_time"].to_numpy(), name=named, **ratios)


def creep_pays(creep: pd.DataFrame) -> dict[str, Any]:
    """What creep costs and what it brings, over all of its runs."""
    creeping = creep[creep["variant"] != NO_CREEP]
    plain = creep[creep["variant"] == NO_CREEP]
    fastest = [rows.loc[rows["cycle_time"].idxmin()] for _, rows in creeping.groupby("variant", sort=False)]
    names = ("added", "swing_right_ratio", "rope_force_ripple_ratio", "torque_rms_ratio")
    return {
        **{name: (creeping[name].min(), creeping[name].max()) for name in names},
        "quieter": int((creeping["swing_right_ratio"] < 1.0).sum()),
        "count": len(creeping),
        "without": _fast(plain.loc[plain["cycle_time"].idxmin()]),
        "fastest": [_fast(row) for row in fastest],
    }


def _fast(row: pd.Series) -> dict[str, Any]:
    """Who winds with which limit of jerk [m/s^3], in which time [s] and with which swing [mm]."""
    return {
        "variant": row["variant"],
        "name": row["name"],
        "jerk": row["winding.jerk"],
        "time": row["cycle_time"],
        "swing": 1e3 * row["swing_right"],
    }


def tuning_pays(tuning: pd.DataFrame, verified: pd.DataFrame) -> dict[str, Any]:
    """What the search has won on the complete rope: times [s] and swings [mm]."""
    times, swings = tuning["cycle_time"], 1e3 * tuning["swing_right"]
    complete = verified[verified["rope"] == "complete"].set_index("gains")
    ours = {
        gains: {"time": complete["cycle_time"][gains], "swing": 1e3 * complete["swing_right"][gains]}
        for gains in ("tuned", "default")
    }
    return {
        "count": len(tuning),
        "times": (times.min(), times.max()),
        "swings": (swings.min(), swings.max()),
        **ours,
    }
