"""What the meshes cost: at the source's element counts, and at equal error."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from benchmarks.kinematic import Winding
from evidence.claims import Measured
from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
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


def saved(tables: Tables, coupling: str) -> float:
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
    """Time of EEM as a + b n: a in s, b in s per element; only meshes whose steps are not rejected."""
    t = family(tables, "eem")
    smooth = t["rejections"] == 0
    b, a = np.polyfit(t["elements"][smooth], t["processor time [s]"][smooth], 1)
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
            Measured(counts, saved(tables, c), "%", ">", SOURCE_SAVED[c]),
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
        f"Error against EEM with {REFERENCE_ELEMENTS} elements, same time step", x=0.01, ha="left", fontsize=11
    )
    return made


def reading(tables: Tables) -> str:
    """The tables of times, of equal error, and of all meshes."""
    return "\n\n".join((_times(tables), _equal(tables), _levels(tables), _all(tables), _steps(tables)))


def _times(tables: Tables) -> str:
    times, t = median_times(tables), tables["times"]
    rows = ["| | TMN-ETM | EEM | saved | source: elements | source: saved |", "|---|---|---|---|---|---|"]
    for c in COUPLINGS:
        spread = []
        for mesh in ("TMN-ETM", "EEM"):
            mine = t["processor time [s]"][(t["coupling"] == c) & (t["mesh"] == mesh)]
            elements = int(t["elements"][t["mesh"] == mesh][0])
            spread.append(f"{elements} elements, {times[c, mesh]:.2f} s ({mine.min():.2f} to {mine.max():.2f})")
        rows.append(
            f"| {c} | {spread[0]} | {spread[1]} | {saved(tables, c):.1f} % | "
            f"{SOURCE_ELEMENTS[1]} / {SOURCE_ELEMENTS[0]} | {SOURCE_SAVED[c]} % |"
        )
    return (
        f"Processor time of the steps alone; both meshes in turns, medians of {ROUNDS} rounds and range.\n\n"
        + "\n".join(rows)
    )


def _equal(tables: Tables) -> str:
    rows = [
        "| error | of the default TMN-ETM | EEM elements with the same error | EEM time | TMN-ETM time | saved |",
        "|---|---|---|---|---|---|",
    ]
    for error, value, elements, time, own, percent in at_equal_error(tables):
        name, unit = error.removesuffix("]").split(" [")
        rows.append(f"| {name} | {value:.2g} {unit} | {elements:.0f} | {time:.2g} s | {own:.2g} s | {percent:.0f} % |")
    return (
        "600 elements are more than the loop needs: an EEM mesh that is only as good as TMN-ETM is smaller. At "
        "equal error TMN-ETM saves less (coupled winding, one run per mesh, EEM interpolated between "
        "neighbouring runs):\n\n"
    ) + "\n".join(rows)


def _levels(tables: Tables) -> str:
    rows = [
        "| end-force error | EEM elements | EEM time | smallest TMN-ETM mesh within it | its time | saved |",
        "|---|---|---|---|---|---|",
    ]
    for level in LEVELS:
        elements, time = eem_at(tables, ERRORS[0], level)
        fitting = meshes_within(tables, ERRORS[0], level)
        if fitting:
            own = fitting[min(fitting)]
            rows.append(
                f"| {level:g} % | {elements:.0f} | {time:.2g} s | {min(fitting)} elements | {own:.2g} s | "
                f"{100 * (1 - own / time):.0f} % |"
            )
        else:
            rows.append(f"| {level:g} % | {elements:.0f} | {time:.2g} s | none of those run | | |")
    return "\n".join(rows)


def _all(tables: Tables) -> str:
    rows = [
        "| mesh | elements | time | end force, RMS | lowest point | kinetic energy per transformation | rejections |",
        "|---|---|---|---|---|---|---|",
    ]
    t = tables["costs"]
    for i, name in enumerate(t["mesh"]):
        change = f"{t['kinetic change [J]'][i]:.1e} J" if t["kind"][i] == "tmn" else ""
        rows.append(
            f"| {name} | {t['elements'][i]:.0f} | {t['processor time [s]'][i]:.1f} s | {t[ERRORS[0]][i]:.2g} % | "
            f"{t[ERRORS[1]][i]:.2g} mm | {change} | {t['rejections'][i]:.0f} |"
        )
    return f"All meshes, coupled, against EEM with {REFERENCE_ELEMENTS} elements:\n\n" + "\n".join(rows)


def _steps(tables: Tables) -> str:
    t = tables["time-step"]
    rows = ["| | end force, RMS | lowest point |", "|---|---|---|"]
    rows += [f"| {t['what'][i]} | {t[ERRORS[0]][i]:.2g} % | {t[ERRORS[1]][i]:.2g} mm |" for i in range(t["what"].size)]
    return STEPS_TEXT + "\n".join(rows)


STEPS_TEXT = """All runs share their time steps, and their time errors cancel: a transformation waits for the end of the
step in which it is due. (Cut so that they end on that instant, as published, the steps of TMN-ETM bring an error of
their own, however fine the mesh: tests/test_legs.py.) The table shows what the time step of 10 ms costs by itself:
where it is larger than the errors above, these compare meshes and not accuracies.

"""

SECTION = Section(
    title="Elements and computation time",
    scene=(
        "The windings of the sections before, timed. The source's ladder is known only by its counts, 600 elements of "
        "0.2 m against 98. Of the patterns with 0.2 m in segment IV that give 98 elements on 120 m we take one "
        "(assumed): l = 1.6 m, counts 4, 8, 8, 8, 4 in II to VI. Its segment IV is 1.6 m long, shorter than the bend "
        "of our loop. "
        "Our default mesh has a longer segment IV, no segments III and V, halves the outermost elements towards the "
        "clamped ends, and joins the legs' elements far from ends and loop."
    ),
    pictures=[
        Picture("costs", "End-force and loop-bottom error over element count and time for both kinds of mesh", draw)
    ],
    claims=claims,
    reading=reading,
    data=["times", "costs", "time-step"],
)
