"""A drive controller of one's own winds 90 m with the FMU of the rope.

It ends 0.14 m off, for want of a position loop.

python examples/own_controller.py build/rope.fmu
"""

import sys
from pathlib import Path
from typing import Any

from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import Command, Measurement
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.parameters import Coupling, Hoist
from hoist_demo.report.rows import render
from hoist_demo.report.summary import summarize


class Proportional:
    """Torque by the speed error alone, on what holds and accelerates the hoist."""

    def __init__(self, hoist: Hoist, holding_torque: float) -> None:
        self.hoist = hoist
        self.holding_torque = holding_torque

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        """Torque of the step that begins now.

        This law has no memory, so its state stays as it is.
        """
        error = reference.speed - measured.speed  # m/s
        force = self.hoist.moving_mass * reference.acceleration + 4e5 * error  # N
        torque = self.holding_torque + self.hoist.sheave_radius * force
        limit = self.hoist.torque_available(measured.speed / self.hoist.sheave_radius)
        return Command(min(max(torque, -limit), limit), abs(torque) > limit, state)


if len(sys.argv) != 2:
    sys.exit("usage: python examples/own_controller.py FMU")
case = find_case("rope-120")
rope = FmuRope(Path(sys.argv[1]), case.rope)
result = Host(rope, case.hoist, case.winding, controller=Proportional).run()
rope.close()
print(render(summarize(result, case.hoist, case.winding, Coupling())))
