"""Interface table as C: ``MODEL_VARIABLES`` of model.h."""

from collections.abc import Iterable, Sequence

from fmu_src.interface import ACCURACY, INPUTS_AT_STEP_END, RATES, Variable
from fmu_src.profile import arrays, scalars
from rope_model.scene_names import Value, choices_of
from rope_model.texts import c_string

_SOURCES = {"status.valid": "FROM_STATUS_VALID", "status.message": "FROM_STATUS_MESSAGE"}
_HEAD = """\
/* Generated from the interface table: the variables. */
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
    indices = {
        "MODEL_SCALARS": len(rows),
        "MODEL_ACCURACY": index.get(ACCURACY, len(rows)),
        "MODEL_AT_STEP_END": index.get(INPUTS_AT_STEP_END, len(rows)),
    }
    numbers = [f"const size_t {name} = {number};" for name, number in indices.items()]
    return "\n".join([_HEAD, *numbers, c_array("const Variable MODEL_VARIABLES[]", rows)])


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


def c_array(declaration: str, rows: Iterable[str]) -> str:
    """Return the definition of an array with these rows."""
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
