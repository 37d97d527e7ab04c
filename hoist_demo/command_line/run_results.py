"""Summary and files of a run of `balance-rope wind`."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.exposure import exposure, spectra_table
from hoist_demo.recording.fidelity import fidelities_of, without_remarked
from hoist_demo.recording.nearness import Pair
from hoist_demo.recording.passages import without_told
from hoist_demo.recording.ropes import of_rope
from hoist_demo.recording.time_series import Recording, shape_rows, write_csv, write_shapes
from hoist_demo.report.html.page import Row, unit_text
from hoist_demo.report.html.parameter_tables import Table, rope_tables, tables, word
from hoist_demo.report.rows import Report, told
from hoist_demo.report.summary import exposure_rows, summarize
from hoist_demo.report.verdict import judge
from hoist_demo.study.provenance import Known, of_host, statuses, write_data
from hoist_demo.study.run import RunData, build

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
    """A run that was wound, and what is known of it."""

    title: str
    run: RunData
    result: Result
    ropes: Sequence[RopeData]
    pairs: Sequence[Pair]  # of ropes
    known: Sequence[Known]
    said: Sequence[str]  # warnings of host and rope
    asked: Collection[str]  # names of the values that were set

    def own(self, rope: RopeData) -> Recording:
        """Return the record of a rope."""
        return of_rope(self.result.recording, rope.name)

    @cached_property
    def exposed(self) -> dict[str, Recording]:
        """Return the load history of each place, by the ropes' names."""
        found = {rope.name: exposure(self.own(rope), rope.parameters) for rope in self.ropes}
        return {name: table for name, table in found.items() if table is not None}

    @cached_property
    def report(self) -> Report:
        """What the reports say."""
        run, status, said = self.run, statuses(self.known), without_told(self.said)
        for rope in self.ropes:
            said = without_remarked(said, self.own(rope))
        names = [rope.name for rope in self.ropes]
        rows = summarize(self.result, run.hoist, run.winding, run.coupling, names, run.arrival)
        rows += (*(row for exposed in self.exposed.items() for row in exposure_rows(*exposed)), *told(self.known))
        parts = {"Hoist": run.hoist, "Winding": run.winding, "Coupling": run.coupling, "Gains": run.gains}
        given = tables(parts, status)
        for rope in self.ropes:
            given += rope_tables(rope, fidelities_of(self.own(rope)), status)
        verdict = judge(self.result, run.hoist, self.ropes, said, self.pairs, run.arrival)
        return Report(self.title, verdict, self._changed(), rows, given)

    def _changed(self) -> Table:
        case, own = find_case(self.run.case), build(self.run.case, {})
        before = {**{one.name: one.value for one in of_host(own, {})}, **own.fmu}
        values = dict[str, Value]()
        for rope in self.ropes:
            values |= {f"{rope.prefix}{key}": value for key, value in rope.parameters.items()}
        for tail in case.ropes:
            before |= {f"{tail.name}.{key}": value for key, value in tail.parameters.items()}
        rows: list[Row] = [
            (one.name, word(one.value), unit_text(one.unit), word(before.get(one.name, "the default")))
            for one in self.known
            if {one.name, one.name.partition(".")[2]} & {*self.asked}
            and values.get(one.name, one.value) != before.get(one.name)
        ]
        return f"Settings that differ from the case {self.run.case}", rows


def missing_outputs(units: Mapping[str, str]) -> str:
    """Return the parts of the reports that a rope with these outputs leaves out; "" for none."""
    groups = [group for group in _DRAWN if not any(name.startswith(group) for name in units)]
    if not groups:
        return ""
    outputs, lacking = ", ".join(f"{group}*" for group in groups), ", no ".join(_DRAWN[group] for group in groups)
    return (
        f"the FMU was exported without the outputs {outputs}, so the report has no {lacking}; "
        "`balance-rope export --outputs all` has them"
    )


def write(wound: WoundRun, directory: Path, signals: Sequence[str]) -> list[Path]:
    """All files of a run, report.html last; a run that stopped before its first row leaves the reports only.

    `signals` are the columns of signals.csv, none: the usual. Tables along one of several ropes begin with its name.
    """
    # matplotlib loads slowly and is needed here only
    from hoist_demo.report.figures import write_figures
    from hoist_demo.report.hoist import complete
    from hoist_demo.report.html.run import run_report
    from hoist_demo.report.markdown import render_markdown
    from hoist_demo.report.panels import marks

    result, hoist = wound.result, wound.run.hoist
    recording = result.recording
    data = write_data(wound.known, directory / "data.csv")
    written: list[Path] = []
    pictures: list[Path] = []

    def add(name: str, rope: RopeData) -> Path:
        written.append(directory / f"{rope.prefix}{name}")
        return written[-1]

    if recording.signals:
        written = [directory / "signals.csv"]
        write_csv(recording, written[0], signals)
        pictures = write_figures(recording, hoist, directory, marks(result), wound.ropes)
    for rope in wound.ropes if recording.signals else ():
        own = wound.own(rope)
        if own.shape_at(0) is not None:
            write_shapes(own, shape_rows(own), add("shapes.csv", rope))
        if rope.name in wound.exposed:
            write_csv(wound.exposed[rope.name], add("exposure.csv", rope))
            if (spectra := spectra_table(own))["frequency"].size:
                write_csv(spectra, add("spectra.csv", rope))
    hoist_file = directory / "hoist.toml"
    hoist_file.write_text(complete(find_case(wound.run.case), wound.run, wound.ropes, wound.known), encoding="utf-8")
    report = directory / "report.md"
    report.write_text(render_markdown(wound.report, pictures), encoding="utf-8")
    page = run_report(result, hoist, wound.report, directory / REPORT, wound.ropes)
    return [*written, data, hoist_file, *pictures, report, page]
