"""All cases by name: hoist, winding, controller gains, and the balance rope that belongs to them.

rope-120 and rope-240 are the hoists around the ropes of the published case, the others those of installed sizes. The
rope is given by its FMI parameters, so that one FMU, or the rope in process, serves every case.
"""

from __future__ import annotations

from hoist_demo.cases.case import COULOMB, LOCKED, PUBLISHED_ROPE, Case, swivels
from hoist_demo.cases.installed import INSTALLED
from hoist_demo.cases.scenarios import SCENARIOS
from hoist_demo.parameters import Hoist, Winding


def _published_case(hoist: Hoist, winding: Winding, ends: dict[str, float]) -> Case:
    """The published rope, which has the FMU's own data but for its length and its swivels."""
    return Case(hoist, winding, rope={"rope.length": hoist.tail_rope_length, **ends}, stated=PUBLISHED_ROPE)


CASES = {
    "rope-120": _published_case(Hoist(), Winding(), swivels(LOCKED)),
    "rope-240": _published_case(
        Hoist(shaft_travel=200.0, tail_rope_length=240.0),
        Winding(travel=200.0, speed=10.0),
        swivels(COULOMB, release_time=20.0),
    ),
    **INSTALLED,
}


#: the cases, and what goes wrong in some of them
NAMED = CASES | SCENARIOS


def find_case(name: str) -> Case:
    """The case of this name; ValueError with all names when there is none."""
    if name not in NAMED:
        raise ValueError(f"case = {name!r} must be one of {', '.join(NAMED)}: choose one")
    return NAMED[name]
