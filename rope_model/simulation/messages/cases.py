"""Tables of messages and their cases; codegen.cases makes the C of them.

A case is a message of the rope and the formula that goes with it.  From the facts that a table is about the
formula computes whether the message applies, and then the numbers in it.  A choice is compared with its word.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Cases = Mapping[Callable[..., str], Callable[..., tuple[Any, ...]]]


def first_text(cases: Cases, *facts: Any) -> str:
    """The message of the first case that applies to the facts; '' when none does."""
    for message, formula in cases.items():
        applies, *numbers = formula(*facts)
        if applies:
            return message(*numbers)
    return ""
