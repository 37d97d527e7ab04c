"""The variables as a page (``python -m fmu_src.documentation > docs/reference/variables.md``) and as HTML in FMUs."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterable, Iterator

from fmu_src.arrays import DESCRIPTIONS
from fmu_src.interface import Variable, variables
from fmu_src.profile import ALWAYS, DEFAULT, GROUPS
from rope_model.parameters import rope_120
from rope_model.simulation.outputs.neglected_effects import EFFECTS
from rope_model.texts import html_text

_INTRODUCTION = """\
FMI 2.0 co-simulation, or 3.0 (native flavour), with the start values of the 120 m rope. Units are SI; `1` marks a
pure number. Parameters marked *tunable* may change between steps, the others only before initialisation. [assumed]
marks values without a published source.

X points from the left to the right suspension point, Y up, and Z = X x Y out of plane. The nominal suspension
points lie at x = -spacing/2 and +spacing/2, z = 0. The inputs `x` and `z` count from there; `y` is the height in
the shaft, from any origin that both ends share. Yaw is positive about Y. Twist and torque are positive about the
rope's tangent, which is -Y at the left end and +Y at the right end. Forces and moments are those of the rope on the
conveyance. A run starts from rest. Give `y`, `vy` and `ay` of one smooth motion.
"""
_ERRORS = """\
A call that fails returns *error*. Its message, which `status.message` repeats, names value, bound and cure. Then
restore a state or reset the FMU; a step that fails leaves the state as it was. After a failed initialisation the
real outputs are NaN.

Directional derivatives relate the end forces and moments at the end of a step to the inputs of that step. The step
is as long as the last one, or `solver.step_max` before the first. With `inputs_at_step_end` = false they include
the extrapolation. Inputs that `inputs.given` does not trust have the derivative 0.
"""
_STRUCTURE = """\
An input set after a step takes effect with the next step. So there are no algebraic loops, and the dependencies in
ModelStructure are empty. During initialisation all outputs follow all inputs and parameters at once.

The rope ignores the relative tolerance that a host may pass at set-up: use `accuracy.end_force`, `accuracy.loop` or
`solver.tolerance`. DefaultExperiment states the start value of `accuracy.end_force`, in newtons.
"""
_ALONG = """\
`shape.tension` follows from the balance of momentum between the left end and the point. It includes waves and
damping; in a loop wider than its suspension it can be negative. `shape.bending` (root mean square along each element)
and `shape.torsion` are linear between the middles of elements; the bend at a clamped end is sharper. The points of
`shape` move along the rope with its loop. `station` stands at even places in the rope, for wear and fatigue, from
`station.first` to `station.last`.
"""
_ADDED_MASS = """\
`added_mass` serves hosts that step heavy coupling implicitly. It is the growth of the end's pull with an upward
acceleration a held over the last communication step H; speed grows by a H, travel by a H^2/2. In directional
derivatives at the step's end (`inputs_at_step_end` = true) it is -(dfy/day + H dfy/dvy + H^2/2 dfy/dy); dfy/day
alone is far smaller. With `inputs_at_step_end` = false it is -dfy/day.
"""
_STEPS = """\
A communication step may be as short as the host likes. In a step below 1e-9 s nothing moves and doStep succeeds;
the next step makes up for the time. (Loops with `h = min(H, T - t)` end with such a remainder.)

Inputs at the start of a step are extrapolated with constant acceleration: at its end the rope's path misses the
motion by j H^3/6 at a jerk j. With jerks up to j the path stays within 0.26 j H^3, 0.51 j H^2 and 2.9 j H of the
motion's position, speed and acceleration. In uneven steps up to H the factors are 1.2, 1.2 and 5.9
(tests/test_master_paths.py). The end force errs by up to twice the leg's mass times the error of the
acceleration. With `inputs_at_step_end` = true motions that fit are met exactly.

[Give it your motion](../howto/motion.md) covers motions that do not fit.
"""
_WARNINGS = """\
`status.warning` holds warnings about valid results for as long as they apply; the log has each of them once
(category logStatusWarning). `status.valid` stays true. They tell of

