"""Rules that say which message applies; codegen.rules makes the C of them.

A rule is a message of the rope and the formula that goes with it.  From the facts that a table is about the
formula computes whether the message applies, and then the numbers in it.  A choice is compared with its word.
"""

from collections.abc import Callable, Mapping
from typing import Any

from rope_model.simulation.messages.text import Text

Rules = Mapping[Text, Callable[..., tuple[Any, ...]]]


def first_text(rules: Rules, *facts: Any) -> str:
    """The message of the first rule that applies to the facts; '' when none does."""
    for message, formula in rules.items():
        applies, *numbers = formula(*facts)
        if applies:
            return message(*numbers)
    return ""
