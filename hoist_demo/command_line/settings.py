"""Values for one run from the command line: `NAME=VALUE`, and files of parameters, under the names of a study."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.study.catalogue import Catalogue
from hoist_demo.study.reading import flat, strip_unit, with_file

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
        found[name] = parameter.read(_value(parameter, value))
    return found


def rope_values(path: Path | None, catalogue: Catalogue) -> dict[str, Value]:
    """The values of [fixed] of a parameter file, as --rope names it; none without a file."""
    table = {} if path is None else with_file({"from": str(path)})
    if path is not None and not table:
        raise ValueError(f"--rope {path} has no [fixed]: {_ROPE_FILE}")
    found: dict[str, Value] = {}
    for name, content in flat(table):
        if not name.startswith(("rope.", "air.")):
            raise ValueError(f"--rope {path}: {name} is none of rope.* and air.*: {_ROPE_FILE}, or set it by --set")
        parameter = catalogue[name]
        found[name] = parameter.read(strip_unit(parameter, content))
    return found


_ROPE_FILE = "give a file that balance-rope identify has written"


def _value(parameter: Parameter, text: str) -> Value:
    """Return the parameter's value for a text; a meaningless text is left for the parameter's check."""
    if parameter.kind == "Boolean":
        return {"true": True, "false": False}.get(text.lower(), text)
    if parameter.kind in ("Real", "Integer"):
        try:
            return float(text)
        except ValueError:
            return text
    return text
