"""Units of parameters in one spelling."""

from __future__ import annotations

import re


def fmi_unit(unit: str) -> str:
    """The unit as FMI writes it: `N s/m`, `N*s/m` and `N.s/m` are one, `m/s^2` is `m/s2`, none is `1`."""
    text = re.sub(r"[\s*·]+", ".", unit.strip()).replace("^", "")
    return "1" if text in ("", "-") else text
