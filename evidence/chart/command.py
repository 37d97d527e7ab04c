"""Measures families of the chart, and keeps the other data; page, figures and README's table follow from the data."""

from __future__ import annotations

from pathlib import Path

from evidence.pages import BLOCKS, PAGES, fill, publish
from evidence.tables import Table, Tables, read, write

from . import depth
from .measure import measure, merge
from .points import FAMILIES, complete, quick

DATA, PEER = Path("data") / "chart", Path("data") / "peer"


def run(out: Path, only: str | None = None, few: bool = False) -> list[Path]:
    """Measure what is asked for and write data, figures and page into ``out``; the files written.

    ``only`` measures one of FAMILIES, or ``depth``, anew and keeps the others' data.
    """
    if only not in (None, "depth", *FAMILIES):
        raise ValueError(f"--only {only!r} must be one of {', '.join(FAMILIES)}, or depth")
    if only is not None and not (out / DATA / "points.csv").is_file():
        raise ValueError(f"--only {only} needs the other families' data in {out / DATA}: run without --only first")
    if only in (None, "depth"):
        write({"depth": depth.measure(depth.quick() if few else depth.Depth())}, out / DATA)
    if only != "depth":
        families = FAMILIES if only is None else (only,)
        tables = dict(measure(quick() if few else complete(), families))
        if only is not None:
            tables["points"] = merge(read(out / DATA)["points"], tables["points"], families)
        write(tables, out / DATA)
    if (peer := _peer(out / PEER)) is not None:
        write({"peer": peer}, out / DATA)
    written = publish(PAGES["chart"], out)
    if (out.resolve().parent / BLOCKS["levels"].file).is_file():
        written.append(fill(BLOCKS["levels"], out))
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
