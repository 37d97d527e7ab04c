"""Measurements of a rope, and the model's prediction of each.

On a free loop     width between the legs of a rope that hangs from wherever they like: 2.54307 (EI / rho g)^(1/3)
On a sample        under the load T, the ends held, turned into the lay by w per length (D = Qd - Qb Qc / Qa):
                   torque c1 d T + (D + c2 d^2 T) w; one end free: it unlays by c1 d T l / (D + c2 d^2 T)
In the shaft       any output of the rope at rest, at given heights of its ends; frequencies of its swing; any output
                   over a trip and after it, when the loop swings: by a native run
Anywhere           places of markers while the ends move, as cameras have seen them: calibration.tracks

Torque and rotation of a sample are positive in the sense of the lay, whichever hand it has.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

import rope_model
from hoist_demo.calibration.fit import NotComputed
from hoist_demo.calibration.tracks import Markers
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.files.reading import Table
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.files.values import Text
from hoist_demo.parameters import Winding
from rope_model import SIGNALS, Datum, EndMotion, Scene
from rope_model.analysis.modes import Modes, natural_modes
from rope_model.catalogue import properties_of
from rope_model.engine import NativeRope
from rope_model.physics.estimates import natural_width
from rope_model.scene_names import with_values

Array = NDArray[np.float64]
#: Latest time of a value after a trip's start [s]: no swing lasts longer, and tracks are slow.
MAX_TIME = 3600.0
COMMUNICATION = 0.02  #: Communication step of a track [s].
SAMPLE = 0.1  #: Time between two values of which a largest and a smallest are taken [s].
#: Fidelity at which all is predicted: torsion and its coupling to tension are among the properties.
FIDELITY: Literal["torsional"] = "torsional"
MODES = 14  #: Modes among which those of one plane are looked for.


@dataclass(frozen=True)
class MeasuredTrip:
    """Trip in which the left end rises from rest; the right end falls."""

    left_y: float  # m, at the start
    right_y: float  # m, at the start
    travel: float  # m
    speed: float  # m/s
    acceleration: float  # m/s^2
    jerk: float  # m/s^3

    def reference(self) -> Trajectory:
        """Return the motion of the left end from its first height."""
        winding = Winding(
            travel=self.travel,
            speed=self.speed,
            acceleration=self.acceleration,
            jerk=self.jerk,
            start_delay=0.0,
        )
        return s_curve(winding)


@dataclass
class TripReadings:
    """Outputs and times [s] to be read in one winding of a trip."""

    signals: set[str] = field(default_factory=set)
    times: set[float] = field(default_factory=set)


class RopePredictor:
    """One rope under measurement; each position in the shaft and each trip is computed once."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene.with_(model=replace(scene.model, fidelity=FIDELITY))
        self._at_rest: dict[tuple[float, float], rope_model.BalanceRope] = {}
        self._modes: dict[tuple[float, float], Modes] = {}
        self._readings: dict[MeasuredTrip, TripReadings] = {}
        self._wound: dict[MeasuredTrip, dict[float, dict[str, float]]] = {}
        self.windings = 0  #: number of trips wound and of files of motion followed

    def plan(self, measurements: Iterable["AnyRopeMeasurement"]) -> None:
        """Collect all that measurements read in each trip, so that it is wound once."""
        for m in measurements:
            if not isinstance(m, Track):
                continue
            for trip, times in m.readings():
                readings = self._readings.setdefault(trip, TripReadings())
                readings.signals.add(m.signal)
                readings.times.update(times)
                self._wound.pop(trip, None)

    @cached_property
    def properties(self) -> dict[str, float]:
        """Properties by the names of the catalogue."""
        return properties_of(self.scene.rope)

    def signal(self, name: str, left: float, right: float) -> float:
        """Return an output at rest with the ends at these heights [m]."""
        if (left, right) not in self._at_rest:
            rope = rope_model.balance_rope(self.scene)
            _require_rest(rope.initialize(0.0, EndMotion(y=left), EndMotion(y=right)), left, right)
            self._at_rest[left, right] = rope
        return self._at_rest[left, right].signals([name])[name]

    def track(self, trip: MeasuredTrip, signal: str, times: Iterable[float]) -> list[float]:
        """Return an output at these times [s] of a planned trip; the first call winds it."""
        if trip not in self._wound:
            self._wound[trip] = self._wind(trip, self._readings[trip])
        return [self._wound[trip][t][signal] for t in times]

    def _wind(self, trip: MeasuredTrip, readings: TripReadings) -> dict[float, dict[str, float]]:
        """Return all outputs of the readings by time [s]."""
        self.windings += 1
        names = sorted(readings.signals)
        motion = trip.reference()
        rope = rope_model.balance_rope(self.scene)

        def ends(t: float) -> tuple[EndMotion, EndMotion]:
            p = motion.at(t)
            rising = EndMotion(y=trip.left_y + p.position, vy=p.speed, ay=p.acceleration)
            return rising, EndMotion(y=trip.right_y - p.position, vy=-p.speed, ay=-p.acceleration)

        _require_rest(rope.initialize(0.0, *ends(0.0)), trip.left_y, trip.right_y)
        read = rope.reader(names)
        values = {0.0: rope.signals(names)}
        now = 0.0
        for target in sorted(readings.times - {now}):
            steps = math.ceil((target - now) / COMMUNICATION)
            for t in np.linspace(now, target, steps + 1)[1:].tolist():
                status = rope.advance_to(t, *ends(t))
                if not status.valid:
                    raise NotComputed(
                        f"track of {', '.join(names)} at t = {t:g} s: {status.message}"
                    )
            now = target
            values[now] = dict(zip(names, read().tolist(), strict=True))
        return values

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the ropes at rest."""
        texts: dict[str, None] = {}
        for rope in self._at_rest.values():
            texts |= dict.fromkeys(rope.warnings().values())
        return tuple(texts)

    def torsion(self, load: float) -> float:
        """Torque over twist (N m^2) under the load."""
        rope = self.scene.rope
        return self.properties["torsional_stiffness"] + rope.c2 * rope.diameter**2 * load

    def lay_torque(self, load: float) -> float:
        """Torque (N m) of the load while nothing turns."""
        return self.properties["torque_factor"] * self.scene.rope.diameter * load

    def frequencies(self, plane: str, left: float, right: float) -> Array:
        """Return the frequencies of the lowest modes in or out of plane [Hz]."""
        if (left, right) not in self._modes:
            rope = NativeRope(self.scene)
            _require_rest(rope.initialize(0.0, EndMotion(y=left), EndMotion(y=right)), left, right)
            try:
                self._modes[left, right] = natural_modes(rope, MODES)
            except RuntimeError as error:  # scipy's, of a singular stiffness or no convergence
                raise NotComputed(
                    f"modes with left_y = {left:g} m and right_y = {right:g} m: {error}"
                ) from error
        modes = self._modes[left, right]
        is_out_of_plane = modes.out_of_plane > 0.5
        return np.asarray(modes.frequencies[is_out_of_plane == (plane == "out of plane")])


def _require_rest(status: rope_model.Status, left: float, right: float) -> None:
    if not status.valid:
        raise NotComputed(
            f"at rest with left_y = {left:g} m and right_y = {right:g} m: {status.message}"
        )


def _as_list(content: object) -> object:
    if isinstance(content, list | tuple):
        return content
    return [content]


T = TypeVar("T")
Series = Annotated[tuple[T, ...], BeforeValidator(_as_list), Field(min_length=1)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Magnitude = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Time = Annotated[float, Field(ge=0.0, le=MAX_TIME)]
Signal: Any = Literal[tuple(SIGNALS)]  #: Name of an output, docs/reference/variables.md.


class RopeMeasurement(Table):
    """Values with their standard error, and the circumstances.

    A number that varies has as many as there are values.
    """

    UNIT: ClassVar[str] = ""  # "": the signal's
    name: Text = ""
    what: str
    values: Series[Finite] = Field(alias="value")
    sigma: Magnitude

    @property
    def title(self) -> str:
        """Name of the measurement in results: `name`, else its signal or kind."""
        return self.name or str(getattr(self, "signal", self.what))

    @property
    def unit(self) -> str:
        """Unit of the values, as FMI spells it."""
        return self.UNIT or str(SIGNALS[getattr(self, "signal")].unit)  # noqa: B009 (not of all kinds)

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        """Return the model's prediction of each value, in `unit`."""
        raise NotImplementedError

    def each(self, *names: str) -> list[tuple[float, ...]]:
        """Return the tuples of these fields for each value, single numbers repeated."""
        columns = []
        for name in names:
            column = getattr(self, name)
            columns.append(column * (len(self.values) // len(column)))
        return list(zip(*columns, strict=True))

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        for name, one in self:
            if isinstance(one, tuple) and len(one) not in (1, len(self.values)):
                raise ValueError(
                    f"{name} has {len(one)} numbers, value {len(self.values)}: give one or as many"
                )
        return self


class LoopWidth(RopeMeasurement):
    """Width of the free loop of a piece [m]."""

    UNIT = "m"
    what: Literal["loop width"] = "loop width"
    values: Series[Magnitude] = Field(alias="value")

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [float(natural_width(predictor.scene))] * len(self.values)


class Mass(RopeMeasurement):
    """Mass per length, weighed [kg/m]."""

    UNIT = "kg/m"
    what: Literal["mass"] = "mass"
    values: Series[Magnitude] = Field(alias="value")

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [predictor.scene.rope.mass_per_length] * len(self.values)


class SampleTorque(RopeMeasurement):
    """Torque of a sample whose ends are held, turned into the lay [N m]."""

    UNIT = "N.m"
    what: Literal["sample torque"] = "sample torque"
    load: Series[Magnitude]  # N
    twist: Series[Finite] = (0.0,)  # rad/m

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [
            predictor.lay_torque(load) + predictor.torsion(load) * w
            for load, w in self.each("load", "twist")
        ]


class SampleRotation(RopeMeasurement):
    """Rotation by which a sample with one end free unlays [rad]."""

    UNIT = "rad"
    what: Literal["sample rotation"] = "sample rotation"
    load: Series[Magnitude]  # N
    length: Series[Magnitude]  # m

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [
            predictor.lay_torque(load) * l / predictor.torsion(load)
            for load, l in self.each("load", "length")
        ]


class SampleExtension(RopeMeasurement):
    """Extension of a sample whose ends are held, after settling [m]."""

    UNIT = "m"
    what: Literal["sample extension"] = "sample extension"
    values: Series[Magnitude] = Field(alias="value")
    load: Series[Magnitude]  # N
    length: Series[Magnitude]  # m

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [
            load * length / predictor.scene.rope.Qa for load, length in self.each("load", "length")
        ]


class InShaft(RopeMeasurement):
    """A measurement of the rope in its shaft, with its ends at these heights."""

    left_y: Series[Finite]  # m
    right_y: Series[Finite]  # m

    @property
    def end_places(self) -> list[tuple[float, float, float]]:
        """Heights of left and right end, and their difference [m]."""
        return [(left, right, left - right) for left, right in self.each("left_y", "right_y")]


class AtRest(InShaft):
    """An output of the rope at rest."""

    what: Literal["at rest"] = "at rest"
    signal: Signal

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [
            predictor.signal(self.signal, left, right)
            for left, right in self.each("left_y", "right_y")
        ]


class Swing(InShaft):
    """A natural frequency [Hz]."""

    UNIT = "Hz"
    what: Literal["swing"] = "swing"
    values: Series[Magnitude] = Field(alias="value")
    plane: Literal["in plane", "out of plane"]
    number: Series[Annotated[float, Field(ge=1.0, multiple_of=1.0)]] = (1.0,)

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        predicted = []
        for number, left, right in self.each("number", "left_y", "right_y"):
            frequencies = predictor.frequencies(self.plane, left, right)
            if number > frequencies.size:
                raise NotComputed(
                    f"{self.title}: number = {number:g} must be at most {frequencies.size}, as "
                    f"{MODES} modes hold so many {self.plane}: give a lower one"
                )
            predicted.append(float(frequencies[round(number) - 1]))
        return predicted


class Track(InShaft):
    """An output over a trip and the swing after it."""

    what: Literal["track"] = "track"
    signal: Signal
    t: Series[Time]  # s, after the left end has begun to rise
    travel: Series[Finite]  # m
    speed: Series[Magnitude]  # m/s
    acceleration: Series[Magnitude] = (Winding.acceleration,)
    jerk: Series[Magnitude] = (Winding.jerk,)

    @property
    def end_places(self) -> list[tuple[float, float, float]]:
        """Heights of both ends and their difference, before and after each trip [m]."""
        before = super().end_places
        after = []
        for (left, right, difference), (travel,) in zip(before, self.each("travel"), strict=True):
            after.append((left, right, difference + 2 * travel))
        return [*before, *after]

    def readings(self) -> list[tuple[MeasuredTrip, tuple[float, ...]]]:
        """Return trip and times [s], to the millisecond, of each value."""
        trips = self._trips()
        return [(trip, (round(t, 3),)) for trip, (t,) in zip(trips, self.each("t"), strict=True)]

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        return [predictor.track(trip, self.signal, times)[0] for trip, times in self.readings()]

    def _trips(self) -> list[MeasuredTrip]:
        return [
            MeasuredTrip(*one)
            for one in self.each("left_y", "right_y", "travel", "speed", "acceleration", "jerk")
        ]

    @model_validator(mode="after")
    def _travels(self) -> Self:
        if 0.0 in self.travel:
            raise ValueError("travel = 0 moves nothing: give the distance of the left end in m")
        return self


class Swept(Track):
    """Range of an output between two times of a trip, from `t` on."""

    what: Literal["swept"] = "swept"  # type: ignore[assignment]
    values: Series[Annotated[float, Field(ge=0.0, allow_inf_nan=False)]] = Field(alias="value")
    until: Series[Time]  # s

    def readings(self) -> list[tuple[MeasuredTrip, tuple[float, ...]]]:
        readings = []
        for trip, (start, until) in zip(self._trips(), self.each("t", "until"), strict=True):
            window = np.linspace(start, until, math.ceil((until - start) / SAMPLE) + 1)
            readings.append((trip, tuple(round(t, 3) for t in window.tolist())))
        return readings

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        ranges = []
        for trip, times in self.readings():
            values = predictor.track(trip, self.signal, times)
            ranges.append(max(values) - min(values))
        return ranges

    @model_validator(mode="after")
    def _ends_later(self) -> Self:
        for start, end in self.each("t", "until"):
            if end <= start:
                raise ValueError(f"until = {end:g} must be above t = {start:g}: give times in s")
        return self


AnyRopeMeasurement = RopeMeasurement | Markers
Measurements = Sequence[AnyRopeMeasurement]
MeasurementEntry = Annotated[
    LoopWidth
    | Mass
    | SampleTorque
    | SampleRotation
    | SampleExtension
    | AtRest
    | Track
    | Swept
    | Swing
    | Markers,
    Field(discriminator="what"),
]


@dataclass(frozen=True)
class CalibrationProblem:
    """Rope under identification: its ranges of the catalogue, and the scene in which it hangs."""

    catalogue_rope: rope_model.KnownRope
    scene: Scene
    # ranges of parameters beside the properties
    sought: Mapping[str, Datum] = field(default_factory=dict)

    @property
    def data(self) -> dict[str, Datum]:
        """Data of the properties and of the other parameters sought."""
        return {**self.catalogue_rope.data, **self.sought}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of everything sought: all that has a range."""
        return tuple(name for name, datum in self.data.items() if datum.high > datum.low)

    def value(self, name: str, norm_params: Array) -> float:
        """Return the value at its share of its range."""
        return self.data[name].at(float(norm_params[self.names.index(name)]))

    def rope(self, norm_params: Array) -> rope_model.Rope:
        """Return the rope at these shares of the ranges.

        What the file fixes beyond the properties is the scene's.
        """
        data = self.catalogue_rope.data
        values = {name: datum.low for name, datum in data.items()}
        for name in self.names:
            if name in data:
                values[name] = self.value(name, norm_params)
        rope = self.catalogue_rope.rope(**values)
        return replace(self.scene.rope, **{name: getattr(rope, name) for name in FOLLOWING})

    def scene_at(self, norm_params: Array) -> Scene:
        """Return the scene with the rope at these shares of the ranges."""
        values = {name: self.value(name, norm_params) for name in self.sought}
        return with_values(self.scene.with_(rope=self.rope(norm_params)), values)

    def predictor(self, norm_params: Array) -> RopePredictor:
        """Return the predictor for the rope with these normalised parameters."""
        return RopePredictor(self.scene_at(norm_params))

    def predict(
        self, norm_params: Array, measurements: Measurements, predictor: RopePredictor | None = None
    ) -> Array:
        """Predict all values of the measurements in turn.

        ``norm_params`` are the rope's, then those of starts.
        """
        predictor = predictor or self.predictor(norm_params)
        predictor.plan(measurements)
        starts = iter(norm_params[len(self.names) :].tolist())
        predictions: list[float] = []
        for m in measurements:
            if isinstance(m, Markers):
                predictions += m.predict(predictor, *islice(starts, m.starts)).tolist()
                predictor.windings += 1
            else:
                predictions += m.predict(predictor)
        return np.array(predictions)
