"""What a system of FMUs leaves out of a hoist and its trip, by the name that asks for it."""

from collections.abc import Collection
from dataclasses import replace
from typing import Any, NamedTuple

from hoist_demo.cases.case import Case


class Omission(NamedTuple):
    """Data of a case that are None where they are left out."""

    hoist: tuple[str, ...] = ()
    winding: tuple[str, ...] = ()
    reason: str = ""  # why a system cannot hold them; '' where it can


OMISSIONS = {
    "emergency-stop": Omission(winding=("emergency_at",), reason="an exported drive has no brake"),
    "jam": Omission(
        hoist=("jam_left", "jam_right"),
        reason="an exported drive's steps are too long for what sticks",
    ),
    "lining": Omission(
        hoist=("lining",), reason="in an exported drive the head ropes hold on the sheave"
    ),
    "slack-rope": Omission(
        hoist=("slack_tension",), reason="an exported drive has no safety circuit that stops it"
    ),
    "play": Omission(hoist=("play",)),
}


def leave_out(case: Case, names: Collection[str]) -> Case:
    """Return the case without the parts of these OMISSIONS, and without its brake."""
    chosen = [OMISSIONS[name] for name in names if name in OMISSIONS]
    parts: dict[str, Any] = dict.fromkeys(field for one in chosen for field in one.hoist)
    stops: dict[str, Any] = dict.fromkeys(field for one in chosen for field in one.winding)
    hoist = replace(case.hoist, brake=None, **parts)
    return replace(case, hoist=hoist, winding=replace(case.winding, emergency_law="drive", **stops))


def obstacles(case: Case) -> list[str]:
    """Return what a system cannot hold of a case, each in a sentence that says how to leave it out."""
    return [
        not_held(f"{field} = {value}", "None", one.reason, name)
        for name, one in OMISSIONS.items()
        for part, fields in ((case.hoist, one.hoist), (case.winding, one.winding))
        for field in fields
        if one.reason and (value := getattr(part, field)) is not None
    ]


def not_held(what: str, bound: str, reason: str, name: str) -> str:
    """Return the sentence that names the option."""
    return f"{what} must be {bound}: {reason}; leave it out with --without {name}"
