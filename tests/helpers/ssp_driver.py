"""Winds the SSP of hoist and rope in a tool, in a process of its own; prints some signals after each step as JSON.

Arguments: tool, archive, number of steps, and signals other than SIGNALS as COMPONENT:NAME.

ecos      opens SSP 1.0; the binding inside is applied when init() is given the name of its parameter set. During
          initialisation it hands values over between the FMUs until they agree.
libcosim  opens SSP 1.0, the binding included, and takes the step from its own annotation. What an observer tells of an
          input is the value with which the last step was made.
fmpy      reads and validates SSP 1.0 (fmpy.ssp.ssd). Its simulate_ssp ignores the bindings inside, and before the first
          step all connectors are zero: the rope, initialised at 90 m, is told 0 m and refuses. So a loop of this file
          takes the structure that FMPy read, with values handed over during initialisation.
master    the same loop as a fixed-step master runs it (OMSimulator's is not on the package index): with the step of
          its annotation, adding it up to the stop time of the file, whatever rest that leaves for the last step.
"""

import json
import shutil
import sys
import zipfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import fmpy
from fmpy.ssp.ssd import read_ssd
from masters import remainder_steps
from native_host import OK, Host

H = 0.01
SIGNALS = tuple(("drive", name) for name in ("left.y", "right.y", "left.vy", "drive.torque"))
SIGNALS += ("rope", "left.fy"), ("rope", "right.fy")
Rows = list[list[float]]
#: values of a parameter set by their type
READ: dict[str, Callable[[str], float | bool]] = {
    "Real": float,
    "Integer": int,
    "Boolean": "true".__eq__,
}


def adding_steps(steps: int, h: float = H) -> Iterator[tuple[float, float]]:
    """The clock of ecos: t and h of each step."""
    t = 0.0
    for _ in range(steps):
        yield t, h
        t += h


def counted_steps(steps: int) -> Iterator[tuple[float, float]]:
    """The clock of libcosim, in nanoseconds."""
    for k in range(steps):
        t = k * 10_000_000 / 1e9
        yield t, (k + 1) * 10_000_000 / 1e9 - t


def to_the_end(ssp: str) -> Iterator[tuple[float, float]]:
    """The clock of a fixed-step master, by the annotation and the stop time of the file."""
    with zipfile.ZipFile(ssp) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    master, experiment = (
        root.find(f".//{{*}}{name}") for name in ("FixedStepMaster", "DefaultExperiment")
    )
    return remainder_steps(float(master.get("stepSize", "")), float(experiment.get("stopTime", "")))


def fmpy_rows(ssp: str, clock: Iterable[tuple[float, float]]) -> Rows:
    """Jacobi: all inputs set, all FMUs stepped, all outputs read."""
    system = read_ssd(ssp).system
    folder = fmpy.extract(ssp)
    parts: dict[str, Host] = {}
    folders = [folder]
    for component in system.elements:
        path = Path(folder) / component.source
        folders.append(fmpy.extract(str(path)))
        parts[component.name] = part = Host(path, folders[-1])
        for binding in component.parameterBindings:
            for parameter in binding.parameterValues[0].parameters:
                part.set(**{parameter.name: READ[parameter.type](parameter.value)})
        assert part.enter() == OK, part.said

    def hand_over() -> None:
        values = [parts[c.startElement].get(c.startConnector)[0] for c in system.connections]
        for connection, value in zip(system.connections, values, strict=True):
            parts[connection.endElement].set(**{connection.endConnector: value})

    hand_over()
    hand_over()
    for part in parts.values():
        part.call("ExitInitializationMode")
    rows = []
    for t, h in clock:
        hand_over()
        for name, part in parts.items():
            if message := part.step(t, h):
                raise RuntimeError(f"{name}, doStep({t!r}, {h!r}): {message}")
        rows.append([float(parts[component].get(name)[0]) for component, name in SIGNALS])
    for part in parts.values():
        part.call("Terminate")
        part.free()
    for path in folders:
        shutil.rmtree(path, ignore_errors=True)
    return rows


def ecos_rows(ssp: str, steps: int) -> Rows:
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

    execution = CosimExecution.from_ssp_file(ssp)
    observer = CosimObserver.create_time_series()
    execution.add_observer(observer)
    places = []
    for component, name in SIGNALS:
        index = execution.slave_index_from_instance_name(component)
        variables = execution.slave_variables(index)
        places.append((index, next(v.reference for v in variables if v.name == name.encode())))
    for place in places:
        observer.start_time_series(*place, CosimVariableType.REAL)
    if not all(execution.step() for _ in range(steps)):
        raise RuntimeError("libcosim stopped")
    series = [observer.time_series_real_samples(*place, 1, steps) for place in places]
    assert series[0][0][-1] == round(steps * H * 1e9)
    columns = [values for _, _, values in series]
    return [list(row) for row in zip(*columns, strict=True)]


TOOLS: dict[str, Callable[[str, int], Rows]] = {
    "ecos": ecos_rows,
    "libcosim": libcosim_rows,
    "fmpy_adding": lambda ssp, steps: fmpy_rows(ssp, adding_steps(steps)),
    "fmpy_5_ms": lambda ssp, steps: fmpy_rows(ssp, adding_steps(steps, 0.005)),
    "fmpy_2.5_ms": lambda ssp, steps: fmpy_rows(ssp, adding_steps(steps, 0.0025)),
    "fmpy_counting": lambda ssp, steps: fmpy_rows(ssp, counted_steps(steps)),
    "master": lambda ssp, steps: fmpy_rows(ssp, to_the_end(ssp)),
}

if __name__ == "__main__":
    tool, archive, count, *others = sys.argv[1:]
    if others:
        SIGNALS = tuple((one.split(":")[0], one.split(":")[1]) for one in others)
    print("RESULT " + json.dumps(TOOLS[tool](archive, int(count))))
