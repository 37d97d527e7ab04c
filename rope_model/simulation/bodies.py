"""The bodies of a scene where they are now."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from ..physics import shaft as physics
from ..physics.elementary import both, either
from ..physics.shaft import KINDS, Body
from ..shaft_parameters import FAR, Shaft

LINING, CONVEYANCE, HEAD_ROPES, DIVIDER, FLOOR = range(len(KINDS))
#: what moves with no end of the rope
FIXED = -1


class Placed(NamedTuple):
    """A body, of which kind it is, and with which end of the rope (0 left, 1 right) it moves."""

    kind: int
    moves_with: int
    body: Body


def bodies(shaft: Shaft, ends: Sequence[Any]) -> Iterator[Placed]:
    """The bodies that are there with the rope's ``ends`` (2 of (3,)) at these places."""
    if shaft.lining.width > 0:
        yield Placed(LINING, FIXED, physics.lining(shaft.lining))
    for side, end in enumerate(ends):
        if shaft.conveyance.width > 0:
            yield Placed(CONVEYANCE, side, physics.conveyance(shaft.conveyance, end))
        if shaft.head_ropes.diameter > 0:
            yield Placed(HEAD_ROPES, side, physics.head_ropes(shaft.head_ropes, shaft.conveyance, end))
    for divider in (shaft.divider_1, shaft.divider_2, shaft.divider_3, shaft.divider_4):
        if divider.size > 0:
            yield Placed(DIVIDER, FIXED, physics.divider(divider))
    if shaft.sump.level > -FAR:
        yield Placed(FLOOR, FIXED, physics.floor(shaft.sump))


def may_touch(shaft: Any) -> Any:
    """Whether there are bodies that hold the rope."""
    dividers = shaft.divider_1, shaft.divider_2, shaft.divider_3, shaft.divider_4
    sizes = sum((divider.size for divider in dividers), shaft.lining.width)
    sizes += shaft.conveyance.width + shaft.head_ropes.diameter
    return both(shaft.contact.stiffness > 0, either(sizes > 0, shaft.sump.level > -FAR))
