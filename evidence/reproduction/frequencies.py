"""Natural frequencies over the height difference H of the ends, where their curves veer, and what they are."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from tqdm import tqdm

from evidence.claims import above, below
from evidence.drawing import CURVES, figure
from evidence.reproduction.claim import Claim, Section
from evidence.ropes import require
from evidence.tables import Array, Table, Tables, table
from rope_model import EndMotion, Model, Swivel, rope_120
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope
from rope_model.physics.node import arc_lengths
from rope_model.reference.transfer import interpolated

#: an independent discrete-rod model, Hz
REFERENCE_HZ = {
    ("out", 0.0): (0.06518, 0.07751, 0.17880, 0.18815),
    ("in", 0.0): (0.07759, 0.11735, 0.18137, 0.24060),
    ("out", 80.0): (0.05267, 0.13533, 0.13791, 0.22317),
    ("in", 80.0): (0.07244, 0.13822, 0.19542, 0.26189),
}
#: m, one half of the travel; closer where two curves nearly touch
HEIGHTS: Array = np.unique(
    np.round(np.concatenate((np.linspace(0.0, 90.0, 61), [80.0], np.linspace(80.6, 81.1, 11))), 9)
)
SHOWN = 4
COUNT = 5  # one more, because the fourth veers with the fifth
PLANES = ("out", "in")
GRID = np.linspace(0.0, 120.0, 241)  # m, arc length at which shapes are compared
#: the MAC's columns in the table ``approaches``
SWAPPED = ("MAC lower before, upper after", "MAC upper before, lower after")
ALONG = "smallest MAC of the lower mode from one H to the next"
KEPT = ("MAC lower before, lower after", "MAC upper before, upper after")


def modes(height: float) -> dict[str, tuple[Array, Array]]:
    """Frequencies (5,) and shapes (5, points, components) on GRID by plane, of the uncoupled 120 m rope.

    The left end is ``height`` (m) above the right one.
    """
    scene = rope_120().scene
    ends = {"left": Swivel(), "right": Swivel(mode="free", inertia=1e-12)}
    rope = NativeRope(
        scene.with_(rope=replace(scene.rope, Qb=0.0, Qc=0.0), model=Model("torsional"), **ends)
    )
    require(rope.initialize(0.0, EndMotion(y=0.5 * height), EndMotion(y=-0.5 * height)))
    # one end that turns is enough to free the rope of torsion; two would let it spin as a whole
    require(rope.release_free_swivels())
    s = arc_lengths(rope.state.partition.lengths)
    found = {}
    lowest = natural_modes(rope, 14)
    for plane, columns in (("out", [2]), ("in", [0, 1])):
        chosen = np.flatnonzero((lowest.out_of_plane > 0.5) == (plane == "out"))[:COUNT]
        shapes = [interpolated(lowest.shapes[k], s, GRID)[:, columns] for k in chosen]
        found[plane] = lowest.frequencies[chosen], np.array(shapes)
    return found


def column(plane: str, k: int) -> str:
    """Return the name of a column of the table ``frequencies``."""
    return f"{'out of' if plane == 'out' else 'in'} plane {k + 1} [Hz]"


def measure() -> Tables:
    """Frequencies over H, and the closest approaches of neighbouring curves."""
    found = [
        modes(float(h)) for h in tqdm(HEIGHTS, desc="natural frequencies", unit="H", leave=False)
    ]
    # seen from the other side the rope at -H is the rope at H
    heights = np.concatenate((-HEIGHTS[:0:-1], HEIGHTS))
    columns = {"H [m]": heights}
    rows: list[tuple[object, ...]] = []
    for plane in PLANES:
        f = np.array([m[plane][0] for m in found])
        shapes = np.array([m[plane][1] for m in found])
        seen = np.concatenate((shapes[:0:-1, :, ::-1], shapes)), np.concatenate((f[:0:-1], f))
        columns |= {column(plane, k): seen[1][:, k] for k in range(COUNT)}
        rows += [(plane, *row) for row in approaches(heights, seen[1], seen[0])]
    names = (
        "plane",
        "lower mode",
        "H [m]",
        "gap [Hz]",
        "gap [% of the mean]",
        *SWAPPED,
        *KEPT,
        ALONG,
    )
    return {"frequencies": columns, "approaches": table(names, rows)}


def mac(a: Array, b: Array) -> float:
    """Modal assurance criterion of two shapes (points, components)."""
    return float(np.sum(a * b) ** 2 / (np.sum(a * a) * np.sum(b * b)))


def approaches(heights: Array, f: Array, shapes: Array) -> list[tuple[float, ...]]:
    """Where the gap between neighbouring curves is smallest and doubles on both sides: how close, which shapes swap."""
    rows = []
    for k in range(f.shape[1] - 1):
        gap = f[:, k + 1] - f[:, k]
        for i in range(1, gap.size - 1):
            if not gap[i - 1] >= gap[i] < gap[i + 1]:
                continue
            # at twice the smallest gap a veering is three quarters over
            wide = np.flatnonzero(gap >= 2 * gap[i])
            if not wide.size or not wide[0] < i < wide[-1]:
                continue
            first = wide[wide < i][-1]
            last = wide[wide > i][0]
            low = shapes[first, k]
            high = shapes[first, k + 1]
            after_low = shapes[last, k]
            after_high = shapes[last, k + 1]
            pairs = ((low, after_high), (high, after_low), (low, after_low), (high, after_high))
            relative = 200 * gap[i] / (f[i, k] + f[i, k + 1])
            along = min(mac(shapes[j, k], shapes[j + 1, k]) for j in range(first, last))
            rows.append(
                (k + 1, heights[i], gap[i], relative, *(mac(*pair) for pair in pairs), along)
            )
    return rows


def exchange_rows(t: Table) -> NDArray[np.bool_]:
    """Rows of ``approaches`` at which the shapes after it are rather those of the other mode before it."""
    swapped, kept = (np.array([t[name] for name in names]) for names in (SWAPPED, KEPT))
    return np.asarray(swapped.min(axis=0) > kept.max(axis=0))


def veerings(t: Table) -> NDArray[np.bool_]:
    """Rows of ``approaches`` out of plane at which two curves come close without touching and exchange their shapes."""
    return np.asarray((t["plane"] == "out") & exchange_rows(t))


def ranges(tables: Tables, plane: str) -> Array:
    """Largest over smallest frequency of each mode along the travel, less one, in %."""
    f = np.array([tables["frequencies"][column(plane, k)] for k in range(SHOWN)])
    return np.asarray(100 * (f.max(axis=1) / f.min(axis=1) - 1))


def reference_error(tables: Tables) -> float:
    """Largest deviation from REFERENCE_HZ, %."""
    t = tables["frequencies"]
    errors = [
        abs(t[column(plane, k)][t["H [m]"] == height][0] / f - 1)
        for (plane, height), values in REFERENCE_HZ.items()
        for k, f in enumerate(values)
    ]
    return 100 * float(np.max(errors))


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the frequencies."""
    number = int(veerings(tables["approaches"]).sum())
    ratio = float(ranges(tables, "in").max() / ranges(tables, "out").max())
    return [
        Claim(
            "frequencies agree with an independent code",
            below(
                "largest deviation of the 16 frequencies at H = 0 and 80 m",
                reference_error(tables),
                0.5,
                "%",
            ),
        ),
        Claim(
            "out-of-plane frequencies veer with the height difference",
            above("closest approaches at which two neighbouring modes exchange shapes", number, 0),
        ),
        Claim(
            "in-plane frequencies change little",
            below("largest relative range in plane over the largest out of plane", ratio, 1 / 3),
        ),
    ]


