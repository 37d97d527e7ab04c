"""Measurements of a rope, and the model's prediction of each.

On a free loop     width between the legs of a rope that hangs from wherever they like: 2.54307 (EI / rho g)^(1/3)
On a sample        under the load T, the ends held, turned into the lay by w per length (D = Qd - Qb Qc / Qa):
                   torque c1 d T + (D + c2 d^2 T) w; one end free: it unlays by c1 d T l / (D + c2 d^2 T)
In the shaft       any output of the rope at rest, at given heights of its ends; frequencies of its swing; any output
                   over a trip and after it, when the loop swings: by a native run

Torque and rotation of a sample are positive in the sense of the lay, whichever hand it has.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hoist_demo.calibration.tracks import Track
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import BalanceRope, Datum, EndMotion, KnownRope, Model, Rope, RopeSimulator, Scene, Status, balance_rope
from rope_model.catalogue import properties_of
from rope_model.physics.estimates import natural_width
from rope_model.scene_names import with_values
from rope_model.simulation.outputs.modal import natural_modes

Array = NDArray[np.float64]
Numbers = Mapping[str, tuple[float, ...]]

#: parameters that follow from the properties
FOLLOWING = ("mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ", "length", "diameter")
PLANES = ("in plane", "out of plane")
#: s: communication step of a track, and between two values of which a largest and a smallest are taken
COMMUNICATION, SAMPLE = 0.02, 0.1
#: modes among which those of one plane are looked for
MODES = 14


class Trial:
    """One rope, and what is measured of it; each position in the shaft is computed once."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene.with_(model=Model("torsional"))
        self._at_rest: dict[tuple[float, float], BalanceRope] = {}

    @cached_property
    def properties(self) -> dict[str, float]:
        """Properties by the names of the catalogue."""
        return properties_of(self.scene.rope)

    def signal(self, name: str, left: float, right: float) -> float:
        """An output at rest with the ends at these heights (m)."""
        if (left, right) not in self._at_rest:
            rope = balance_rope(self.scene)
            status = rope.initialize(0.0, EndMotion(y=left), EndMotion(y=right))
            _require_rest(status, left, right)
            self._at_rest[left, right] = rope
        return self._at_rest[left, right].signals([name])[name]

    def track(
        self, name: str, times: Sequence[float], left: float, right: float, trip: Sequence[float]
    ) -> dict[float, float]:
        """An output by the times (s, in order) after the left end has begun to rise from these heights (m) at rest.

        ``trip``: its travel, and limits of speed, acceleration and jerk.
        """
        travel, speed, acceleration, jerk = trip
        winding = Winding(travel=travel, speed=speed, acceleration=acceleration, jerk=jerk, start_delay=0.0)
        motion, rope = s_curve(winding), balance_rope(self.scene)

        def ends(t: float) -> tuple[EndMotion, EndMotion]:
            p = motion.at(t)
            rising = EndMotion(y=left + p.position, vy=p.speed, ay=p.acceleration)
            return rising, EndMotion(y=right - p.position, vy=-p.speed, ay=-p.acceleration)

        _require_rest(rope.initialize(0.0, *ends(0.0)), left, right)
        read, found = rope.reader((name,)), {0.0: rope.signals([name])[name]}
        now = 0.0
        for target in times if times[0] > now else times[1:]:
            for t in np.linspace(now, target, math.ceil((target - now) / COMMUNICATION) + 1)[1:].tolist():
                status = rope.advance_to(t, *ends(t))
                if not status.valid:
                    raise RuntimeError(f"track of {name} at t = {t:g} s: {status.message}")
            now = target
            found[now] = float(read()[0])
        return found

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the ropes at rest."""
        return tuple(dict.fromkeys(text for rope in self._at_rest.values() for text in rope.warnings().values()))

    def frequencies(self, plane: str, left: float, right: float) -> Array:
        """Return the frequencies of the lowest modes in or out of plane [Hz]."""
        # the mesh differs from rope to rope, and to compile for each takes longer than to interpret
        rope = RopeSimulator(self.scene.with_(solver=replace(self.scene.solver, kernels="portable")))
        status = rope.initialize(0.0, EndMotion(y=left), EndMotion(y=right))
        _require_rest(status, left, right)
        modes = natural_modes(rope.system, rope.state.motion.q, MODES)
        return np.asarray(modes.frequencies[(modes.out_of_plane > 0.5) == (plane == "out of plane")])


def _require_rest(status: Status, left: float, right: float) -> None:
    if not status.valid:
        raise RuntimeError(f"at rest with left_y = {left:g} m and right_y = {right:g} m: {status.message}")


@dataclass(frozen=True)
class Kind:
    """A kind of measurement: unit ('' where the signal has it), the numbers that it needs, and its model."""

    unit: str
    numbers: Mapping[str, str]  # unit by name
    model: Callable[[Trial, Measurement], Sequence[float]]
    texts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Measurement:
    """Values with their standard error, and the circumstances; a number that varies has as many as there are values."""

    name: str
    what: str
    unit: str
    values: tuple[float, ...]
    sigma: float
    numbers: Numbers
    texts: Mapping[str, str]
    track: Track | None = None

    def predict(self, trial: Trial) -> Sequence[float]:
        """Predict the values; of a track, whose values are 0, residuals."""
        if self.track is not None:
            residuals: list[float] = (self.sigma * self.track.residuals(trial.scene)).tolist()
            return residuals
        return KINDS[self.what].model(trial, self)

    def each(self, *names: str) -> list[tuple[float, ...]]:
        """Repeat these numbers for each value."""
        columns = [self.numbers[name] * (len(self.values) // len(self.numbers[name])) for name in names]
        return list(zip(*columns, strict=True))


def _loop_width(trial: Trial, m: Measurement) -> list[float]:
    return [float(natural_width(trial.scene))] * len(m.values)


def _weighed(trial: Trial, m: Measurement) -> list[float]:
    return [trial.scene.rope.mass_per_length] * len(m.values)


def _torsion(trial: Trial, load: float) -> float:
    """Torque over twist (N m^2) under the load."""
    rope = trial.scene.rope
    return trial.properties["torsional_stiffness"] + rope.c2 * rope.diameter**2 * load


def _lay_torque(trial: Trial, load: float) -> float:
    return trial.properties["torque_factor"] * trial.scene.rope.diameter * load


def _sample_torque(trial: Trial, m: Measurement) -> list[float]:
    return [_lay_torque(trial, load) + _torsion(trial, load) * twist for load, twist in m.each("load", "twist")]


def _sample_rotation(trial: Trial, m: Measurement) -> list[float]:
    return [_lay_torque(trial, load) * length / _torsion(trial, load) for load, length in m.each("load", "length")]


def _sample_extension(trial: Trial, m: Measurement) -> list[float]:
    return [load * length / trial.scene.rope.Qa for load, length in m.each("load", "length")]


def _at_rest(trial: Trial, m: Measurement) -> list[float]:
    return [trial.signal(m.texts["signal"], left, right) for left, right in m.each("left_y", "right_y")]


def _swing(trial: Trial, m: Measurement) -> list[float]:
    plane, found = m.texts["plane"], []
    for number, left, right in m.each("number", "left_y", "right_y"):
        known = trial.frequencies(plane, left, right)
        if number > known.size:
            raise RuntimeError(
                f"{m.name}: number = {number:g} must be at most {known.size}, as {MODES} modes hold so many {plane}: "
                "give a lower one"
            )
        found.append(float(known[round(number) - 1]))
    return found


def _track(trial: Trial, m: Measurement) -> list[float]:
    return [values[0] for values in _over_trips(trial, m, m.each("t"))]


def _swept(trial: Trial, m: Measurement) -> list[float]:
    windows = [np.linspace(t, until, math.ceil((until - t) / SAMPLE) + 1) for t, until in m.each("t", "until")]
    return [max(values) - min(values) for values in _over_trips(trial, m, [window.tolist() for window in windows])]


def _over_trips(trial: Trial, m: Measurement, times: Sequence[Sequence[float]]) -> list[list[float]]:
    """The signal at the times (s) of each value, to the millisecond; each trip is wound once."""
    trips = m.each(*_HEIGHTS, *_TRIP)
    rounded = [[round(t, 3) for t in some] for some in times]
    runs = {
        trip: trial.track(
            m.texts["signal"],
            sorted({t for of, some in zip(trips, rounded, strict=True) if of == trip for t in some}),
            trip[0],
            trip[1],
            trip[2:],
        )
        for trip in dict.fromkeys(trips)
    }
    return [[runs[trip][t] for t in some] for trip, some in zip(trips, rounded, strict=True)]


_TRIP = {"travel": "m", "speed": "m/s", "acceleration": "m/s2", "jerk": "m/s3"}
_HEIGHTS = {"left_y": "m", "right_y": "m"}
KINDS = {
    "loop width": Kind("m", {}, _loop_width),
    "mass": Kind("kg/m", {}, _weighed),
    "sample torque": Kind("N.m", {"load": "N", "twist": "rad/m"}, _sample_torque),
    "sample rotation": Kind("rad", {"load": "N", "length": "m"}, _sample_rotation),
    "sample extension": Kind("m", {"load": "N", "length": "m"}, _sample_extension),
    "at rest": Kind("", _HEIGHTS, _at_rest, ("signal",)),
    "track": Kind("", {"t": "s", **_HEIGHTS, **_TRIP}, _track, ("signal",)),
    "swept": Kind("", {"t": "s", "until": "s", **_HEIGHTS, **_TRIP}, _swept, ("signal",)),
    "swing": Kind("Hz", {"number": "1", **_HEIGHTS}, _swing, ("plane",)),
}
#: kinds whose values have no sign and are never 0; what is swept may be
MAGNITUDES = ("loop width", "mass", "sample extension", "swing")
#: what a number is where it is not given
DEFAULTS = {"twist": 0.0, "number": 1.0, "acceleration": Winding.acceleration, "jerk": Winding.jerk}


@dataclass(frozen=True)
class Bench:
    """The rope of which something is measured: what the catalogue knows of it, and the scene in which it hangs."""

    known: KnownRope
    scene: Scene
    sought: Mapping[str, Datum] = field(default_factory=dict)  # ranges of parameters beside the properties

    @property
    def data(self) -> dict[str, Datum]:
        """Data of the properties and of the other parameters sought."""
        return {**self.known.data, **self.sought}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of everything sought: all that has a range."""
        return tuple(name for name, datum in self.data.items() if datum.high > datum.low)

    def value(self, name: str, shares: Array) -> float:
        """Return the value at its share of its range."""
        return self.data[name].at(float(shares[self.names.index(name)]))

    def rope(self, shares: Array) -> Rope:
        """The rope at these shares of the ranges; what the file fixes beyond the properties is the scene's."""
        data = self.known.data
        values = {name: self.value(name, shares) if name in self.names else data[name].low for name in data}
        made = self.known.rope(**values)
        return replace(self.scene.rope, **{name: getattr(made, name) for name in FOLLOWING})

    def scene_at(self, shares: Array) -> Scene:
        """The rope in its shaft at these shares."""
        found = {name: self.value(name, shares) for name in self.sought}
        return with_values(self.scene.with_(rope=self.rope(shares)), found)

    def trial(self, shares: Array) -> Trial:
        """Return the rope that has these shares, ready to be measured."""
        return Trial(self.scene_at(shares))

    def predict(self, shares: Array, measurements: Sequence[Measurement]) -> Array:
        """All values of the measurements, one after the other."""
        trial = self.trial(shares)
        return np.array([value for m in measurements for value in m.predict(trial)])
