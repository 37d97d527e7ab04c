"""Complete state of a run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.boundary.end_paths import EndPath
from rope_model.boundary.input_filter import InputFilter
from rope_model.fidelity.choice import Fidelity
from rope_model.method.audit import Audit
from rope_model.method.generalized_alpha import Motion
from rope_model.method.leg_waves import LegWaves
from rope_model.method.partition import Partition
from rope_model.method.step_errors import ErrorSums
from rope_model.method.swivel_phases import SwivelState
from rope_model.physics.contact_error import ContactSums
from rope_model.physics.element import POINTS
from rope_model.physics.energy_balance import EnergyBalance, Powers
from rope_model.physics.guard import GuardState
from rope_model.physics.initial_curvature import START
from rope_model.physics.shaft import KINDS
from rope_model.shaft_parameters import FAR

#: state z of a rope without friction between its wires
NO_HYSTERESIS = np.zeros((0, 3 * len(POINTS)))


class Counts(NamedTuple):
    """Numbers of steps, iterations and events since the start."""

    steps: int = 0
    rejections: int = 0
    newton: int = 0
    transformations: int = 0
    swivel_events: int = 0
    given_up: int = 0  # steps with accuracy given up because of work_max

    def plus(self, **more: int) -> Counts:
        """Return a copy with some counts raised."""
        return self._replace(**{name: getattr(self, name) + n for name, n in more.items()})


class Event(NamedTuple):
    """Event between two steps, with the energy change it caused (J)."""

    t: float
    what: str
    kinetic: float = 0.0
    potential: float = 0.0


class Nearest(NamedTuple):
    """Nearest point of the rope to the bodies of a kind; see csrc/monitoring/shaft.c."""

    clearance: float = FAR  # m, distance of its surface
    time: float = 0.0  # s
    s: float = 0.0  # m, arc length from the left end
    y: float = 0.0  # m, height
    touched_at: float = 0.0  # s, instant at which the clearance was first 0 or less


#: clearances of each kind before any search
NOT_NEAR = (Nearest(),) * len(KINDS)


class Crossing(NamedTuple):
    """Passages of one side of the rope through the other, and overlap of the rope: csrc/monitoring/shaft.c."""

    net: float = 0.0  # passages that were not undone, with their sense
    number: float = 0.0  # all passages
    since: float = 0.0  # s, instant of the first passage
    y: float = 0.0  # m, height of the first passage
    overlap: float = 0.0  # m, largest depth of the rope in itself
    touched_at: float = 0.0  # s, instant of the first overlap
    touched_y: float = 0.0  # m, height of the largest overlap


class RopeState(NamedTuple):
    """Complete state of the rope, immutable: a step makes a new one, and the old one serves a rollback."""

    motion: Motion
    partition: Partition
    offsets: tuple[float, float]
    swivels: tuple[SwivelState, SwivelState]
    paths: tuple[EndPath, EndPath]
    filters: tuple[InputFilter, InputFilter]  # states of the input filters
    step_next: float
    last_interval: float  # s, length of the last advance
    force_mean: tuple[float, float]  # N, vertical force over the last advance
    calm_since: float  # s, instant of the last step whose error was not small
    loop_yaw: float  # rad, yaw at the lowest node, unwrapped
    fidelity: Fidelity
    fidelity_reason: str
    events: tuple[Event, ...] = ()  # events of the last advance
    energy_balance: EnergyBalance = EnergyBalance()
    errors: ErrorSums = ErrorSums()
    waves: LegWaves = LegWaves()
    contact: ContactSums = ContactSums()
    powers: Powers = Powers(0.0, 0.0)
    counts: Counts = Counts()
    # rad, twist at which the rope last snapped through when it was hung up; 0: never
    snap_twist: float = 0.0
    given_up_since: float = 0.0  # s, instant of the first of counts.given_up
    audit: Audit = Audit()
    nearest: tuple[Nearest, ...] = NOT_NEAR
    crossing: Crossing = Crossing()
    monitored_at: float = 0.0  # s, instant of nearest, crossing and guard
    guard: GuardState = GuardState()
    director: tuple[float, float, float] = START  # e1 of physics.initial_curvature at the left end
    hysteresis: Array = NO_HYSTERESIS  # 1/m, z of physics.wire_friction
