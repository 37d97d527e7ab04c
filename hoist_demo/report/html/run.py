"""The report of a run: its rope in motion over linked time plots, its numbers and its data, in one file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Hoist
from hoist_demo.recording.incidents import guard_trip
from hoist_demo.recording.passages import FAR
from hoist_demo.recording.time_series import ALONG_ROPE, TIME, Array, Recording
from hoist_demo.report import panels
from hoist_demo.report.html import packing, page, parameter_tables
from hoist_demo.report.html.packing import along
from hoist_demo.report.rows import CHANGED, Report
from hoist_demo.report.verdict import COLUMNS, Verdict
from rope_model.texts import html_text

MOST_TIMES = 2000  #: Points of a time plot: twice what a laptop's screen resolves; peaks are kept.

MOST_FRAMES = 600  #: Positions of the rope; the browser interpolates between them.

NONE_KNOWN = RopeData({}, {}, {})  #: A rope of which nothing is known.

NO_PICTURES: Mapping[str, Path] = {}

SHAPE_RESOLUTION = 1e-4  #: Error that packing may bring into a point of the rope [m].


def run_report(
    result: Result,
    hoist: Hoist,
    report: Report,
    path: Path,
    rope: RopeData = NONE_KNOWN,
    pictures: Mapping[str, Path] = NO_PICTURES,
) -> Path:
    """Write the report of a run to `path`: verdict, pictures, and the rest.

    `rope` has the shaft that is drawn; `pictures` are PNG files by what they show.
    Same run, same bytes but the clock's.
    """
    numbers = "".join(
        page.table(group, [(row.quantity, row.text, page.unit_text(row.unit)) for row in found])
        for group in dict.fromkeys(row.group for row in report.rows)
        for found in ([row for row in report.rows if row.group == group],)
    )
    body = page.fill(
        "run.html",
        numbers=numbers,
        pictures="".join(page.picture(*item) for item in pictures.items()),
        given="".join(page.table(*table) for table in report.given),
    )
    data = _data(result, hoist, rope.locked)
    data |= {"shaft": drawn_shaft(rope.parameters, result.recording), "open": report.verdict.when}
    scripts = page.running(("player.js", "plots.js", "rope.js", "shaft.js", "run.js"), data)
    return page.write(path, page.render("run", report.title, body, _verdict(report.verdict, report.changed), scripts))


_NO = '<td class="tripped">NO</td>'


def _verdict(verdict: Verdict, changed: parameter_tables.Table) -> str:
    kind = "note good" if verdict.good else "note stopped"
    parts = [f'<p class="{kind}"><strong>{html_text(verdict.words)}</strong></p>']
    if verdict.rows:
        rows = page.grid(COLUMNS, [row.cells for row in verdict.rows])
        parts.append(f'<div class="scroll">{rows.replace("<td>NO</td>", _NO)}</div>')
    parts += [f'<p class="note stopped"><strong>Warning.</strong> {html_text(text)}</p>' for text in verdict.remarks]
    if changed[1]:
        parts.append(
            f"<details open><summary>{html_text(changed[0])}</summary>{page.grid(CHANGED, changed[1])}</details>"
        )
    return "".join(parts)


def _data(result: Result, hoist: Hoist, locked: Collection[str]) -> dict[str, object]:
    """All that the scripts read; a run without a recorded row leaves the numbers of its end only."""
    recording = result.recording
    if not recording.signals:
        return {"time": None}
    start, extra = float(recording.time[0]), panels.derived_signals(recording, hoist)
    known = [name for name, values in recording.signals.items() if bool(np.isfinite(values).any())]
    names = [name for name in known if name != TIME and not name.startswith(ALONG_ROPE)]
    signals = {name: _signal(recording[name], recording.units.get(name, "")) for name in names}
    signals |= {name: _signal(values, unit) for name, (values, unit) in extra.items()}
    shown = panels.panels(recording, hoist)
    return {
        "time": packing.pack_to(packing.thin_times(recording.time, MOST_TIMES), 1e-4),
        # a run that stopped at once has one row, and an axis needs a length
        "span": [start, max(float(recording.time[-1]), start + 1e-3)],
        "signals": signals,
        "panels": [_panel(panel, recording) for panel in shown],
        "marks": [{"t": mark.t, "label": mark.label} for mark in panels.marks(result)],
        "transformations": panels.transformations(recording),
        "slips": {end: panels.slips(recording, end) for end in ("left", "right")},
        "swivels": {end: f"{end}.swivel.slipping" in names for end in ("left", "right")},
        "locked": list(locked),
        "sheave": {"height": hoist.sheave_height, "radius": hoist.sheave_radius},
        **_curve(recording),
    }


def _signal(values: Array, unit: str) -> dict[str, object]:
    return {"unit": page.unit_text(unit), "values": packing.pack(packing.thin(values, MOST_TIMES))}


def _panel(panel: panels.Panel, recording: Recording) -> dict[str, object]:
    lines = [
        {
            "signal": line.signal,
            "label": line.label,
            "style": line.style,
            "factor": line.factor,
            "rise": line.from_start,
        }
        for line in panel.lines
    ]
    return {
        "group": panel.group,
        "title": panel.title,
        "unit": panel.unit,
        "lines": lines,
        "least": panel.least,
        "limit": None if panel.limit is None else {"value": panel.limit[0], "label": panel.limit[1]},
        "quiet": panels.quiet(recording, panel),
    }


def _curve(recording: Recording) -> Mapping[str, object]:
    """The rope's curve at its frames, and what is known along it; both null when no curve was recorded."""
    rows = packing.frames(len(recording.time), MOST_FRAMES)
    shapes = [recording.shape_at(row) for row in rows]
    curves = np.array([shape for shape in shapes if shape is not None])
    if curves.size == 0 or not bool(np.all(np.isfinite(curves))):
        return {"rope": None, "along": None}
    rope = {
        "points": curves.shape[1],
        "t": packing.pack_to(recording.time[rows], 1e-4),
        **{axis: packing.pack_to(curves[:, :, k], SHAPE_RESOLUTION) for k, axis in enumerate("xyz")},
    }
    return {"rope": rope, "along": along(recording)}


Drawn = Mapping[str, object]

_GROUPS = {
    "lining": ("width", "depth", "rounding", "x", "z"),
    "conveyance": ("width", "depth", "height", "above"),
    "head_ropes": ("diameter", "row"),
    "guard": ("rise", "rise_y", "window", "window_y"),
}
_DIVIDER = ("size", "y", "offset", "direction", "rounding")


def drawn_shaft(parameters: Mapping[str, object], recording: Recording) -> Drawn:
    """Sizes by part, from the rope's parameters by FMI name; what is not there has none, or the size 0."""
    values = {name: float(x) for name, x in parameters.items() if isinstance(x, int | float)}

    def part(group: str, names: tuple[str, ...]) -> dict[str, float]:
        return {name: values.get(f"{group}.{name}", 0.0) for name in names}

    level = values.get("sump.level", -FAR)
    dividers = [part(f"divider_{k}", _DIVIDER) for k in (1, 2, 3, 4)]
    trip = guard_trip(recording)
    return {
        **{group: part(group, names) for group, names in _GROUPS.items()},
        "dividers": [divider for divider in dividers if divider["size"] > 0.0],
        "floor": level if level > -FAR else None,
        "far": FAR,
        "trip": None if trip is None else {"t": trip.t, "cause": trip.cause},
    }
