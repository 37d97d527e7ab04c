"""One hoist: all that its file says, see hoist_demo.files.hoist_file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from hoist_demo.control.controller import Gains
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.quantity import Value
from rope_model import Level

#: files of the hoists that come with the project
FOLDER = Path(str(files("hoist_demo"))) / "hoists"

#: in the order in which they are told: hoists, and what goes wrong in some of them
HOISTS = ("rope-120", "rope-240", "kiruna-355", "kiruna-710", "monopol-1000", "robert-1096", "palabora-1282")
SCENARIOS = ("overwind", "slack-rope", "seized-swivel", "jammed-conveyance", "caught-rope")


@dataclass(frozen=True)
class Tail:
    """One balance rope, or several equal ones: its name, its own parameters, where it hangs, and its break."""

    name: str
    parameters: Mapping[str, Value]  # by FMI name, beside those of all ropes
    place: Mapping[str, float] = field(default_factory=dict)  # m: x_left, x_right, z
    breaks: Mapping[str, float] = field(default_factory=dict)  # breaks_at [s], breaks_s [m]
    given: Mapping[str, str] = field(default_factory=dict)  # status of each parameter


@dataclass(frozen=True)
class Case:
    """A hoist, its trip, its controller, and its balance ropes."""

    hoist: Hoist
    winding: Winding
    gains: Gains = field(default_factory=Gains)
    rope: Mapping[str, Value] = field(default_factory=dict)  # of the first, by FMI name; the rest is the rope's own
    settings: Mapping[str, Value] = field(default_factory=dict)  # controller, coupling.*, and others of a study
    ropes: tuple[Tail, ...] = ()  # where there are several, or one with a place or a break
    shared: Mapping[str, Value] = field(default_factory=dict)  # parameters of all ropes, by FMI name
    given: Mapping[str, str] = field(default_factory=dict)  # status of what the file sets, by name
    sources: Mapping[str, str] = field(default_factory=dict)
    name: str = ""
    source: str = ""
    level: Level = "standard"
    signals: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()  # on values that are far from what hoists have