- *bodies of the shaft*: the rope has struck one, was pressed into it by more than its diameter, or has passed into it
  without contact (`contact.stiffness` = 0);
- *legs* that have touched or pressed each other (`loop.overlap`), passed through each other, a conveyance or its head
  ropes (`loop.crossings`), or turned about each other by more than half a turn (`loop.turns`).
  `loop.clearance` may stay large: on a deep rope the long leg swings through the short side's conveyance;
- *a loop yawed by more than 30 degrees at rest*, with the parameter that turns it most. The published coupling turns a
  rope of several hundred metres that far, or over; real ropes are made to turn less;
- *the audit*. The change of momentum over a communication step contradicts end forces and weight: `audit.momentum` is
  above 0.1 % of the largest end force, or `audit.moment` above 0.5 % of that times `layout.spacing`. Or steps do not
  follow an abrupt change of an end force: `audit.force_change` is above 5 % and `audit.steps_per_period` below 3. Or
  elements do not follow the sharpest bend: `audit.elements_per_bend` is below 4. The rigid model has no audit;
- *accuracy given up* for the bound `solver.work_max` (`status.given_up`);
- *a model without torsion* of a rope that carries torque, and a guard that the model cannot serve;
- *inputs that do not fit*: rounded, interpolated, repeated, or of more than one motion (`inputs.misfit.*`);
- *communication steps above 20 ms with extrapolated inputs*. In the 90 m winding, end forces are off by 2 % of the
  largest at 50 ms and 0.1 % at 20 ms; in an emergency stop by 20 % and 4 %.
