"""One run of a study, from its data to its outcome: plain data, whatever goes wrong."""

import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.progress import warnings_of
from hoist_demo.recording.fidelity import fidelities_of, mask_neglected
from hoist_demo.recording.incidents import circuit_stop, incidents
from hoist_demo.recording.passages import passages
from hoist_demo.recording.time_series import TIME
from hoist_demo.run.data import RunData, contradictions
from hoist_demo.run.metrics import ROPE_SIGNALS, UNITS, measure
from hoist_demo.run.slip import slip_warnings
from hoist_demo.run.wind import wind_run

CUT_SHORT = "cut short"  #: State of a run that the safety circuit stopped.
#: States that a resumed study does not repeat: wound to the end, cut short, or ended by rope or
#: drive with a cause.
FINISHED = ("completed", "stopped", CUT_SHORT)
#: State of a run that could not be carried out (a dead worker, an exception); resuming tries it
#: again.
ERROR = "error"


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run: plain data that travels between processes."""

    status: str  # completed, stopped, cut short or error
    cause: str
    metrics: Mapping[str, float]
    signals: Mapping[str, list[float]]  # requested time series by name, and their time
    units: Mapping[str, str] = field(default_factory=dict)  # units of the signals
    fidelity: str = ""  # models of the rope that ran, which may lack a metric
    warnings: tuple[str, ...] = ()  # warnings of hoist, coupling and rope
    missing: str = ""  # reason why a metric is missing
    passed: str = ""  # bodies that the rope struck or passed through


def execute(run: RunData, fmu: Path) -> Outcome:
    """Design, wind and measure; whatever goes wrong is an outcome, with its cause."""
    with warnings_of("hoist_demo") as warnings:
        outcome = _outcome(run, fmu)
    return replace(outcome, warnings=(*outcome.warnings, *warnings))


def _outcome(run: RunData, fmu: Path) -> Outcome:
    try:
        rope = FmuRope(fmu, run.rope_values, ROPE_SIGNALS.union(run.signals))
        try:
            result = wind_run(run, rope)
            data = rope.data()
        finally:
            rope.close()
        contradicted = contradictions(run.hoist, data.parameters)
        result = replace(result, recording=mask_neglected(result.recording, data.torque_free))
        fidelity = ", ".join(fidelities_of(result.recording))
        metrics, missing = measure(result, run.hoist, run.arrival)
    except Exception as error:  # recorded, so that the other runs go on
        where = traceback.extract_tb(error.__traceback__)[-1]
        cause = (
            f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno})"
        )
        return Outcome(ERROR, cause, dict.fromkeys(UNITS, float("nan")), {})
    # a series means nothing without its instants
    series: dict[str, list[float]] = {}
    if run.signals:
        for name in (TIME, *run.signals):
            if name in result.recording:
                series[name] = result.recording[name].tolist()
    status = "completed" if result.completed else "stopped"
    cause = result.cause
    stopped_at = result.winding.emergency_at
    if result.completed and stopped_at is not None and stopped_at != run.winding.emergency_at:
        status = CUT_SHORT
        cause = circuit_stop(result.recording, stopped_at) + incidents(result.recording)
    return Outcome(
        status,
        cause,
        metrics,
        signals=series,
        units={name: result.recording.units[name] for name in series},
        fidelity=fidelity,
        warnings=tuple(filter(None, (*slip_warnings(result, run.hoist), contradicted))),
        missing=missing,
        passed=passages(result.recording),
    )
