"""The page and its data from the results; every number on it is one of them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .cases import OPTIONS_AT, REFERENCE_OURS, REFERENCE_PEER
from .elements import ELEMENTS
from .exudyn_rope import VERSION
from .precision import LEVELS, Measured, Metric, cost_at, front
from .runs import Error, Run
from .statics import MODES, Frequencies, Yaw


@dataclass(frozen=True)
class Results:
    """All that was computed."""

    frequencies: list[Frequencies]
    yaws: list[Yaw]
    references: Error  # of our finest run against Exudyn's finest
    measured: list[Measured]
    options: list[tuple[str, Measured]]
    damping: Error  # what beta_K changes in Exudyn's planar beam
    damping_3d: Error  # and in its spatial one
    functions: tuple[Run, Run]  # the ends' motion symbolic, and as Python functions
    space: list[tuple[str, list[tuple[str, Run, Error]]]]


Table = list[list[str]]


def write_data(results: Results, directory: Path) -> None:
    """One CSV file per table."""
    directory.mkdir(parents=True, exist_ok=True)
    modes = [f"f{k + 1}_Hz" for k in range(MODES)]
    rows = [[f"{r.height:g}", r.plane, r.code, *(f"{f:.6f}" for f in r.values)] for r in results.frequencies]
    _write(directory / "frequencies.csv", [["height_m", "plane", "code", *modes], *rows])
    head = ["code", "twist_rad", "torque_Nm", "yaw_deg", "left_z_m", "right_z_m"]
    rows = [[y.code, *(f"{v:.5f}" for v in (y.twist, y.torque, y.yaw, y.left, y.right))] for y in results.yaws]
    _write(directory / "yaw.csv", [head, *rows])
    head = [
        "code",
        "group",
        "variant",
        "elements",
        "step_s",
        "cpu_s_per_s",
        "force_error_vs_ours",
        "force_error_vs_exudyn",
    ]
    head += ["loop_error_vs_ours_m", "loop_error_vs_exudyn_m", "failure"]
    rows = [
        [m.run.code, m.run.group, m.run.label, str(m.run.elements), f"{m.run.step:g}", f"{m.run.cost:.4f}"]
        + [f"{e:.3e}" for e in (m.ours.force, m.peer.force, m.ours.loop, m.peer.loop)]
        + [m.run.failure]
        for m in results.measured
    ]
    _write(directory / "winding.csv", [head, *rows])
    rows = [
        [
            title,
            r.code,
            label,
            str(r.elements),
            f"{r.step:g}",
            f"{r.cost:.4f}",
            f"{e.force:.3e}",
            f"{e.loop:.3e}",
            r.failure,
        ]
        for title, runs in results.space
        for label, r, e in runs
    ]
    head = ["case", "code", "variant", "elements", "step_s", "cpu_s_per_s", "force_error", "loop_error_m", "failure"]
    _write(directory / "space.csv", [head, *rows])


def _write(path: Path, rows: Sequence[Sequence[str]]) -> None:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    path.write_text(text.getvalue(), encoding="utf-8")


def page(results: Results) -> str:
    """docs/peer.md."""
    parts = (
        _head(results),
        _frequencies(results),
        _planar(results),
        _equal(results),
        _options(results),
        _space(results),
        _limits(),
    )
    return "\n\n".join(parts) + "\n"


def _table(rows: Table) -> str:
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def _head(results: Results) -> str:
    twins = _repetitions(results)
    return f"""# The rope in an independent code

`make peer` writes this page, its figures and its data (docs/data/peer). It puts the same rope into Exudyn {VERSION}, a
general multibody code written by others in C++, and runs both side by side: same rope, same motion, one process, one
thread, the runs of the two codes in turn, processor time of the time steps alone (median of three for runs below 3 s).
The rope is the 120 m one of [model.md](model.md) with Qb = Qc = 0, because Exudyn's elements do not couple tension and
torsion. One Exudyn run ({twins[0].group}, {twins[0].label}) occurs {len(twins)} times on this page, minutes apart, and
took {min(r.cost for r in twins):.3f} to {max(r.cost for r in twins):.3f} s per simulated second: ratios of times that
differ from 1 by less than that spread say nothing. The machine was shared with other work."""


def _repetitions(results: Results) -> list[Run]:
    """The run that the symbolic functions were timed with, wherever it was timed again."""
    twin = results.functions[0]
    named = "10 ms, full Newton, radius 0.8"
    found = [m.run for m in results.measured if (m.run.group, m.run.label) == (twin.group, twin.label)]
    return [twin, *found, *(m.run for name, m in results.options if name == named)]


def _frequencies(results: Results) -> str:
    rows = [
        ["height difference", "plane", "", *(f"f{k + 1} [Hz]" for k in range(MODES)), "largest difference from ours"]
    ]
    mine = {(r.height, r.plane): r for r in results.frequencies if r.code.startswith("ours")}
    worst, where = {"reference": 0.0, "Exudyn": 0.0}, ""
    for r in results.frequencies:
        ratio = np.array(r.values) / mine[r.height, r.plane].values - 1
        off = float(np.abs(ratio).max())
        if not r.code.startswith("ours"):
            key = "reference" if r.code == "reference" else "Exudyn"
            worst[key] = max(worst[key], off)
            if key == "reference" and off == worst[key]:
                where = f"f{int(np.argmax(np.abs(ratio))) + 1}, {r.plane} of plane, {r.height:g} m".replace(
                    "in of", "in"
                )
        name = "printed reference" if r.code == "reference" else r.code
        rows.append([f"{r.height:g} m", r.plane, name, *(f"{f:.5f}" for f in r.values), f"{100 * off:.3f} %"])
    said = "reached" if worst["Exudyn"] <= 2e-3 else "not reached"
    also = "reached" if worst["reference"] <= 2e-3 else f"not reached at {where}, where the two codes agree"
    return f"""## Natural frequencies

