"""One hoist: the data of its file (hoist_demo.cases.hoist_file), and what follows by rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path

from hoist_demo.control.controller import Gains
from hoist_demo.files.values import ParameterValue, statuses, values_of
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.quantity import Value
from rope_model import Level

#: Folder of the hoists that come with the project.
FOLDER = Path(str(files("hoist_demo.cases"))) / "hoists"
# names of hoists, and of scenarios in which something goes wrong, in the order of help texts
HOISTS = (
    "rope-120",
    "rope-240",
    "kiruna-355",
    "kiruna-710",
    "monopol-1000",
    "robert-1096",
    "palabora-1282",
)
SCENARIOS = ("overwind", "slack-rope", "seized-swivel", "jammed-conveyance", "caught-rope")
BUILTIN_HOISTS = (*HOISTS, *SCENARIOS)
DEFAULT_HOIST = "rope-120"


@dataclass(frozen=True)
class BalanceRopeData:
    """One balance rope, or several equal ones: suspension, break, and values by FMI name."""

    name: str
    values: Mapping[str, ParameterValue]
    number: int = 1
    suspension: Mapping[str, float] = field(default_factory=dict)  # m: x_left, x_right, z
    breaks: Mapping[str, float] = field(default_factory=dict)  # breaks_at [s], breaks_s [m]
    construction: str = ""  # name in the catalogue, if it has the rope
    lay: str = "right-hand"

    @property
    def parameters(self) -> dict[str, Value]:
        """Values by FMI name, without status and source."""
        return values_of(self.values)


@dataclass(frozen=True)
class Case:
    """A hoist, its trip, its controller, and its balance ropes."""

    name: str
    hoist: Hoist
    winding: Winding
    gains: Gains
    # stated and derived values of controller, hoist.*, winding.* and others
    host: Mapping[str, ParameterValue]
    balance_ropes: tuple[BalanceRopeData, ...]
    # parameters of the first rope by FMI name; the rest is the rope's own
    rope: Mapping[str, Value]
    source: str = ""
    level: Level = "standard"
    signals: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()  # sentences on values that are far from what hoists have
    notes: tuple[str, ...] = ()  # sentences on values that are right for some hoists only

    @property
    def distinct_ropes(self) -> tuple[BalanceRopeData, ...]:
        """Several ropes, or one with a suspension or a break; none where all are equal."""
        first, *others = self.balance_ropes
        if others or first.suspension or first.breaks:
            return self.balance_ropes
        return ()

    @property
    def values(self) -> dict[str, ParameterValue]:
        """Stated and derived values of the host and of equal ropes, by name."""
        if self.distinct_ropes:
            return dict(self.host)
        return {**self.host, **self.balance_ropes[0].values}

    @property
    def status_by_name(self) -> dict[str, str]:
        """Status of each value by name."""
        return statuses(self.values)

    def with_rope(self, rope: BalanceRopeData) -> Case:
        """Return the hoist with this rope as its only one."""
        only_rope = BalanceRopeData(rope.name, rope.values)
        return replace(self, balance_ropes=(only_rope,), rope=rope.parameters)
