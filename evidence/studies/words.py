"""What the worked study of the drive's controllers says with numbers: sentences, tables and a figure from its results.

`evidence.studies` puts them into docs/study_controllers.md. Words that are not here carry no measured number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from hoist_demo.control.controller import Gains
from hoist_demo.study.definition import read_study
from hoist_demo.study.run import execute

NAMES = {"pi": "PI", "pi-feed-forward": "PI with feed-forward", "input-shaping": "input shaping, ZVD"}
COLOURS = dict(zip(NAMES, ("#b03a2e", "#d9731a", "#2f8f5b"), strict=True))
NO_CREEP = "none"


def winner(table: pd.DataFrame) -> str:
    """Who is first on the complete rope, by how much, and who is gentlest with the same limit of jerk."""
    ranked = table.sort_values("cycle_time")
    first = ranked.iloc[0]
    gentle = table.loc[table.loc[table["winding.jerk"] == first["winding.jerk"], "rope_force_ripple"].idxmin()]
    behind = ", ".join(f"{row.cycle_time - first.cycle_time:.2f} s ({row.variant})" for row in ranked[1:].itertuples())
    return (
        f"First is: **{first.variant}**, {first.cycle_time:.2f} s with {1e3 * first.swing_right:.1f} mm of swing on "
        f"the complete rope. The others need more: {behind}. The torque's RMS does not tell them apart, "
        f"{1e-3 * table.torque_rms.min():.1f} to {1e-3 * table.torque_rms.max():.1f} kN m, because holding 5 t takes "
        f"most of it.\n\nGentlest with the same limit of jerk is: **{gentle.variant}**. The rope's force ripples by "
        f"{gentle.rope_force_ripple:.0f} N with it, by {first.rope_force_ripple:.0f} N with the first; the slip safety "
        f"is {gentle.slip_safety:.2f} and {first.slip_safety:.2f}."
    )


def draft_error(draft: pd.DataFrame, complete: pd.DataFrame) -> str:
    """How far the draft rope is from the complete one in the windings that both have."""
    # variants of the complete study append the jerk to the name, or name one of the shapers
    complete = complete.assign(variant=complete["variant"].str.replace(r", jerk \d+$", "", regex=True))
    both = draft.merge(complete, on=["variant", "winding.jerk"], suffixes=("", "_complete"))
    assert len(both) == len(complete)
    time, swing = (
        max((both[n] - both[f"{n}_complete"]).abs().max() for n in names)
        for names in (("cycle_time",), ("swing_left", "swing_right"))
    )
    return (
        f"Draft rope ([chart.md](chart.md)): its winding times are within {_at_most(time)} s and its swing within "
        f"{_at_most(1e3 * swing)} mm of those of the complete rope in the {len(both)} windings above."
    )


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


def creep_pays(creep: pd.DataFrame) -> str:
    """What creep costs and what it brings, over all of its runs."""
    creeping = creep[creep["variant"] != NO_CREEP]
    plain = creep[creep["variant"] == NO_CREEP]
    without = plain.loc[plain["cycle_time"].idxmin()]
    fastest = [rows.loc[rows["cycle_time"].idxmin()] for _, rows in creeping.groupby("variant", sort=False)]
    per_creep = "; ".join(
        f"{row['variant']}: {row['name']}, jerk {row['winding.jerk']:g}, {row['cycle_time']:.2f} s with "
        f"{1e3 * row['swing_right']:.2f} mm"
        for row in fastest
    )
    quiet = creeping[creeping["swing_right_ratio"] < 1.0]
    span = {
        name: f"{creeping[name].min():.2f} to {creeping[name].max():.2f}"
        for name in ("added", "swing_right_ratio", "rope_force_ripple_ratio", "torque_rms_ratio")
    }
    return (
        f"A creep adds {span['added']} s to the winding time of the same controller with the same jerk. The right "
        f"conveyance's swing becomes {span['swing_right_ratio']} times that without creep, smaller in {len(quiet)} of "
        f"{len(creeping)} windings; the rope's force ripple {span['rope_force_ripple_ratio']} times, the torque's "
        f"RMS {span['torque_rms_ratio']} times.\n\nThe fastest "
        f"without creep: {without['name']}, jerk {without['winding.jerk']:g} m/s^3, {without['cycle_time']:.2f} s with "
        f"{1e3 * without['swing_right']:.2f} mm. The fastest with it: {per_creep}."
    )


def creep_figure(creep: pd.DataFrame) -> Figure:
    """Winding time, swing and ripple over the creeps, a line per controller and jerk."""
    figure, axes = plt.subplots(1, 3, figsize=(9.0, 3.6), layout="constrained")
    for (controller, jerk), rows in creep.groupby(["controller", "winding.jerk"], sort=False):
        style = {"color": COLOURS[controller], "ls": "-" if jerk > 2.0 else "--", "marker": "o", "ms": 4}
        axes[0].plot(rows["variant"], rows["cycle_time"], **style, label=f"{NAMES[controller]}, {jerk:g} m/s$^3$")
        axes[1].semilogy(rows["variant"], 1e3 * rows["swing_right"], **style)
        axes[2].plot(rows["variant"], rows["rope_force_ripple"], **style)
    axes[0].set_ylabel("winding time [s]")
    axes[1].set_ylabel("swing after arrival, right [mm]")
    axes[2].set_ylabel("rope force ripple [N]")
    for axis in axes:
        axis.tick_params(axis="x", rotation=35)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", frameon=False, fontsize=8, ncols=3)
    return figure


def verify(tuning: pd.DataFrame, file: Path, fmu: Path) -> pd.DataFrame:
    """The best run of a search's table, and its gains and the default ones on another rope, with their `cost` [s]."""
    study = read_study(file, fmu)
    assert study.tuning is not None
    weights, variant = study.tuning.minimise, next(iter(study.variants))
    best = tuning.loc[_cost(tuning, weights).idxmin()]
    rows = [{"gains": "tuned", "rope": "draft", **best}]
    for label, gains in (
        ("tuned", {name: float(best[name]) for name in study.ranges}),
        ("default", {name: getattr(Gains(), name.partition(".")[2]) for name in study.ranges}),
    ):
        outcome = execute(study.sample(variant, gains).data, fmu)
        if outcome.status != "completed":
            raise RuntimeError(f"{label} gains on {fmu}: {outcome.cause}")
        rows.append({"gains": label, "rope": "complete", **gains, **outcome.metrics})
    table = pd.DataFrame(rows)
    return table.assign(cost=_cost(table, weights))


def _cost(table: pd.DataFrame, weights: Mapping[str, float]) -> pd.Series:
    return table[list(weights)].mul(pd.Series(weights)).sum(axis=1, skipna=False)


def tuning_pays(tuning: pd.DataFrame, verified: pd.DataFrame) -> str:
    """What the search has won on the complete rope."""
    times, swings = tuning["cycle_time"], 1e3 * tuning["swing_right"]
    complete = verified[verified["rope"] == "complete"].set_index("gains")
    tuned, default = (
        f"{complete['cycle_time'][gains]:.2f} s with {1e3 * complete['swing_right'][gains]:.2f} mm"
        for gains in ("tuned", "default")
    )
    return (
        f"{len(tuning)} windings, with times of {times.min():.2f} to {times.max():.2f} s and a swing of "
        f"{swings.min():.2f} to {swings.max():.2f} mm. On the complete rope the best gains take {tuned}, the default "
        f"ones {default}."
    )
