"""Ropes in this process: those of named hoists, and some for groups of several."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.schemes.interface import Reader
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import build_single_trip
from hoist_demo.run.ropes import Ropes, ropes_of
from rope_model import EndMotion, Level, Status

CASE = find_case("rope-120")
KNOWN = 2.336e5


def rope(coupling: float = KNOWN, **more: float) -> InProcessRope:
    """A draft rope with torsion."""
    given = {name.replace("_", ".", 1): value for name, value in more.items()}
    values = {**CASE.rope, "rope.Qb": coupling, "rope.Qc": coupling, "model.fidelity": 1, **given}
    return InProcessRope(rope_scene(values, "draft"))


def rope_in_process(
    case: str, level: Level = "standard", parameters: Mapping[str, Value] | None = None
) -> InProcessRope:
    """The rope of a named case at a level of accuracy, with other parameters by FMI name."""
    return InProcessRope(rope_scene({**find_case(case).rope, **(parameters or {})}, level))


def ropes_in(path: Path) -> Ropes:
    """Ropes of a hoist's file."""
    case = find_case(str(path))
    return ropes_of(case, build_single_trip(str(path), {}), {}, case.level)


@dataclass
class Weight:
    """A rope whose forces are given, and which remembers how its ends moved."""

    forces: dict[str, float]
    ends: list[tuple[EndMotion, EndMotion]] = field(default_factory=list)

    def initialize(self, t0: float, left: EndMotion, right: EndMotion) -> Status:
        self.ends.append((left, right))
        return Status(True)

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        self.ends.append((left, right))
        return Status(True)

    def reader(self, names: Sequence[str]) -> Reader:
        return lambda: np.array([self.forces.get(name, math.nan) for name in names])

    def units(self) -> dict[str, str]:
        return dict.fromkeys(self.forces, "")

    def save(self) -> Any:
        return None
