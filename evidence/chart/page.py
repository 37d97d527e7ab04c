"""docs/chart.md from the tables."""

from __future__ import annotations

import numpy as np

from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import Table, Tables

from . import depth
from .front import cheapest
from .levels import levels, times
from .measure import COST
from .reading import FORCE, LOOP, TWIST, finest, limit, needed, rows, saved, the

IMAGES, DATA = "images/chart", "data/chart"
COUPLINGS = ("coupled", "uncoupled")
#: asked for in the tables: fraction of the largest force, m
FORCES, PLACES = (1e-2, 1e-3, 1e-4), (0.1, 0.01, 0.001)
ASKED = [(FORCE, bound, f"{100 * bound:g} % end force") for bound in FORCES]
ASKED += [(LOOP, bound, f"{1e3 * bound:g} mm loop") for bound in PLACES]

HEAD = """# Accuracy against speed

This page is written by `make chart`; edit the generator, `evidence/chart`, and not the page.

The scene is the 120 m rope on its winding of 90 m at up to 8 m/s, coupled, and uncoupled (Qb = Qc = 0). Without
coupling nothing twists the rope or moves it out of plane; the planar rung of the model is then exact, and 'auto' takes
it. Every point is one run with its own mesh, largest step or model. The host communicates every 10 ms, or at the
largest step where that is longer.

Errors are those against a reference solution, at instants 40 ms apart: the RMS error of both end forces over the
largest force, the largest distance of the loop's lowest point, and, coupled, the largest difference of theta at the
two observation points 3 m above it. Cost is processor time per simulated second, its inverse the real-time factor.
"""

FIGURE_NOTES = """Points to the lower left are better. A large marker is a long step, a hollow one an error that the
reference solution does not tell from zero. The black line joins the points that no other mesh beats in both error and
time, the grey one the same among equal elements."""


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["points"]
    parts = [
        HEAD + "\n" + _machine(tables["machine"]) + "\n",
        "## The levels\n\n" + levels(tables) + "\n\n" + _verdict(t) + "\n",
        "## The reference solution\n\n" + _reference(t) + "\n",
        "## Coupled\n\n" + FIGURE_NOTES + "\n\n" + _pictures("coupled", ("force", "loop", "twist")),
        "## Uncoupled\n\n" + _peer(tables) + _pictures("uncoupled", ("force", "loop")),
        "## What the fronts teach\n\n" + _lessons(t) + "\n",
        "## TMN-ETM against equal elements\n\n" + _meshes(t) + "\n",
        "## Over the depth of the shaft\n\n" + _depth(tables["depth"]) + "\n",
        "## The solver's numbers\n\n" + _solver(t),
        f"Data: [points.csv]({DATA}/points.csv), [depth.csv]({DATA}/depth.csv), [machine.csv]({DATA}/machine.csv).\n",
    ]
    return "\n".join(parts)


def _machine(t: Table) -> str:
    m = dict(zip(t["what"].tolist(), t["value"].tolist(), strict=True))
    return (
        f"Measured on {m['processors']} processors ({m['processor']}) with Python {m['Python']}, numpy {m['numpy']} "
        f"and CasADi {m['casadi']}. Times of the levels, the rungs and the fronts are medians of rounds that take "
        "turns (column `rounds` of the data); the others are single runs and scatter more."
    )


def _pictures(coupling: str, errors: tuple[str, ...]) -> str:
    return "".join(
        f"![Error over processor time: {coupling}, {error}]({IMAGES}/{coupling}-{error}.png)\n\n" for error in errors
    )


def _verdict(t: Table) -> str:
    lines = []
    for name, bound, factor in (("draft", 0.03, 30), ("standard", 0.005, 10), ("standard, 10 ms", 0.005, 10)):
        r = rows(t, family="levels", name=name, coupling="coupled")
        if r["name"].size:
            error, fast = float(r[FORCE][0]), 1 / float(r[COST][0])
            reached = [f"{'reached' if ok else 'not reached'}" for ok in (error < bound, fast >= factor)]
            lines.append(
                f"- {name}: end-force error below {100 * bound:g} %: {reached[0]} ({100 * error:.2g} %); "
                f"{factor} times real time, coupled: {reached[1]} ({times(fast)})."
            )
    return "What the levels are meant to reach, and whether they did in this run:\n\n" + "\n".join(lines)


