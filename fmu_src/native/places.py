"""Places of the interface's scalars in the rope, as C for rope_model.c."""

import re
from collections.abc import Sequence
from dataclasses import fields

from fmu_src.interface import INPUTS_AT_STEP_END, MOTION, Variable
from fmu_src.shell.table import c_array
from rope_model.boundary.end_paths import EndMotion
from rope_model.shaft_parameters import PARTS
from rope_model.signals.signal_table import LOADS, SIGNALS

#: inputs of an end, by their numbers in EndMotion
_MOTIONS = [field.name for field in fields(EndMotion)]
_TEXTS = {
    "status.fidelity": "FIDELITY_NAME",
    "status.fidelity_reason": "FIDELITY_REASON",
    "status.warning": "WARNING",
}
#: fields of struct Scene with other names than the interface's
_SCENE = {"left.swivel": "swivels[LEFT]", "right.swivel": "swivels[RIGHT]"} | {
    part: f"shaft.{part}" for part in PARTS
}
_HEAD = """\
/* Generated from the interface table: the place of each variable in the rope. */
#include "rope.h"
#include "rope_table.h"
"""


def c_places(table: Sequence[Variable], fmi: int) -> str:
    """Return places.c with the location of each scalar for rope_model.c."""
    rows = [_location(v) for v in table]
    if fmi == 3:
        rows.append("{NOWHERE, 0, -1}")
    names = [v.name for v in table]
    motions = [_places_of_motion(side, names) for side in MOTION]
    inputs = c_array("const size_t ROPE_MOTIONS[2][END_MOTIONS]", motions)
    return "\n".join([_HEAD, c_array("const Place ROPE_PLACES[]", rows), inputs])


def _places_of_motion(side: str, names: Sequence[str]) -> str:
    """Return the initializer with the places of an end's inputs among all names."""
    places = [names.index(f"{side}.{name}") for name in _MOTIONS]
    return f"{{{', '.join(map(str, places))}}}"


def _location(v: Variable) -> str:
    where, offset = _home(v)
    load = LOADS.index(v.name) if v.name in LOADS else _NO_LOAD
    return f"{{{where}, {offset}, {load}}}"


_NO_LOAD = -1  #: Place among LOADS of a variable that is none.


def _home(v: Variable) -> tuple[str, str]:
    """Return the kind of place where a variable lives in the rope, and its offset there."""
    group, _, field = v.name.rpartition(".")
    if v.name in _TEXTS:
        return _TEXTS[v.name], "0"
    if v.name in SIGNALS:
        return "SIGNAL", str(list(SIGNALS).index(v.name))
    # those of the component
    if v.causality == "output" or v.name == INPUTS_AT_STEP_END:
        return "NOWHERE", "0"
    if v.causality == "input":
        return f"{group.upper()}_MOTION", str(_MOTIONS.index(field))
    if match := re.fullmatch(r"counts\[(\d+)\]", field):
        field = f"counts[{int(match[1]) - 1}]"
    where = "SCENE_REAL" if v.kind == "Real" else "SCENE_INTEGER"
    return where, f"offsetof(Scene, {_SCENE.get(group, group)}.{field})"
