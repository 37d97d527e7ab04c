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
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from hoist_demo.calibration.fit import NotComputed
from hoist_demo.calibration.prediction import MODES, MeasuredTrip, RopePredictor
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.reading import TomlTable
from hoist_demo.files.values import Text
from hoist_demo.parameters import Winding
from rope_model import SIGNALS
from rope_model.physics.estimates import natural_width

#: Latest time of a value after a trip's start [s]: no swing lasts longer, and tracks are slow.
MAX_TIME = 3600.0
SAMPLE = 0.1  #: Time between two values of which a largest and a smallest are taken [s].


def _as_list(content: object) -> object:
    if isinstance(content, list | tuple):
        return content
    return [content]


T = TypeVar("T")
Series = Annotated[tuple[T, ...], BeforeValidator(_as_list), Field(min_length=1)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Magnitude = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Time = Annotated[float, Field(ge=0.0, le=MAX_TIME)]
OutputName: Any = Literal[tuple(SIGNALS)]  #: Name of an output, docs/reference/variables.md.


class RopeMeasurement(TomlTable):
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
        """Name of the measurement in results: ``name``, else its signal or kind."""
        return self.name or str(getattr(self, "signal", self.what))

    @property
    def unit(self) -> str:
        """Unit of the values, as FMI spells it."""
        return self.UNIT or str(SIGNALS[getattr(self, "signal")].unit)  # noqa: B009 (not of all kinds)

    def predict(self, predictor: RopePredictor) -> Sequence[float]:
        """Return the model's prediction of each value, in ``unit``."""
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
    signal: OutputName

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
    signal: OutputName
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
    """Range of an output between two times of a trip, from ``t`` on."""

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
