"""Trial starts of an FMU with the data of a run, before anything is wound."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import get_args

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.fmu_description import read_parameters
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of, rope_scene
from hoist_demo.cosimulation.progress import warnings_of
from hoist_demo.parameters import start_heights
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import RunData
from rope_model import EndMotion, Level

MAX_LISTED = 5  #: Differences between an FMU and a hoist that a message lists.
#: Relative difference of two numbers that the text of a start value may leave by rounding.
TEXT_ROUNDING = 1e-12


class FmuProbe:
    """Trial starts of an FMU, each made only once."""

    def __init__(self, fmu: Path) -> None:
        self._fmu = fmu
        # messages by parameters and heights, None where the rope starts
        self._refusals: dict[str, str | None] = {}

    def require_start(self, run: RunData) -> None:
        """Refuse a rope that does not start with the run's parameters.

        The message names the key if a single one is the cause.
        """
        heights = start_heights(run.hoist, run.winding)
        refusal = self._refusal(run.rope_values, heights)
        if refusal is None:
            return
        values_of_case = find_case(run.case).rope
        set_here = {
            key: value for key, value in run.rope_values.items() if values_of_case.get(key) != value
        }
        problems = Problems()
        for key, value in set_here.items():
            refusal_of_key = self._refusal({**values_of_case, key: value}, heights)
            if refusal_of_key is not None:
                problems.append(f"{key} = {value!r}: {refusal_of_key}")
        if not problems:
            words = ", ".join(f"{key} = {value!r}" for key, value in set_here.items())
            cause = words or "the FMU's own parameters"
            problems.append(f"{cause}: {refusal}")
        problems.refuse()

    def require_hoist(self, run: RunData) -> None:
        """Refuse an FMU of another hoist.

        All values that the run does not set must start with those of its hoist. The settings of
        accuracy may be those of any level.
        """
        starts = {
            name: p.start
            for name, p in read_parameters(self._fmu).items()
            if name not in run.rope_values
        }
        levels = sorted(get_args(Level), key=lambda level: level != find_case(run.case).level)
        differences: list[dict[str, Value]] = []
        for level in levels:
            try:
                scene = rope_scene(run.rope_values, level)
            except ValueError:
                continue  # the hoist's own settings do not fit this level
            differences.append(_differing(starts, rope_data_of(scene).parameters))
        # settings that fit no level are refused when the rope starts
        fewest = min(differences, key=len, default={})
        if not fewest:
            return
        listed = [f"{key} is {starts[key]} there, {value} here" for key, value in fewest.items()]
        if len(listed) > MAX_LISTED:
            listed[MAX_LISTED:] = [f"and {len(fewest) - MAX_LISTED} more"]
        raise ValueError(
            f"FMU '{self._fmu}' must be of this hoist, '{run.case}', but {len(fewest)} of its "
            f"values that the hoist leaves out differ: {'; '.join(listed)}: export this hoist "
            f"(`balance-rope export {run.case}`), wind the FMU's own, or state them (a hoist's "
            "file, or --set NAME=VALUE)"
        )

    def _refusal(self, parameters: Mapping[str, Value], heights: tuple[float, float]) -> str | None:
        key = json.dumps([dict(parameters), heights], sort_keys=True)
        if key not in self._refusals:
            left, right = (EndMotion(y=y) for y in heights)
            self._refusals[key] = _refusal_at_start(self._fmu, parameters, left, right)
        return self._refusals[key]


def _differing(starts: Mapping[str, Value | None], scene: Mapping[str, Value]) -> dict[str, Value]:
    """Return the values of a scene from which an FMU's start values differ, by name."""
    differing: dict[str, Value] = {}
    for name, start in starts.items():
        if name in scene and start is not None and not _is_equal(start, scene[name]):
            differing[name] = scene[name]
    return differing


def _is_equal(one: Value, other: Value) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=TEXT_ROUNDING)
    return one == other


def _refusal_at_start(
    fmu: Path, parameters: Mapping[str, Value], left: EndMotion, right: EndMotion
) -> str | None:
    """Return the message with which the FMU refuses to start; None if it starts."""
    try:
        rope = FmuRope(fmu, parameters)
    except ValueError as error:
        return str(error)
    try:
        with warnings_of(FmuRope.__module__):  # the runs warn again
            status = rope.initialize(0.0, left, right)
    finally:
        rope.close()
    if status.valid:
        return None
    return status.message or "the FMU does not initialize, without a message"
