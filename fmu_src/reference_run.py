"""Reference run of the rope, to check an FMU after import, after FMI-LS-REF 1.0.0-alpha.1.

Both ends move as at the beginning of a slow trip; inputs are read as FMI does, at the start of each step.  The rope of
the flavour makes it: a native FMU that is exported where there is no engine has no reference run.
"""

import logging
from collections.abc import Callable, Collection, Sequence
from functools import cache
from itertools import product

from fmu_src.interface import MOTION, variables
from fmu_src.xml import node, xml_bytes
from rope_model.boundary.end_paths import EndMotion
from rope_model.cases import RopeCase
from rope_model.codegen.build import NoEngine
from rope_model.public import balance_rope

H = 0.01  #: s, communication step
STEPS = 100  #: of the native flavour
PYTHON_STEPS = 20  #: of the Python flavour, which takes more time for a step
TRAVEL = 2.0  #: m, length of the whole trip
DURATION = 4.0  #: s, its duration
_DIGITS = 6  #: Decimals of results; further ones are rounding, which differs between machines.
_END_OUTPUTS = ("fx", "fy", "fz", "mx", "my", "mz", "fy_mean")
_OUTPUTS = [
    *(f"{side}.{name}" for side, name in product(MOTION, _END_OUTPUTS)),
    *("loop.x", "loop.y", "loop.z", "energy.total"),
]
_TABLES = {"Stimuli": "in", "References": "ref"}
_LAYER = "org.fmi-standard.fmi-ls-ref"
_CRITERION = (
    "every output within the tolerance times (1 + its magnitude), in SI units; "
    "inputs of a step are its start's"
)

Rows = list[dict[str, float]]
log = logging.getLogger(__name__)


def reference_files(
    case: RopeCase, name: str, described: Collection[str], *, native: bool
) -> dict[str, bytes]:
    """Return manifest, experiment, inputs and ``described`` outputs by path; none without a rope.

    Raises RuntimeError if the run fails.
    """
    try:
        inputs, results = _run(case, native)
    except NoEngine as error:
        log.warning("the FMU has no reference run to check it by: %s", error)
        return {}
    outputs = ["time", *(key for key in _OUTPUTS if key in described)]
    times = {
        "startTime": 0,
        "stopTime": _text(inputs[-1]["time"]),
        "stepSize": _text(H),
        "tolerance": "1e-6",
    }
    stimuli, expected = (node(tag, source=f"{name}_{end}.csv") for tag, end in _TABLES.items())
    experiment = node(
        "Experiment", stimuli, expected, name="slow trip", description=_CRITERION, **times
    )
    related = {
        "type": "application/x-ma-ls-experiments",
        "role": "experiment/smoke-test",
        "source": f"{name}.exp",
    }
    head = {
        "xmlns:fmi-ls": "http://fmi-standard.org/fmi-ls-manifest",
        "fmi-ls:fmi-ls-name": _LAYER,
        "fmi-ls:fmi-ls-version": "1.0.0-alpha.1",
        "fmi-ls:fmi-ls-description": (
            "Layered Standard providing information on related files included in an FMU."
        ),
    }
    files = {
        "fmi-ls-manifest.xml": xml_bytes(node("fmiReferences", node("Related", **related), **head)),
        f"{name}.exp": xml_bytes(node("Experiments", experiment, name=name)),
        f"{name}_in.csv": _table([*inputs[0]], inputs, _text),
        f"{name}_ref.csv": _table(outputs, results, lambda x: f"{round(x, _DIGITS) + 0.0:.9g}"),
    }
    return {f"extra/{_LAYER}/{path}": data for path, data in files.items()}


@cache
def _run(case: RopeCase, native: bool) -> tuple[Rows, Rows]:
    """Return inputs and outputs at each instant; raises NoEngine."""
    rope = balance_rope(case.scene, "native" if native else "reference")
    steps = STEPS if native else PYTHON_STEPS
    table = variables(case)
    start = {
        v.name: v.start for v in table if v.causality == "input" and isinstance(v.start, float)
    }
    inputs: Rows = []
    results: Rows = []
    motion = start
    status = rope.initialize(0.0, *_ends(start))
    for k in range(steps + 1):
        if k > 0:
            status = rope.advance_to(k * H, *_ends(motion), (k - 1) * H)
        if not status.valid:
            raise RuntimeError(f"the reference run fails: {status.message}")
        motion = start | _motion(k * H, start["left.y"], start["right.y"])
        inputs.append({"time": k * H} | motion)
        results.append({"time": k * H} | rope.signals(_OUTPUTS))
    return inputs, results


def _ends(motion: dict[str, float]) -> tuple[EndMotion, EndMotion]:
    left, right = (EndMotion(*map(motion.__getitem__, names)) for names in MOTION.values())
    return left, right


def _motion(t: float, left: float, right: float) -> dict[str, float]:
    """Return the inputs at ``t``: the lower end rises."""
    s = t / DURATION
    travel = TRAVEL if left <= right else -TRAVEL
    x = travel * s**3 * (10 - 15 * s + 6 * s**2)
    v = travel / DURATION * 30 * s**2 * (1 - s) ** 2
    a = travel / DURATION**2 * 60 * s * (1 - s) * (1 - 2 * s)
    return {
        "left.y": left + x,
        "left.vy": v,
        "left.ay": a,
        "right.y": right - x,
        "right.vy": -v,
        "right.ay": -a,
    }


def _text(x: float) -> str:
    return f"{x:.15g}"


def _table(columns: Sequence[str], rows: Rows, text: Callable[[float], str]) -> bytes:
    """Return the table as text, with a time in the first column."""
    lines = [",".join(f'"{column}"' for column in columns)]
    for row in rows:
        t, *values = (row[column] for column in columns)
        lines.append(",".join([_text(t), *map(text, values)]))
    return "\n".join([*lines, ""]).encode()
