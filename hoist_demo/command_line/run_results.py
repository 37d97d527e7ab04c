"""Summary and files of a run of ``balance-rope wind``."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.exposure import exposure, spectra_table
from hoist_demo.recording.fidelity import drop_duplicates_of_remark, fidelities_of
from hoist_demo.recording.nearness import RopePair
from hoist_demo.recording.passages import without_passages
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Recording, shape_rows, write_csv, write_shapes
from hoist_demo.report.formatting import Row, unit_text
from hoist_demo.report.parameter_tables import TitledRows, parameter_tables, rope_tables, word
from hoist_demo.report.rows import Report, status_rows
from hoist_demo.report.summary import exposure_rows, summarize
from hoist_demo.report.verdict import judge
from hoist_demo.run.data import RunData, build
from hoist_demo.run.provenance import SourcedValue, host_provenance, statuses, write_data
from rope_model.files import write_text

#: Outputs that an FMU may have been exported without, and what the reports then lack.
_DRAWN = {
    "shape.": "3-D rope, shapes.png and stress along the rope",
    "station.": "exposure.csv",
    "loop.": "loop.png",
    "stress.": "largest stresses",
    "energy.": "energies of the rope",
    "left.swivel.": "swivels.png",
}

REPORT = "report.html"  #: Page of a run, in its folder.


@dataclass(frozen=True)
class WoundRun:
    """Run that was wound, with the provenance of its data."""

    title: str
    run: RunData
    result: Result
    ropes: Sequence[RopeData]
    pairs: Sequence[RopePair]
    provenance: Sequence[SourcedValue]
    warnings: Sequence[str]  # from host and rope
    set_names: Collection[str]  # names of the values that were set

    def recording_of(self, rope: RopeData) -> Recording:
        """Return the record of a rope."""
        return rope_signals(self.result.recording, rope.name)

    @cached_property
    def exposures(self) -> dict[str, Recording]:
        """Load history of each place in the ropes that have stations, by the ropes' names."""
        tables: dict[str, Recording] = {}
        for rope in self.ropes:
            table = exposure(self.recording_of(rope), rope.parameters)
            if table is not None:
                tables[rope.name] = table
        return tables


def report_of(wound: WoundRun) -> Report:
    """Return the content of the reports: verdict, summary, changed settings and data."""
    run = wound.run
    result = wound.result
    status = statuses(wound.provenance)
    warnings = without_passages(wound.warnings)
    for rope in wound.ropes:
        warnings = drop_duplicates_of_remark(warnings, wound.recording_of(rope))
    names = [rope.name for rope in wound.ropes]
    rows = list(summarize(result, run.hoist, run.winding, run.coupling, names, run.arrival))
    for name, table in wound.exposures.items():
        rows += exposure_rows(name, table)
    rows += status_rows(wound.provenance)
    parts = {
        "Hoist": run.hoist,
        "Winding": run.winding,
        "Coupling": run.coupling,
        "Gains": run.gains,
    }
    data_tables = parameter_tables(parts, status)
    for rope in wound.ropes:
        data_tables += rope_tables(rope, fidelities_of(wound.recording_of(rope)), status)
    verdict = judge(result, run.hoist, wound.ropes, warnings, wound.pairs, run.arrival)
    return Report(wound.title, verdict, _changed(wound), rows, data_tables)


def _changed(wound: WoundRun) -> TitledRows:
    """Return the values that were set and differ from the hoist's own."""
    case = wound.run.case
    unchanged = build(case, {})
    before = {row.name: row.value for row in host_provenance(unchanged, {})}
    before |= unchanged.rope_values
    for data in find_case(case).distinct_ropes:
        before |= {f"{data.name}.{key}": value for key, value in data.parameters.items()}
    values: dict[str, Value] = {}
    for rope in wound.ropes:
        values |= {f"{rope.prefix}{key}": value for key, value in rope.parameters.items()}
    rows: list[Row] = []
    for one in wound.provenance:
        is_set = one.name in wound.set_names or one.name.partition(".")[2] in wound.set_names
        if is_set and values.get(one.name, one.value) != before.get(one.name):
            text_before = word(before.get(one.name, "the default"))
            rows.append((one.name, word(one.value), unit_text(one.unit), text_before))
    return f"Settings that differ from the case {case}", rows


def missing_outputs(units: Mapping[str, str]) -> str | None:
    """Return the parts of the reports that a rope with these outputs leaves out; None without any."""
    groups = [group for group in _DRAWN if not _has_group(units, group)]
    if not groups:
        return None
    outputs = ", ".join(f"{group}*" for group in groups)
    lacking = ", no ".join(_DRAWN[group] for group in groups)
    return (
        f"the FMU was exported without the outputs {outputs}, so the report has no {lacking}; "
        "`balance-rope export --outputs all` has them"
    )


def _has_group(names: Iterable[str], group: str) -> bool:
    return any(name.startswith(group) for name in names)


class WrittenTables(NamedTuple):
    """Files of a run beside its reports."""

    paths: list[Path]
    pictures: list[Path]


def write_tables(wound: WoundRun, directory: Path, signals: Sequence[str]) -> WrittenTables:
    """Write tables and figures of a run, and its hoist's file; without a row no signals.

    ``signals`` are the columns of signals.csv, none: the usual. Tables along one of several ropes
    begin with its name.
    """
    from hoist_demo.report.figures import write_figures
    from hoist_demo.report.panels import marks
    from hoist_demo.run.complete_file import complete_file

    result = wound.result
    recording = result.recording
    written: list[Path] = []
    pictures: list[Path] = []

    def add(name: str, rope: RopeData) -> Path:
        written.append(directory / f"{rope.prefix}{name}")
        return written[-1]

    if recording.signals:
        written = [directory / "signals.csv"]
        write_csv(recording, written[0], signals)
        pictures = write_figures(recording, wound.run.hoist, directory, marks(result), wound.ropes)
        for rope in wound.ropes:
            of_rope = wound.recording_of(rope)
            if of_rope.shape_at(0) is not None:
                write_shapes(of_rope, shape_rows(of_rope), add("shapes.csv", rope))
            if rope.name in wound.exposures:
                write_csv(wound.exposures[rope.name], add("exposure.csv", rope))
                spectra = spectra_table(of_rope)
                if spectra["frequency"].size:
                    write_csv(spectra, add("spectra.csv", rope))
    written.append(write_data(wound.provenance, directory / "data.csv"))
    text = complete_file(find_case(wound.run.case), wound.run, wound.ropes, wound.provenance)
    written.append(directory / "hoist.toml")
    write_text(written[-1], text)
    return WrittenTables(written, pictures)


def write_reports(
    wound: WoundRun, report: Report, tables: WrittenTables, directory: Path
) -> list[Path]:
    """Write the report as Markdown and as a page; return their paths, report.html last."""
    from hoist_demo.report.html.run import run_report
    from hoist_demo.report.markdown import render_markdown

    markdown = directory / "report.md"
    write_text(markdown, render_markdown(report, tables.pictures))
    path = directory / REPORT
    return [markdown, run_report(wound.result, wound.run.hoist, report, path, wound.ropes)]