def draw(tables: Tables) -> Figure:
    """Both planes over H, and the narrowest gap from near."""
    t = tables["frequencies"]
    close = tables["approaches"]
    made, axes = figure(1, 2, 4.6)
    for ax, plane in zip(axes[0], PLANES, strict=True):
        for k in range(SHOWN):
            ax.plot(t["H [m]"], t[column(plane, k)], color=CURVES[k], label=f"mode {k + 1}")
            for height in (0.0, 80.0):
                ax.plot(
                    height,
                    REFERENCE_HZ[plane, height][k],
                    "o",
                    mfc="white",
                    mec="black",
                    ms=5,
                    zorder=3,
                )
        for i in np.flatnonzero(veerings(close)) if plane == "out" else ():
            k = int(close["lower mode"][i]) - 1
            at = t["H [m]"] == close["H [m]"][i]
            middle = np.mean(
                [t[column(plane, k + j)][at][0] for j in (0, 1)]
            )  # Hz, between the two curves
            ax.plot(close["H [m]"][i], middle, "s", mfc="none", mec="#c0392b", ms=11)
        ax.set(xlabel="height difference H [m]", ylim=(0.0, 0.28), xticks=range(-80, 81, 40))
        ax.set_title("Out of plane" if plane == "out" else "In plane")
    front = axes[0, 0]
    front.set_ylabel("natural frequency [Hz]")
    front.plot([], [], "o", mfc="white", mec="black", ms=5, label="reference numbers")
    front.plot([], [], "s", mfc="none", mec="#c0392b", ms=9, label="veering")
    made.legend(*front.get_legend_handles_labels(), loc="outside lower center", ncols=6)
    return made


SECTION = Section("Natural frequencies", claims, ("frequencies", "approaches"))
