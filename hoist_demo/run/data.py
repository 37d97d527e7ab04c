"""One run: its complete data, and its key.

The key is the hash of everything that decides the result: all data with their defaults, the FMU's
bytes, and the version of this package. Equal keys are equal runs, so that a finished run is never
repeated.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, NamedTuple

from hoist_demo.cases.case import Case
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.identity import Identity, named_values
from hoist_demo.design.controllers import DesignTask
from hoist_demo.files.registry import CONTROLLER, data_of, host_parameters
from hoist_demo.files.values import GIVEN, ParameterValue, values_of
from hoist_demo.parameters import GRAVITY, Arrival, Coupling, Hoist
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.winding import require_jams_on_the_way, require_trip_fits

KEY_DIGITS = 24  #: Hexadecimal digits of a run's key.
#: Relative difference of the drive's copy of the rope's data that is no contradiction.
COPY_TOLERANCE = 1e-3
if TYPE_CHECKING:
    from hoist_demo.design.arrival_swing import ArrivalSwing

_VERSION = version("balance-rope")
#: Data that only one controller uses, and that is not part of the key of the others' runs.
CONTROLLER_BY_SECTION = {"shaper": "input-shaping", "trajectory": "optimised-trajectory"}
#: Data of the winding that is not part of the key of runs without creep.
_CREEP = ("creep_speed", "creep_distance", "departure_creep_distance")

#: Fields that say for what a trip was designed, where that is not what is wound.
_DESIGN_FIELDS = ("nominal", "start")
#: Keys of fields in records, where they differ.
_RECORD_KEYS = {"rope_values": "fmu", "status_by_name": "given"}


@dataclass(frozen=True)
class RunData(DesignTask):
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
            if name not in _DESIGN_FIELDS or value is not None
        }

    @property
    def identity(self) -> Identity:
        """All that decides the result, by name, but the FMU's bytes."""
        values = named_values(replace(self, rope_values={}))
        return values | dict(self.rope_values)

    def host_values(self) -> dict[str, Value]:
        """Return the host's values by their names in files, without parts that are None."""
        values: dict[str, Value] = {}
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
            for name in _DESIGN_FIELDS:
                data.pop(name, None)
        for tuning, controller in CONTROLLER_BY_SECTION.items():
            if self.controller != controller:
                del data[tuning]
        if not self.winding.creeps:
            for name in _CREEP:
                del data["winding"][name]
        text = json.dumps([data, fmu_hash], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS]


def build(
    case: str,
    values: Mapping[str, Value | ParameterValue],
    signals: tuple[str, ...] = (),
    varied: Mapping[str, Value | ParameterValue] | None = None,
    nominal: Mapping[str, Value | ParameterValue] | None = None,
    start: float | None = None,
) -> RunData:
    """Return the data of a run; a ``ValueError`` names what does not fit together.

    ``values`` count as if they stood in the hoist's file; ``varied`` differ between runs of one
    hoist, and nothing follows from them: rules and the design of the trip take the ``nominal``
    values in their place, or else those of the file. ``start`` is the height of the left conveyance
    before the trip [m]; None: at a landing.
    """
    hoist_case = case_with_values(find_case(case), values)
    varied = dict(varied or {})
    differing = values_of(varied)
    status_by_name = dict(hoist_case.status_by_name)
    for key, value in varied.items():
        if isinstance(value, ParameterValue):
            status_by_name[key] = value.status
        else:
            status_by_name[key] = GIVEN
    host = {**values_of(hoist_case.host), **differing}
    run = RunData(
        case=case,
        controller=str(host.get(CONTROLLER.name, CONTROLLER.start)),
        rope_values={**hoist_case.rope, **fmu_part(differing)},
        signals=signals,
        start=start,
        status_by_name=status_by_name,
        **data_of(host),
    )
    designed = _designed(hoist_case, values_of(nominal or {}))
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


def build_single_trip(
    case: str,
    values: Mapping[str, Value | ParameterValue],
    signals: tuple[str, ...] = (),
    varied: Mapping[str, Value | ParameterValue] | None = None,
    nominal: Mapping[str, Value | ParameterValue] | None = None,
) -> RunData:
    """Return the data of a run of one trip, from a landing; ValueError also for a jam that it misses.

    The arguments are those of ``build``.
    """
    run = build(case, values, signals, varied, nominal)
    require_jams_on_the_way(run.hoist, run.winding)
    return run


def _designed(case: Case, nominal: Mapping[str, Value]) -> Case:
    """Return the hoist with the values at which its trip is designed."""
    hoist = data_of({**values_of(case.host), **nominal})["hoist"]
    return replace(case, hoist=hoist, rope={**case.rope, **fmu_part(nominal)})


#: Swings by all that decides them: many runs of a study share one design.
_SWINGS: dict[str, "ArrivalSwing"] = {}


def _swing(case: Case, start: float) -> "ArrivalSwing":
    """Return the swing for which a trip is shaped that begins at this height [m]."""
    from hoist_demo.design.arrival_swing import swing_at_arrival  # scipy is slow to load

    ropes = [(rope.parameters, rope.number, rope.suspension) for rope in case.distinct_ropes]
    values = sorted(case.rope.items())
    key = repr((values, ropes, case.hoist, case.winding.travel, case.gains, start))
    if key not in _SWINGS:
        _SWINGS[key] = swing_at_arrival(case, start)
    return _SWINGS[key]


def fmu_part(values: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values that are the FMU's."""
    return {key: v for key, v in values.items() if key not in host_parameters()}


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
