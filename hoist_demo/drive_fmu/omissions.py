"""Parts of a hoist and its trip that a system of FMUs can leave out, by name."""

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
    of_hoist: dict[str, Any] = {"brake": None}
    of_winding: dict[str, Any] = {"emergency_law": "drive"}
    for name in names:
        if name in OMISSIONS:
            of_hoist |= dict.fromkeys(OMISSIONS[name].hoist)
            of_winding |= dict.fromkeys(OMISSIONS[name].winding)
    hoist = replace(case.hoist, **of_hoist)
    return replace(case, hoist=hoist, winding=replace(case.winding, **of_winding))


def obstacles(case: Case) -> list[str]:
    """Return the parts of a case that no system can hold, each in a sentence with the cure."""
    sentences = []
    for name, omission in OMISSIONS.items():
        if not omission.reason:
            continue
        values = {field: getattr(case.hoist, field) for field in omission.hoist}
        values |= {field: getattr(case.winding, field) for field in omission.winding}
        for field, value in values.items():
            if value is not None:
                sentences.append(omission_text(f"{field} = {value}", "None", omission.reason, name))
    return sentences


def omission_text(what: str, bound: str, reason: str, name: str) -> str:
    """Return the sentence that names the option."""
    return f"{what} must be {bound}: {reason}; leave it out with --without {name}"