def _reference(t: Table) -> str:
    parts = []
    for coupling in COUPLINGS:
        r = rows(t, family="reference", coupling=coupling)
        n, h = finest(t, coupling)
        parts += [
            f"{coupling.capitalize()}: EEM with {n:.0f} elements and steps of {1e3 * h:g} ms. Differences to it:\n",
            "| elements | step | end forces | loop's lowest point | theta |",
            "|---|---|---|---|---|",
        ]
        for k, s, *e in zip(r["elements"], r["largest step [s]"], r[FORCE], r[LOOP], r[TWIST], strict=True):
            if (k, s) != (n, h):
                theta = f"{1e3 * e[2]:.2g} mrad" if np.isfinite(e[2]) else ""
                parts.append(f"| {k:.0f} | {1e3 * s:g} ms | {100 * e[0]:.2g} % | {1e3 * e[1]:.2g} mm | {theta} |")
        theta = f", {1e3 * limit(t, coupling, TWIST):.2g} mrad" if coupling == "coupled" else ""
        parts.append(
            f"\nBy the rate at which these shrink the reference solution itself errs by about "
            f"{100 * limit(t, coupling, FORCE):.1g} % in the end forces, {1e3 * limit(t, coupling, LOOP):.2g} mm "
            f"in the loop's place{theta}: the grey band at the foot of the figures.\n"
        )
    return "\n".join(parts)


def _lessons(t: Table) -> str:
    lines = ["The fastest mesh and step within an error, compiled:\n"]
    lines += ["| error below | coupled | uncoupled |", "|---|---|---|"]
    for error, bound, words in ASKED:
        lines.append(f"| {words} | {_fastest(t, 'coupled', error, bound)} | {_fastest(t, 'uncoupled', error, bound)} |")
    return "\n".join([*lines, "", _step_and_mesh(t), "", _fidelities(t)])


def _fastest(t: Table, coupling: str, error: str, bound: float) -> str:
    r = rows(t, family=("eem", "tmn", "levels"), coupling=coupling)
    i = cheapest(r[COST], r[error], bound)
    if i is None:
        return "none"
    kind = str(r["mesh"][i]).split(",")[0]
    step = min(r["largest step [s]"][i], r["communication step [s]"][i])
    return f"{kind} {r['elements'][i]:.0f}, {1e3 * step:g} ms: {1 / r[COST][i]:.0f} x real time"


