"""One run of a study: its complete data, its key, and its co-simulation with the FMU.

The key is the hash of everything that decides the result: all data with their defaults, the FMU's
bytes, and the version of this package. Equal keys are equal runs, so that a finished run is never
repeated.
"""

import hashlib
import json
import math
import traceback
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from hoist_demo.cases.case import Case
from hoist_demo.cases.rules import with_values
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.host import Host, Progress
from hoist_demo.cosimulation.participants.fmu_description import read_parameters
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of, rope_scene
from hoist_demo.cosimulation.progress import warnings_of
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.design.controllers import Drive, Task
from hoist_demo.files.registry import CONTROLLER, data_of, host_parameters
from hoist_demo.files.values import GIVEN, ParameterValue, plain
from hoist_demo.parameters import GRAVITY, Arrival, Coupling, Hoist, start_heights
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.winding import require_jams_on_the_way, require_trip_fits
from hoist_demo.recording.fidelity import fidelities_of, mask_neglected
from hoist_demo.recording.incidents import circuit_stop, incidents
from hoist_demo.recording.passages import passages
from hoist_demo.recording.time_series import TIME
from hoist_demo.study.metrics import ROPE_SIGNALS, UNITS, measure
from hoist_demo.study.slip import slip_warnings
from rope_model import EndMotion, Level

KEY_DIGITS = 24  #: Hexadecimal digits of a run's key.
MAX_LISTED = 5  #: Differences between an FMU and a hoist that a message lists.
#: Relative difference of two numbers that the text of a start value may leave by rounding.
ROUNDING = 1e-12
#: Relative difference of the drive's copy of the rope's data that is no contradiction.
COPY_TOLERANCE = 1e-3
if TYPE_CHECKING:
    from hoist_demo.design.arrival_swing import ArrivalSwing

CUT_SHORT = "cut short"  #: State of a run that the safety circuit stopped.
#: States that a resumed study does not repeat: wound to the end, cut short, or ended by rope or
#: drive with a cause.
FINISHED = ("completed", "stopped", CUT_SHORT)
#: State of a run that could not be carried out (a dead worker, an exception); resuming tries it
#: again.
ERROR = "error"
_VERSION = version("balance-rope")
#: Data that only one controller uses, and that is not part of the key of the others' runs.
CONTROLLER_OF = {"shaper": "input-shaping", "trajectory": "optimised-trajectory"}
#: Data of the winding that is not part of the key of runs without creep.
_CREEP = ("creep_speed", "creep_distance", "departure_creep_distance")

#: Fields that say for what a trip was designed, where that is not what is wound.
_OF_DESIGN = ("nominal", "start")
#: Keys of fields in records, where they differ.
_RECORD_KEYS = {"rope_values": "fmu", "status_by_name": "given"}


@dataclass(frozen=True)
class RunData(Task):
    """Everything that decides a run's result but the FMU's bytes."""

    case: str  # the hoist, by name or file
    coupling: Coupling
    arrival: Arrival
    rope_values: Mapping[str, Value]  # parameters of the case's rope, and those that the study sets
    signals: tuple[str, ...] = ()  # time series to keep
    # statuses by name
    status_by_name: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    def record(self) -> dict[str, Any]:
        """Return the data by their keys in records."""
        data = {_RECORD_KEYS.get(name, name): value for name, value in asdict(self).items()}
        return {
            name: value
            for name, value in data.items()
            if name not in _OF_DESIGN or value is not None
        }

    def host_values(self) -> dict[str, Value]:
        """Return the host's values by their names in files, without parts that are None."""
        values = dict[str, Value]()
        for name in host_parameters():
            value: Any = self
            for part in name.split("."):
                value = getattr(value, part, None)
            if value is not None:
                values[name] = value
        return values

    def key(self, fmu_hash: str) -> str:
        """Return the name of the run, 24 hexadecimal digits."""
        data = self.record() | {"fmu": dict(sorted(self.rope_values.items())), "version": _VERSION}
        del data["case"], data["given"]  # all that its file says is in the rest
        # of other controllers all that was designed is in the rest
        if self.controller != "optimised-trajectory":
            for name in _OF_DESIGN:
                data.pop(name, None)
        for tuning, controller in CONTROLLER_OF.items():
            if self.controller != controller:
                del data[tuning]
        if not self.winding.creeps:
            for name in _CREEP:
                del data["winding"][name]
        text = json.dumps([data, fmu_hash], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS]


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


