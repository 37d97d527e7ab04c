"""Drives the exported FMU in a process of its own; the tests send it a scenario by name and read JSON back.

An FMU shares the interpreter of the process that loads it, so each test gives it a fresh one.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from native_host import Host

from benchmarks.kinematic import fixed_steps
from rope_model.parameters import rope_120
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.sensitivity import LOADS
from rope_model.simulation.simulator import RopeSimulator

H = 0.01
#: steps as long as the host's
EVEN = {"inputs_at_step_end": True, "solver__step_max": H, "solver__tolerance": 1e6}
COMPARED = [f"{side}.{key}" for side in ("left", "right") for key in ("fx", "fy", "fz", "mx", "my", "mz", "fy_mean")]
COMPARED += ["loop.x", "loop.y", "loop.z", "loop.yaw", "loop.clearance", "stress.bending_max", "energy.total"]
#: arrays, one number of each
ALONG = [f"shape.{name}[{i}]" for name in ("x", "tension", "bending", "torsion") for i in (30, 41)]


def motion(t: float, travel: float = 20.0, duration: float = 5.0) -> tuple[dict[str, float], dict[str, float]]:
    """A smooth trip of the 120 m scene, as inputs of both ends."""
    s = min(max(t / duration, 0.0), 1.0)
    x = travel * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = travel / duration * 30 * s**2 * (1 - s) ** 2
    a = travel / duration**2 * (60 * s - 180 * s**2 + 120 * s**3)
    return {"y": x, "vy": v, "ay": a}, {"y": 90.0 - x, "vy": -v, "ay": -a}


class Fmu:
    """One instance, variables by name."""

    def __init__(self, path: str, folder: str, name: str = "rope") -> None:
        description = fmpy.read_model_description(path)
        self.variables = {v.name: v for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.instantiate()

    def set(self, **values: Any) -> None:
        for name, value in values.items():
            variable = self.variables[name.replace("__", ".")]
            getattr(self.slave, f"set{variable.type}")([variable.valueReference], [value])

    def get(self, *names: str) -> list[Any]:
        out = []
        for name in names:
            variable = self.variables[name]
            value = getattr(self.slave, f"get{variable.type}")([variable.valueReference])[0]
            out.append(value.decode() if isinstance(value, bytes) else value)
        return out

    def start(self, **parameters: Any) -> None:
        self.set(**parameters)
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def move(self, t: float) -> None:
        """Inputs for the time ``t``."""
        for side, values in zip(("left", "right"), motion(t), strict=True):
            self.set(**{f"{side}.{key}": value for key, value in values.items()})

    def step(self, t: float, h: float = H) -> str:
        """'' or what the FMU says when the step fails."""
        try:
            self.slave.doStep(t, h)
        except FMICallException:
            valid, message = self.get("status.valid", "status.message")
            return message if not valid else "failed with status.valid true"
        return ""

    def run(self, first: int, last: int) -> list[list[float]]:
        """Steps of H with the inputs of their end."""
        record = []
        for k in range(first, last):
            self.move((k + 1) * H)
            message = self.step(k * H)
            if message:
                raise RuntimeError(message)
            record.append(self.get(*COMPARED, *ALONG))
        return record

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()


@contextmanager
def extract(path: str) -> Iterator[str]:
    """The FMU's folder."""
    folder = fmpy.extract(path)
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


