"""Computation time of the meshes at the source's element counts."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from evidence.claims import above
from evidence.drawing import COLOURS, REFERENCE, figure
from evidence.tables import Tables, table
from rope_model.parameters import Mesh

from .section import Claim, Picture, Section
from .windings import COUPLINGS, ROUNDS, follow, scene_of

#: % of the computation time that the source states as saved, 600 against 98 elements
SOURCE_SAVED = {"uncoupled": 86.5, "coupled": 92.7}
SOURCE_ELEMENTS = 600, 98
#: meshes of equal elements that take as few steps as the finest
EEM_ELEMENTS = (135, 150, 200, 300, 450, 600)


def measure() -> Tables:
    """Time equal elements on the coupled winding."""
    rows = []
    for n in EEM_ELEMENTS:
        run = follow(scene_of("coupled", Mesh(kind="eem", elements=n)), f"EEM {n}")
        rows.append((n, run.cpu, run.rope.state.counts.steps))
    return {"costs": table(("elements", "processor time [s]", "steps"), rows)}


def median_times(tables: Tables) -> dict[tuple[str, str], float]:
    """s of the processor by coupling and mesh, medians of the interleaved rounds."""
    t = tables["times"]
    keys = sorted(set(zip(t["coupling"].tolist(), t["mesh"].tolist(), strict=True)))
    return {k: float(np.median(t["processor time [s]"][(t["coupling"] == k[0]) & (t["mesh"] == k[1])])) for k in keys}


def time_saving(tables: Tables, coupling: str) -> float:
    """% of the computation time of EEM 600."""
    times = median_times(tables)
    return 100 * (1 - times[coupling, "TMN-ETM"] / times[coupling, "EEM"])


def line(tables: Tables) -> tuple[float, float]:
    """Return the time of equal elements as a + b n: a in s, b in s per element."""
    t = tables["costs"]
    b, a = np.polyfit(t["elements"], t["processor time [s]"], 1)
    return float(a), float(b)


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the computation time."""
    a, b = line(tables)
    elements = {m: int(tables["times"]["elements"][tables["times"]["mesh"] == m][0]) for m in ("TMN-ETM", "EEM")}
    by_count = 100 * (1 - elements["TMN-ETM"] / elements["EEM"])
    source_by_count = 100 * (1 - SOURCE_ELEMENTS[1] / SOURCE_ELEMENTS[0])
    counts = f"saved with {elements['TMN-ETM']} against {elements['EEM']} elements"
    because = (
        f"our time is a part of {a:.2g} s that no mesh changes and {1e3 * b:.0f} ms per element; the element counts "
        f"alone allow {by_count:.1f} % here and {source_by_count:.1f} % with the source's, so the source's time must "
        "grow faster than its element count, or its steps differ"
    )
    return [
        Claim(
            f"TMN-ETM saves {SOURCE_SAVED[c]} % of the computation time ({c})",
            above(counts, time_saving(tables, c), SOURCE_SAVED[c], "%"),
            because,
        )
        for c in COUPLINGS
    ]


def draw(tables: Tables) -> Figure:
    """Draw time over elements."""
    made, axes = figure(1, 1, 3.6)
    ax, t, times = axes[0, 0], tables["costs"], median_times(tables)
    a, b = line(tables)
    ax.plot(t["elements"], t["processor time [s]"], "o", color=REFERENCE, label="equal elements")
    n = np.array([0.0, float(t["elements"].max())])
    ax.plot(n, a + b * n, "-", color=REFERENCE, lw=0.9, label=f"{a:.2g} s + {1e3 * b:.1f} ms per element")
    counts = tables["times"]
    for c, marker in zip(COUPLINGS, "sD", strict=True):
        elements = counts["elements"][counts["mesh"] == "TMN-ETM"][0]
        ax.plot(elements, times[c, "TMN-ETM"], marker, color=COLOURS["left"], mfc="none", label=f"TMN-ETM, {c}")
    ax.set(
        xlabel="elements",
        ylabel="processor time of the winding [s]",
        title="Time of the 90 m winding over the elements",
    )
    ax.legend()
    return made


def numbers(tables: Tables) -> dict[str, Any]:
    """Return the times of both meshes."""
    return {"rounds": ROUNDS, "times": _times(tables)}


def _times(tables: Tables) -> list[tuple[str, ...]]:
    """Both meshes, with the range of their rounds, and the source's numbers."""
    times, t, rows = median_times(tables), tables["times"], []
    for c in COUPLINGS:
        spread = []
        for mesh in ("TMN-ETM", "EEM"):
            mine = t["processor time [s]"][(t["coupling"] == c) & (t["mesh"] == mesh)]
            elements = int(t["elements"][t["mesh"] == mesh][0])
            spread.append(f"{elements} elements, {times[c, mesh]:.2f} s ({mine.min():.2f} to {mine.max():.2f})")
        counts = f"{SOURCE_ELEMENTS[1]} / {SOURCE_ELEMENTS[0]}"
        rows.append((c, *spread, f"{time_saving(tables, c):.1f} %", counts, f"{SOURCE_SAVED[c]} %"))
    return rows


SECTION = Section(
    key="costs",
    title="Elements and computation time",
    pictures=[Picture("costs", "Processor time of the winding over the number of elements", draw)],
    claims=claims,
    numbers=numbers,
    data=["times", "costs"],
)
