"""Pages from templates: page = render(template, data).

A template is a file *.md.j2 (Jinja2) beside the code that measures; it holds the prose, and numbers are filled in from
the tables in docs/data.  A name that the data do not have is an error.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

FOLDER = Path(__file__).resolve().parent
DOCS = FOLDER.parent / "docs"
#: what an SI value, or a fraction, is multiplied by to be printed in a unit
SCALES = {
    "%": 1e2,
    "mm": 1e3,
    "ms": 1e3,
    "mrad": 1e3,
    **dict.fromkeys(
        (
            "m",
            "s",
            "N",
            "J",
            "W",
            "N m",
            "rad",
            "rad/s",
            "m/s",
            "m/s^2",
            "m/s^3",
            "kg",
            "Hz",
            "deg",
        ),
        1.0,
    ),
}
#: numbers from here on are printed with a power of ten
LARGE = 1e6


def number(x: float, form: str = ".3g") -> str:
    """``x`` in a format of Python's; significant digits (g) without a positive power of ten below LARGE."""
    text = format(float(x), form)
    return f"{float(text):.0f}" if form.endswith("g") and "e+" in text and abs(x) < LARGE else text


def quantity(x: float, unit: str, form: str = ".3g") -> str:
    """An SI value, or a fraction in per cent, with its unit."""
    return f"{number(SCALES[unit] * float(x), form)} {unit}"


def with_unit(x: float, unit: str, form: str = ".3g") -> str:
    """``x`` in its unit, or '1' without one."""
    return number(x, form) if unit == "1" else f"{number(x, form)} {unit}"


def markdown(rows: Iterable[Sequence[str]], *head: str) -> str:
    """A table."""
    lines = [f"| {' | '.join(cells)} |" for cells in (head, *rows)]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def folded(text: str, summary: str) -> str:
    """Return ``text`` so that a browser shows it when its summary is clicked."""
    return f"<details><summary>{summary}</summary>\n\n{text}\n\n</details>"


def listed(words: Sequence[str]) -> str:
    """A list in a sentence: "a", "a and b", "a, b and c"."""
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def links(names: Iterable[str], folder: str) -> str:
    """Links to the tables of these names in docs/data/``folder``, for a page in docs."""
    return ", ".join(f"[{name}.csv](data/{folder}/{name}.csv)" for name in names)


@cache
def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(FOLDER),
        undefined=StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters.update(
        number=number, quantity=quantity, table=markdown, folded=folded, listed=listed, links=links
    )
    return made


def render(template: str, data: Mapping[str, Any]) -> str:
    """The page; ``template`` is a path in this package."""
    return _environment().get_template(template).render(data)


def fill_block(text: str, mark: str, block: str) -> str:
    """A hand-written text with a new ``block`` between its marks <!-- mark --> and <!-- /mark -->."""
    begin = f"<!-- {mark} -->\n"
    end = f"<!-- /{mark} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        raise ValueError(
            f"the text must have one place for {mark}, between lines {begin.strip()} and {end}"
        )
    before, _, rest = text.partition(begin)
    return f"{before}{begin}{block.strip()}\n{end}{rest.partition(end)[2]}"
