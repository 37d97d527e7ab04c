"""The interface table as Markdown: ``python -m fmu_src.documentation > docs/interface.md``."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator

from rope_model.parameters import rope_120

from .interface import Variable, variables

_INTRODUCTION = """\
# The FMU's variables

FMI 2.0 co-simulation, start values of the 120 m scene. Units are SI; `1` marks a pure number. Parameters marked
*tunable* may be changed between steps, the others only before initialisation. [assumed] marks data that are ours.

X points from the left to the right suspension point, Y up, Z = X x Y out of plane. The nominal suspension points are
at x = -spacing/2 and +spacing/2, z = 0; inputs `x` and `z` count from there, `y` is the height in the shaft from any
origin common to both ends. Yaw of conveyances and loop is positive about Y. Twist and torque are positive about the
rope's tangent, which is -Y at the left end and +Y at the right end. Forces and moments are those of the rope on the
conveyance. A run starts from rest. Give `y`, `vy` and `ay` of one smooth motion: an end that would have to
accelerate by more than 100 m/s^2 within a step is refused.

When a call fails, doStep returns *discard* (FMPy's `simulate_fmu` then ends early without an error), `status.valid` is
false and `status.message` names value, bound and cure; the state is that before the step, which may be tried again.
After a failed initialisation the real outputs are NaN. `added_mass` is for hosts that want to step heavy coupling
implicitly: how much the end's pull grows with an upward acceleration held over one communication step.
"""


def interface_page() -> str:
    """The page; the numbered shape points are folded into one row per axis."""
    table = variables(rope_120())
    lines = [_INTRODUCTION]
    for causality, title in (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs")):
        lines += [f"## {title}", "", "| name | unit or type | start | |", "|---|---|---|---|"]
        lines += _rows([v for v in table if v.causality == causality])
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _rows(table: list[Variable]) -> Iterator[str]:
    for v in table:
        if match := re.fullmatch(r"(shape\.[xyz])\[(\d+)\]", v.name):
            if match[2] == "1":
                yield f"| `{match[1]}[1]` ... `[81]` | {v.unit} | | points along the rope, denser around the loop |"
            continue
        start = "" if v.start is None else str(v.start).lower() if isinstance(v.start, bool) else f"{v.start:g}"
        tunable = "*tunable*; " if v.variability == "tunable" else ""
        yield f"| `{v.name}` | {v.unit or v.kind} | {start} | {tunable}{v.description} |"


if __name__ == "__main__":
    sys.stdout.write(interface_page())
