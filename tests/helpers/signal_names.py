"""Names of the rope's signals at both of its ends."""

from itertools import product

SIDES = ("left", "right")


def of_both_ends(*names: str) -> tuple[str, ...]:
    """Return these signals of the left end, and then those of the right one."""
    return tuple(f"{side}.{name}" for side, name in product(SIDES, names))