def same_as_in_process(path: str) -> Any:
    """Largest difference from the in-process rope, relative to each signal's largest value."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.start(**EVEN)
        record = fmu.run(0, 250)
        fmu.close()
    rope = RopeSimulator(rope_120().scene.with_(solver=fixed_steps(H)))
    rope.initialize(0.0, *(EndMotion(**m) for m in motion(0.0)))
    expected = []
    for k in range(250):
        rope.advance_to(k * H + H, *(EndMotion(**m) for m in motion((k + 1) * H)))
        values = rope.signals()
        expected.append([values[name] for name in (*COMPARED, *ALONG)])
    worst = 0.0
    for i in range(len(expected[0])):
        scale = max(abs(row[i]) for row in expected) or 1.0
        worst = max(worst, max(abs(a[i] - b[i]) for a, b in zip(record, expected, strict=True)) / scale)
    return {"worst": worst, "transformations": rope.state.counts.transformations}


def rollback(path: str) -> Any:
    """Save, go on over a transformation, restore (also from bytes, in another instance) and go on again."""
    with extract(path) as folder:
        fmu, other = Fmu(path, folder), Fmu(path, folder, "other")
        fmu.start(**EVEN)
        fmu.run(0, 120)
        state = fmu.slave.getFMUState()
        data = fmu.slave.serializeFMUState(state)
        first = fmu.run(120, 200)
        fmu.slave.setFMUState(state)
        second = fmu.run(120, 200)
        other.start(**EVEN)
        other.slave.setFMUState(other.slave.deSerializeFMUstate(data))
        third = other.run(120, 200)
        count = fmu.get("count.transformations")[0]
        fmu.slave.freeFMUState(state)
        fmu.close()
        other.close()
    return {"same": first == second == third, "transformations": count, "data": data.hex(), "last": first[-1]}


def continue_from(path: str, data: str) -> Any:
    """Go on from bytes that another process serialized."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.start(**EVEN)
        fmu.slave.setFMUState(fmu.slave.deSerializeFMUstate(bytes.fromhex(data)))
        record = fmu.run(120, 200)
        fmu.close()
    return record[-1]


def two_instances(path: str, second: str) -> Any:
    """Two instances of one FMU interleaved, and one of another FMU beside them."""
    with extract(path) as folder, extract(second) as second_folder:
        a, b, c = Fmu(path, folder, "a"), Fmu(path, folder, "b"), Fmu(second, second_folder, "c")
        for fmu in (a, b, c):
            fmu.start(**EVEN)
        records: list[list[Any]] = [[], []]
        for k in range(60):
            for record, fmu in zip(records, (a, b), strict=True):
                record += fmu.run(k, k + 1)
        lengths = [fmu.get("rope.length")[0] for fmu in (a, c)]
        weights = [sum(fmu.get("left.fy", "right.fy")) for fmu in (a, c)]
        for fmu in (a, b, c):
            fmu.close()
    return {"same": records[0] == records[1], "lengths": lengths, "weights": weights}


def communication_steps(path: str) -> Any:
    """End force after 1 s with various, also varying, communication steps and both readings of the inputs."""
    out = {}
    with extract(path) as folder:
        for name, steps in {
            "5": [0.005] * 200,
            "20": [0.02] * 50,
            "vary": [0.004, 0.016] * 50,
        }.items():
            for at_end in (True, False):
                fmu = Fmu(path, folder)
                fmu.start(inputs_at_step_end=at_end)
                t = 0.0
                for h in steps:
                    fmu.move(t + h if at_end else t)
                    if message := fmu.step(t, h):
                        raise RuntimeError(message)
                    t += h
                out[f"{name} {at_end}"] = fmu.get("left.fy")[0]
                fmu.close()
    return out


def bad_calls(path: str) -> Any:
    """Messages after wrong values and calls in the wrong order; the instance must stay usable."""
    out: dict[str, Any] = {}
    with extract(path) as folder:
        host = Host(Path(path), folder)

        def error_text(call: Callable[[], Any]) -> str:
            try:
                call()
            except FMICallException:
                return host.error()
            return "accepted"

        def step(t: float, h: float = H, **values: float) -> str:
            return error_text(lambda: (host.set(**values), host.fmu.doStep(t, h)))

        out["before initialisation"] = step(0.0)
        host.start(inputs_at_step_end=True)
        state = host.state()
        for name, call in {
            "nan": lambda: step(0.0, left__vy=math.nan),
            "inf": lambda: step(0.0, left__y=math.inf),
            "range": lambda: step(0.0, left__vy=1e4),
            "jump": lambda: step(0.0, left__y=5.0),
            "wrong time": lambda: step(0.5),
            "zero step": lambda: step(0.0, 0.0),
            "negative step": lambda: step(0.0, -0.01),
            "nan step": lambda: step(0.0, math.nan),
            "fixed parameter": lambda: step(0.0, rope__EI=100.0),
            "output set": lambda: step(0.0, left__fy=0.0),
            "unknown reference": lambda: error_text(lambda: host.fmu.setReal([99999], [1.0])),
            "bytes": lambda: error_text(lambda: host.deserialize(b"{}")),
        }.items():
            out[name] = call()
            host.restore(state)
            assert host.step(0.0) == ""
            host.restore(state)
        for name, value in {"rope__EI": -1.0, "left__swivel__mode": 7, "layout__spacing": 500.0}.items():
            host.fmu.reset()
            out[name] = error_text(lambda name=name, value=value: host.start(**{name: value}))
            out[f"{name} step"] = step(0.0)
        host.fmu.reset()
        host.start()
        out["after reset"] = host.step(0.0)
        host.fmu.terminate()
        host.fmu.freeInstance()
    return out


