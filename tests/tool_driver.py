"""Winds an FMU in an importing tool from the package index, in a process of its own; prints the end forces as JSON.

What the tools were found to do, and what the driver makes of it:

fmpy      simulate_fmu sets the inputs of t_k and steps to t_k + H; the inputs of 0 are set before initialisation. There
          is no way to give it the inputs of the end of a step, so it runs with the reading of FMI's text alone.
libcosim  loads FMI 1 and 2. The slave is instantiated when it is added; set-up, initialisation mode and the initial
          values come with the first step. A step is: manipulators' values set, doStep of all slaves (in parallel, a
          thread each), outputs read, connections transferred. An override manipulator holds its values until they are
          replaced. Time is an integer number of nanoseconds.
ecos      loads FMI 1, 2 and 3. Parameters and initial values come in a parameter set that init() names. Values set
          between two steps are handed over at the start of the next; outputs are read and connections transferred
          after all instances have stepped. It needs libtbb: LD_LIBRARY_PATH on the `lib` of the environment.

Both masters are thus of the Jacobi kind: what one component sends, the other has one step later.

Rounding of the clock is part of the comparison, because the rope's axial waves make 1e-8 of the force out of the last
digit of a time: fmpy counts t_k = k H, libcosim whole nanoseconds, both with h = t_k+1 - t_k; ecos adds up t += H.
"""

import itertools
import json
import sys
from collections.abc import Callable

import fmpy
import numpy as np

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding

H = 0.01
TRAVEL = 90.0  # m, the winding of the 120 m rope
REFERENCE = s_curve(Winding(travel=TRAVEL, start_delay=0.0))
STEPS = round((REFERENCE.duration + 1.0) / H)
FORCES = tuple(f"{side}.{key}" for side in ("left", "right") for key in ("fx", "fy", "fz", "mx", "my", "mz"))
INPUTS = tuple(f"{side}.{key}" for side in ("left", "right") for key in ("y", "vy", "ay"))

#: start values: steps as long as the host's
START = {"solver.step_max": H, "solver.tolerance": 1e6}

Rows = list[list[float]]


def inputs(t: float) -> list[float]:
    """Values of INPUTS: the left conveyance rises by TRAVEL, the right one falls."""
    p = REFERENCE.at(t)
    return [p.position, p.speed, p.acceleration, TRAVEL - p.position, -p.speed, -p.acceleration]


def clock(tool: str, steps: int) -> list[tuple[float, float]]:
    """Arguments t, h of each doStep."""
    if tool == "ecos":
        return [(t, H) for t in itertools.accumulate([0.0] + [H] * (steps - 1))]
    times = [k * H if tool == "fmpy" else k * round(H * 1e9) / 1e9 for k in range(steps + 1)]
    return [(t, after - t) for t, after in itertools.pairwise(times)]


def fmpy_rows(path: str, at_end: bool, steps: int) -> Rows:
    """Forces after each step."""
    if at_end:
        raise ValueError("simulate_fmu has no inputs of a step's end")
    times = H * np.arange(steps + 1)
    columns = np.array([inputs(t) for t in times]).T
    signals = np.rec.fromarrays([times, *columns], names=["time", *INPUTS])
    result = fmpy.simulate_fmu(
        path, stop_time=steps * H, output_interval=H, start_values=START, input=signals, output=list(FORCES)
    )
    return [list(row)[1:] for row in result[1:]]


def libcosim_rows(path: str, at_end: bool, steps: int) -> Rows:
    """Forces after each step."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    references = {v.name: v.valueReference for v in fmpy.read_model_description(path).modelVariables}
    execution = CosimExecution.from_step_size(round(H * 1e9))
    rope = execution.add_local_slave(CosimLocalSlave(path, "rope"))
    execution.boolean_initial_value(rope, references["inputs_at_step_end"], at_end)
    for name, value in START.items():
        execution.real_initial_value(rope, references[name], value)
    # an observer of last values would read all outputs, also those that are costly to compute
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_time_series()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    set_, read = [references[name] for name in INPUTS], [references[name] for name in FORCES]
    for reference in read:
        observer.start_time_series(rope, reference, CosimVariableType.REAL)
    for k in range(steps):
        manipulator.slave_real_values(rope, set_, inputs((k + at_end) * H))
        if not execution.step():
            raise RuntimeError(f"libcosim stopped in step {k}")
    columns = [observer.time_series_real_samples(rope, reference, 1, steps)[2] for reference in read]
    return [list(row) for row in zip(*columns, strict=True)]


def ecos_rows(path: str, at_end: bool, steps: int) -> Rows:
    """Forces after each step."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        structure.add_model("rope", path)
        structure.add_parameter_set(
            "start", {"rope::inputs_at_step_end": at_end} | {f"rope::{name}": value for name, value in START.items()}
        )
        with EcosSimulation(structure=structure, step_size=H) as simulation:
            simulation.init(parameter_set="start")
            rows = []
            for k in range(steps):
                for name, value in zip(INPUTS, inputs((k + at_end) * H), strict=True):
                    simulation.set_real(f"rope::{name}", value)
                simulation.step()
                rows.append([simulation.get_real(f"rope::{name}") for name in FORCES])
            simulation.terminate()
    return rows


TOOLS: dict[str, Callable[[str, bool, int], Rows]] = {"fmpy": fmpy_rows, "libcosim": libcosim_rows, "ecos": ecos_rows}

if __name__ == "__main__":
    tool, fmu, reading, count = sys.argv[1:]
    print("RESULT " + json.dumps(TOOLS[tool](fmu, reading == "end", int(count))))
