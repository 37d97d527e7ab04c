"""Winds the SSP of hoist and rope in a tool, in a process of its own; prints some signals after each step as JSON.

ecos      opens SSP 1.0; the binding inside is applied when init() is given the name of its parameter set. During
          initialisation it hands values over between the FMUs until they agree.
libcosim  opens SSP 1.0, the binding included, and takes the step from its own annotation. What an observer tells of an
          input is the value with which the last step was made.
fmpy      reads and validates SSP 1.0 (fmpy.ssp.ssd). Its simulate_ssp ignores the bindings inside, and before the first
          step all connectors are zero: the rope, hung up at 90 m, is told 0 m and refuses. So a loop of this file
          takes the structure that FMPy read, with values handed over during initialisation.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import read_ssd

H = 0.01
SIGNALS = (
    ("drive", "left.y"),
    ("drive", "right.y"),
    ("drive", "left.vy"),
    ("drive", "drive.torque"),
    ("rope", "left.fy"),
    ("rope", "right.fy"),
)
Rows = list[list[float]]


def fmpy_rows(ssp: str, steps: int, adding: bool = True) -> Rows:
    """Jacobi: all inputs set, all FMUs stepped, all outputs read; ``adding``: the clock of ecos, else of libcosim."""
    system, folder = read_ssd(ssp).system, fmpy.extract(ssp)
    fmus: dict[str, tuple[Any, dict[str, Any]]] = {}
    folders = [folder]
    for component in system.elements:
        path = str(Path(folder) / component.source)
        description = fmpy.read_model_description(path)
        folders.append(fmpy.extract(path))
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folders[-1],
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=component.name,
        )
        slave.instantiate()
        fmus[component.name] = slave, {v.name: v for v in description.modelVariables}
        for parameter in (p for b in component.parameterBindings for p in b.parameterValues[0].parameters):
            reference = [fmus[component.name][1][parameter.name].valueReference]
            getattr(slave, f"set{parameter.type}")(reference, [parameter.value == "true"])
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()

    def get(component: str, name: str) -> float:
        slave, variables = fmus[component]
        return float(slave.getReal([variables[name].valueReference])[0])

    def hand_over() -> None:
        values = [get(c.startElement, c.startConnector) for c in system.connections]
        for connection, value in zip(system.connections, values, strict=True):
            slave, variables = fmus[connection.endElement]
            slave.setReal([variables[connection.endConnector].valueReference], [value])

    hand_over()
    hand_over()
    for slave, _ in fmus.values():
        slave.exitInitializationMode()
    rows, t = [], 0.0
    for k in range(steps):
        t = t if adding else k * 10_000_000 / 1e9
        hand_over()
        h = H if adding else (k + 1) * 10_000_000 / 1e9 - t
        for slave, _ in fmus.values():
            slave.doStep(t, h)
        t += H
        rows.append([get(*signal) for signal in SIGNALS])
    for slave, _ in fmus.values():
        slave.terminate()
        slave.freeInstance()
    for path in folders:
        shutil.rmtree(path, ignore_errors=True)
    return rows


def ecos_rows(ssp: str, steps: int) -> Rows:
    """As SIGNALS."""
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=ssp, step_size=H) as simulation:
        simulation.init(parameter_set="initialValues")
        rows = []
        for _ in range(steps):
            simulation.step()
            rows.append([simulation.get_real("::".join(signal)) for signal in SIGNALS])
        simulation.terminate()
    return rows


def libcosim_rows(ssp: str, steps: int) -> Rows:
    """As SIGNALS; the step is that of the file."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution, observer = CosimExecution.from_ssp_file(ssp), CosimObserver.create_time_series()
    execution.add_observer(observer)
    index = {name: execution.slave_index_from_instance_name(name) for name in ("drive", "rope")}
    places = []
    for component, name in SIGNALS:
        variables = execution.slave_variables(index[component])
        places.append((index[component], next(v.reference for v in variables if v.name == name.encode())))
    for place in places:
        observer.start_time_series(*place, CosimVariableType.REAL)
    if not all(execution.step() for _ in range(steps)):
        raise RuntimeError("libcosim stopped")
    series = [observer.time_series_real_samples(*place, 1, steps) for place in places]
    assert series[0][0][-1] == round(steps * H * 1e9)
    return [list(row) for row in zip(*(values for _, _, values in series), strict=True)]


TOOLS: dict[str, Callable[[str, int], Rows]] = {
    "ecos": ecos_rows,
    "libcosim": libcosim_rows,
    "fmpy_adding": fmpy_rows,
    "fmpy_counting": lambda ssp, steps: fmpy_rows(ssp, steps, adding=False),
}

if __name__ == "__main__":
    tool, archive, count = sys.argv[1:]
    print("RESULT " + json.dumps(TOOLS[tool](archive, int(count))))
