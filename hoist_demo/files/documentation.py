"""Tables of the page on files: ``python -m hoist_demo.files.documentation docs/reference/files.md`` fills them."""

from __future__ import annotations

import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from hoist_demo.files.catalogue import CONTROLLER, SECTIONS, host_parameters
from hoist_demo.files.hoist_file import RULES, TAIL_SPARE


def tables() -> dict[str, str]:
    """Return the Markdown of each table by its mark in the page."""
    rules = [("rope.length", f"hoist.shaft_travel + {TAIL_SPARE:g} m"), *((one.key, one.words) for one in RULES)]
    lines = [
        "| key | what it is where nobody gives it |",
        "|---|---|",
        *(f"| `{key}` | {words} |" for key, words in rules),
    ]
    ruled = {key for key, _ in rules}
    host = ["| key | unit | default | meaning |", "|---|---|---|---|"]
    for name, p in {CONTROLLER.name: CONTROLLER, **host_parameters()}.items():
        start = CONTROLLER.start if p is CONTROLLER else "by rule" if name in ruled else _default(name)
        meaning = ", ".join(filter(None, (p.meaning, " or ".join(p.choices))))
        host.append(f"| `{name}` | {'' if p.unit == '1' else p.unit} | {start} | {meaning} |")
    return {"rules": "\n".join(lines), "host": "\n".join(host)}


def _default(name: str) -> str:
    """Return the default of a key; "none" of a part that a hoist has not got."""
    section, *path = name.split(".")
    value: Any = SECTIONS[section]()
    for part in path:
        kind, value = type(value), getattr(value, part)
        if value is None and part != path[-1]:
            hint = next(str(f.type) for f in fields(kind) if f.name == part).partition(" ")[0]
            return f"none; {_default_of(hint, path[-1])}"
    return "none" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _default_of(kind: str, name: str) -> str:
    from hoist_demo.parameters import components

    value = getattr(getattr(components, kind)(), name)
    assert not is_dataclass(value)
    return f"{value:.6g}"


def filled(text: str) -> str:
    """Return the page with its tables."""
    for mark, table in tables().items():
        before, begin, rest = text.partition(f"<!-- {mark} -->\n")
        _, end, after = rest.partition(f"<!-- /{mark} -->")
        text = f"{before}{begin}{table}\n{end}{after}"
    return text


if __name__ == "__main__":
    page = Path(sys.argv[1])
    page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
