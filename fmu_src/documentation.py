"""The variables as a page (``python -m fmu_src.documentation > docs/reference/variables.md``) and as HTML in FMUs."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Iterable, Iterator

from rope_model.parameters import rope_120
from rope_model.simulation.outputs.neglected_effects import EFFECTS
from rope_model.texts import html_text

from .arrays import DESCRIPTIONS
from .interface import Variable, variables
from .profile import ALWAYS, DEFAULT, GROUPS

_INTRODUCTION = """\
FMI 2.0 co-simulation, or 3.0 (native flavour), with the start values of the 120 m rope. Units are SI; `1` marks a
pure number. Parameters marked *tunable* may change between steps, the others only before initialisation. [assumed]
marks values without a published source.

X points from the left to the right suspension point, Y up, and Z = X x Y out of plane. The nominal suspension
points lie at x = -spacing/2 and +spacing/2, z = 0. The inputs `x` and `z` count from there; `y` is the height in
the shaft, from any origin that both ends share. Yaw is positive about Y. Twist and torque are positive about the
rope's tangent, which is -Y at the left end and +Y at the right end. Forces and moments are those of the rope on the
conveyance. A run starts from rest. Give `y`, `vy` and `ay` of one smooth motion: the rope refuses an end that would
have to accelerate by more than 100 m/s^2 within a step.
"""
_ERRORS = """\
A call that fails returns *error*. Its message, which `status.message` repeats, names value, bound and cure. After
an error in a step, during initialisation or in setting a value, restore a state or reset the FMU; the state is that
before the step. After a failed initialisation the real outputs are NaN.

Directional derivatives relate the end forces and moments at the end of a step to the inputs of that step. The step
is as long as the last one, or `solver.step_max` before the first. With `inputs_at_step_end` = false they include
the extrapolation. Inputs that `inputs.given` does not trust have the derivative 0.
"""
_STRUCTURE = """\
No output depends on an input of the same instant: an input set after a step takes effect with the next step. So
there are no algebraic loops at communication points, and the dependencies in ModelStructure are empty. During
initialisation all outputs follow all inputs and parameters at once.

The rope ignores the relative tolerance that a host may pass at set-up, because its error control knows lengths and
angles; use `accuracy.end_force`, `accuracy.loop` or `solver.tolerance`. DefaultExperiment states the start value of
`accuracy.end_force`, in newtons.
"""
_ALONG = """\
`shape.tension` follows from the balance of momentum between the left end and the point. It therefore meets the end
forces and includes waves and damping; in a loop wider than its suspension it can be negative. `shape.bending` and
`shape.torsion` are those of the elements (bending as root mean square along each), linear between their middles;
the bend at a clamped end is sharper. Models without torsion have no torsional stress. The rigid model gives the
tension of its closed form and the bending of its half circle. The points of `shape` move along the rope with its
loop. `station` stands at places fixed in the rope, for wear and fatigue; `station.first` and `station.last` choose
the part.
"""
_ADDED_MASS = """\
`added_mass` serves hosts that step heavy coupling implicitly. It is the growth of the end's pull with an upward
acceleration a held over the last communication step H, together with the speed a H and the travel a H^2/2. In
directional derivatives at the step's end (`inputs_at_step_end` = true) it is -(dfy/day + H dfy/dvy + H^2/2 dfy/dy);
dfy/day alone holds `y` and `vy` and is far smaller. With `inputs_at_step_end` = false, dfy/day includes the
extrapolation and equals -added_mass.
"""
_STEPS = """\
A communication step may be as short as the host likes. In a step below 1e-9 s nothing moves and doStep succeeds;
the next step makes up for the time. (Loops with `h = min(H, T - t)` end with such a remainder.)

Inputs at the start of a step are extrapolated with constant acceleration, so at its end the rope's path misses the
motion by j H^3/6 at a jerk j. The next path corrects what the change of the acceleration explains; the rest is drawn
in slowly (`inputs.bandwidth`). With jerks of at most j and no step longer than H the path stays within 0.26 j H^3,
0.51 j H^2 and 2.9 j H of the motion's position, speed and acceleration in even steps, within 1.2, 1.2 and 5.9 of these
in any order of steps (tests/test_master_paths.py). The end force errs by up to twice the leg's mass times the error of
the acceleration. Inputs at the step's end (`inputs_at_step_end` = true) are met exactly where they fit.

