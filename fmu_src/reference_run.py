"""A short run of the rope, to compare an FMU with after import; the format is that of the FMI cross-check.

Both ends move as in the first second of a slow trip; inputs are read as FMI does, at the start of each step.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache

from rope_model.parameters import RopeCase
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

from .interface import MOTION, variables
from .steps import advance_with_extrapolation

H, STEPS = 0.01, 100
#: m and s of the whole trip
TRAVEL, DURATION = 2.0, 4.0
_OUTPUTS = [f"{side}.{key}" for side in ("left", "right") for key in ("fx", "fy", "fz", "mx", "my", "mz", "fy_mean")]
_OUTPUTS += ["loop.x", "loop.y", "loop.z", "energy.total"]


@cache
def reference_files(case: RopeCase, name: str, described: frozenset[str]) -> Mapping[str, bytes]:
    """``name``_in.csv, ``name``_ref.csv and ``name``_ref.opt of ``described`` outputs; RuntimeError when it fails."""
    outputs = [key for key in _OUTPUTS if key in described]
    # the form of the kernels that every machine has, and that needs no compiler
    scene = case.scene.with_(solver=replace(case.scene.solver, kernels="portable"))
    rope, table = RopeSimulator(scene), variables(case)
    start = {v.name: v.start for v in table if v.causality == "input" and isinstance(v.start, float)}
    inputs, results = [("time", *start)], [("time", *outputs)]
    motion, status = start, rope.initialize(0.0, *_ends(start))
    for k in range(STEPS + 1):
        if k > 0:
            status = advance_with_extrapolation(rope, (k - 1) * H, H, *_ends(motion))
        if not status.valid:
            raise RuntimeError(f"the reference run fails: {status.message}")
        motion = start | _motion(k * H, start["right.y"])
        inputs.append((_text(k * H), *map(_text, motion.values())))
        results.append((_text(k * H), *map(_round, rope.signals(outputs).values())))
    options = f"StartTime, 0\nStopTime, {_text(H * STEPS)}\nStepSize, {_text(H)}\nRelTol, 1e-6\n"
    return {
        f"{name}_in.csv": "\n".join(_lines(inputs)).encode(),
        f"{name}_ref.csv": "\n".join(_lines(results)).encode(),
        f"{name}_ref.opt": options.encode(),
    }


def _ends(motion: dict[str, float]) -> tuple[EndMotion, EndMotion]:
    left, right = (EndMotion(*(motion[name] for name in names)) for names in MOTION.values())
    return left, right


def _motion(t: float, height: float) -> dict[str, float]:
    s = t / DURATION
    x = TRAVEL * s**3 * (10 - 15 * s + 6 * s**2)
    v = TRAVEL / DURATION * 30 * s**2 * (1 - s) ** 2
    a = TRAVEL / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    names = ("left.y", "left.vy", "left.ay", "right.y", "right.vy", "right.ay")
    return dict(zip(names, (x, v, a, height - x, -v, -a), strict=True))


def _text(x: float) -> str:
    return f"{x:.15g}"


def _round(x: float) -> str:
    """Nine digits, six decimals: below is rounding, which differs between machines."""
    return f"{round(x, 6) + 0.0:.9g}"


def _lines(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield from (",".join(f'"{cell}"' if i == 0 else cell for cell in row) for i, row in enumerate(rows))
    yield ""
