"""The report of a run in one file: the rope in motion over linked plots, numbers, and data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import NO_DATA, RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.recording.incidents import guard_trip
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import TIME, Array, Recording, is_along
from hoist_demo.report import formatting, panels, parameter_tables
from hoist_demo.report.html import packing, page
from hoist_demo.report.html.packing import along
from hoist_demo.report.rows import CHANGED, Report, rows_by_group
from hoist_demo.report.verdict import Verdict
from hoist_demo.report.verdict_row import COLUMNS
from rope_model import FAR
from rope_model.texts import html_text

MAX_TIMES = 2000  #: Points of a time plot: twice what a laptop's screen resolves; peaks are kept.
MAX_FRAMES = 600  #: Positions of the rope; the browser interpolates between them.
SHAPE_RESOLUTION = 1e-4  #: Error that packing may bring into a point of the rope [m].
TIME_RESOLUTION = 1e-4  #: Error that packing may bring into an instant [s].


def run_report(
    result: Result, hoist: Hoist, report: Report, path: Path, ropes: Sequence[RopeData] = (NO_DATA,)
) -> Path:
    """Write the report of a run, the same bytes but the clock's.

    The shaft drawn is that of the first of ``ropes``.
    """
    numbers = ""
    for group, rows in rows_by_group(report.rows).items():
        cells: list[formatting.Row] = [
            (row.quantity, row.text, formatting.unit_text(row.unit)) for row in rows
        ]
        numbers += page.titled_table(group, cells)
    tables = "".join(page.titled_table(title, rows) for title, rows in report.data_tables)
    body = page.fill("run.html", numbers=numbers, tables=tables)
    data = _data(result, hoist, ropes)
    data |= {
        "shaft": drawn_shaft(ropes[0].parameters, result.recording),
        "open": report.verdict.when,
    }
    scripts = page.running(("player.js", "plots.js", "rope.js", "shaft.js", "run.js"), data)
    note = _verdict(report.verdict, report.changed)
    return page.write_html(path, page.render_page("run", report.title, body, note, scripts))


_NO = '<td class="tripped">NO</td>'


def _verdict(verdict: Verdict, changed: parameter_tables.TitledRows) -> str:
    kind = "note good" if verdict.good else "note stopped"
    parts = [f'<p class="{kind}"><strong>{html_text(verdict.summary)}</strong></p>']
    if verdict.rows:
        table = page.untitled_table(COLUMNS, [row.cells for row in verdict.rows])
        parts.append(f'<div class="scroll">{table.replace("<td>NO</td>", _NO)}</div>')
    parts += [
        f'<p class="note stopped"><strong>Warning.</strong> {html_text(text)}</p>'
        for text in verdict.remarks
    ]
    title, rows = changed
    if rows:
        table = page.untitled_table(CHANGED, rows)
        parts.append(f"<details open><summary>{html_text(title)}</summary>{table}</details>")
    return "".join(parts)


def _data(result: Result, hoist: Hoist, ropes: Sequence[RopeData]) -> dict[str, object]:
    """Return the data for the scripts; a run without a recorded row has no time."""
    recording = result.recording
    of_ropes = [rope.name for rope in ropes]
    if not recording.signals:
        return {"time": None}
    start = float(recording.time[0])
    extra = panels.derived_signals(recording, hoist)
    finite = [name for name, values in recording.signals.items() if bool(np.isfinite(values).any())]
    names = [name for name in finite if name != TIME and not is_along(name)]
    signals = {name: _signal(recording[name], recording.units.get(name, "")) for name in names}
    signals |= {name: _signal(values, unit) for name, (values, unit) in extra.items()}
    shown = panels.panels(recording, hoist, of_ropes)
    drawn = []
    for rope in ropes:
        rope_recording = rope_signals(recording, rope.name)
        if _has_curve(rope_recording):
            drawn.append((rope, rope_recording))
    return {
        "time": packing.pack_to(packing.thin_times(recording.time, MAX_TIMES), TIME_RESOLUTION),
        # a run that stopped at once has one row, and an axis needs a length
        "span": [start, max(float(recording.time[-1]), start + 1e-3)],
        "signals": signals,
        "panels": [
            asdict(panel) | {"quiet": panels.is_constant(recording, panel)} for panel in shown
        ],
        "marks": [asdict(mark) for mark in panels.marks(result)],
        "transformations": panels.transformations(recording, of_ropes),
        "slips": {end: panels.slips(recording, end, of_ropes) for end in SIDES},
        "swivels": {end: f"{end}.swivel.slipping" in names for end in SIDES},
        "locked": ropes[0].locked,
        "alike": hoist.tail_rope_number,
        "sheave": {"height": hoist.sheave_height, "radius": hoist.sheave_radius},
        "ropes": [_curve(rope_recording, rope) for rope, rope_recording in drawn],
        "along": [along(rope_recording, rope.name) for rope, rope_recording in drawn],
    }


def _signal(values: Array, unit: str) -> dict[str, object]:
    return {
        "unit": formatting.unit_text(unit),
        "values": packing.pack(packing.thin(values, MAX_TIMES)),
    }


def _has_curve(rope: Recording) -> bool:
    """Return True if the rope's curve was recorded and computed."""
    shapes = rope.shapes_at([0, -1])
    return shapes is not None and bool(np.isfinite(shapes).all())


def _curve(recording: Recording, rope: RopeData) -> Mapping[str, object]:
    """Return the rope's curve in the shaft at each frame, and the places of its ends."""
    rows = packing.frames(len(recording.time), MAX_FRAMES)
    shapes = recording.shapes_at(rows)
    assert shapes is not None
    curves = shapes + rope.suspension.origin
    return {
        "name": rope.name,
        "places": [rope.suspension.at(end) for end in SIDES],
        "points": curves.shape[1],
        "t": packing.pack_to(recording.time[rows], TIME_RESOLUTION),
        "x": packing.pack_to(curves[:, :, 0], SHAPE_RESOLUTION),
        "y": packing.pack_to(curves[:, :, 1], SHAPE_RESOLUTION),
        "z": packing.pack_to(curves[:, :, 2], SHAPE_RESOLUTION),
    }


Drawn = Mapping[str, object]

_GROUPS = {
    "lining": ("width", "depth", "rounding", "x", "z"),
    "conveyance": ("width", "depth", "height", "above"),
    "head_ropes": ("diameter", "row"),
    "guard": ("rise", "rise_y", "window", "window_y"),
}
_DIVIDER = ("size", "y", "offset", "direction", "rounding")


def drawn_shaft(parameters: Mapping[str, object], recording: Recording) -> Drawn:
    """Sizes by part, from the rope's parameters by FMI name.

    What is not there has none, or the size 0.
    """
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