def initialization(path: str) -> Any:
    """End forces in initialization mode, after a change of an input there, and after it."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.slave.setupExperiment(startTime=0.0)
        fmu.slave.enterInitializationMode()
        first = fmu.get("left.fy", "right.fy")
        fmu.set(**{"right.y": 80.0})
        second = fmu.get("left.fy", "right.fy")
        fmu.slave.exitInitializationMode()
        third = fmu.get("left.fy", "right.fy")
        fmu.close()
    return [first, second, third]


def foreign_state(path: str) -> Any:
    """A heavier rope's state, on another mesh, taken over by an instance; then bytes that are no state."""
    with extract(path) as folder:
        heavy, other = Host(Path(path), folder), Host(Path(path), folder)
        heavy.start(rope__mass_per_length=16.0, mesh__kind=1, mesh__elements=60)
        other.start()
        assert heavy.step(0.0) == ""
        other.restore(heavy.state())
        out: dict[str, Any] = {"weight": sum(other.get("left.fy_mean", "right.fy_mean"))}
        try:
            other.deserialize(b"x")
            out["message"] = "accepted"
        except FMICallException:
            out["message"] = other.error()
        out["kept"] = other.get("rope.mass_per_length")[0]
        out["next"] = other.step(H)
        for host in (heavy, other):
            host.fmu.terminate()
            host.fmu.freeInstance()
    return out


def derivatives(path: str) -> Any:
    """By reading of the inputs and name: directional derivatives of all loads, and differences of a step's."""
    out = {}
    with extract(path) as folder:
        for at_end in (True, False):
            host = Host(Path(path), folder)
            host.start(inputs_at_step_end=at_end, solver__tolerance=1e6)

            def step(k: int, host: Host = host, at_end: bool = at_end, **changes: float) -> None:
                for side, values in zip(("left", "right"), motion((k + at_end) * H), strict=True):
                    host.set(**{f"{side}.{key}": value for key, value in values.items()})
                for name, change in changes.items():
                    host.set(**{name: host.get(name)[0] + change})
                assert host.step(k * H) == ""

            for k in range(30):
                step(k)
            state = host.state()
            for name, size in {"left.y": 1e-7, "right.vy": 1e-5, "left.ay": 1e-3, "right.ax": 1e-3}.items():
                forces = []
                for change in (-size, size):
                    host.restore(state)
                    step(30, **{name: change})
                    forces.append(host.get(*LOADS))
                host.restore(state)
                step(30)
                differences = [(b - a) / (2 * size) for a, b in zip(*forces, strict=True)]
                out[f"{at_end} {name}"] = [[host.derivative(load, name) for load in LOADS], differences]
            host.fmu.terminate()
            host.fmu.freeInstance()
    return out


def tunable(path: str) -> Any:
    """A tunable parameter takes effect during the run."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.start(inputs_at_step_end=True)
        fmu.run(0, 10)
        before = fmu.get("count.steps")[0]
        fmu.set(solver__step_max=0.0025)
        fmu.run(10, 20)
        after = fmu.get("count.steps")[0]
        fmu.close()
    return [before, after]


def portable(path: str) -> Any:
    """The interpreted kernels inside the FMU."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.start(inputs_at_step_end=True, solver__kernels=2)
        record = fmu.run(0, 5)
        fmu.close()
    return record[-1]


def brief(path: str) -> Any:
    """As short a life as there is."""
    with extract(path) as folder:
        fmu = Fmu(path, folder)
        fmu.start(inputs_at_step_end=True)
        fmu.run(0, 3)
        fmu.close()
    return True


if __name__ == "__main__":
    scenario, *arguments = sys.argv[1:]
    print("RESULT " + json.dumps(globals()[scenario](*arguments)))
