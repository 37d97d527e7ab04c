"""Computation time of the meshes at the source's element counts."""

import numpy as np

from evidence.claims import above
from evidence.reproduction.claim import Claim, Section
from evidence.reproduction.windings import COUPLINGS, follow, scene_of
from evidence.tables import Tables, rows, table
from rope_model.solver_parameters import Mesh

#: % of the computation time that the source states as saved, 600 against 98 elements
SOURCE_SAVED = {"uncoupled": 86.5, "coupled": 92.7}
SOURCE_ELEMENTS = 600, 98
#: meshes of equal elements that take as few steps as the finest
EEM_ELEMENTS = (135, 150, 200, 300, 450, 600)


def measure() -> Tables:
    """Time equal elements on the coupled winding."""
    times = []
    for n in EEM_ELEMENTS:
        run = follow(scene_of("coupled", Mesh(kind="eem", elements=n)), f"EEM {n}")
        times.append((n, run.cpu, run.rope.state.counts.steps))
    return {"costs": table(("elements", "processor time [s]", "steps"), times)}


def median_time(tables: Tables, coupling: str, mesh: str) -> float:
    """Return the processor's time of a winding, s: the median of the interleaved rounds."""
    return float(
        np.median(rows(tables["times"], coupling=coupling, mesh=mesh)["processor time [s]"])
    )


def claims(tables: Tables) -> list[Claim]:
    """Compare what the source says of the computation time."""
    # the time of equal elements as a + b n, s
    b, a = np.polyfit(tables["costs"]["elements"], tables["costs"]["processor time [s]"], 1)
    elements = {m: int(rows(tables["times"], mesh=m)["elements"][0]) for m in ("TMN-ETM", "EEM")}
    by_count = 100 * (1 - elements["TMN-ETM"] / elements["EEM"])
    source_by_count = 100 * (1 - SOURCE_ELEMENTS[1] / SOURCE_ELEMENTS[0])
    counts = f"saved with {elements['TMN-ETM']} against {elements['EEM']} elements"
    because = (
        f"the time consists of {a:.2g} s for any mesh and {1e3 * b:.0f} ms per element; the element counts "
        f"allow only {by_count:.1f} % here and {source_by_count:.1f} % in the source, so the source's time must "
        "grow faster than its element count, or its steps differ"
    )
    saved = {
        c: 100 * (1 - median_time(tables, c, "TMN-ETM") / median_time(tables, c, "EEM"))
        for c in COUPLINGS
    }
    return [
        Claim(
            f"TMN-ETM saves {SOURCE_SAVED[c]} % of the computation time ({c})",
            above(counts, saved[c], SOURCE_SAVED[c], "%"),
            because,
        )
        for c in COUPLINGS
    ]


SECTION = Section("Computation time", claims, ("times", "costs"))