def build(
    case: str,
    values: Mapping[str, Value | ParameterValue],
    signals: tuple[str, ...] = (),
    varied: Mapping[str, Value | ParameterValue] | None = None,
    nominal: Mapping[str, Value | ParameterValue] | None = None,
    start: float | None = None,
) -> RunData:
    """Return the data of a run; a `ValueError` names what does not fit together.

    `values` count as if they stood in the hoist's file; `varied` differ between runs of one hoist,
    and nothing follows from them: rules and the design of the trip take the `nominal` values in
    their place, or else those of the file. `start` is the height of the left conveyance before the
    trip [m]; None: at a landing.
    """
    hoist_case = with_values(find_case(case), values)
    varied = dict(varied or {})
    differing = plain(varied)
    status_by_name = dict(hoist_case.status_by_name)
    for key, value in varied.items():
        status_by_name[key] = value.status if isinstance(value, ParameterValue) else GIVEN
    host = {**plain(hoist_case.host), **differing}
    run = RunData(
        case=case,
        controller=str(host.get(CONTROLLER.name, CONTROLLER.start)),
        rope_values={**hoist_case.rope, **fmu_part(differing)},
        signals=signals,
        start=start,
        status_by_name=status_by_name,
        **data_of(host),
    )
    designed = _designed(hoist_case, plain(nominal or {}))
    if designed.hoist != run.hoist:
        run = replace(run, nominal=designed.hoist)
    run.require_possible()
    if run.controller == "input-shaping" and run.shaper.frequency == 0.0:
        designed = replace(designed, winding=run.winding, gains=run.gains)
        swing = _swing(designed, run.start_height)
        shaper = replace(run.shaper, frequency=swing.frequency, damping=swing.damping)
        run = replace(run, shaper=shaper)
    require_trip_fits(run.hoist, run.winding)
    s_curve(run.winding)
    return run


def _designed(case: Case, nominal: Mapping[str, Value]) -> Case:
    """Return the hoist with the values at which its trip is designed."""
    hoist = data_of({**plain(case.host), **nominal})["hoist"]
    return replace(case, hoist=hoist, rope={**case.rope, **fmu_part(nominal)})


#: Swings by all that decides them: many runs of a study share one design.
_SWINGS = dict[str, "ArrivalSwing"]()


def _swing(case: Case, start: float) -> "ArrivalSwing":
    """Return the swing for which a trip is shaped that begins at this height [m]."""
    from hoist_demo.design.arrival_swing import swing_at_arrival  # scipy is slow to load

    ropes = [(rope.parameters, rope.number, rope.suspension) for rope in case.distinct_ropes]
    values = sorted(case.rope.items())
    key = repr((values, ropes, case.hoist, case.winding.travel, case.gains, start))
    if key not in _SWINGS:
        _SWINGS[key] = swing_at_arrival(case, start)
    return _SWINGS[key]


def from_landing(run: RunData) -> RunData:
    """Return a run that begins at a landing; refuse a jam that it does not reach."""
    require_jams_on_the_way(run.hoist, run.winding)
    return run


