"""Warnings of an FMU of any flavour, in a process of its own: ``warning_driver.py FMU`` prints them as JSON."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import fmpy
from native_host import Host

WARNING = 1
OUTPUTS = ("status.valid", "status.warning", "left.swivel.torque", "stress.torsion_max", "stress.bending_max")
#: name -> parameters, and communication steps
RUNS: dict[str, tuple[dict[str, Any], tuple[float, ...]]] = {
    "plain": ({}, (0.01, 0.02)),
    "passed": ({"rope.installed_twist": 7.0}, (0.01, 0.01)),
    "touching": ({"rope.installed_twist": 5.5, "rope.diameter": 0.9, "layout.spacing": 1.0}, (0.01, 0.01)),
    "yawed by its coupling": (
        {
            "rope.length": 690.0,
            "rope.mass_per_length": 8.2,
            "rope.EI": 450.0,
            "layout.spacing": 1.8,
            "left.y": 0.0,
            "right.y": 650.0,
        },
        (),
    ),
    "yawed by its twist": ({"rope.installed_twist": 3.0}, (0.01, 0.01)),
    "yawed by its ends": ({"left.yaw": 2.0, "right.yaw": 1.5}, (0.01, 0.01)),
    "yawed, then wound": ({"rope.installed_twist": 3.0, "right.ay": -1.0}, (0.01,)),
    "spatial": ({"model.fidelity": 2}, (0.01,)),
    "planar": ({"model.fidelity": 3}, (0.01,)),
    "rigid": ({"model.fidelity": 4}, (0.01,)),
    "planar in a cross wind": (
        {"model.fidelity": 3, "rope.Qb": 0.0, "rope.Qc": 0.0, "air.density": 1.2, "air.vz": 5.0},
        (0.01,),
    ),
    "planar without torque": ({"model.fidelity": 3, "rope.Qb": 0.0, "rope.Qc": 0.0}, (0.01,)),
    "long steps": ({}, (0.05, 0.05)),
    "steps of the bound": ({}, (0.02, 0.02)),
    "a long step, then a short one": ({}, (0.05, 0.01)),
    "long steps, motion at their end": ({"inputs_at_step_end": True}, (0.05, 0.05)),
    "large step_max, no step yet": ({"solver.step_max": 0.04}, ()),
}


def collect_warnings(path: str) -> dict[str, Any]:
    """Log warnings and the outputs at the end of each run."""
    folder, out = fmpy.extract(path), {}
    for name, (parameters, steps) in RUNS.items():
        host = Host(Path(path), folder)
        host.start(**parameters)
        t = 0.0
        for h in steps:
            assert host.step(t, h) == ""
            t += h
        warnings = [message for status, message in host.log if status == WARNING]
        out[name] = {"warnings": warnings, **dict(zip(OUTPUTS, host.get(*OUTPUTS), strict=True))}
        host.call("FreeInstance")
    return out


if __name__ == "__main__":
    print("RESULT " + json.dumps(collect_warnings(sys.argv[1])))
