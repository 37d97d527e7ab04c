"""Interface table as C: ``MODEL_VARIABLES`` of model.h, and places of scalars in the rope."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import fields

from fmu_src.interface import MOTION, RATES, Variable
from fmu_src.profile import arrays, scalars
from rope_model.boundary.end_paths import EndMotion
from rope_model.scene_names import Value, choices_of
from rope_model.shaft_parameters import PARTS
from rope_model.signals.signal_table import LOADS, SIGNALS
from rope_model.texts import c_string

_SOURCES = {"status.valid": "FROM_STATUS_VALID", "status.message": "FROM_STATUS_MESSAGE"}
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
/* Generated from the interface table: the variables, and where each lives in the rope. */
#include "model.h"
"""


def c_table(table: Sequence[Variable], fmi: int) -> str:
    """Return variables.c with the scalars; FMI 3 has arrays, enumerations and the time."""
    index = {v.name: i for i, v in enumerate(table)}
    rows = [
        _row(v, fmi, length, index.get(RATES.get(v.name, ""), 0))
        for v, length in zip(table, lengths(table, fmi), strict=True)
    ]
    if fmi == 3:
        rows.append(
            '{"time", NULL, 0, 1, 0, '
            "KIND_REAL, CAUSALITY_INDEPENDENT, VARIABILITY_CONTINUOUS, FROM_TIME}"
        )
    scalars = f"const size_t MODEL_SCALARS = {len(rows)};"
    return "\n".join([_HEAD, scalars, _array("const Variable MODEL_VARIABLES[]", rows)])


def lengths(table: Sequence[Variable], fmi: int) -> list[int]:
    """Return the number of elements of the array under each value reference; 0 within an array."""
    gather = arrays if fmi == 3 else scalars
    lengths = {array.reference: array.length for array in gather(dict(enumerate(table)))}
    return [lengths.get(i, 0) for i in range(len(table))]


def start_values(table: Sequence[Variable], fmi: int) -> tuple[float, ...]:
    """Return the start value of each scalar, 0 if it has none; FMI 3 has the time."""
    starts = [_number(v.start) for v in table]
    if fmi == 3:
        starts.append(0.0)
    return tuple(starts)


def _number(start: Value | None) -> float:
    """Return a start value as a number, 0 without one."""
    if isinstance(start, int | float):
        return float(start)
    return 0.0


def c_places(table: Sequence[Variable], fmi: int) -> str:
    """Return places.c with the location of each scalar for rope_model.c."""
    rows = [_location(v) for v in table]
    if fmi == 3:
        rows.append("{NOWHERE, 0, -1}")
    includes = '#include "rope.h"\n#include "rope_table.h"\n'
    names = [v.name for v in table]
    motions = [_places_of_motion(side, names) for side in MOTION]
    inputs = _array("const size_t ROPE_MOTIONS[2][END_MOTIONS]", motions)
    return "\n".join([_HEAD.rstrip(), includes, _array("const Place ROPE_PLACES[]", rows), inputs])


def _places_of_motion(side: str, names: Sequence[str]) -> str:
    """Return the initializer with the places of an end's inputs among all names."""
    places = [names.index(f"{side}.{name}") for name in _MOTIONS]
    return f"{{{', '.join(map(str, places))}}}"


def _array(declaration: str, rows: Iterable[str]) -> str:
    return f"{declaration} = {{\n" + "".join(f"    {row},\n" for row in rows) + "};\n"


def _row(v: Variable, fmi: int, length: int, rate: int) -> str:
    words = choices_of(v.name)
    kind = v.kind.upper()
    choices = "NULL"
    if words:
        choices = c_string(", ".join(f"{i} {word}" for i, word in enumerate(words)))
    if words and fmi == 3:
        kind = "ENUMERATION"
    source = "FROM_ENTRY"
    if v.causality == "output":
        source = _SOURCES.get(v.name, "FROM_MODEL")
    return (
        f"{{{c_string(v.name)}, {choices}, {len(words)}, {length}, {rate}, KIND_{kind}, "
        f"CAUSALITY_{v.causality.upper()}, VARIABILITY_{v.variability.upper()}, {source}}}"
    )


def _location(v: Variable) -> str:
    where, offset = _home(v)
    load = LOADS.index(v.name) if v.name in LOADS else _NO_LOAD
    return f"{{{where}, {offset}, {load}}}"


_NO_LOAD = -1  #: Place among LOADS of a variable that is none.


def _home(v: Variable) -> tuple[str, str]:
    """Return the kind of place where a variable lives in the rope, and its offset there."""
    group, _, field = v.name.rpartition(".")
    if v.name == "inputs_at_step_end":
        return "AT_STEP_END", "0"
    if v.name in _TEXTS:
        return _TEXTS[v.name], "0"
    if v.name in SIGNALS:
        return "SIGNAL", str(list(SIGNALS).index(v.name))
    # outputs of the component
    if v.causality == "output":
        return "NOWHERE", "0"
    if v.causality == "input":
        return f"{group.upper()}_MOTION", str(_MOTIONS.index(field))
    if match := re.fullmatch(r"counts\[(\d+)\]", field):
        field = f"counts[{int(match[1]) - 1}]"
    where = "SCENE_REAL" if v.kind == "Real" else "SCENE_INTEGER"
    return where, f"offsetof(Scene, {_SCENE.get(group, group)}.{field})"