*Motions that do not fit.* Position, speed and acceleration of tables, sensors and slower parts need not be of one
motion. The rope's ends follow the given acceleration and draw position and speed in like a critically damped observer.
`inputs.misfit.*` tell what is left, `status.end_force_error` contains its effect on the end forces, and
`status.warning` names the likely cause. `inputs.given` says what to trust. Trusted inputs of a moving end that are the
same as before to the last bit are no new sample: the motion is extrapolated on, and `inputs.repeated` counts the steps.
"""
_WARNINGS = """\
`status.warning` holds warnings about valid results for as long as they apply; the log has each of them once
(category logStatusWarning). `status.valid` stays true:

- *The rope has struck a body of its shaft* or *was pressed into* it: contact held it; the text gives time, depth
  and place.
- *The rope has passed into a body of its shaft*: without contact (`contact.stiffness` = 0) no real rope could do
  what follows.
- *The legs have passed through each other, or one of them through what hangs above the other* (`loop.crossings`),
  with the time and height of the first passage. This also happens at rest: a long rope with the default `rope.Qb`
  and `rope.Qc` and locked swivels turns its loop over during initialisation. `loop.clearance` may stay large: on a
  deep rope the long leg swings through the short side's conveyance and head ropes.
- *The rope is turned around itself*: `loop.turns` exceeds half a turn.
- *Its legs have touched or pressed each other*, with time, depth and height (`loop.overlap`), from then on.
- *The loop hangs yawed by more than 30 degrees at rest*, with the parameter that turns it most: the coupling
  `rope.Qb`, `rope.Qc`, `rope.installed_twist`, or the ends. The published coupling turns a rope of several hundred
  metres that far; real ropes are made to turn less.
- *The audit fails*: over each communication step the rope compares the change of its momentum and angular momentum
  with end forces, end moments and weight (`audit.momentum` above 0.1 % of the largest end force, `audit.moment`
  above 0.5 % of that times `layout.spacing`). It also checks that its time steps follow the waves of an abrupt
  change of an end force (`audit.force_change` above 5 % and `audit.steps_per_period` below 3) and its elements the
  sharpest bend (`audit.elements_per_bend` below 4). Each is the worst so far; the rigid model has no audit and
  gives 0.
- *Accuracy was given up*: a communication step wanted more work than `solver.work_max` allows (`status.given_up`,
  `status.given_up_since`).
- *The model has no torsion*, although the rope carries torque; the outputs it leaves out are 0 (below).
- *A guard sees nothing*: the model does not compute the quantity that it watches.
- *The inputs do not fit*: positions look rounded or interpolated in a coarse table, samples come again, or position,
  speed and acceleration are not of one motion (`inputs.misfit.*`, `inputs.repeated`).
- *A communication step above 20 ms with extrapolated inputs*: in the 90 m winding, end forces are off by up to 2 %
  of the largest at 50 ms and 0.1 % at 20 ms; in an emergency stop by 20 % and 4 %.

The table states what each fidelity computes (`status.fidelity`). All other outputs are 0, which is exact only for a
rope without torque:
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
{", ".join(f"`{group}`" for group in GROUPS if group not in DEFAULT)}, which the demo's report draws. Results and value
references do not depend on the choice; outputs that are not shown are not computed.
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
#: parts of names and of descriptions in which the rows of the page that share a line differ, and what stands for these
_SHARED = (
    (re.compile(r"(?<=`)(left|right)(?=\.)"), re.compile(r"\b(left|right)[. ]"), ""),
    (re.compile(r"(?<=`divider_)\d"), re.compile(r"(?!)"), ""),
    (re.compile(r"(?<=`mesh\.counts)\[\d\]"), re.compile(r"segment \w+"), "segments II to VI"),
    (re.compile(r"(?<=`nearest\.)\w+"), re.compile(r"nearest\.\w+\.clearance|clearance\.\w+"), "that clearance"),
)
_TITLES = (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs"))


def interface_page() -> str:
    """Return the page; both ends, numbered bodies and places along the rope share a row."""
    table = variables(rope_120())
    lines = ["# The FMU's variables", "", _INTRODUCTION, "## Errors and derivatives\n", _ERRORS, _STRUCTURE]
    lines += ["## Along the rope\n", _SHAPES, _ALONG, "## Added mass\n", _ADDED_MASS]
    lines += ["## Steps of any length\n", _STEPS, "## Warnings\n", _WARNINGS]
    lines += [
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
    parts += [_STRUCTURE, _SHAPES if native and along else "", _ALONG if along else "", _ADDED_MASS, _WARNINGS]
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
