"""The FMU's own opinion of its parameters, before anything runs: it is asked to initialize with them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.progress import warnings_of
from hoist_demo.parameters import start_heights
from hoist_demo.parameters.quantity import Value
from hoist_demo.study.run import RunData
from rope_model import EndMotion


class Probe:
    """Asks an FMU, and the same question only once."""

    def __init__(self, fmu: Path) -> None:
        self._fmu = fmu
        self._answers: dict[str, str] = {}

    def rejection(self, run: RunData) -> list[str]:
        """Return why the rope does not start with the run's parameters, with the key if one alone is to blame."""
        heights = start_heights(run.hoist, run.winding)
        together = self._ask(run.fmu, heights)
        if not together:
            return []
        own = find_case(run.case).rope
        set_here = {key: value for key, value in run.fmu.items() if own.get(key) != value}
        alone = {key: self._ask({**own, key: value}, heights) for key, value in set_here.items()}
        blamed = [f"{key} = {run.fmu[key]!r}: {answer}" for key, answer in alone.items() if answer]
        chosen = ", ".join(f"{key} = {value!r}" for key, value in set_here.items()) or "the FMU's own parameters"
        return blamed or [f"{chosen}: {together}"]

    def _ask(self, parameters: Mapping[str, Value], heights: tuple[float, float]) -> str:
        question = json.dumps([dict(parameters), heights], sort_keys=True)
        if question not in self._answers:
            left, right = (EndMotion(y=y) for y in heights)
            self._answers[question] = _answer(self._fmu, parameters, left, right)
        return self._answers[question]


def _answer(fmu: Path, parameters: Mapping[str, Value], left: EndMotion, right: EndMotion) -> str:
    """Return why the FMU does not start; "" if it does."""
    try:
        rope = FmuRope(fmu, parameters)
    except ValueError as error:
        return str(error)
    try:
        with warnings_of(FmuRope.__module__):  # the runs tell them again
            status = rope.initialize(0.0, left, right)
    finally:
        rope.close()
    return "" if status.valid else status.message or "the FMU does not initialize, without a message"
