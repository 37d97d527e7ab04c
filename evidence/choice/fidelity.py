"""What a lower fidelity of the model costs in accuracy and saves in processor time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from benchmarks.kinematic import Winding, wind
from benchmarks.robustness import LIMITS
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import Layout, Model, Scene, Swivel, balance_rope
from rope_model.parameters import FidelityChoice
from rope_model.physics.estimates import Travel, lean_error, longitudinal_error
from rope_model.simulation.fidelity_cases import force_error

from .scenes import P120, P240, Case

ROUNDS = 3


@dataclass(frozen=True)
class Choice:
    """What 'auto' does with a scene, and how it differs from the torsional model."""

    case: Case
    fidelity: str
    reason: str
    switches: tuple[str, ...]  # to which fidelity when, and why
    force: float  # root mean square of the vertical end forces' difference over the largest force
    peak: float  # largest difference over the largest force
    bottom: float  # m, largest distance of the loop's lowest points
    time: float  # processor time over that of the torsional model


def first_choice(case: Case) -> tuple[str, str]:
    """Fidelity and reason at the start."""
    rope = balance_rope(case.scene)
    status = rope.initialize(0.0, *case.ends(case.trip, case.travel, 0.0))
    assert status.valid, status.message
    return rope.fidelity, rope.fidelity_reason


def measure_choice(case: Case) -> Choice:
    """Measure; nothing differs where the torsional model is taken."""
    fidelity, reason = first_choice(case)
    if fidelity == "torsional":
        return Choice(case, fidelity, reason, (), 0.0, 0.0, 0.0, 1.0)
    runs = [(valid(case.wind(case.on("torsional"))), valid(case.wind(case.scene))) for _ in range(ROUNDS)]
    full, auto = runs[0]
    last = auto.rope.state.fidelity_reason
    switches = tuple(f"{e.what.split()[1]} at {e.t:.2f} s, because {last}" for e in auto.events if "model" in e.what)
    time = median(lower.cpu for _, lower in runs) / median(whole.cpu for whole, _ in runs)
    bottom = float(np.linalg.norm(np.array(auto.bottom) - full.bottom, axis=1).max())
    return Choice(case, fidelity, reason, switches, *force_difference(auto, full), bottom, time)


def valid(run: Winding) -> Winding:
    """The run, if it came to its end."""
    if not run.status.valid:
        raise RuntimeError(run.status.message)
    return run


def force_difference(run: Winding, reference: Winding) -> tuple[float, float]:
    """Root mean square and largest difference of the vertical end forces, over the largest force."""
    difference, largest = np.array(run.force) - reference.force, np.abs(reference.force).max()
    return float(np.sqrt(np.mean(difference**2)) / largest), float(np.abs(difference).max() / largest)


@dataclass(frozen=True)
class Calibration:
    """Measured and estimated errors of one winding of a coupled rope."""

    length: float  # m
    swivels: str
    speed: float  # m/s
    EI: float  # N m^2
    spacing: float  # m
    planar: float  # against torsional
    planar_estimate: float
    rigid: float  # against planar
    rigid_estimate: float

    @property
    def factors(self) -> tuple[float, float]:
        """Estimate over error, planar and rigid."""
        return self.planar_estimate / self.planar, self.rigid_estimate / self.rigid


#: EI in N m^2 and spacing in m
VARIED = ((300.0, 2.0), (50.0, 2.0), (1000.0, 2.0), (300.0, 1.5), (300.0, 3.0), (1000.0, 1.5), (50.0, 3.0))


def calibrations() -> Iterator[Calibration]:
    """The windings from which the constants of physics.estimates are taken, and one whose swivels are released."""
    for rope_case, speed, (EI, spacing) in itertools.product((P120, P240), LIMITS, VARIED):
        acceleration, jerk = LIMITS[speed]
        trip = Trip(travel=rope_case.travel, speed=speed, acceleration=acceleration, jerk=jerk)
        rope = replace(rope_case.scene.rope, EI=EI)
        scene = rope_case.scene.with_(rope=rope, layout=Layout(spacing=spacing), left=Swivel(), right=Swivel())
        yield calibration(scene, trip)
    yield calibration(P240.scene, Trip(travel=P240.travel, speed=P240.speed), until=25.0)


def calibration(scene: Scene, trip: Trip, until: float | None = None) -> Calibration:
    """One winding at three fidelities."""
    reference = s_curve(trip)
    settle = 3.0 if until is None else until - reference.duration
    fidelities: tuple[FidelityChoice, ...] = ("torsional", "planar", "rigid")
    full, planar, rigid = (
        valid(wind(scene.with_(model=Model(fidelity)), reference, trip.travel, settle, sample=2))
        for fidelity in fidelities
    )
    travel = Travel(trip.travel, reference.peak_speed, trip.acceleration, trip.jerk)
    return Calibration(
        scene.rope.length,
        "locked" if scene.left.mode == "locked" else f"released at {scene.left.release_time:g} s",
        trip.speed,
        scene.rope.EI,
        scene.layout.spacing,
        force_difference(planar, full)[0],
        force_error(scene, "planar", travel),
        force_difference(rigid, planar)[0],
        longitudinal_error(scene, travel) + lean_error(scene, travel),
    )
