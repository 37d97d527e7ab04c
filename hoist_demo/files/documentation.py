"""Tables of the page on files: ``python -m hoist_demo.files.documentation docs/reference/files.md`` fills them."""

from __future__ import annotations

import sys
from pathlib import Path

from hoist_demo.cases.rules import LENGTH, RULES
from hoist_demo.files.catalogue import host_parameters
from hoist_demo.parameters.quantity import Parameter


def tables() -> dict[str, str]:
    """Return the Markdown of each table by its mark in the page."""
    ruled = {rule.key: rule.words for rule in (LENGTH, *RULES)}
    rules = [f"| `{key}` | {words} |" for key, words in ruled.items()]
    host = [
        f"| `{p.name}` | {'' if p.unit == '1' else p.unit} | {'by rule' if p.name in ruled else _default(p)} "
        f"| {', '.join(filter(None, (p.meaning, ' or '.join(p.choices))))} |"
        for p in host_parameters().values()
    ]
    heads = {"rules": "| key | what it is where nobody gives it |\n|---|---|"}
    heads["host"] = "| key | unit | default | meaning |\n|---|---|---|---|"
    return {"rules": "\n".join([heads["rules"], *rules]), "host": "\n".join([heads["host"], *host])}


def _default(p: Parameter) -> str:
    """Return the default; "none" of a part that a hoist has not got, with that of the part."""
    value = "none" if p.start is None else f"{p.start:.6g}" if isinstance(p.start, float) else str(p.start)
    return f"none; {value}" if p.name.count(".") > 1 else value


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
