"""All scenes by name: hoist, winding, controller gains, and the balance rope that belongs to them.

rope-120 and rope-240 are the hoists around the ropes of the published case, the others those of installed sizes. The
rope is given by its FMI parameters, so that one FMU, or the rope in process, serves every scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hoist_demo.cases.presets import PRESETS
from hoist_demo.control.controller import Gains
from hoist_demo.parameters import SETUPS, Setup

_SIDES = ("left", "right")
_LOCKED, _COULOMB = 0, 2  # codes of swivel.mode, docs/interface.md
_FASTENED = {f"{side}.swivel.mode": _LOCKED for side in _SIDES}
_RELEASED_AT_20_S = {
    **{f"{side}.swivel.mode": _COULOMB for side in _SIDES},
    **{f"{side}.swivel.release_time": 20.0 for side in _SIDES},
}


@dataclass(frozen=True)
class SceneData(Setup):
    """What a run needs besides the coupling."""

    gains: Gains = field(default_factory=Gains)
    rope: Mapping[str, float] = field(default_factory=dict)  # parameters by FMI name; the rest is the rope's own


def _published(name: str, rope: Mapping[str, float]) -> SceneData:
    """A scene of the published case, whose rope has the FMU's own data but for its length and its swivels."""
    setup = SETUPS[name]
    return SceneData(setup.hoist, setup.winding, rope={"rope.length": setup.hoist.tail_rope_length, **rope})


SCENES = {
    "rope-120": _published("rope-120", _FASTENED),
    "rope-240": _published("rope-240", _RELEASED_AT_20_S),
    **{name: SceneData(p.hoist, p.winding, p.gains, {**p.rope, **_FASTENED}) for name, p in PRESETS.items()},
}


def scene_named(name: str) -> SceneData:
    """The scene of this name; ValueError with all names when there is none."""
    if name not in SCENES:
        raise ValueError(f"scene = {name!r} must be one of {', '.join(SCENES)}: choose one")
    return SCENES[name]
