"""Decision tables: which of several messages applies; codegen.rules makes the C of them.

A rule is a message and its formula.  From the facts of a table the formula computes whether the
message applies, and then the numbers in it.  A choice is compared with its word.
"""

from collections.abc import Callable, Mapping
from typing import Any

from rope_model.messages.text import Template

Rules = Mapping[Template, Callable[..., tuple[Any, ...]]]


def first_text(rules: Rules, *facts: Any) -> str:
    """Return the message of the first rule that applies to the facts; '' if none does."""
    for message, formula in rules.items():
        applies, *numbers = formula(*facts)
        if applies:
            return message(*numbers)
    return ""
