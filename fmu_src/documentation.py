"""Documentation in FMUs as HTML: use of the FMU, the model and the variables."""

import re
from collections.abc import Collection, Iterable, Iterator
from itertools import chain
from pathlib import Path

from fmu_src.interface import Variable
from fmu_src.profile import DESCRIPTIONS
from rope_model.fidelity.neglected_effects import EFFECTS
from rope_model.texts import html_text

_PAGES = Path(__file__).resolve().parent / "pages"
#: docs/reference/variables.md without its tables; index_html has parts of it, and docs/theory in
#: short
TEXT = (_PAGES / "variables.md").read_text(encoding="utf-8")
_MODEL = (_PAGES / "model.html").read_text(encoding="utf-8")
#: fidelities that compute the outputs of each effect, from the lowest
_COMPUTED = {
    "planar": "planar, spatial, torsional",
    "spatial": "spatial: by motion out of plane; torsional: by torque, too",
    "torsional": "torsional",
}
_EFFECTS = [
    (", ".join(f"`{name}`" for name in effect.outputs), _COMPUTED[effect.lowest])
    for effect in EFFECTS
]
#: outputs, and the fidelities that compute them
COMPUTED_BY = (
    ("`fy`, `fy_mean`, `added_mass`, `energy.kinetic`, `energy.gravity`", "all"),
    _EFFECTS[0],
    (
        "`loop.x`, `loop.y`, `loop.clearance`, `shape`, `station`, `stress.bending_max`",
        "planar, spatial, torsional; rigid: of a loop drawn as half a circle",
    ),
    *_EFFECTS[1:],
)
_STYLE = (
    "body{font:15px/1.45 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.15em .5em;text-align:left;vertical-align:top}"
    "code{white-space:nowrap}"
)
TITLES = (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs"))
HEADS = ("name", "unit or type", "start", "")


def index_html(described: Collection[Variable], native: bool) -> str:
    """Return documentation/index.html: use of the FMU, the model, the variables."""
    sections = dict(part.split("\n\n", 1) for part in TEXT.removeprefix("# ").split("\n## "))
    arrays, _, along = sections["Along the rope"].partition("\n\n")
    if not any(v.name.startswith("shape.") for v in described):
        arrays = along = ""
    if not native:
        arrays = ""
    parts = [
        sections["The FMU's variables"].replace(", with the start values of the 120 m rope", ""),
        sections["Errors and derivatives"],
        arrays,
        along,
        sections["Added mass"],
        sections["Warnings"],
        sections["Fidelities"].removesuffix("{fidelities}\n"),
    ]
    texts = chain.from_iterable(part.split("\n\n") for part in parts)
    paragraphs = "\n".join(_paragraph(text) for text in texts if text.strip())
    fidelities = "".join(
        f"<tr><td>{_to_html(outputs)}</td><td>{which}</td></tr>" for outputs, which in COMPUTED_BY
    )
    body = [
        f"<h1>Balance rope of a friction hoist</h1>\n{paragraphs}\n<table>{fidelities}</table>",
        _MODEL,
    ]
    head = "".join(f"<th>{text}</th>" for text in HEADS)
    for causality, title in TITLES:
        table = rows(v for v in described if v.causality == causality)
        lines = "\n".join(f"<tr>{_cells(row)}</tr>" for row in table)
        body.append(f"<h2>{title}</h2>\n<table><tr>{head}</tr>\n{lines}")
        body.append("</table>")
    head = f'<meta charset="utf-8"><title>Balance rope</title><style>{_STYLE}</style>'
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n'
        + "\n".join(body)
        + "\n</body></html>\n"
    )


def _cells(row: Iterable[str]) -> str:
    """Return the cells of a table's row."""
    return "".join(f"<td>{_to_html(cell)}</td>" for cell in row)


def _paragraph(text: str) -> str:
    if not text.startswith("- "):
        return f"<p>{_to_html(text)}</p>"
    items = "".join(f"<li>{_to_html(item)}</li>" for item in text.removeprefix("- ").split("\n- "))
    return f"<ul>{items}</ul>"


def _to_html(text: str) -> str:
    text = re.sub(r"`(.+?)`", r"<code>\1</code>", html_text(text.strip()))
    return re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"<em>\1</em>", text)


def rows(table: Iterable[Variable]) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, unit or type, start and description of each variable; an array is one row."""
    for v in table:
        if match := re.fullmatch(r"((?:shape|station)\.\w+)\[(\d+)\]", v.name):
            if match[2] == "1":
                yield f"`{match[1]}[1...81]`", v.unit, "", DESCRIPTIONS[match[1]]
            continue
        tunable = "*tunable*; " if v.variability == "tunable" else ""
        yield f"`{v.name}`", v.unit or v.kind, _start_text(v), f"{tunable}{v.description}"


def _start_text(v: Variable) -> str:
    """Return the start value of a variable, "" without one."""
    if v.start is None:
        return ""
    if isinstance(v.start, bool):
        return str(v.start).lower()
    return f"{v.start:g}"