"""
_FIDELITIES = """\
The table states the outputs of each fidelity (`status.fidelity`). All others are 0, which is exact only for a rope
without torque:
"""
#: the fidelities that compute the outputs of each effect, from the lowest
_COMPUTED = {
    "planar": "planar, spatial, torsional",
    "spatial": "spatial: by motion out of plane; torsional: by torque, too",
    "torsional": "torsional",
}
_EFFECTS = [(", ".join(f"`{name}`" for name in effect.outputs), _COMPUTED[effect.lowest]) for effect in EFFECTS]
#: outputs -> the fidelities that compute them
_COMPUTED_BY = (
    ("`fy`, `fy_mean`, `added_mass`, `energy.kinetic`, `energy.gravity`", "all"),
    _EFFECTS[0],
    (
        "`loop.x`, `loop.y`, `loop.clearance`, `shape`, `stress.bending_max`",
        "planar, spatial, torsional; rigid: of a loop drawn as half a circle",
    ),
    *_EFFECTS[1:],
)
_GROUPS = f"""\
`balance-rope export --outputs GROUP ...` chooses the outputs that the model description shows: `all`, or groups.
{" and ".join(f"`{group}`" for group in ALWAYS)} are always there. The default leaves out
{" and ".join(f"`{group}`" for group in GROUPS if group not in DEFAULT)}, which the demo's report draws.
Results and value references do not depend on the choice.
"""
_SHAPES = """\
FMI 3.0 has the arrays `shape.x` ... `shape.torsion` (81) and `mesh.counts` (5), and enumerations for the choices,
with the same codes. Other names and all value references equal those of FMI 2.0. With `--scalar` the FMU has no
arrays: each element is a variable, named as in FMI 2.0.
"""
#: docs/theory in short
_MODEL = """\
<h2>Model</h2>
<p>Each element joins two nodes with position r, slope r' and torsion angle &theta;; r is cubic, &theta; linear in the
arc length x. With t = r'/|r'|: axial strain e = |r'| &minus; 1, curvature vector k = r' &times; r''/|r'|&sup2;,
torsional strain &tau; = &theta;' + twist of the frame, spin w = &theta;<sub>t</sub> + spin of the frame.</p>
<table>
<tr><td>Costello's law</td><td>T = Qa e + Qb &tau;, &nbsp; M = Qc e + Qd &tau;</td></tr>
<tr><td>strain energy</td><td>U = &int; &frac12; (Qa e&sup2; + 2 Qs e &tau; + Qd &tau;&sup2; + EI |k|&sup2;) dx,
&nbsp; Qs = (Qb + Qc)/2</td></tr>
<tr><td>kinetic energy</td><td>K = &int; &frac12; &rho; |r<sub>t</sub>|&sup2; + &frac12; &rho;J w&sup2; dx</td></tr>
<tr><td>potential of the weight</td><td>V = &int; &rho; g r<sub>Y</sub> dx</td></tr>
<tr><td>swivel that slips</td><td>M = &minus;(&frac12; &mu; d<sub>m</sub> T + M<sub>seal</sub>) sgn b<sub>t</sub>,
with the tension T at the end</td></tr>
</table>
<p>Damping is proportional to stiffness (beta_K). Ends are vertical and prescribed; between two instants of the host
each coordinate follows a quintic in time. Time integration: generalized-alpha with step control. Mesh: TMN-ETM, seven
segments with element lengths l, l/2, l/4, l/8, l/4, l/2, l that follow the loop. Its fidelity follows the case:
torsional (all), spatial (no torsion), planar, rigid. Bodies of the shaft hold the rope; its legs hold each other where
<code>contact.rope_stiffness</code> is above 0, else they pass through each other: <code>status.warning</code> and
<code>loop.clearance</code> show it.</p>
"""
_STYLE = (
    "body{font:15px/1.45 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.15em .5em;text-align:left;vertical-align:top}code{white-space:nowrap}"
)
#: differing parts of names and descriptions of rows that share a line, and the words for both
_SHARED = (
    (re.compile(r"(?<=`)(left|right)(?=\.)"), re.compile(r"\b(left|right)[. ]"), ""),
    (re.compile(r"(?<=`divider_)\d"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`mesh\.counts)\[\d\]"), re.compile(r"segment \w+"), "segments II to VI"),
    (re.compile(r"(?<=`nearest\.)\w+"), re.compile(r"nearest\.\w+\.clearance|clearance\.\w+"), "that clearance"),
    (re.compile(r"(?<=`contact\.)\w+(?=\.impulse)"), re.compile(r"contact\.\w+(?= since)"), "that pressure"),
    (re.compile(r"(?<=`contact\.)\w+(?=`)"), re.compile(r"(?<=between rope and )\w+( ropes)?"), "such bodies"),
    (re.compile(r"(?:shape|loop)\.[xyz](?=\[|`)"), re.compile(r"^[XYZ]\b"), "X, Y and Z"),
    (re.compile(r"(?<=`guard\.)\w+(?=_delay)"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`air\.v)[xz]"), re.compile(r"(?<=along )[XZ]\b"), "X and Z"),
)
_TITLES = (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs"))


def interface_page() -> str:
    """Return the page; both ends, numbered bodies and places along the rope share a row."""
    table = variables(rope_120())
    lines = ["# The FMU's variables", "", _INTRODUCTION, "## Errors and derivatives\n", _ERRORS, _STRUCTURE]
    lines += ["## Along the rope\n", _SHAPES, _ALONG, "## Added mass\n", _ADDED_MASS]
    lines += ["## Steps of any length\n", _STEPS, "## Warnings\n", _WARNINGS]
    lines += [
        "## Fidelities\n",
        _FIDELITIES,
        "| outputs | fidelities |",
        "|---|---|",
        *(f"| {outputs} | {fidelities} |" for outputs, fidelities in _COMPUTED_BY),
        "",
    ]
    lines += ["## Groups of outputs", "", _GROUPS, "| group | holds |", "|---|---|"]
    lines += [f"| `{group}` | {holds} |" for group, holds in GROUPS.items()] + [""]
    for causality, title in _TITLES:
        heads = ["name", "unit or type", "start", ""]
        rows = [[*row] for row in _folded(_rows(v for v in table if v.causality == causality))]
        if causality == "output":
            heads, rows = [x for x in heads if x != "start"], [[*row[:2], *row[3:]] for row in rows]
        lines += [f"## {title}", "", f"| {' | '.join(heads)}|", "|---" * len(heads) + "|"]
        lines += [f"| {' | '.join(row)} |" for row in rows] + [""]
    return "\n".join(lines).rstrip() + "\n"


def index_html(described: Collection[Variable], native: bool) -> str:
    """documentation/index.html: how to use the FMU, the model, the variables."""
    parts = [_INTRODUCTION.replace(", start values of the 120 m rope", ""), _ERRORS]
    along = any(v.name.startswith("shape.") for v in described)
    parts += [
        _STRUCTURE,
        _SHAPES if native and along else "",
        _ALONG if along else "",
        _ADDED_MASS,
        _WARNINGS,
        _FIDELITIES,
    ]
    paragraphs = "\n".join(_paragraph(text) for part in parts for text in part.split("\n\n") if text)
    fidelities = "".join(f"<tr><td>{_to_html(outputs)}</td><td>{which}</td></tr>" for outputs, which in _COMPUTED_BY)
    body = [f"<h1>Balance rope of a friction hoist</h1>\n{paragraphs}\n<table>{fidelities}</table>", _MODEL]
    for causality, title in _TITLES:
        rows = _rows(v for v in described if v.causality == causality)
        cells = ["".join(f"<td>{_to_html(cell)}</td>" for cell in row) for row in rows]
        head = "".join(f"<th>{text}</th>" for text in ("name", "unit or type", "start", ""))
        body.append(f"<h2>{title}</h2>\n<table><tr>{head}</tr>\n" + "\n".join(f"<tr>{row}</tr>" for row in cells))
        body.append("</table>")
    head = f'<meta charset="utf-8"><title>Balance rope</title><style>{_STYLE}</style>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n' + "\n".join(body) + "\n</body></html>\n"


def _paragraph(text: str) -> str:
    if not text.startswith("- "):
        return f"<p>{_to_html(text)}</p>"
    items = "".join(f"<li>{_to_html(item)}</li>" for item in text.removeprefix("- ").split("\n- "))
    return f"<ul>{items}</ul>"


def _to_html(text: str) -> str:
    text = re.sub(r"`(.+?)`", r"<code>\1</code>", html_text(text.strip()))
    return re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"<em>\1</em>", text)


def _rows(table: Iterable[Variable]) -> Iterator[tuple[str, str, str, str]]:
    for v in table:
        if match := re.fullmatch(r"((?:shape|station)\.\w+)\[(\d+)\]", v.name):
            if match[2] == "1":
                yield f"`{match[1]}[1]` ... `[81]`", v.unit, "", DESCRIPTIONS[match[1]]
            continue
        start = "" if v.start is None else str(v.start).lower() if isinstance(v.start, bool) else f"{v.start:g}"
        tunable = "*tunable*; " if v.variability == "tunable" else ""
        yield f"`{v.name}`", v.unit or v.kind, start, f"{tunable}{v.description}"


def _folded(rows: Iterable[tuple[str, str, str, str]]) -> Iterator[tuple[str, str, str, str]]:
    """Join the rows that differ in the end, the number or the kind of body alone."""
    alike: dict[tuple[str, str, str], list[tuple[str, str]]] = {}
    for name, unit, start, description in rows:
        shared, words = name, description
        for in_name, in_description, common in _SHARED:
            if in_name.search(name):
                shared, words = in_name.sub("", name), in_description.sub(common, description)
        alike.setdefault((shared, unit, words), []).append((name, start))
    for (_, unit, words), group in alike.items():
        names, starts = zip(*group, strict=True)
        name = ", ".join(names) if len(names) < 3 else f"{names[0]} ... {names[-1]}"
        yield name, unit, starts[0] if len(set(starts)) == 1 else ", ".join(starts), words


if __name__ == "__main__":
    sys.stdout.write(interface_page())
