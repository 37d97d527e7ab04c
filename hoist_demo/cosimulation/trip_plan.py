"""What a run winds: rope, hoist, trip and coupling, from the start to the end of the settling."""

import math
from dataclasses import dataclass, field
from functools import partial

from hoist_demo.control.controller import ControllerFactory, Gains, SpeedController
from hoist_demo.control.trajectory import Course, Trajectory
from hoist_demo.cosimulation.loading import Loading
from hoist_demo.cosimulation.participants.identity import Identity, named_values
from hoist_demo.cosimulation.run_state import TripEnd
from hoist_demo.cosimulation.schemes.interface import RopePlant, Scheme, Stopwatch
from hoist_demo.parameters import Coupling, Hoist, Winding, start_heights

SAMPLE_ROUNDING = (
    1e-9  #: Part of a sample by which rounding alone may exceed a whole number of them.
)


@dataclass(frozen=True)
class NeighbouringTrips:
    """Trips of a duty before and after one; None: there is none."""

    #: End of the trip before with the same rope, which goes on from there; None: all begins at rest.
    before: TripEnd | None = None
    #: Hoist with the payloads of the trip that follows; they change in the middle of the dwell.
    next_hoist: Hoist | None = None


@dataclass(frozen=True)
class Clocks:
    """Times that a run takes."""

    drive: Stopwatch = field(default_factory=Stopwatch)  # of the drive's steps
    # of the rope's steps, reading its outputs included
    rope: Stopwatch = field(default_factory=Stopwatch)
    start: Stopwatch = field(default_factory=Stopwatch)  # of the rope's initialization


@dataclass(frozen=True)
class TripPlan:
    """Data of a run that stay the same until its end; RunState has what changes."""

    rope: RopePlant
    hoist: Hoist
    winding: Winding
    coupling: Coupling
    gains: Gains | None  # None: the controller's own
    controller: ControllerFactory | None  # None: SpeedController
    trajectory: Trajectory
    scheme: Scheme
    before: TripEnd | None  # end of the trip before; None: all begins at rest
    loading: Loading
    clocks: Clocks = field(default_factory=Clocks)

    @property
    def identity(self) -> Identity:
        """Data that a checkpoint and the run that continues it share.

        Scheme and step may change.
        """
        coupling = self.coupling
        controller = self.controller or SpeedController
        if isinstance(controller, partial):
            controller = controller.func
        return named_values(
            {
                "hoist": self.hoist,
                "winding": self.winding,
                "gains": self.gains,
                "controller": getattr(controller, "__qualname__", ""),
                "coupling.start": coupling.start,
                "coupling.sample_time": coupling.sample_time,
                "coupling.period": coupling.period,
            }
        )

    @property
    def start_heights(self) -> tuple[float, float]:
        """Heights of left and right conveyance before the trip [m].

        They are the landings, or where the trip before has ended.
        """
        if self.before is None:
            return start_heights(self.hoist, self.winding)
        return self.before.landing, self.hoist.shaft_travel - self.before.landing

    @property
    def sample_count(self) -> int:
        """Number of recorded samples in the whole run, the first not counted."""
        duration = self.trajectory.duration + self.winding.settle
        return math.ceil(duration / self.coupling.period - SAMPLE_ROUNDING)

    @property
    def course(self) -> Course:
        """Course without a stop by the safety circuit."""
        return Course(self.trajectory, self.winding)

    def sample_time(self, k: int) -> float:
        """Return the time of the recorded sample k [s]."""
        return self.coupling.start + k * self.coupling.period

    def payload_changes(self, k: int) -> bool:
        """Return True if a payload may change in a step between sample k and the next."""
        period = self.coupling.period
        return self.loading.changes((k + 1) * period, period)
