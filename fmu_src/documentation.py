"""The variables as a page (``python -m fmu_src.documentation > docs/reference/variables.md``) and as HTML in FMUs."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path

from fmu_src.interface import Variable, variables
from fmu_src.profile import ALWAYS, DEFAULT, DESCRIPTIONS, GROUPS
from rope_model.parameters import rope_120
from rope_model.simulation.outputs.neglected_effects import EFFECTS
from rope_model.texts import html_text

_PAGES = Path(__file__).resolve().parent / "pages"
#: the page but for its tables; index_html has parts of it, and the model, docs/theory in short
_TEXT = (_PAGES / "variables.md").read_text(encoding="utf-8")
_MODEL = (_PAGES / "model.html").read_text(encoding="utf-8")
#: the fidelities that compute the outputs of each effect, from the lowest
_COMPUTED = {
    "planar": "planar, spatial, torsional",
    "spatial": "spatial: by motion out of plane; torsional: by torque, too",
    "torsional": "torsional",
}
_EFFECTS = [(", ".join(f"`{name}`" for name in effect.outputs), _COMPUTED[effect.lowest]) for effect in EFFECTS]
#: outputs -> the fidelities that compute them
_COMPUTED_BY = (
    ("`fy`, `fy_mean`, `added_mass`, `energy.kinetic`, `energy.gravity`", "all"),
    _EFFECTS[0],
    (
        "`loop.x`, `loop.y`, `loop.clearance`, `shape`, `stress.bending_max`",
        "planar, spatial, torsional; rigid: of a loop drawn as half a circle",
    ),
    *_EFFECTS[1:],
)
_STYLE = (
    "body{font:15px/1.45 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.15em .5em;text-align:left;vertical-align:top}code{white-space:nowrap}"
)
#: differing parts of names and descriptions of rows that share a line, and the words for both
_SHARED = (
    (re.compile(r"(?<=`)(left|right)(?=\.)"), re.compile(r"\b(left|right)[. ]"), ""),
    (re.compile(r"(?<=`divider_)\d"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`mesh\.counts)\[\d\]"), re.compile(r"segment \w+"), "segments II to VI"),
    (re.compile(r"(?<=`nearest\.)\w+"), re.compile(r"nearest\.\w+\.clearance|clearance\.\w+"), "that clearance"),
    (re.compile(r"(?<=`contact\.)\w+(?=\.impulse)"), re.compile(r"contact\.\w+(?= since)"), "that pressure"),
    (re.compile(r"(?<=`contact\.)\w+(?=`)"), re.compile(r"(?<=between rope and )\w+( ropes)?"), "such bodies"),
    (re.compile(r"(?:shape|loop)\.[xyz](?=\[|`)"), re.compile(r"^[XYZ]\b"), "X, Y and Z"),
    (re.compile(r"(?<=`guard\.)\w+(?=_delay)"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`air\.v)[xz]"), re.compile(r"(?<=along )[XZ]\b"), "X and Z"),
)
_TITLES = (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs"))
_HEADS = ("name", "unit or type", "start", "")


def interface_page() -> str:
    """Return the page; both ends, numbered bodies and places along the rope share a row."""
    table = variables(rope_120())
    folded = {
        causality: [[*row] for row in _folded(_rows(v for v in table if v.causality == causality))]
        for causality, _ in _TITLES
    }
    without_start = [[*row[:2], *row[3:]] for row in folded["output"]]
    return _TEXT.format(
        fidelities=_table(("outputs", "fidelities "), _COMPUTED_BY),
        groups=_table(("group", "holds "), [(f"`{group}`", holds) for group, holds in GROUPS.items()]),
        always=" and ".join(f"`{group}`" for group in ALWAYS),
        left_out=" and ".join(f"`{group}`" for group in GROUPS if group not in DEFAULT),
        parameters=_table(_HEADS, folded["parameter"]),
        inputs=_table(_HEADS, folded["input"]),
        outputs=_table([head for head in _HEADS if head != "start"], without_start),
    )


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(heads)}|", "|---" * len(heads) + "|", *(f"| {' | '.join(row)} |" for row in rows)]
    return "\n".join(lines)


def index_html(described: Collection[Variable], native: bool) -> str:
    """documentation/index.html: how to use the FMU, the model, the variables."""
    sections = dict(part.split("\n\n", 1) for part in _TEXT.removeprefix("# ").split("\n## "))
    arrays, _, along = sections["Along the rope"].partition("\n\n")
    if not any(v.name.startswith("shape.") for v in described):
        arrays = along = ""
    parts = [sections["The FMU's variables"].replace(", start values of the 120 m rope", "")]
    parts += [sections["Errors and derivatives"], arrays if native else "", along, sections["Added mass"]]
    parts += [sections["Warnings"], sections["Fidelities"].removesuffix("{fidelities}\n")]
    paragraphs = "\n".join(_paragraph(text) for part in parts for text in part.split("\n\n") if text.strip())
    fidelities = "".join(f"<tr><td>{_to_html(outputs)}</td><td>{which}</td></tr>" for outputs, which in _COMPUTED_BY)
    body = [f"<h1>Balance rope of a friction hoist</h1>\n{paragraphs}\n<table>{fidelities}</table>", _MODEL]
    for causality, title in _TITLES:
        rows = _rows(v for v in described if v.causality == causality)
        cells = ["".join(f"<td>{_to_html(cell)}</td>" for cell in row) for row in rows]
        head = "".join(f"<th>{text}</th>" for text in _HEADS)
        body.append(f"<h2>{title}</h2>\n<table><tr>{head}</tr>\n" + "\n".join(f"<tr>{row}</tr>" for row in cells))
        body.append("</table>")
    head = f'<meta charset="utf-8"><title>Balance rope</title><style>{_STYLE}</style>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n' + "\n".join(body) + "\n</body></html>\n"


def _paragraph(text: str) -> str:
    if not text.startswith("- "):
        return f"<p>{_to_html(text)}</p>"
    items = "".join(f"<li>{_to_html(item)}</li>" for item in text.removeprefix("- ").split("\n- "))
    return f"<ul>{items}</ul>"


def _to_html(text: str) -> str:
    text = re.sub(r"`(.+?)`", r"<code>\1</code>", html_text(text.strip()))
    return re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"<em>\1</em>", text)


def _rows(table: Iterable[Variable]) -> Iterator[tuple[str, str, str, str]]:
    for v in table:
        if match := re.fullmatch(r"((?:shape|station)\.\w+)\[(\d+)\]", v.name):
            if match[2] == "1":
                yield f"`{match[1]}[1]` ... `[81]`", v.unit, "", DESCRIPTIONS[match[1]]
            continue
        start = "" if v.start is None else str(v.start).lower() if isinstance(v.start, bool) else f"{v.start:g}"
        tunable = "*tunable*; " if v.variability == "tunable" else ""
        yield f"`{v.name}`", v.unit or v.kind, start, f"{tunable}{v.description}"


def _folded(rows: Iterable[tuple[str, str, str, str]]) -> Iterator[tuple[str, str, str, str]]:
    """Join the rows that differ in the end, the number or the kind of body alone."""
    alike: dict[tuple[str, str, str], list[tuple[str, str]]] = {}
    for name, unit, start, description in rows:
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
