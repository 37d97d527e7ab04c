"""The parameter file that a fit writes: [fixed] for every command, [rope] and [known] for what goes on from them."""

from __future__ import annotations

import textwrap
from pathlib import Path

from hoist_demo.calibration.identify import Identified
from hoist_demo.calibration.measurements import FOLLOWING
from hoist_demo.calibration.page import misfit
from rope_model.texts import printable, toml_string


def write_rope_file(found: Identified, path: Path) -> Path:
    """Write what was found."""
    known = found.known
    rope = found.measured.bench.rope(found.fit.shares)
    lines = [
        f"# Found by balance-rope identify from {printable(found.measured.path.name)}. demo and export take it as",
        '# --rope FILE, studies, duties and ropes as [fixed] from = "FILE".',
        *_warning(found),
        "[rope]",
        f"construction = {toml_string(known.construction)}",
        f"diameter = {known.diameter!r}",
        f"length = {known.length!r}",
        f"lay = {toml_string(known.lay)}",
        "",
        "[known]",
    ]
    for name, datum in known.data.items():
        facts = f"status = {toml_string(datum.status)}, source = {toml_string(datum.source)}"
        lines.append(f"{name} = {{ low = {datum.low:.6g}, high = {datum.high:.6g}, {facts} }}")
    lines += ["", "[fixed]", *(f"rope.{name} = {getattr(rope, name):.8g}" for name in FOLLOWING)]
    for name in found.measured.bench.sought:
        status = toml_string(found.data[name].status)
        lines.append(f"{name} = {{ value = {found.value(name):.6g}, status = {status} }}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return path


def _warning(found: Identified) -> list[str]:
    """Return warnings to readers of the file, as comments."""
    return [f"# {printable(line)}" for line in textwrap.wrap(misfit(found), 110)]
