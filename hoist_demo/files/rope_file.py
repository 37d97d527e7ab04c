"""Parameter files of ropes, as balance-rope identify writes them: [fixed] has the values, [rope] and [known] why."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.reading import FileError, flat, read_toml
from hoist_demo.files.values import Given, read_given

#: parameters by the property that decides them
_FOLLOWING = {
    "mass_per_length": ("rope.mass_per_length", "rope.rhoJ", "hoist.tail_rope_mass"),
    "axial_stiffness": ("rope.Qa",),
    "torque_factor": ("rope.Qb", "rope.Qc"),
    "torsional_stiffness": ("rope.Qd",),
    "bending_stiffness": ("rope.EI",),
}
_CURE = "give a file that balance-rope identify has written"


def following_statuses(known: Mapping[str, str]) -> dict[str, str]:
    """Return the statuses of the parameters that follow from properties of a rope with these statuses."""
    return {name: status for key, status in known.items() for name in _FOLLOWING.get(key, ())}


def read_rope_file(path: Path, catalogue: Catalogue) -> dict[str, Given]:
    """Return the values of a rope and of its air with their statuses; raise FileError with all problems."""
    raw, found, problems = read_toml(path), dict[str, Given](), []
    fixed, known = raw.get("fixed"), raw.get("known", {})
    if not isinstance(fixed, dict) or not isinstance(known, dict):
        raise FileError(path, [f"has no [fixed]: {_CURE}"])
    statuses = following_statuses(
        {key: one.get("status", "measured") if isinstance(one, dict) else "measured" for key, one in known.items()}
    )
    for name, content in flat(fixed):
        try:
            if not name.startswith(("rope.", "air.")):
                raise ValueError(f"{name} is none of rope.* and air.*: {_CURE}, or set it in the hoist's file")
            given = read_given(catalogue[name], content)
            plain = not isinstance(content, dict)
            found[name] = Given(given.value, statuses[name] if plain and name in statuses else given.status, path.name)
        except ValueError as error:
            problems.append(str(error))
    if problems:
        raise FileError(path, problems)
    return found