Vertical clamped ends 2 m apart, no torsion (in ours a free swivel; Exudyn's cable in space has no torsional stiffness).
Largest difference between Exudyn and ours {100 * worst["Exudyn"]:.3f} % (wanted 0.2 %: {said}), between the printed
reference of a discrete-rod model and ours {100 * worst["reference"]:.2f} % (wanted 0.2 %: {also}).

{_table(rows)}"""


def _measured_rows(measured: list[Measured]) -> Table:
    rows = [["", "mesh, step", "end force", "loop [mm]", "CPU s per s", "real-time factor"]]
    for m in sorted(measured, key=lambda m: (m.run.code, m.run.group)):
        name = ELEMENTS[m.run.group].label if m.run.group in ELEMENTS else f"ours, {m.run.group}"
        if m.run.failure:
            rows.append([name, m.run.label, "fails", "", "", ""])
        else:
            force, loop = f"{m.of('force'):.1e}", f"{1e3 * m.of('loop'):.2f}"
            rows.append([name, m.run.label, force, loop, f"{m.run.cost:.3f}", f"{1 / m.run.cost:.1f}"])
    return rows


def _planar(results: Results) -> str:
    element, count, method = REFERENCE_PEER
    references, damping = results.references, results.damping
    finest = f"{ELEMENTS[element].label}, {count} elements, {1e3 * method.step:g} ms"
    return f"""## The planar winding

90 m at up to 8 m/s (S-curve), both ends vertical and their motion prescribed, and 3 s of rest after it. Errors are
those of the vertical forces on both ends (root mean square over time, relative to the largest force) and of the loop's
lowest point (largest in x or y), sampled every 40 ms. They are taken against our equal elements
({REFERENCE_OURS.label}) and against Exudyn's finest run ({finest}), and the larger one counts. The two references
differ from each other by {references.force:.1e} in the end force and by {1e3 * references.loop:.2f} mm at the loop:
errors near these numbers mean nothing.

How it is set up in Exudyn: prescribed coordinates of the end nodes, their motion a symbolic user function that Exudyn
evaluates without Python; generalized-alpha, spectral radius 0.8, index 3, relative Newton tolerance 1e-5, sparse
solver, fast build without range checks, no output files, the recording subtracted. Damping is the same in both:
beta_K = 1 ms times the stiffnesses on the strain rates. Left out in Exudyn it changes the end force by
{damping.force:.1e} and the loop by {1e3 * damping.loop:.2f} mm.

Lines join the runs that no other of the same code beats in both error and time; these carry labels: element count, or
(in mm) the error of the loop's place that our mesh is made for, and step. Ours takes the planar rung of its element by
itself here; Exudyn's four are planar too. "fails" says that this program's static start (one load step from our
shape) did not converge, not that the element cannot do it.

![Error of the end forces against computation time](images/peer/force.png)

![Error of the loop against computation time](images/peer/loop.png)

{_table(_measured_rows(results.measured))}"""


def _equal(results: Results) -> str:
    fronts: dict[tuple[str, Metric], list[Measured]] = {
        (code, metric): front([m for m in results.measured if m.run.code == code], metric)
        for code in ("ours", "Exudyn")
        for metric in LEVELS
    }
    rows = [["error", "ours, CPU s per s", "Exudyn", "Exudyn / ours"]]
    for metric, levels in LEVELS.items():
        for level in levels:
            a, b = (cost_at(fronts[code, metric], metric, level) for code in ("ours", "Exudyn"))
            what = f"end force {level:.0e}" if metric == "force" else f"loop {1e3 * level:g} mm"
            rows.append([what, *("-" if math.isnan(x) else f"{x:.3f}" for x in (a, b)), _ratio(b / a)])
    return f"""### Time at equal error

Interpolated on both fronts in logarithms; Exudyn's best element at each error. A ratio above 1 means that ours is
faster, below 1 that Exudyn is; - where no run of a code is that good. The cheapest runs with good end forces may have
their loop at the wrong place (Exudyn's linear beam): ask for both.

{_table(rows)}"""


def _ratio(x: float) -> str:
    return "-" if math.isnan(x) else f"{x:.2f}"


def _options(results: Results) -> str:
    rows = [["", "end force", "loop [mm]", "CPU s per s"]]
    rows += [
        [name, f"{m.of('force'):.1e}", f"{1e3 * m.of('loop'):.2f}", f"{m.run.cost:.3f}"] for name, m in results.options
    ]
    element, count = OPTIONS_AT
    symbolic, python = results.functions
    return f"""### Exudyn's options

{ELEMENTS[element].label}, {count} elements. The runs above use radius 0.8, full Newton at 10 and 20 ms and modified
Newton at 5 ms.
With the ends' motion as Python functions instead of symbolic ones, 10 ms take {python.cost:.3f} instead of
{symbolic.cost:.3f} s per s (full Newton, both in turn): the runs above use symbolic ones.

{_table(rows)}"""


def _space(results: Results) -> str:
    parts = []
    for title, runs in results.space:
        rows = [["", "end force", "loop [mm]", "CPU s per s"]]
        for label, run, e in runs:
            name = f"{'ours, ' if run.code == 'ours' else ''}{label}"
            if run.failure:
                rows.append([name, "fails", "", ""])
            else:
                rows.append([name, f"{e.force:.1e}", f"{1e3 * e.loop:.2f}", f"{run.cost:.3f}"])
        parts.append(f"**{title[0].upper() + title[1:]}.**\n\n{_table(rows)}\n\n{_space_ratio(runs)}")
    yaw = [["", "installed twist [rad]", "torque [N m]", "yaw [deg]", "left, right at 3 m [m]"]]
    yaw += [
        [y.code, f"{y.twist:.2f}", f"{y.torque:.3f}", f"{y.yaw:.3f}", f"{y.left:+.4f}, {y.right:+.4f}"]
        for y in results.yaws
    ]
    tables = "\n\n".join(parts)
    return f"""## In space

The same winding while the left end swings out of plane by 0.1 m in its first 4 s. Errors against our 600 equal elements
at 10 ms, the first row; the loop's is the largest of x, y and z.

{tables}

The spatial beam of this version drops the damping matrix it is given: with and without it the end forces differ by
{results.damping_3d.force:.1e} and the loop by {1e3 * results.damping_3d.loop:.2f} mm (120 elements, 20 ms). In the
planar beam the same damping changes the end force by {results.damping.force:.1e} (10 ms), about the error above.

**The twisted rope.** Legs of 60 m, 2 m apart, locked ends, a twist turned in at the right end. The torque yaws the loop
and moves the legs out of plane in opposite directions. Printed reference: 1.23 deg and 0.0336 m at 1 N m, 5.64 deg and
0.1537 m at 4.58 N m. Exudyn's torque is the mean over its elements.

{_table(yaw)}"""


def _space_ratio(runs: list[tuple[str, Run, Error]]) -> str:
    """Time at the error of the best run of either code that the other reaches too."""
    fronts = [
        front([Measured(run, e, e) for _, run, e in runs[1:] if run.code == code], "loop")
        for code in ("ours", "Exudyn")
    ]
    level = max(kept[-1].of("loop") for kept in fronts)
    mine, theirs = (cost_at(kept, "loop", level) for kept in fronts)
    return (
        f"At a loop error of {1e3 * level:.1f} mm ours takes {mine:.3f} s per s and Exudyn {theirs:.3f}: "
        f"ratio {theirs / mine:.1f}."
    )


def _limits() -> str:
    return """## What Exudyn cannot be asked

- Coupled tension and torsion (Qb, Qc): the spatial beam rejects off-diagonal terms of the section's stiffness, and the
  cable has no torsion.
- A swivel with Coulomb friction, stick and slip: we found no friction element that takes the tension of a beam's end as
  its normal force; it would have to be written as Python functions.
- A time-varying mesh (TMN-ETM): elements keep their reference length for a whole run.
- The ALE cable for the winding: one axial coordinate serves all nodes and element lengths are fixed, while the legs
  change theirs.
- An FMU for co-simulation: we found no export; another program would drive it from Python.

These follow from its documentation and, for the first, from its error message; none is a measurement. Where Exudyn's
numbers are poor the fault may be ours: we are no experts in it."""
