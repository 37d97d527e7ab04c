"""Options of `balance-rope demo`, and values for one run: `NAME=VALUE` and files of parameters."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.values import read_value
from hoist_demo.parameters import EmergencyLaw
from hoist_demo.parameters.quantity import Parameter, Value
from rope_model import Level
from rope_model.scene_names import choices_of

KERNELS = choices_of("solver.kernels")  #: Choices of the FMU's integer parameter, in the order of its codes.


def add_trip(demo: argparse.ArgumentParser) -> None:
    """Add the options that change the case's winding."""
    demo.add_argument("--speed", type=float, metavar="V", help="speed limit [m/s] (that of the case)")
    demo.add_argument("--travel", type=float, metavar="S", help="left conveyance up [m] (that of the case)")
    demo.add_argument(
        "--creep-distance", type=float, metavar="S", help="creep over the last S [m], stop included (that of the case)"
    )
    demo.add_argument("--creep-speed", type=float, metavar="V", help="at V [m/s] (that of the case)")
    demo.add_argument(
        "--estop-at",
        type=float,
        metavar="T",
        help="emergency stop from time T [s], at the case's winding.emergency_deceleration: 2 m/s^2 for hoists of "
        "installed size, else 5 m/s^2",
    )
    demo.add_argument(
        "--estop-law",
        choices=get_args(EmergencyLaw),
        help="who stops: the drive, along its reference; or the brake of a case that has one: at a regulated "
        "deceleration, with its full torque, or in two stages, a part of it first (that of the case)",
    )


def add_data(demo: argparse.ArgumentParser) -> None:
    """Add the options for the rope's data and for the columns written."""
    demo.add_argument(
        "--kernels",
        choices=KERNELS,
        default="auto",
        help="the rope computes by compiled C, portably, which is slow, by CasADi's virtual machine, or auto: "
        "compiled where that can be had (%(default)s)",
    )
    demo.add_argument(
        "--level",
        choices=get_args(Level),
        help="accuracy against speed of the rope in process (standard); an FMU has that of its export",
    )
    demo.add_argument(
        "--rope", type=Path, metavar="FILE", help="parameters of the rope, as balance-rope identify writes them"
    )
    demo.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the rope by its name in docs/reference/variables.md, or of the host as "
        "hoist.payload_left, in SI units; may be repeated, and overrides other options",
    )
    demo.add_argument(
        "--signals",
        nargs="+",
        default=[],
        metavar="NAME",
        help="columns of signals.csv, beside the time: names of its header, * for any letters (all but the shape's)",
    )


STUDY_ONLY = ("controller", "shaper", "trajectory", "arrival")  #: First parts of the names that only a study takes.


def settings(texts: Iterable[str], catalogue: Catalogue) -> dict[str, Value]:
    """The values by name, each of its parameter's type and within its bounds; ValueError names what is not."""
    found: dict[str, Value] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise ValueError(f"--set {text} must be NAME=VALUE, as in --set rope.EI=450: give the value")
        if name.partition(".")[0] in STUDY_ONLY:
            raise ValueError(f"--set {text}: {name} is for studies: see docs/reference/files.md")
        parameter = catalogue[name]
        if name in found:
            raise ValueError(f"--set {text}: {name} is {found[name]!r} already: give it once")
        found[name] = read_value(parameter, _plain(parameter, value))
    return found


def _plain(parameter: Parameter, text: str) -> bool | float | str:
    """Return the code of a choice, or truth, for its text; another text is left for its reader."""
    if parameter.kind == "Boolean":
        return {"true": True, "false": False}.get(text.lower(), text)
    if parameter.choices and parameter.kind == "Integer" and text.lstrip("+-").isdigit():
        return int(text)
    return text
