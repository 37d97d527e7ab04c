"""The hoist's drive and the rope at 5 and 10 ms, in libcosim and ecos, which repeat the slower part's values.

Run as a program it steps one tool: ``python -m evidence.signals.multirate TOOL FOLDER``, for ecos with libtbb on
LD_LIBRARY_PATH.  The force is compared with that of both parts at 5 ms.
"""

import importlib.util
import json
import os
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from evidence.tables import Tables, table
from fmu_src.native.export import export_model, export_native
from fmu_src.profile import FULL
from fmu_src.shell.build import host_platform
from hoist_demo.cases.table import find_case
from hoist_demo.drive_fmu.description import drive_model

COLUMNS = ("tool", "drive [s]", "rope [s]", "RMS", "largest", "told", "repeated", "failure")
PACKAGES = {"libcosim": "libcosimpy", "ecos": "ecospy"}
STEP = 0.005
STOP = 26.0
#: steps of drive and rope, s
PAIRS = ((2 * STEP, STEP), (STEP, 2 * STEP))
READ = ("left.fy", "status.end_force_error", "inputs.repeated")
MOTIONS = tuple(f"{side}.{kind}" for side in ("left", "right") for kind in ("y", "vy", "ay"))
FORCES = ("left.fy_mean", "right.fy_mean")
_OSP = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"


def tables() -> Tables:
    """Step every tool with every pair of steps."""
    with TemporaryDirectory() as folder:
        return {"multirate": table(COLUMNS, list(multirate(Path(folder))))}


def multirate(folder: Path) -> Iterator[tuple[Any, ...]]:
    """A row for each tool that is installed, and each pair of steps."""
    here = (host_platform(),)
    export_native(folder / "rope.fmu", platforms=here, profile=FULL)
    export_model(folder / "drive.fmu", here, 2, drive_model(find_case("rope-120")))
    for tool, package in PACKAGES.items():
        if importlib.util.find_spec(package) is None:
            print(f"{tool} is left out: {package} is not installed", file=sys.stderr)
            continue
        equal = _stepped(tool, folder, STEP, STEP)
        for steps in PAIRS:
            found = _stepped(tool, folder, *steps)
            if isinstance(equal, str) or isinstance(found, str):
                why = equal if isinstance(equal, str) else found
                yield tool, *steps, np.nan, np.nan, np.nan, np.nan, why
                continue
            at = slice(1, None, 2)  # instants of both parts
            off = (found[at, 0] - equal[at, 0]) / np.abs(equal[:, 0]).max()
            yield (
                tool,
                *steps,
                np.sqrt((off**2).mean()),
                np.abs(off).max(),
                found[-1, 1],
                found[-1, 2],
                "",
            )


def _stepped(tool: str, folder: Path, *steps: float) -> Any:
    """READ every STEP, or why there is nothing."""
    libraries = str(Path(sysconfig.get_path("data")) / "lib")
    command = [
        sys.executable,
        "-m",
        "evidence.signals.multirate",
        tool,
        str(folder),
        *map(str, steps),
    ]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "LD_LIBRARY_PATH": libraries},
    )
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT ")), None)
    return (
        done.stderr[-300:] or "no result"
        if line is None
        else np.array(json.loads(line.removeprefix("RESULT ")))
    )


def _libcosim(folder: Path, *steps: float) -> list[list[float]]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    (folder / "OspSystemStructure.xml").write_text(_structure(*steps), encoding="utf-8")
    execution = CosimExecution.from_osp_config_file(str(folder))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    rope = execution.slave_index_from_instance_name("rope")
    place = {v.name.decode(): v.reference for v in execution.slave_variables(rope)}
    rows = []
    for _ in range(round(STOP / STEP)):
        if not execution.step():
            raise RuntimeError("libcosim stopped")
        reals = observer.last_real_values(rope, [place[name] for name in READ[:2]])
        rows.append([*reals, *observer.last_integer_values(rope, [place[READ[2]]])])
    return rows


def _structure(drive_step: float, rope_step: float) -> str:
    """The system for libcosim, with a step for each part."""

    def connection(source: str, target: str, name: str) -> str:
        ends = "".join(f'<Variable simulator="{part}" name="{name}"/>' for part in (source, target))
        return f"<VariableConnection>{ends}</VariableConnection>"

    links = "".join(connection("drive", "rope", name) for name in MOTIONS)
    links += "".join(connection("rope", "drive", name) for name in FORCES)
    return (
        f'<OspSystemStructure xmlns="{_OSP}" version="0.1"><BaseStepSize>{STEP}</BaseStepSize>'
        "<Algorithm>fixedStep</Algorithm><Simulators>"
        f'<Simulator name="drive" source="drive.fmu" stepSize="{drive_step}"/>'
        f'<Simulator name="rope" source="rope.fmu" stepSize="{rope_step}"/></Simulators>'
        f"<Connections>{links}</Connections></OspSystemStructure>"
    )


def _ecos(folder: Path, *steps: float) -> list[list[float]]:
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    structure.add_model("drive", str(folder / "drive.fmu"), step_size_hint=steps[0])
    structure.add_model("rope", str(folder / "rope.fmu"), step_size_hint=steps[1])
    for name in MOTIONS:
        structure.make_real_connection(f"drive::{name}", f"rope::{name}")
    for name in FORCES:
        structure.make_real_connection(f"rope::{name}", f"drive::{name}")
    with EcosSimulation(structure=structure, step_size=STEP) as simulation:
        simulation.init()
        rows = []
        for _ in range(round(STOP / STEP)):
            simulation.step()
            reals = [simulation.get_real(f"rope::{name}") for name in READ[:2]]
            rows.append([*reals, simulation.get_integer(f"rope::{READ[2]}")])
        simulation.terminate()
    return rows


if __name__ == "__main__":
    tool, folder, *steps = sys.argv[1:]
    step = {"libcosim": _libcosim, "ecos": _ecos}[tool]
    print("RESULT", json.dumps(step(Path(folder), *map(float, steps))))
