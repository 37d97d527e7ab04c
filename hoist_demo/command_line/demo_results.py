"""Summary and files of a run of `balance-rope demo`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.recording.exposure import exposure, spectra_table
from hoist_demo.recording.fidelity import fidelities_of, without_remarked
from hoist_demo.recording.time_series import Recording, shape_rows, write_csv, write_shapes
from hoist_demo.report.rows import OUTCOME, WARNING, SummaryRow, told
from hoist_demo.report.summary import exposure_rows, summarize
from hoist_demo.study.provenance import Known, statuses, write_data
from hoist_demo.study.run import RunData

#: Outputs that an FMU may have been exported without, and what the reports then lack.
_DRAWN = {
    "shape.": "3-D rope, shapes.png and stress along the rope",
    "station.": "exposure.png",
    "loop.": "loop.png",
    "stress.": "largest stresses",
    "energy.": "energies of the rope",
    "left.swivel.": "swivels.png",
}


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

    @cached_property
    def exposed(self) -> Recording | None:
        """Return the load history of each place in the rope."""
        return exposure(self.result.recording, self.rope.parameters)

    @cached_property
    def rows(self) -> tuple[SummaryRow, ...]:
        """The summary."""
        run, exposed = self.run, self.exposed
        rows = summarize(self.result, run.hoist, run.winding, run.coupling)
        rows += () if exposed is None else exposure_rows(exposed)
        said = without_remarked(self.said, self.result.recording)
        rows += tuple(SummaryRow(OUTCOME, WARNING, text) for text in said)
        return rows + tuple(told(self.known))


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
    from hoist_demo.report.exposure_figures import write_exposure_figure, write_spectra_figure
    from hoist_demo.report.figures import write_figures
    from hoist_demo.report.html.parameter_tables import rope_tables, tables
    from hoist_demo.report.html.run import run_report
    from hoist_demo.report.markdown import write_report
    from hoist_demo.report.panels import marks

    run, result, rope, status = wound.run, wound.result, wound.rope, statuses(wound.known)
    recording, hoist, winding = result.recording, run.hoist, run.winding
    host = {"Hoist": hoist, "Winding": winding, "Coupling": run.coupling, "Gains": run.gains}
    given = [*tables(host, status), *rope_tables(rope, wound.level, fidelities_of(recording), status)]
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
        pictures = write_figures(recording, hoist, directory, marks(result, winding), rope.locked)
    if (exposed := wound.exposed) is not None:
        written.append(directory / "exposure.csv")
        write_csv(exposed, written[-1])
        picture = write_exposure_figure(exposed, directory / "exposure.png")
        exposures = {"What each place in the rope went through": picture}
        spectra = spectra_table(recording)
        if (vibrations := write_spectra_figure(spectra, exposed["s"], directory / "spectra.png")) is not None:
            exposures["How it vibrates there"] = vibrations
            written.append(directory / "spectra.csv")
            write_csv(spectra, written[-1])
        pictures += exposures.values()
    page, title, rows = directory / "report.html", wound.title, wound.rows
    reports = [
        write_report(directory / "report.md", title, rows, pictures, given),
        run_report(result, hoist, winding, rows, title, page, given, rope.locked, rope.parameters, exposures),
    ]
    return [*written, data, *pictures, *reports]
