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
"""


def interface_page() -> str:
    """The page; the numbered shape points are folded into one row per axis."""
    table = variables(rope_120())
    lines = [_INTRODUCTION]
    for causality, title in (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs")):
        lines += [f"## {title}", "", "| name | unit | start | |", "|---|---|---|---|"]
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
