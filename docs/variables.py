"""The page of the FMU's variables: ``python -m docs.variables > docs/reference/variables.md``."""

import re
import sys
from collections.abc import Iterable, Iterator, Sequence

from fmu_src.documentation import COMPUTED_BY, HEADS, TEXT, TITLES, rows
from fmu_src.interface import variables
from fmu_src.profile import ALWAYS, DEFAULT, OUTPUT_GROUPS, output_group
from rope_model.cases import rope_120
from rope_model.reference.outputs import COMPUTED_NAMES
from rope_model.signals.signal_table import SIGNALS

#: differing parts of names and descriptions of rows that share a line, and the words for both
_SHARED = (
    (re.compile(r"(?<=`)(left|right)(?=\.)"), re.compile(r"\b(left|right)[. ]"), ""),
    (re.compile(r"(?<=`divider_)\d"), re.compile(r"(?!)"), ""),
    (
        re.compile(r"(?<=`inputs\.misfit\.)\w+"),
        re.compile(r"^(largest|RMS)(?= misfit)"),
        "largest and RMS",
    ),
    (re.compile(r"(?<=`mesh\.counts)\[\d\]"), re.compile(r"segment \w+"), "segments II to VI"),
    (
        re.compile(r"(?<=`nearest\.)\w+"),
        re.compile(r"nearest\.\w+\.clearance|clearance\.\w+"),
        "that clearance",
    ),
    (
        re.compile(r"(?<=`contact\.)\w+(?=\.impulse)"),
        re.compile(r"contact\.\w+(?= since)"),
        "that pressure",
    ),
    (
        re.compile(r"(?<=`contact\.)\w+(?=`)"),
        re.compile(r"(?<=between rope and )\w+( ropes)?"),
        "such bodies",
    ),
    (re.compile(r"(?:shape|loop|station)\.[xyz](?=\[|`)"), re.compile(r"^[XYZ]\b"), "X, Y and Z"),
    (
        re.compile(r"(?<=`rope\.curvature_)\w+?(?=_across`|`)"),
        re.compile(r"(?<=added )at.*?(?=, across|$)"),
        "at the left end, 1, 2, 4 and 5 sixths, the middle and the right end",
    ),
    (re.compile(r"(?<=`guard\.)\w+(?=_delay)"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`air\.v)[xz]"), re.compile(r"(?<=along )[XZ]\b"), "X and Z"),
)


def interface_page() -> str:
    """Return the page; both ends, numbered bodies and places along the rope share a row."""
    table = variables(rope_120())
    tables = {
        causality: [[*row] for row in folded(rows(v for v in table if v.causality == causality))]
        for causality, _ in TITLES
    }
    without_start = [[*row[:2], *row[3:]] for row in tables["output"]]
    return TEXT.format(
        fidelities=_table(("outputs", "fidelities "), COMPUTED_BY),
        groups=_table(
            ("group", "holds", "in the Python flavour "),
            [(f"`{group}`", holds, in_python(group)) for group, holds in OUTPUT_GROUPS.items()],
        ),
        always=" and ".join(f"`{group}`" for group in ALWAYS),
        left_out=" and ".join(f"`{group}`" for group in OUTPUT_GROUPS if group not in DEFAULT),
        parameters=_table(HEADS, tables["parameter"]),
        inputs=_table(HEADS, tables["input"]),
        outputs=_table([head for head in HEADS if head != "start"], without_start),
    )


def in_python(group: str) -> str:
    """Return the outputs of a group that the Python flavour has, in words."""
    outputs = [name for name in SIGNALS if output_group(name) == group]
    has = dict.fromkeys(_short(name) for name in outputs if name in COMPUTED_NAMES)
    lacks = dict.fromkeys(_short(name) for name in outputs if name not in COMPUTED_NAMES)
    if not lacks:
        return "all"
    if not has:
        # those of the status that the FMU itself gives
        return "none" if group not in ALWAYS else "validity, messages, fidelity"
    if len(has) <= len(lacks):
        return ", ".join(f"`{name}`" for name in has)
    return "all but " + ", ".join(f"`{name}`" for name in lacks)


def _short(name: str) -> str:
    """Return the name of an output without its side and its place in an array."""
    return re.sub(r"^(left|right)\.|\[\d+\]$", "", name)


def _table(heads: Sequence[str], lines_of_cells: Iterable[Sequence[str]]) -> str:
    lines = [
        f"| {' | '.join(heads)}|",
        "|---" * len(heads) + "|",
        *(f"| {' | '.join(row)} |" for row in lines_of_cells),
    ]
    return "\n".join(lines)


def folded(table: Iterable[tuple[str, str, str, str]]) -> Iterator[tuple[str, str, str, str]]:
    """Join the rows that differ in the end, the number or the kind of body alone."""
    alike: dict[tuple[str, str, str], list[tuple[str, str]]] = {}
    for name, unit, start, description in table:
        shared, words = name, description
        for in_name, in_description, common in _SHARED:
            if in_name.search(name):
                shared, words = in_name.sub("", name), in_description.sub(common, description)
        alike.setdefault((shared, unit, words), []).append((name, start))
    for (_, unit, words), group in alike.items():
        names, starts = zip(*group, strict=True)
        name = ", ".join(names) if len(names) < 3 else f"{names[0]} ... {names[-1]}"
        yield name, unit, starts[0] if len(set(starts)) == 1 else ", ".join(starts), words


if __name__ == "__main__":
    sys.stdout.write(interface_page())
