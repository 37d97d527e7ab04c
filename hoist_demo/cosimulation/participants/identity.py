"""Identity of what a saved state belongs to: values by name, and the differences of two of them."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

#: Numbers and words by name.
Identity = Mapping[str, Any]
MAX_DIFFERENCES = 6  #: Differences at most that a message lists.
_NOT_SET = "not set"


def named_values(value: object, name: str = "") -> dict[str, Any]:
    """Return numbers and words in data classes, mappings and tuples, as ``hoist.lining.sliding``.

    None is left out, and so are fields that take no part in comparisons. ``name`` is that of
    ``value`` itself.
    """
    if value is None:
        return {}
    if is_dataclass(value):
        parts = {part.name: getattr(value, part.name) for part in fields(value) if part.compare}
    elif isinstance(value, Mapping):
        parts = dict(value)
    elif isinstance(value, list | tuple):
        parts = {str(k): part for k, part in enumerate(value, 1)}
    else:
        return {name: value}
    values: dict[str, Any] = {}
    for part_name, part in parts.items():
        if name:
            part_name = f"{name}.{part_name}"
        values |= named_values(part, part_name)
    return values


def differences(there: Identity, here: Identity) -> str:
    """List the values that differ between a saved state's identity and the present one; "" if none does."""
    found = []
    for name in {**there, **here}:
        saved = there.get(name, _NOT_SET)
        present = here.get(name, _NOT_SET)
        if saved != present:
            found.append(f"{name} is {saved} there, {present} here")
    listed = ", ".join(found[:MAX_DIFFERENCES])
    if len(found) > MAX_DIFFERENCES:
        return f"{listed} and {len(found) - MAX_DIFFERENCES} more"
    return listed
