"""One winding with any rope."""

from hoist_demo.cosimulation.host import Host, Progress
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.cosimulation.trip_plan import NeighbouringTrips
from hoist_demo.design.controllers import Drive
from hoist_demo.run.data import RunData


def wind_run(
    run: RunData,
    rope: RopePlant,
    progress: Progress | None = None,
    drive: Drive | None = None,
    neighbours: NeighbouringTrips | None = None,
) -> Result:
    """Return the co-simulation of a run with any rope.

    `progress` is that of `Host.run`; `drive` is the design of the run if it is known; `neighbours` are
    the trips of a duty before and after.
    """
    drive = drive or run.design()
    host = Host(
        rope,
        run.hoist,
        run.winding,
        run.coupling,
        drive.gains,
        trajectory=drive.trajectory,
        neighbours=neighbours,
    )
    return host.run(progress)
