"""Tables, figures and data of the worked studies: ``python -m evidence.studies``.

Reads what `balance-rope study` has left in out/study, winds with the gains of the search on the complete rope, and
writes docs/images/study, docs/data/study and what stands between the markers of docs/study_controllers.md and
docs/study_swivel.md.
"""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from hoist_demo.parameters import Hoist
from hoist_demo.study.metrics import METRICS
from hoist_demo.study.store import Results, Store, read_results

from . import words

STUDIES, DOCS = Path("out") / "study", Path("docs")
IMAGES, DATA = DOCS / "images" / "study", DOCS / "data" / "study"
COLOURS = ("#b03a2e", "#d9731a", "#8e44ad", "#1f5fa8", "#2f8f5b")
NAMES = ("controllers", "controllers_complete", "swivel", "creep", "tuning")
COMPLETE = Path("build") / "standard.fmu"

CONTROLLER_COLUMNS = {
    "variant": ("controller", 1.0, "{}"),
    "winding.jerk": ("jerk, m/s^3", 1.0, "{:g}"),
    "cycle_time": ("winding time, s", 1.0, "{:.2f}"),
    "trajectory_time": ("reference, s", 1.0, "{:.2f}"),
    "swing_left": ("swing left, mm", 1e3, "{:.2f}"),
    "swing_right": ("swing right, mm", 1e3, "{:.2f}"),
    "torque_rms": ("torque RMS, kN m", 1e-3, "{:.2f}"),
    "torque_peak": ("peak, kN m", 1e-3, "{:.1f}"),
    "tracking_error": ("tracking, mm", 1e3, "{:.0f}"),
    "rope_force_ripple": ("rope force ripple, N", 1.0, "{:.1f}"),
    "slip_safety": ("slip safety", 1.0, "{:.3f}"),
}
CREEP_COLUMNS = {
    "variant": ("creep", 1.0, "{}"),
    "name": ("controller", 1.0, "{}"),
    "winding.jerk": ("jerk, m/s^3", 1.0, "{:g}"),
    "cycle_time": ("winding time, s", 1.0, "{:.2f}"),
    "added": ("of it by creep, s", 1.0, "{:.2f}"),
    **{
        name: CONTROLLER_COLUMNS[name]
        for name in ("trajectory_time", "swing_left", "swing_right", "torque_rms", "rope_force_ripple", "slip_safety")
    },
}
TUNING_COLUMNS = {
    "gains": ("gains", 1.0, "{}"),
    "rope": ("rope", 1.0, "{}"),
    "gains.speed": ("speed, kN s/m", 1e-3, "{:.1f}"),
    "gains.integral_time": ("integral time, s", 1.0, "{:.2f}"),
    "gains.position": ("position, 1/s", 1.0, "{:.2f}"),
    "cost": ("minimised, s", 1.0, "{:.3f}"),
    **{
        name: CONTROLLER_COLUMNS[name]
        for name in ("cycle_time", "swing_left", "swing_right", "torque_rms", "torque_peak", "tracking_error")
    },
}
SWIVEL_COLUMNS = {
    "variant": ("swivels", 1.0, "{}"),
    "rope.installed_twist": ("installed twist, turns", 0.5 / np.pi, "{:g}"),
    "left_starting_torque": ("starts to slip at, left, N m", 1.0, "{:.2f}"),
    "right_starting_torque": ("right", 1.0, "{:.2f}"),
    "left_slip": ("slip path, left, turns", 0.5 / np.pi, "{:.2f}"),
    "right_slip": ("right", 0.5 / np.pi, "{:.2f}"),
    "left_slip_time": ("slipping, left, s", 1.0, "{:.1f}"),
    "right_slip_time": ("right", 1.0, "{:.1f}"),
    "left_swivel_torque": ("largest torque, left, N m", 1.0, "{:.1f}"),
    "right_swivel_torque": ("right", 1.0, "{:.1f}"),
    "loop_yaw": ("largest yaw of the loop, deg", 180.0 / np.pi, "{:.1f}"),
    "yaw_at_end": ("at the end", 180.0 / np.pi, "{:.1f}"),
    "clearance": ("clearance, m", 1.0, "{:.3f}"),
}


