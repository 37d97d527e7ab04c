"""Summary and files of a run of `balance-rope demo`."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.recording.exposure import exposure, spectra_table
from hoist_demo.recording.fidelity import fidelities_of, without_remarked
from hoist_demo.recording.passages import without_told
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
    "station.": "exposure.png",
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
    rope: RopeData
    level: str  # of the rope, "" for none
    known: Sequence[Known]
    said: Sequence[str]  # warnings of host and rope
    asked: Collection[str]  # names of the values that were set

    @cached_property
    def exposed(self) -> Recording | None:
        """Return the load history of each place in the rope."""
        return exposure(self.result.recording, self.rope.parameters)

    @cached_property
    def report(self) -> Report:
        """What the reports say."""
        run, recording, status = self.run, self.result.recording, statuses(self.known)
        said = without_told(without_remarked(self.said, recording))
        rows = summarize(self.result, run.hoist, run.winding, run.coupling)
        rows += (*(exposure_rows(self.exposed) if self.exposed else ()), *told(self.known))
        host = {"Hoist": run.hoist, "Winding": run.winding, "Coupling": run.coupling, "Gains": run.gains}
        given = [*tables(host, status), *rope_tables(self.rope, self.level, fidelities_of(recording), status)]
        return Report(self.title, judge(self.result, run.hoist, self.rope, *said), self._changed(), rows, given)

    def _changed(self) -> Table:
        own = build(self.run.case, {})
        before = {**{one.name: one.value for one in of_host(own, {})}, **own.fmu}
        rows: list[Row] = [
            (one.name, word(one.value), unit_text(one.unit), word(before.get(one.name, "rope's default")))
            for one in self.known
            if one.name in self.asked and self.rope.parameters.get(one.name, one.value) != before.get(one.name)
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

    `signals` are the columns of signals.csv, none: the usual.
    """
    # matplotlib loads slowly and is needed here only
    from hoist_demo.report.figures import write_exposure_figure, write_figures
    from hoist_demo.report.html.run import run_report
    from hoist_demo.report.markdown import render_markdown
    from hoist_demo.report.panels import marks

    result, rope, hoist = wound.result, wound.rope, wound.run.hoist
    recording = result.recording
    data = write_data(wound.known, directory / "data.csv")
    written: list[Path] = []
    pictures: list[Path] = []
    exposures: dict[str, Path] = {}
    if recording.signals:
        written = [directory / "signals.csv"]
        write_csv(recording, written[0], signals)
        if recording.shape_at(0) is not None:
            written.append(directory / "shapes.csv")
            write_shapes(recording, shape_rows(recording), written[1])
        pictures = write_figures(recording, hoist, directory, marks(result))
    if (exposed := wound.exposed) is not None:
        written.append(directory / "exposure.csv")
        write_csv(exposed, written[-1])
        picture = write_exposure_figure(exposed, directory / "exposure.png")
        exposures = {"What each place in the rope went through": picture}
        if (spectra := spectra_table(recording))["frequency"].size:
            written.append(directory / "spectra.csv")
            write_csv(spectra, written[-1])
        pictures += exposures.values()
    report = directory / "report.md"
    report.write_text(render_markdown(wound.report, pictures), encoding="utf-8")
    page = run_report(result, hoist, wound.report, directory / REPORT, rope, exposures)
    return [*written, data, *pictures, report, page]
