"""The command: measure, write the tables, then draw and write everything from the tables."""

from __future__ import annotations

from pathlib import Path

from evidence.drawing import draw_to
from evidence.tables import Table, Tables, read, write

from . import depth
from .figures import FIGURES
from .levels import with_block
from .measure import measure, merge
from .page import page
from .points import FAMILIES, complete, quick

DATA, IMAGES, PEER = Path("data") / "chart", Path("images") / "chart", Path("data") / "peer"


def run(out: Path, only: str | None = None, few: bool = False) -> list[Path]:
    """Measure what is asked for and write data, figures and page into ``out``; the files written.

    ``only`` measures one of FAMILIES, or ``depth``, anew and keeps the others' data, or ``draw``: nothing is measured.
    """
    if only not in (None, "draw", "depth", *FAMILIES):
        raise ValueError(f"--only {only!r} must be one of {', '.join(FAMILIES)}, depth, or draw")
    if only is not None and not (out / DATA / "points.csv").is_file():
        raise ValueError(f"--only {only} needs the other families' data in {out / DATA}: run without --only first")
    if only in (None, "depth"):
        write({"depth": depth.measure(depth.quick() if few else depth.Depth())}, out / DATA)
    if only not in ("draw", "depth"):
        families = FAMILIES if only is None else (only,)
        tables = dict(measure(quick() if few else complete(), families))
        if only is not None:
            tables["points"] = merge(read(out / DATA)["points"], tables["points"], families)
        write(tables, out / DATA)
    if (peer := _peer(out / PEER)) is not None:
        write({"peer": peer}, out / DATA)
    return publish(out)


def publish(out: Path) -> list[Path]:
    """Figures, page and the table in the README beside ``out``, from the data that is there."""
    tables = read(out / DATA)
    written = sorted((out / DATA).glob("*.csv"))
    for name, draw in FIGURES.items():
        written.append(out / IMAGES / f"{name}.png")
        draw_to(written[-1], draw, tables)
    written.append(out / "chart.md")
    written[-1].write_text(page(tables), encoding="utf-8")
    readme = out.resolve().parent / "README.md"
    if readme.is_file() and (text := with_block(old := readme.read_text(encoding="utf-8"), tables)) != old:
        readme.write_text(text, encoding="utf-8")
        written.append(readme)
    return written


def _peer(folder: Path) -> Table | None:
    """Points of the peer's code, from its own run, where there are any."""
    tables: Tables = read(folder) if (folder / "winding.csv").is_file() else {}
    if "winding" not in tables:
        return None
    names = ("code", "group", "variant", "cpu_s_per_s", "force_error_vs_ours", "loop_error_vs_ours_m")
    t = tables["winding"]
    kept = [i for i, cost in enumerate(t["cpu_s_per_s"]) if cost == cost and t["code"][i] != "ours"]
    return {name: t[name][kept] for name in names}