def fmu_part(values: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values that are the FMU's."""
    return {key: v for key, v in values.items() if key not in host_parameters()}


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
    series = dict[str, list[float]]()
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


def wind_run(
    run: RunData,
    rope: RopePlant,
    progress: Progress | None = None,
    drive: Drive | None = None,
    **trips: Any,
) -> Result:
    """Return the co-simulation of a run with any rope.

    `progress` is that of `Host.run`; `drive` is the design of the run if it is known; `trips` are
    arguments of `Host` on the trips before and after.
    """
    drive = drive or run.design()
    host = Host(
        rope,
        run.hoist,
        run.winding,
        run.coupling,
        drive.gains,
        trajectory=drive.trajectory,
        **trips,
    )
    return host.run(progress)


class SharedParameter(NamedTuple):
    """Parameter of the rope of which the hoist has a copy for its controller."""

    name: str
    copy: str  # field of Hoist
    unit: str


SHARED = (
    SharedParameter("rope.mass_per_length", "tail_rope_mass", "kg/m"),
    SharedParameter("rope.length", "tail_rope_length", "m"),
)


def contradictions(hoist: Hoist, rope: Mapping[str, Value]) -> str:
    """Return where the drive's copy of the balance rope's data differs from the rope's.

    "" if they agree.
    """
    sentences = []
    for name, copy, unit in SHARED:
        computed = rope.get(name)
        assumed = getattr(hoist, copy)
        if not isinstance(computed, int | float):
            continue
        if not math.isclose(computed, assumed, rel_tol=COPY_TOLERANCE):
            sentences.append(
                f"{name} = {computed:g} {unit} and hoist.{copy} = {assumed:g} {unit} contradict "
                f"each other: the drive holds and accelerates by its own number; set hoist.{copy} "
                f"= {computed:g}, too"
            )
    gravity = float(rope.get("layout.gravity", GRAVITY))
    if gravity != GRAVITY:
        sentences.append(
            f"layout.gravity = {gravity:g} m/s2 and the drive's {GRAVITY:g} contradict each other: "
            "leave it out"
        )
    return "; ".join(sentences)


class Probe:
    """Trial starts of an FMU, each made only once."""

    def __init__(self, fmu: Path) -> None:
        self._fmu = fmu
        self._refusals: dict[str, str] = {}  # by parameters and heights

    def require_start(self, run: RunData) -> None:
        """Refuse a rope that does not start with the run's parameters.

        The message names the key if a single one is the cause.
        """
        heights = start_heights(run.hoist, run.winding)
        refusal = self._refusal(run.rope_values, heights)
        if not refusal:
            return
        values_of_case = find_case(run.case).rope
        set_here = {
            key: value for key, value in run.rope_values.items() if values_of_case.get(key) != value
        }
        problems = Problems()
        for key, value in set_here.items():
            refusal_of_key = self._refusal({**values_of_case, key: value}, heights)
            if refusal_of_key:
                problems.append(f"{key} = {value!r}: {refusal_of_key}")
        if not problems:
            words = ", ".join(f"{key} = {value!r}" for key, value in set_here.items())
            cause = words or "the FMU's own parameters"
            problems.append(f"{cause}: {refusal}")
        problems.refuse()

    def require_hoist(self, run: RunData) -> None:
        """Refuse an FMU of another hoist.

        All values that the run does not set must start with those of its hoist. The settings of
        accuracy may be those of any level.
        """
        starts = {
            name: p.start
            for name, p in read_parameters(self._fmu).items()
            if name not in run.rope_values
        }
        levels = sorted(get_args(Level), key=lambda level: level != find_case(run.case).level)
        differences = list[dict[str, Value]]()
        for level in levels:
            with suppress(ValueError):  # the hoist's own settings do not fit this level
                scene = rope_scene(run.rope_values, level)
                differences.append(_differing(starts, rope_data_of(scene).parameters))
        # settings that fit no level are refused when the rope starts
        fewest = min(differences, key=len, default={})
        if not fewest:
            return
        listed = [f"{key} is {starts[key]} there, {value} here" for key, value in fewest.items()]
        if len(listed) > MAX_LISTED:
            listed[MAX_LISTED:] = [f"and {len(fewest) - MAX_LISTED} more"]
        raise ValueError(
            f"FMU '{self._fmu}' must be of this hoist, '{run.case}', but {len(fewest)} of its "
            f"values that the hoist leaves out differ: {'; '.join(listed)}: export this hoist "
            f"(`balance-rope export {run.case}`), wind the FMU's own, or state them (a hoist's "
            "file, or --set NAME=VALUE)"
        )

    def _refusal(self, parameters: Mapping[str, Value], heights: tuple[float, float]) -> str:
        key = json.dumps([dict(parameters), heights], sort_keys=True)
        if key not in self._refusals:
            left, right = (EndMotion(y=y) for y in heights)
            self._refusals[key] = _refusal_at_start(self._fmu, parameters, left, right)
        return self._refusals[key]


def _differing(starts: Mapping[str, Value | None], scene: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values of a scene from which an FMU's start values differ, by name."""
    differing = dict[str, Value]()
    for name, start in starts.items():
        if name in scene and start is not None and not _same(start, scene[name]):
            differing[name] = scene[name]
    return differing


def _same(one: Value, other: Value) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=ROUNDING)
    return one == other


def _refusal_at_start(
    fmu: Path, parameters: Mapping[str, Value], left: EndMotion, right: EndMotion
) -> str:
    """Return the message with which the FMU refuses to start; "" if it starts."""
    try:
        rope = FmuRope(fmu, parameters)
    except ValueError as error:
        return str(error)
    try:
        with warnings_of(FmuRope.__module__):  # the runs warn again
            status = rope.initialize(0.0, left, right)
    finally:
        rope.close()
    if status.valid:
        return ""
    return status.message or "the FMU does not initialize, without a message"
