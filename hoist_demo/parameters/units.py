"""Units of parameters: one spelling, and the unit that each field of a data class states in its comment.

The house writes every field with its unit as the first words of the comment, `spacing: float = 2.0  # m, between ...`;
that comment is the only place where the unit is written, and it is read from there.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

_FIELD = re.compile(r"^    (\w+): [^#]+#\s*(.+)$", re.MULTILINE)


def spelled(unit: str) -> str:
    """The unit as FMI writes it: `N s/m`, `N*s/m` and `N.s/m` are one, `m/s^2` is `m/s2`, none is `1`."""
    text = re.sub(r"[\s*·]+", ".", unit.strip()).replace("^", "")
    return "1" if text in ("", "-") else text


def field_units(data: type[Any]) -> dict[str, str]:
    """First words of the comment of each field that has one: the unit, where the field is a number."""
    comments = _FIELD.findall(inspect.getsource(data))
    return {name: spelled(re.split(r"[,:]", comment)[0].split(" [assumed]")[0]) for name, comment in comments}
