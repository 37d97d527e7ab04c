"""Options of ``balance-rope wind``, and values for one run: ``NAME=VALUE`` and files."""

import argparse
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import get_args

from hoist_demo.files.reading import cure_of
from hoist_demo.files.registry import host_parameters
from hoist_demo.files.values import read_value
from hoist_demo.parameters import EmergencyLaw
from hoist_demo.parameters.quantity import FileParameter, Value
from rope_model import Level

TRIP = ("speed", "travel", "creep_distance", "creep_speed")  #: Values of the trip that are options.
SET = """\
a parameter of the rope by its name in docs/reference/variables.md, or of the host as hoist.payload_left, in SI or with
a unit; counts as if it stood in the hoist's file; may be repeated, and overrides other options"""


def add_trip(wind: argparse.ArgumentParser) -> None:
    """Add the options that change the hoist's trip."""
    for name in TRIP:
        text = f"{host_parameters()[f'winding.{name}'].help_text} (that of the hoist)"
        wind.add_argument(
            f"--{name.replace('_', '-')}", type=float, metavar=name[0].upper(), help=text
        )
    text = "emergency stop from time T [s], at the hoist's winding.emergency_deceleration"
    wind.add_argument("--estop-at", type=float, metavar="T", help=text)
    text = (
        "who stops: the drive, along its reference; or the brake of a hoist that has one (that of "
        "the hoist)"
    )
    wind.add_argument("--estop-law", choices=get_args(EmergencyLaw), help=text)


def add_data(wind: argparse.ArgumentParser) -> None:
    """Add the options for the rope's data and for the columns written."""
    text = (
        "accuracy against speed of the rope in process (that of the hoist); an FMU has that of "
        "its export"
    )
    wind.add_argument("--level", choices=get_args(Level), help=text)
    text = "parameters of the rope, as balance-rope identify writes them"
    wind.add_argument("--rope", type=Path, metavar="FILE", help=text)
    wind.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=SET)
    text = (
        "columns of signals.csv, beside the time: names of its header, * for any letters (all but "
        "the shape's)"
    )
    wind.add_argument("--signals", nargs="+", default=[], metavar="NAME", help=text)


def settings(texts: Iterable[str], parameters: Mapping[str, FileParameter]) -> dict[str, Value]:
    """Parse NAME=VALUE texts into values of their parameters' types and bounds.

    A ValueError names a wrong one.
    """
    values: dict[str, Value] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise ValueError(
                f"--set {text} must be NAME=VALUE, as in --set rope.EI=450: give the value"
            )
        if name not in parameters:
            raise ValueError(
                f"--set {text}: {name} is not a parameter: {cure_of(name, [*parameters])}"
            )
        parameter = parameters[name]
        content: Value = {"true": True, "false": False}.get(value.lower(), value)
        if name in values:
            raise ValueError(f"--set {text}: {name} is {values[name]!r} already: give it once")
        if parameter.choices and parameter.numeric and value.lstrip("+-").isdigit():
            content = int(value)
        values[name] = read_value(parameter, content)
    return values
