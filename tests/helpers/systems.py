"""Hoist drive and rope as one SSP."""

from pathlib import Path

import ssp_driver

from fmu_src.ssp import Component, System, export_ssp
from hoist_demo.cases.table import find_case
from hoist_demo.drive_fmu.description import duration

STOP = duration(find_case("rope-120").winding)

COUPLING = {"inputs_at_step_end": False}  # drive and rope step at the same time


def system(folder: Path, rope: Path, drive: Path) -> Path:
    components = [Component("drive", drive, {}), Component("rope", rope, COUPLING)]
    whole = System("FrictionHoist", stop=STOP, step=ssp_driver.H)
    return export_ssp(folder / "balance_rope.ssp", components, whole)
