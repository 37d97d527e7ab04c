"""Units of parameters: one spelling, and the unit that each field of a data class states in its comment.

The house writes every field with its unit as the first words of the comment, `spacing: float = 2.0  # m, between ...`;
that comment is the only place where the unit is written, and it is read from there.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from typing import Any

_FIELD = re.compile(r"^    (\w+): [^#]+#\s*(.+)$", re.MULTILINE)


def spelled(unit: str) -> str:
    """The unit as FMI writes it: `N s/m`, `N*s/m` and `N.s/m` are one, `m/s^2` is `m/s2`, none is `1`."""
    text = re.sub(r"[\s*·]+", ".", unit.strip()).replace("^", "")
    return "1" if text in ("", "-") else text


def field_units(data: type[Any]) -> dict[str, str]:
    """Unit of each field of a data class."""
    comments = dict(_FIELD.findall(inspect.getsource(data)))
    units = {}
    for field in fields(data):
        if field.name not in comments:
            raise ValueError(f"{data.__name__}.{field.name} must state its unit in a comment: write `# m, what it is`")
        units[field.name] = spelled(re.split(r"[,:]", comments[field.name])[0].split(" [assumed]")[0])
    return units
