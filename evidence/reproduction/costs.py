"""What the meshes cost: at the source's element counts, and at equal error."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from benchmarks.kinematic import Winding
from evidence.claims import Measurement
from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.rendering import number, quantity
from evidence.tables import Table, Tables, table
from rope_model.parameters import Mesh

from .section import Claim, Picture, Section
from .timestep import ERRORS, errors
from .windings import COUPLINGS, DEFAULT_MESH, ROUNDS, follow, scene_of

Array = NDArray[np.float64]

#: % of the computation time that the source states as saved, 600 against 98 elements
SOURCE_SAVED = {"uncoupled": 86.5, "coupled": 92.7}
SOURCE_ELEMENTS = 600, 98
REFERENCE_ELEMENTS = 1200
EEM_ELEMENTS = (60, 90, 100, 120, 135, 150, 200, 300, 450, 600)
TMN_MESHES = {
    "l = 6 m, IV 6 m": Mesh(coarse_length=6.0, counts=(2, 4, 8, 4, 2)),
    "l = 6 m, IV 12 m": Mesh(coarse_length=6.0, counts=(2, 4, 16, 4, 2)),
    "l = 4 m, IV 12 m": Mesh(coarse_length=4.0, counts=(2, 4, 24, 4, 2)),
    "l = 3 m, IV 12 m": Mesh(coarse_length=3.0, counts=(2, 4, 32, 4, 2)),
    "the default": DEFAULT_MESH,
    "l = 2 m, IV 10 m": Mesh(),
    "l = 1.5 m, IV 10.5 m": Mesh(coarse_length=1.5, counts=(2, 4, 56, 4, 2)),
    "l = 1 m, IV 10 m": Mesh(coarse_length=1.0, counts=(2, 4, 80, 4, 2)),
    "l = 1.6 m, IV 1.6 m, ends not halved": Mesh(coarse_length=1.6, counts=(4, 8, 8, 8, 4), end_levels=0),
}
DEFAULT = "the default"
LEVELS = (1.0, 0.1, 0.01)  # %


def measure() -> Tables:
    """Every mesh once through the coupled winding, against EEM with REFERENCE_ELEMENTS."""
    meshes = {f"EEM {n}": Mesh(kind="eem", elements=n) for n in EEM_ELEMENTS} | TMN_MESHES
    exact = follow(scene_of("coupled", Mesh(kind="eem", elements=REFERENCE_ELEMENTS)), "reference")
    rows = []
    for name, mesh in meshes.items():
        run = follow(scene_of("coupled", mesh), name)
        rows.append((name, mesh.kind, *_row(run, exact)))
    names = ("mesh", "kind", "elements", "processor time [s]", *ERRORS, "kinetic change [J]", "steps", "rejections")
    return {"costs": table(names, rows)}


def _row(run: Winding, exact: Winding) -> tuple[float, ...]:
    counts = run.rope.state.counts
    elements = run.rope.state.partition.lengths.size
    change = max((abs(e.kinetic) for e in run.events if e.what == "transformation"), default=0.0)
    return elements, run.cpu, *errors(run, exact), change, counts.steps, counts.rejections


def median_times(tables: Tables) -> dict[tuple[str, str], float]:
    """s of the processor by coupling and mesh, medians of the interleaved rounds."""
    t = tables["times"]
    keys = sorted(set(zip(t["coupling"].tolist(), t["mesh"].tolist(), strict=True)))
    return {k: float(np.median(t["processor time [s]"][(t["coupling"] == k[0]) & (t["mesh"] == k[1])])) for k in keys}


def time_saving(tables: Tables, coupling: str) -> float:
    """% of the computation time of EEM 600."""
    times = median_times(tables)
    return 100 * (1 - times[coupling, "TMN-ETM"] / times[coupling, "EEM"])


def family(tables: Tables, kind: str) -> Table:
    """The rows of one kind of mesh."""
    t = tables["costs"]
    return {name: column[t["kind"] == kind] for name, column in t.items()}


def eem_at(tables: Tables, error: str, value: float) -> tuple[float, float]:
    """Elements and time (s) at which EEM has this error: interpolated in the logarithms between neighbouring runs."""
    t = family(tables, "eem")
    x, n = np.log(t[error]), t["elements"]
    if not x.min() <= np.log(value) <= x.max():
        return float("nan"), float("nan")
    k = int(np.flatnonzero(x > np.log(value))[-1])  # the last run that is worse
    part = (np.log(value) - x[k]) / (x[k + 1] - x[k])
    elements = float(np.exp(np.log(n[k]) + part * (np.log(n[k + 1]) - np.log(n[k]))))
    return elements, float(np.interp(elements, n, t["processor time [s]"]))


def meshes_within(tables: Tables, column: str, bound: float) -> dict[int, float]:
    """Time (s) by element count of the TMN-ETM meshes whose ``column`` is within ``bound``."""
    t = family(tables, "tmn")
    good = t[column] <= bound
    return dict(zip(t["elements"][good].astype(int).tolist(), t["processor time [s]"][good].tolist(), strict=True))


def at_equal_error(tables: Tables) -> list[tuple[str, float, float, float, float, float]]:
    """For each error of the default mesh: name, value, EEM's elements and time, the mesh's time, % saved."""
    t = family(tables, "tmn")
    i = int(np.flatnonzero(t["mesh"] == DEFAULT)[0])
    rows = []
    for error in ERRORS:
        elements, time = eem_at(tables, error, float(t[error][i]))
        own = float(t["processor time [s]"][i])
        rows.append((error, float(t[error][i]), elements, time, own, 100 * (1 - own / time)))
    return rows


def line(tables: Tables) -> tuple[float, float]:
    """Time of EEM as a + b n: a in s, b in s per element; of meshes that take as few steps as the finest."""
    t = family(tables, "eem")
    same = t["steps"] == t["steps"].min()
    b, a = np.polyfit(t["elements"][same], t["processor time [s]"][same], 1)
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
            Measurement(counts, time_saving(tables, c), "%", ">", SOURCE_SAVED[c]),
            because,
        )
        for c in COUPLINGS
    ]


def draw(tables: Tables) -> Figure:
    """Errors over elements and over time."""
    made, axes = figure(2, 2, 6.4, sharey="row", sharex="col")
    for row, error in zip(axes, ERRORS, strict=True):
        for ax, abscissa in zip(row, ("elements", "processor time [s]"), strict=True):
            eem, tmn = family(tables, "eem"), family(tables, "tmn")
            order = np.argsort(eem["elements"])
            ax.loglog(eem[abscissa][order], eem[error][order], "o-", color=REFERENCE, ms=4, label="EEM")
            other = np.char.find(tmn["mesh"].astype(str), "not halved") >= 0
            ax.loglog(tmn[abscissa][~other], tmn[error][~other], "s", color=COLOURS["left"], ms=5, label="TMN-ETM")
            ax.loglog(
                tmn[abscissa][other],
                tmn[error][other],
                "x",
                color=ACCENTS[2],
                ms=7,
                label="98 elements, as the source's count",
            )
            main = tmn["mesh"] == DEFAULT
            ax.loglog(
                tmn[abscissa][main], tmn[error][main], "s", color=COLOURS["right"], ms=7, label="TMN-ETM, default"
            )
        row[0].set_ylabel({"force error [%]": "end force, RMS error [%]"}.get(error, "lowest point, error [mm]"))
    for level in LEVELS:
        for ax in axes[0]:
            ax.axhline(level, color="black", lw=0.6, ls=":")
    for ax, label in zip(axes[1], ("elements", "processor time of the winding [s]"), strict=True):
        ax.set_xlabel(label)
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
        ax.xaxis.set_major_formatter("{x:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    made.suptitle(
        f"Error against EEM with {REFERENCE_ELEMENTS} elements, same largest time step", x=0.01, ha="left", fontsize=11
    )
    return made


def numbers(tables: Tables) -> dict[str, Any]:
    """Times, errors, and what is saved at equal error."""
    return {
        "rounds": ROUNDS,
        "reference": REFERENCE_ELEMENTS,
        "times": _times(tables),
        "equal": _equal(tables),
        "levels": [_level(tables, level) for level in LEVELS],
        "meshes": _meshes(tables["costs"]),
        "steps": _steps(tables["time-step"]),
    }


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


def _equal(tables: Tables) -> list[tuple[str, ...]]:
    """EEM with the errors of the default mesh."""
    rows = []
    for error, value, elements, time, own, percent in at_equal_error(tables):
        name, unit = error.removesuffix("]").split(" [")
        seconds = (quantity(x, "s", ".2g") for x in (time, own))
        rows.append((name, f"{number(value, '.2g')} {unit}", number(elements, ".0f"), *seconds, f"{percent:.0f} %"))
    return rows


def _level(tables: Tables, level: float) -> tuple[str, ...]:
    """EEM with this error of the end forces (%), and the smallest TMN-ETM mesh within it."""
    elements, time = eem_at(tables, ERRORS[0], level)
    fitting = meshes_within(tables, ERRORS[0], level)
    eem = f"{level:g} %", number(elements, ".0f"), quantity(time, "s", ".2g")
    if not fitting:
        return (*eem, "none of those run", "", "")
    own = fitting[min(fitting)]
    return (*eem, f"{min(fitting)} elements", quantity(own, "s", ".2g"), f"{100 * (1 - own / time):.0f} %")


def _meshes(t: Table) -> list[tuple[str, ...]]:
    """Every mesh."""
    return [
        (
            name,
            number(t["elements"][i], ".0f"),
            quantity(t["processor time [s]"][i], "s", ".1f"),
            *_errors(t, i),
            quantity(t["kinetic change [J]"][i], "J", ".1e") if t["kind"][i] == "tmn" else "",
            number(t["rejections"][i], ".0f"),
        )
        for i, name in enumerate(t["mesh"].tolist())
    ]


def _errors(t: Table, i: int) -> tuple[str, str]:
    return f"{number(t[ERRORS[0]][i], '.2g')} %", f"{number(t[ERRORS[1]][i], '.2g')} mm"


def _steps(t: Table) -> list[tuple[str, ...]]:
    """What the time step costs."""
    return [(what, *_errors(t, i)) for i, what in enumerate(t["what"].tolist())]


SECTION = Section(
    key="costs",
    title="Elements and computation time",
    pictures=[
        Picture("costs", "End-force and loop-bottom error over element count and time for both kinds of mesh", draw)
    ],
    claims=claims,
    numbers=numbers,
    data=["times", "costs", "time-step"],
)