def _step_and_mesh(t: Table) -> str:
    """How much the step, and how much the mesh, changes each error."""
    r = rows(t, family="tmn", coupling="coupled")
    chosen = np.char.find(r["name"].astype(str), " m, ") >= 0
    r = {name: column[chosen & ~np.char.startswith(r["name"].astype(str), "l = ")] for name, column in r.items()}
    steps, sizes = np.unique(r["largest step [s]"]), np.unique(r["elements"])
    if min(steps.size, sizes.size) < 2:
        return ""
    at = r["elements"] == sizes[sizes.size // 2]
    short = r["largest step [s]"] == steps[0]
    words = []
    for error, scale, unit in ((FORCE, 100.0, "%"), (LOOP, 1e3, "mm"), (TWIST, 1e3, "mrad")):
        by_step = scale * r[error][at][np.argsort(r["largest step [s]"][at])]
        by_mesh = scale * r[error][short][np.argsort(r["elements"][short])]
        words.append(
            f"- {error.split(' error')[0]}: {by_step[0]:.2g} to {by_step[-1]:.2g} {unit} by the step alone, "
            f"{by_mesh[0]:.2g} to {by_mesh[-1]:.2g} {unit} by the mesh alone"
        )
    head = (
        f"What the step does and what the mesh does, TMN-ETM, coupled. Step: {1e3 * steps[0]:g} to "
        f"{1e3 * steps[-1]:g} ms on {sizes[sizes.size // 2]:.0f} elements. Mesh: {sizes[0]:.0f} to "
        f"{sizes[-1]:.0f} elements at {1e3 * steps[0]:g} ms.\n\n"
    )
    return head + "\n".join(words)


def _fidelities(t: Table) -> str:
    u = rows(t, family="rungs", coupling="uncoupled")
    c = rows(t, family="rungs", coupling="coupled")
    full = the(u, "torsional", COST)
    exact = [f"{n} {full / the(u, n, COST):.1f} times as fast" for n in ("spatial", "planar") if n in u["name"]]
    left_out = [
        f"{n} {full_c / the(c, n, COST):.3g} times as fast with an end-force error of {100 * the(c, n, FORCE):.2g} % "
        f"and the loop {the(c, n, LOOP):.2g} m off"
        for full_c in [the(c, "torsional", COST)]
        for n in ("planar", "rigid")
    ]
    k = rows(t, family="kernels", kernels="portable", coupling="coupled")[COST]
    compiled = rows(t, family="levels", name="standard", coupling="coupled")[COST]
    form = (
        f" Interpreted, the standard level takes {k[0] / compiled[0]:.1f} times as long as compiled." if k.size else ""
    )
    return (
        f"Rungs of the model on the standard mesh, against the complete (torsional) one. Uncoupled, where they leave "
        f"nothing out: {', '.join(exact)}. Coupled, as approximations: {'; '.join(left_out)}.{form}"
    )


def _meshes(t: Table) -> str:
    head = "| for an error of | " + " | ".join(
        f"{what}, {c}" for c in COUPLINGS for what in ("elements TMN-ETM", "elements EEM", "time saved")
    )
    lines = [
        "Elements needed, and processor time that TMN-ETM saves at the same error: interpolated in the logarithms on "
        "each family's own front, over all steps tried. At most: the cheapest mesh tried is better already.\n",
        head + " |",
        "|---" * 7 + "|",
    ]
    for error, bound, words in ASKED:
        cells = []
        for c in COUPLINGS:
            cells += [needed(t, f, c, "elements", error, bound) for f in ("tmn", "eem")]
            part = saved(t, c, error, bound)
            cells.append(f"{part:.0f} %" if np.isfinite(part) else "")
        lines.append(f"| {words} | {' | '.join(cells)} |")
    stated = "; ".join(_statement(t, c) for c in COUPLINGS)
    return (
        "\n".join(lines)
        + "\n\nThe source states savings for 600 equal elements against 98 of TMN-ETM, not at equal error. The "
        + f"same comparison here, EEM 600 against the standard level, at the same largest step: {stated}."
    )


def _depth(t: Table) -> str:
    return (
        "Equal elements spread over the whole rope what the loop needs; TMN-ETM needs far fewer more on a longer rope. "
        "Every rope winds a long way with the same 10 ms steps for all meshes, uncoupled on the planar rung, so that "
        f"only the mesh differs; errors are against equal elements of {depth.FINEST:g} m, the loop's the largest of "
        "the run. Ropes are those of the scenes, swivels locked. Times of TMN-ETM are medians of 3 runs, of EEM "
        "one.\n\n"
        f"{depth.reading(t)}\n\n![Time saved over the length of the rope]({IMAGES}/depth.png)\n\n"
        "Hollow: the deepest rope's fast trip."
    )


def _statement(t: Table, coupling: str) -> str:
    r = rows(t, family="levels", name="standard", coupling=coupling)
    eem = the(t, f"600, {1e3 * float(r['largest step [s]'][0]):g} ms", COST, family="eem", coupling=coupling)
    part = 100 * (1 - float(r[COST][0]) / eem)
    return (
        f"{coupling} {part:.1f} % saved with {r['elements'][0]:.0f} elements, where the source states "
        f"{SOURCE_SAVED[coupling]} %"
    )


def _peer(tables: Tables) -> str:
    if "peer" not in tables:
        return ""
    return (
        "Crosses are Exudyn, a multibody code in C++, with planar cable and beam elements in the same winding. They "
        "come from `make peer`, another run on perhaps another machine, and their errors are against that run's "
        "reference solution: compare orders of magnitude.\n\n"
    )


def _solver(t: Table) -> str:
    c = rows(t, coupling="coupled")
    lines = []
    for family, column, name in (
        ("tolerance", "tolerance", "the tolerance of the local error (largest step 40 ms)"),
        ("newton", "newton tolerance", "Newton's tolerance"),
        ("rho_inf", "rho_inf", "rho_inf"),
    ):
        r = rows(c, family=family)
        cells = [
            f"{value:g}: {100 * f:.2g} %, {1e3 * p:.2g} mm, {1 / cost:.3g} x"
            for value, f, p, cost in zip(r[column], r[FORCE], r[LOOP], r[COST], strict=True)
        ]
        lines.append(f"- {name}: {'; '.join(cells)}.")
    return (
        "One number at a time about the defaults, standard mesh, coupled: end-force error, error of the loop's place, "
        "and real-time factor.\n\n"
        + "\n".join(lines)
        + f"\n\n![Errors and processor time over tolerance, Newton's tolerance and rho_inf]({IMAGES}/solver.png)\n"
    )
