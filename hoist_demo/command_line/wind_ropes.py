"""Winding of several balance ropes: summary and files."""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hoist_demo.command_line.results import interruption, results_folder
from hoist_demo.cosimulation.progress import progress_bar
from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.recording.time_series import write_csv
from hoist_demo.report.rows import OUTCOME, WARNING, SummaryRow, for_people, render

if TYPE_CHECKING:
    from hoist_demo.cosimulation.run_state import Result
    from hoist_demo.ropes.definition import Ropes
    from hoist_demo.ropes.table import Neighbours

_SUMS = {
    "fy": ("largest pull", "N"),
    "mx": ("tilt about X", "N.m"),
    "my": ("moment about Y", "N.m"),
    "mz": ("tilt about Z", "N.m"),
}


def wind_ropes(options: argparse.Namespace, ropes: Ropes, given: Mapping[str, str]) -> int:
    """Wind several balance ropes in this process, and write their results; `given` is where set values come from."""
    # figures load slowly and are needed here only
    from hoist_demo.report.figures import write_ropes_figure
    from hoist_demo.report.rows import told
    from hoist_demo.ropes.table import COLUMNS, neighbours, row, without_neglected
    from hoist_demo.study.provenance import write_data
    from hoist_demo.study.run import wind

    if options.resume:
        raise ValueError(f"--resume {options.resume} is for a hoist with one rope: wind this one anew")
    if options.check:
        print(f"{options.hoist}: {len(ropes.ropes)} ropes, nothing wrong")
        return 0
    out = results_folder(options.out)
    group = ropes.group()
    with interruption() as interrupted, progress_bar() as bar:
        run = replace(ropes.run, hoist=ropes.hoist)
        result, _ = wind(run, group, lambda fraction, t: bar(fraction, t) and not interrupted())
    recording = result.recording
    if not recording.signals:
        print(f"balance-rope: stopped: {result.cause}", file=sys.stderr)
        return 1
    names, known = [rope.name for rope in ropes.ropes], ropes.provenance(given)
    with interruption(f"the run is over, its results are being written to {out}"):
        recording = without_neglected(recording, {rope.name: rope.torque_free for rope in ropes.ropes})
        result = replace(result, recording=recording)
        rows = {name: row(recording, name) for name in names}
        placed = [(rope.name, rope.place, rope.scene.rope.diameter) for rope in ropes.ropes]
        pairs = neighbours(recording, placed, group.accounts())
        header = ["rope", *(f"{name} [{unit}]" for name, (unit, _) in COLUMNS.items())]
        _write(out / "ropes.csv", header, ([name, *values.values()] for name, values in rows.items()))
        _write(out / "neighbours.csv", _NEIGHBOURS, (_pair(pair) for pair in pairs))
        write_csv(
            recording,
            out / "signals.csv",
            [name for name in recording.signals if ".shape." not in name and ".station." not in name],
        )
        write_ropes_figure(recording, names, out / "ropes.png")
        write_data(known, out / "data.csv")
    print(f"{ropes.case.name}: level {ropes.level}, {len(names)} ropes")
    print(render([*_summary(ropes, result, rows, pairs), *told(known)]))
    print(f"\n{ASSUMED_DATA}\n\nwritten: {out}/ropes.csv, neighbours.csv, signals.csv, data.csv, ropes.png")
    if result.completed:
        return 0
    print(f"balance-rope: stopped: {result.cause}", file=sys.stderr)
    return 130 if interrupted() else 1


_NEIGHBOURS = [
    *("one", "other", "clearance [m]", "time [s]", "x [m]", "y [m]", "z [m]"),
    *("largest force [N]", "force time [s]", "force x [m]", "force y [m]", "force z [m]"),
    *("dissipated [J]", "made by the steps [J]"),
]


def _pair(pair: Neighbours) -> list[object]:
    a = pair.account
    force = [""] * 7 if a is None else [a.peak, a.peak_t, *a.peak_place, a.dissipated, a.made]
    return [pair.one, pair.other, pair.nearest.clearance, pair.nearest.t, *pair.nearest.place, *force]


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([f"{x:.10g}" if isinstance(x, float) else x for x in row] for row in rows)


def _summary(
    ropes: Ropes, result: Result, rows: dict[str, dict[str, float]], pairs: Sequence[Neighbours]
) -> list[SummaryRow]:
    from hoist_demo.report.verdict import incidents, warnings
    from hoist_demo.ropes.table import COLUMNS, outcome, remarks, unbroken

    recording = result.recording
    ended = outcome(result.completed, recording, [*rows])
    told = [SummaryRow(OUTCOME, "status", ended + incidents(recording))]
    breaks = {rope.name: rope.breaks.t for rope in ropes.ropes if rope.breaks is not None and result.completed}
    warned = *warnings(result, ropes.hoist), *remarks(recording, [*rows]), *unbroken(recording, breaks)
    told += [SummaryRow(OUTCOME, WARNING, text) for text in warned]
    told += [
        SummaryRow(f"{name}, z = {rope.place.z:g} m", column, *for_people(rows[name][column], unit))
        for rope in ropes.ropes
        for name in [rope.name]
        for column, (unit, _) in COLUMNS.items()
        if math.isfinite(rows[name][column])
    ]
    for end in ("left", "right"):
        for name, (words, unit) in _SUMS.items():
            if math.isfinite(peak := float(np.max(np.abs(recording[f"{end}.{name}"])))):
                told.append(SummaryRow(f"All ropes on the {end} conveyance, about its centre", words, peak, unit))
    for pair in (one for one in pairs if math.isfinite(one.nearest.clearance)):
        near, (x, y, z) = pair.nearest, pair.nearest.place
        text = f"{near.clearance:.4g} m at t = {near.t:.4g} s, x = {x:.3g} m, y = {y:.4g} m, z = {z:.3g} m"
        text += ": they touch, and each went on as if alone" if near.clearance <= 0.0 and pair.account is None else ""
        told.append(SummaryRow("Smallest clearances between ropes", f"{pair.one}, {pair.other}", text))
    return told + [row for pair in pairs for row in _pressed(pair)]


def _pressed(pair: Neighbours) -> list[SummaryRow]:
    account = pair.account
    if account is None or account.peak == 0.0:
        return []
    subject, (x, y, z) = f"{pair.one} on {pair.other}", account.peak_place
    place = f"{account.peak:.4g} N at t = {account.peak_t:.4g} s, x = {x:.3g} m, y = {y:.4g} m, z = {z:.3g} m"
    return [
        SummaryRow(subject, "largest force", place),
        SummaryRow(subject, "dissipated", account.dissipated, "J"),
        SummaryRow(subject, "made by the steps, no physics", account.made, "J"),
        SummaryRow(subject, "law of contact missed by, of the force", account.missed, "1"),
    ]
