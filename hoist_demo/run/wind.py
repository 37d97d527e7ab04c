"""One winding with any rope."""

from pathlib import Path

from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host, Progress
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.cosimulation.trip_plan import NeighbouringTrips
from hoist_demo.design.controllers import Drive, design_drive
from hoist_demo.run.data import RunData


def wind_run(
    run: RunData,
    rope: RopePlant,
    progress: Progress | None = None,
    drive: Drive | None = None,
    neighbours: NeighbouringTrips | None = None,
    save_to: Path | None = None,
    resume: Checkpoint | None = None,
    name: str = "",
) -> Result:
    """Return the co-simulation of a run with any rope.

    ``drive`` is the design of the run if it is known; ``neighbours`` are the trips of a duty before
    and after. ``progress``, ``save_to``, ``resume`` and ``name`` are those of ``Host.run``.
    """
    drive = drive or design_drive(run)
    host = Host(
        rope,
        run.hoist,
        run.winding,
        run.coupling,
        drive.gains,
        trajectory=drive.trajectory,
        neighbours=neighbours,
    )
    return host.run(progress, save_to, resume, name)
