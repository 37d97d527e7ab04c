"""Prediction of outputs, modes and properties of a rope under measurement; each is computed once."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

import rope_model
from hoist_demo.calibration.fit import NotComputed
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding
from rope_model import EndMotion, Scene
from rope_model.analysis.modes import Modes, natural_modes
from rope_model.arrays import Array
from rope_model.catalogue import properties_of
from rope_model.engine import NativeRope

COMMUNICATION = 0.02  #: Communication step of a track [s].
#: Fidelity at which all is predicted: torsion and its coupling to tension are among the properties.
FIDELITY: Literal["torsional"] = "torsional"
MODES = 14  #: Modes among which those of one plane are looked for.
_HALF = 0.5  #: Share of a mode's motion out of plane above which it is one out of plane.


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

    def plan(self, trip: MeasuredTrip, signal: str, times: Iterable[float]) -> None:
        """Add what is read in a trip, so that one winding of it gives all that is planned."""
        readings = self._readings.setdefault(trip, TripReadings())
        readings.signals.add(signal)
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
        is_out_of_plane = modes.out_of_plane > _HALF
        return np.asarray(modes.frequencies[is_out_of_plane == (plane == "out of plane")])


def _require_rest(status: rope_model.Status, left: float, right: float) -> None:
    if not status.valid:
        raise NotComputed(
            f"at rest with left_y = {left:g} m and right_y = {right:g} m: {status.message}"
        )
