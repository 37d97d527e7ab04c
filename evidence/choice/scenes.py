"""Ten scenes with the fidelity that 'auto' takes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from benchmarks.kinematic import Winding, ends_at, wind
from hoist_demo.control.trajectory import Trajectory, emergency_stop, s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import FidelityChoice, Model, Scene, Swivel, rope_120, rope_240
from rope_model.simulation.ends.paths import EndMotion

P120, P240 = rope_120(), rope_240()
TRIP = s_curve(Trip())
STOP = emergency_stop(TRIP, 12.0, 5.0, 50.0)
#: s, of the windings whose first seconds tell all
SHORT = 12.0
LONG_TRIP = s_curve(Trip(travel=P240.travel, speed=P240.speed))

COUPLED = P120.scene
UNCOUPLED = COUPLED.with_(rope=replace(COUPLED.rope, Qb=0.0, Qc=0.0))
FREE = Swivel(mode="free")
LOOSE = UNCOUPLED.with_(left=FREE, right=FREE)


@dataclass(frozen=True)
class Case:
    """A winding, and the motion of its left end that a fidelity may not follow."""

    title: str
    scene: Scene
    trip: Trajectory = TRIP
    travel: float = P120.travel  # m
    until: float = TRIP.duration + 3.0  # s
    z: float = 0.0  # m, by which the left conveyance moves out of plane between 1 s and 4 s
    yaw: float = 0.0  # rad, by which it turns

    def ends(self, reference: Trajectory, travel: float, t: float) -> tuple[EndMotion, EndMotion]:
        """The ends' motion at ``t``."""
        left, right = ends_at(reference, travel, t)
        x, v, a = smooth_step(t)
        left = replace(left, z=self.z * x, vz=self.z * v, az=self.z * a, yaw=self.yaw * x, yaw_rate=self.yaw * v)
        return left, right

    def wind(self, scene: Scene) -> Winding:
        """The winding with other data."""
        settle = self.until - self.trip.duration
        return wind(scene, self.trip, self.travel, settle, sample=2, ends_at=self.ends)

    def on(self, fidelity: FidelityChoice) -> Scene:
        """The scene at a fidelity by name, or at the one 'auto' takes."""
        return self.scene.with_(model=replace(self.scene.model, fidelity=fidelity))


def smooth_step(t: float, start: float = 1.0, duration: float = 3.0) -> tuple[float, float, float]:
    """From 0 to 1, with its two derivatives in 1/s and 1/s^2."""
    s = min(max((t - start) / duration, 0.0), 1.0)
    return (
        10 * s**3 - 15 * s**4 + 6 * s**5,
        30 * s**2 * (1 - s) ** 2 / duration,
        (60 * s - 180 * s**2 + 120 * s**3) / duration**2,
    )


def tolerating(scene: Scene, force_tolerance: float) -> Scene:
    return scene.with_(model=Model(force_tolerance=force_tolerance))


LOWER = "same, uncoupled rope"
SIDE, TURN = "left conveyance moves 0.2 m out of plane", "left conveyance turns by 0.1 rad"
CASES = (
    Case("120 m winding, swivels locked", COUPLED),
    Case(LOWER, UNCOUPLED),
    Case(f"{LOWER}, swivels free, {SIDE}", LOOSE, until=SHORT, z=0.2),
    Case(f"{LOWER}, {SIDE}", UNCOUPLED, z=0.2),
    Case(f"{LOWER}, {TURN}", UNCOUPLED, yaw=0.1),
    Case(f"{LOWER}, swivels free, {TURN}", LOOSE, yaw=0.1),
    Case("120 m winding, swivels locked, force tolerance 0.1 %", tolerating(COUPLED, 1e-3)),
    Case("120 m winding, swivels locked, force tolerance 0.5 %", tolerating(COUPLED, 5e-3)),
    Case(
        "120 m winding, emergency stop at 12 s, force tolerance 0.5 %",
        tolerating(COUPLED, 5e-3),
        trip=STOP,
        until=STOP.duration + 5.0,
    ),
    Case(
        "240 m winding, swivels released at 20 s, until 25 s, force tolerance 1 %",
        tolerating(P240.scene, 1e-2),
        trip=LONG_TRIP,
        travel=P240.travel,
        until=25.0,
    ),
)
