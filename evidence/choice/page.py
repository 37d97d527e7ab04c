"""The page docs/choice.md and its data."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from rope_model.physics.estimates import ASSUMED

from .fidelity import Taken
from .terms import SCENES, VARIANTS, Base, Change

DOCS = Path(__file__).parents[2] / "docs"
DATA = DOCS / "data" / "choice"

INTRODUCTION = """\
# How much model a scene needs

This page is written by `make choice`; do not edit it. Times are processor times and differ from run to run; all other
numbers are reproduced to the digit. End forces are the vertical ones. `tests/test_fidelity.py` asserts the choices.
"""

FIDELITY_NAMES = f"""\
## The rungs

| rung | unknowns per node | leaves out | exact when |
|---|---|---|---|
| torsional | r, r', theta | nothing | always |
| spatial | r, r' | torque, twist, spin inertia | no coupling, no installed twist, swivels free |
| planar | r, r' in X and Y | also all motion out of plane | no coupling, no twist, nothing out of plane or turning |
| rigid | none | also bending, stretch, waves, side forces, the loop's own motion | never |

`spatial` leaves the inertia of the spin and of the swivels out even then, and what the interpolation of theta on a
finite mesh adds (0.13 mm on elements of 0.5 m, 0.02 mm on 0.25 m in `tests/test_fidelity.py`): a small difference. With
swivels that hold, a rope that moves out of plane is twisted by its own writhe, and only `torsional` follows. Planar and
rigid give no yaw, and no rung but torsional gives torque or twist; that is why the force tolerance is 0 by default.

`model.fidelity = auto` takes the lowest rung that leaves nothing out. With `model.force_tolerance` above 0 it may take
a lower one whose estimated error (root mean square of the end forces over a winding, relative to the largest force) is
within the tolerance. When the ends do what the rung cannot follow, the run goes on with the lowest rung that can; it
never goes back down. The estimates do not know the winding: they expect ends at up to
{ASSUMED.speed:g} m/s, {ASSUMED.acceleration:g} m/s^2 and {ASSUMED.jerk:g} m/s^3, and more when the ends show more.
Inputs do not tell the jerk; it is taken to grow with the acceleration, so that a brake that bites faster than that is
underestimated until its acceleration shows. A single peak may exceed the tolerance, which is of the root mean square.
`rope_model/physics/estimates.py` states the formulas.

A run that is raised from an approximate rung takes the stretch and twist of the rung above at once (within 0.1 s in the
real rope), and from the rigid one the shape of an equilibrium: the loop's place then jumps. The energy that this brings
is booked with the transformations.
"""

SCENES_TEXT = """\
## Ten scenes

What `auto` takes, why, and how the run differs from the torsional rung: end force (root mean square and largest
difference, over the largest force), loop (largest distance between the loops' lowest points), time (processor time
over that of the torsional rung, medians of 3 interleaved runs). A scene on the torsional rung differs by nothing and is
not run.
"""

ESTIMATES_TEXT = """\
## How good the estimates are

`python -m evidence.choice --estimates` (some ten minutes) compares estimate and error for the coupled 120 m and 240
m ropes with locked swivels at 4, 8 and 16 m/s, EI 50 to 1000 N m^2 and spacings of 1.5 to 3 m, and for the 240 m rope
whose swivels are released. The estimates here know the limits of the winding. Read the table as a fit, not as a
prediction: the three constants that no theory gives (lean, its growth, whip) and the forms of these terms were chosen
with the windings with locked swivels in sight, and scenes 7 and 8 above repeat one of them. The release term has no
fitted constant, but it was added after a version without it had estimated 0.067 % where 0.13 % was measured. Of the
windings shown only scene 9, the emergency stop, is a test of the estimates on a motion that they were not made with.
"""

TERMS_TEXT = """\
## The terms of the equations

Each term is changed alone, on the torsional rung, and compared with the default rope. Force is the root mean square of
the end forces' difference over the largest force; loop, theta (at the observation points 3 m above the lowest point)
and torque (at the ends) are largest differences, the latter two also in per cent of their largest value in the scene.
"""

ROW = "| {} |".format


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown."""
    lines = [ROW(" | ".join(cells)) for cells in (head, ["---"] * len(head), *rows)]
    return "\n".join(line.replace("| --- ", "|---").replace("--- |", "---|") for line in lines)


def percent(x: float) -> str:
    """Two digits; what is below 1e-6 % is rounding of Newton's method."""
    return "0" if x == 0 else "< 1e-6 %" if x < 1e-8 else f"{digits(100 * x, 2)} %"


def millimetres(x: float) -> str:
    return "0" if x == 0 else "< 0.001 mm" if x < 1e-6 else f"{digits(1e3 * x, 3)} mm"


def digits(x: float, n: int) -> str:
    """At least ``n`` digits, without an exponent where x is large."""
    return f"{x:.{n}g}" if x < 0.99 * 10**n else f"{x:.0f}"


