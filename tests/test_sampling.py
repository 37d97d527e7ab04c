"""A controller that samples within the communication step does what it does in shorter steps, repeated or not."""

from typing import Any

import pytest
from numpy.testing import assert_allclose
from rope_groups import Weight

from hoist_demo.control.controller import Command, Measurement, SpeedController
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import Scheme
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.parameters import Coupling, Hoist, Winding
from rope_model import EndMotion, Status

TRIP = Winding(travel=4.0, speed=4.0, jerk=2.0, start_delay=0.2, settle=0.8)
FORCES = {"left.fy": -2000.0, "right.fy": -7500.0, "left.fy_mean": -2000.0, "right.fy_mean": -7500.0}


class Spring(Weight):
    """A rope that pulls by its places alone: constantly, or harder where its ends are higher [N/m]."""

    def __init__(self, stiffness: float) -> None:
        super().__init__(dict(FORCES))
        self.stiffness = stiffness

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        return self.step(t0, 0.0, left, right)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        places = {"left": left.y, "right": right.y}
        self.forces = {name: f - self.stiffness * places[name.partition(".")[0]] for name, f in FORCES.items()}
        return Status(True)

    def save(self) -> dict[str, float]:
        return dict(self.forces)

    def restore(self, snapshot: dict[str, float]) -> None:
        self.forces = dict(snapshot)

    def close(self) -> None: ...


class Counting(SpeedController):
    """Remembers, in a state that it changes in place, where each of its samples asked the hoist to be."""

    calls = 0

    def command(self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float) -> Command:
        self.calls += 1
        self.latest = {"inner": None, "places": []} if state is None else state
        self.latest["places"].append(reference.position)
        found = super().command(reference, measured, self.latest["inner"], h)
        self.latest["inner"] = found.state
        return found._replace(state=self.latest)


def wind(step: float, stiffness: float = 0.0, scheme: Scheme | None = None) -> tuple[Result, Counting]:
    made: list[Counting] = []

    def controller(hoist: Hoist, torque: float) -> Counting:
        made.append(Counting(hoist, torque))
        return made[0]

    coupling = Coupling(step=step, sample=0.01)
    result = Host(Spring(stiffness), Hoist(), TRIP, coupling, controller=controller, scheme=scheme).run()
    assert result.completed
    return result, made[0]


@pytest.mark.parametrize("step", [0.02, 0.04])
def test_the_hoist_moves_as_with_a_step_of_one_sample(step: float) -> None:
    every = round(step / 0.01)
    long, short = wind(step)[0].recording, wind(0.01)[0].recording
    shared = short.time[::every].size  # the longer step may end behind the shorter one
    assert_allclose(long.time[:shared], short.time[::every], rtol=1e-15)
    # the rope pulls constantly, so what is left is the drive's integration, 1e-9 of a step
    for name in ("conveyance.left.y", "conveyance.right.y", "drive.torque_command"):
        assert_allclose(long[name][:shared], short[name][::every], rtol=1e-6, atol=1e-8, err_msg=name)


def test_samples_that_are_taken_back_leave_nothing_behind() -> None:
    result, controller = wind(0.02, stiffness=500.0, scheme=Iterative("secant", tolerance=1e-6))
    assert result.recording["coupling.exchanges"][-1] > 1.5 * result.steps
    asked = [result.trajectory.at(0.01 * k).position for k in range(2 * result.steps + 1)]
    assert_allclose(controller.latest["places"], asked, rtol=1e-12, atol=1e-12)
    assert controller.calls > len(asked)


def test_a_scheme_that_divides_the_step_has_no_samples_within_it() -> None:
    with pytest.raises(ValueError, match=r"sample = 0\.01 must be at least the communication step 0\.02 s"):
        Coupling(step=0.02, sample=0.01, scheme="energy-controlled")