def main() -> None:
    """Write everything; a study that has not been run stops with the command that runs it."""
    if not COMPLETE.is_file():
        raise SystemExit(f"{COMPLETE} is missing: run `balance-rope export --native --platform host --out {COMPLETE}`")
    for folder in (IMAGES, DATA):
        folder.mkdir(parents=True, exist_ok=True)
    stores, found = {}, {}
    for name in NAMES:
        table = STUDIES / name / "results.parquet"
        if not table.is_file():
            raise SystemExit(f"{table} is missing: run `balance-rope study docs/studies/{name}.toml` first")
        stores[name], found[name] = Store(table.parent), read_results(table)
        shutil.copyfile(table.with_suffix(".csv"), DATA / f"{name}.csv")
    with plt.rc_context({"font.size": 9, "axes.grid": True, "grid.color": "#e3e3e3", "savefig.dpi": 150}):
        controllers(found["controllers"])
        creep = words.with_differences(found["creep"].table)
        save(words.creep_figure(creep), "creep")
        arrivals(stores["controllers_complete"], found["controllers_complete"])
        swivels(stores["swivel"], found["swivel"])
    swivel = found["swivel"].table
    swivel["yaw_at_end"] = [float(stores["swivel"].signals(key)["loop.yaw"].iloc[-1]) for key in swivel["key"]]
    page = DOCS / "study_controllers.md"
    draft, complete, tuning = (found[name].table for name in ("controllers", "controllers_complete", "tuning"))
    verified = words.verify(tuning, DOCS / "studies" / "tuning.toml", COMPLETE)
    verified.to_csv(DATA / "tuning_complete.csv", index=False, float_format="%.9g", lineterminator="\n")
    insert(page, "winner", wrap(words.winner(complete)))
    insert(page, "controllers_complete", markdown(complete, CONTROLLER_COLUMNS))
    insert(page, "draft_error", wrap(words.draft_error(draft, complete)))
    insert(page, "controllers", markdown(draft, CONTROLLER_COLUMNS))
    insert(page, "creep_pays", wrap(words.creep_pays(creep)))
    insert(page, "creep", markdown(creep, CREEP_COLUMNS))
    insert(page, "tuning_pays", wrap(words.tuning_pays(tuning, verified)))
    insert(page, "tuning", markdown(verified, TUNING_COLUMNS))
    insert(
        DOCS / "study.md",
        "metrics",
        "\n".join(f"| `{name}` | {unit} | {text} |" for name, (unit, text) in METRICS.items()),
    )
    insert(DOCS / "study_swivel.md", "swivel", markdown(swivel, SWIVEL_COLUMNS))


def markdown(table: pd.DataFrame, columns: Mapping[str, tuple[str, float, str]]) -> str:
    """The table in the units of its heads."""
    lines = ["| " + " | ".join(head for head, _, _ in columns.values()) + " |", "|---" * len(columns) + "|"]
    for row in table.to_dict("records"):
        cells = [
            form.format(row[name] * factor if isinstance(row[name], float) else row[name])
            for name, (_, factor, form) in columns.items()
        ]
        lines.append("| " + " | ".join("-" if cell == "nan" else cell for cell in cells) + " |")
    return "\n".join(lines)


def wrap(text: str) -> str:
    """Paragraphs with lines as long as the page's own."""
    return "\n\n".join(textwrap.fill(paragraph, 118, break_on_hyphens=False) for paragraph in text.split("\n\n"))