def span(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def scenes(results: Sequence[Taken]) -> str:
    """Table of the ten scenes, and what was raised."""
    rows, raised = [], []
    for i, x in enumerate(results, start=1):
        then = "".join(f", then {s.split()[0]}" for s in x.switches)
        same = x.fidelity == "torsional"
        differences = ["same"] * 3 if same else [percent(x.force), percent(x.peak), millimetres(x.bottom)]
        rows.append((str(i), x.case.title, x.fidelity + then, x.reason, *differences, "1" if same else f"{x.time:.2f}"))
        raised += [f"- {i}: {s}." for s in x.switches]
    head = ("", "scene", "rung", "because", "force", "largest", "loop", "time")
    return table(head, rows) + "\n\nRaised in the run:\n\n" + "\n".join(raised)


def estimates(rows: Sequence[dict[str, str]]) -> str:
    """Summary of the calibration."""
    if not rows:
        return "The comparison has not been run yet."
    out = []
    for length, swivels, speed in sorted({(float(r["length"]), r["swivels"], float(r["speed"])) for r in rows}):
        part = [r for r in rows if (float(r["length"]), r["swivels"], float(r["speed"])) == (length, swivels, speed)]
        cells = [f"{length:g} m", swivels, f"{speed:g} m/s"]
        for fidelity in ("planar", "rigid"):
            errors = [float(r[fidelity]) for r in part]
            factors = [float(r[f"{fidelity}_estimate"]) / float(r[fidelity]) for r in part]
            cells.append(span(percent(min(errors)), percent(max(errors))))
            cells.append(span(f"{min(factors):.1f}", f"{max(factors):.1f}"))
        out.append(cells)
    head = ("rope", "swivels", "speed", "planar against torsional", "estimate / error", "rigid against planar")
    link = "[All windings](data/choice/estimates.csv)"
    return table((*head, "estimate / error"), out) + f"\n\n{link}"


def terms(bases: Sequence[Base], changes: Sequence[Change]) -> str:
    """One table, and a conclusion per term."""
    base = {b.scene: b for b in bases}
    rows = []
    for x in changes:
        b, v = base[x.scene], x.variant
        values = (
            ["fails: " + x.message] + [""] * 4
            if x.message
            else [
                percent(x.force),
                millimetres(x.bottom),
                f"{1e3 * x.theta:.3g} mrad ({percent(x.theta / b.theta)})",
                f"{x.torque:.3g} N m ({percent(x.torque / b.torque)})",
                f"{x.steps} ({b.steps})",
            ]
        )
        rows.append((v.term, v.change, SCENES[x.scene].title, *values))
    rows.sort(key=lambda row: [v.change for v in VARIANTS].index(row[1]))
    head = ("term", "change", "scene", "force", "loop", "theta", "torque", "steps (default)")
    return table(head, rows) + "\n\n" + conclusions(base, changes)


def conclusions(base: dict[str, Base], changes: Sequence[Change]) -> str:
    """What the numbers say, term by term."""

    def worst(term: str, what: str, scenes: Sequence[str] = tuple(SCENES)) -> float:
        values = []
        for x in (x for x in changes if x.variant.term == term and x.scene in scenes and not x.message):
            values.append({"force": x.force, "loop": x.bottom, "torque": x.torque / base[x.scene].torque}[what])
        return max(values)

    def says(term: str, scenes: Sequence[str] = tuple(SCENES)) -> str:
        force, loop, torque = (worst(term, what, scenes) for what in ("force", "loop", "torque"))
        return (
            f"up to {percent(force)} of the end force, {millimetres(loop)} of the loop, {percent(torque)} of the torque"
        )

    def needed(term: str) -> str:
        return "needed" if worst(term, "force") > NEEDED or worst(term, "loop") > NEEDED_PLACE else "not needed"

    calm, sudden = ("winding",), ("emergency stop", "release")
    lines = [f"A term counts as needed when it changes the end force by {percent(NEEDED)} or the loop's place by "]
    lines[0] += f"{millimetres(NEEDED_PLACE)} in one of the scenes.\n"
    lines += [
        f"- **Gyroscopic and spin inertia: {needed('spin inertia')}.** In a quiet winding a hundredth of it changes "
        f"{says('spin inertia', calm)}; after an emergency stop or a release {says('spin inertia', sudden)}, because "
        "it sets the speed of the torsional waves and, through the coupling, a part of the tension. The "
        "swivels keep their inertia here. It costs no steps. Default: on, in the torsional rung, for those two.",
        f"- **Qb != Qc: {needed('non-conservative coupling')}.** The published pair changes "
        f"{says('non-conservative coupling')}: its Qc, which makes the torque, is 1.5 % below the mean. Energy is "
        "no longer conserved. Default: off, Qb = Qc = the mean.",
        f"- **Material damping: {needed('material damping')}.** None at all or ten times as much changes "
        f"{says('material damping', calm)} in a winding and {says('material damping', sudden)} after a sudden change, "
        "where it decides how long waves ring. Its value is assumed. Default: on, beta_K = 1e-3 s.",
        f"- **Stretch: {needed('stretch')}.** A rope ten times as stiff at the same Qb and Qc changes "
        f"{says('stretch')}: the torque comes from the stretch (M0 = Qc/Qa times the mean tension) and goes with it, "
        "and the longitudinal waves are faster. It saves no steps. Default: on; only the rigid rung does without.",
    ]
    return "\n".join(lines)


#: a fifth of the 0.5 % and all of the 1 cm to which the meshes must agree
NEEDED, NEEDED_PLACE = 1e-3, 0.01


def page(results: Sequence[Taken], calibration: Sequence[dict[str, str]], term_part: str) -> str:
    """The whole page."""
    parts = [INTRODUCTION, FIDELITY_NAMES, SCENES_TEXT, scenes(results), "[Data](data/choice/rungs.csv)"]
    parts += [ESTIMATES_TEXT, estimates(calibration), TERMS_TEXT, term_part, "[Data](data/choice/terms.csv)"]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def write_csv(path: Path, rows: Sequence[dict[str, object]]) -> None:
    """Six digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{x:.6g}" if isinstance(x, float) else x for k, x in row.items()})


def read_csv(path: Path) -> list[dict[str, str]]:
    """Rows by name; none without the file."""
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