def insert(page: Path, name: str, text: str) -> None:
    """Put the text between `<!-- name -->` and `<!-- /name -->`."""
    before = page.read_text(encoding="utf-8")
    new, found = re.subn(
        rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", lambda m: f"{m[1]}{text}\n{m[2]}", before, flags=re.S
    )
    if found != 1:
        raise ValueError(f"{page} has {found} places for {name}, it must have one: mark it with <!-- {name} -->")
    page.write_text(new, encoding="utf-8")


def controllers(results: Results) -> None:
    """Winding time and residual swing over jerk, per controller."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    for colour, (variant, rows) in zip(COLOURS, results.table.groupby("variant", sort=False), strict=False):
        axes[0].plot(rows["winding.jerk"], rows["cycle_time"], "o-", color=colour, label=variant)
        axes[1].semilogy(rows["winding.jerk"], 1e3 * rows["swing_right"], "o-", color=colour)
    axes[0].set(xlabel="limit of jerk [m/s$^3$]", ylabel="winding time [s]")
    axes[1].set(xlabel="limit of jerk [m/s$^3$]", ylabel="residual swing, right, peak to peak [mm]")
    axes[0].legend(frameon=False, fontsize=8)
    save(figure, "controllers")


def arrivals(store: Store, results: Results) -> None:
    """The right conveyance against the rope at the sheave, and the torque, about the arrival."""
    figure, axes = plt.subplots(2, 1, figsize=(9.0, 5.2), sharex=True, layout="constrained")
    radius = Hoist().sheave_radius
    for colour, row in zip(COLOURS, results.table.itertuples(), strict=False):
        series = store.signals(row.key)
        t = 0.01 * np.arange(len(series)) - 1.0  # s, from the end of the start delay
        swing = series["conveyance.right.y"] + radius * series["drive.angle"]
        axes[0].plot(t, 1e3 * (swing - swing.iloc[-1]), color=colour, label=row.variant)
        axes[1].plot(t, 1e-3 * series["drive.torque"], color=colour)
        axes[0].axvline(row.cycle_time, color=colour, lw=0.8, ls=":")
    axes[0].set(ylabel="right conveyance on its ropes [mm]", xlim=(20.5, 27.5), ylim=(-10.0, 9.0))
    axes[1].set(ylim=(30.0, 70.0), ylabel="motor torque [kN m]", xlabel="time since the start of the trip [s]")
    axes[0].legend(frameon=False, fontsize=8, ncols=2)
    save(figure, "arrival")


def swivels(store: Store, results: Results) -> None:
    """Torque and angle of the right swivel and yaw of the loop along the winding, without and with installed twist."""
    twists = results.table["rope.installed_twist"].unique()
    variants = list(results.table["variant"].unique())
    colours = dict(zip(variants, plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(variants))), strict=True))
    figure, axes = plt.subplots(3, len(twists), figsize=(9.0, 7.0), sharex=True, layout="constrained")
    for column, twist in enumerate(twists):
        axes[0, column].set_title(f"installed twist {twist / (2 * np.pi):.2g} turns", fontsize=9)
        for row in results.table[results.table["rope.installed_twist"] == twist].itertuples():
            series = store.signals(row.key)
            t = 0.01 * np.arange(len(series))
            axes[0, column].plot(t, series["right.swivel.torque"], color=colours[row.variant], lw=1, label=row.variant)
            axes[1, column].plot(t, series["right.swivel.angle"] / (2 * np.pi), color=colours[row.variant], lw=1)
            axes[2, column].plot(t, np.degrees(series["loop.yaw"]), color=colours[row.variant], lw=1)
        axes[2, column].set_xlabel("time [s]")
    for k, label in enumerate(("right swivel torque [N m]", "right swivel angle [turns]", "loop yaw [deg]")):
        axes[k, 0].set_ylabel(label)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(), loc="outside lower center", frameon=False, fontsize=8, ncols=4
    )
    save(figure, "swivel")


def save(figure: Any, name: str) -> None:
    """The figure without a date, so that the same data give the same bytes."""
    figure.savefig(IMAGES / f"{name}.png", metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
