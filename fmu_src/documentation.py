"""The interface table as Markdown (``python -m fmu_src.documentation > docs/interface.md``) and as HTML in the FMUs."""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Collection, Iterable, Iterator

from rope_model.parameters import rope_120
from rope_model.simulation.neglected_effects import EFFECTS

from .arrays import DESCRIPTIONS
from .interface import Variable, variables
from .profile import ALWAYS, DEFAULT, GROUPS

_INTRODUCTION = """\
FMI 2.0 co-simulation, or 3.0 (native flavour), start values of the 120 m rope. Units are SI; `1` marks a pure number.
Parameters marked *tunable* may be changed between steps, the others only before initialisation. [assumed] marks data
that are ours.

X points from the left to the right suspension point, Y up, Z = X x Y out of plane. The nominal suspension points are
at x = -spacing/2 and +spacing/2, z = 0; inputs `x` and `z` count from there, `y` is the height in the shaft from any
origin common to both ends. Yaw of conveyances and loop is positive about Y. Twist and torque are positive about the
rope's tangent, which is -Y at the left end and +Y at the right end. Forces and moments are those of the rope on the
conveyance. A run starts from rest. Give `y`, `vy` and `ay` of one smooth motion: an end that would have to
accelerate by more than 100 m/s^2 within a step is refused.
"""
_ERRORS = """\
When a call fails it returns *error*, and its message, which `status.message` repeats, names value, bound and cure.
After an error in a step, in initialisation or of a value to be set, restore a state or reset the FMU; the state is
that before the step. After a failed initialisation the real outputs are NaN. Directional derivatives are those of end
forces and moments at the end of a step to the inputs of that step, for a step as long as the last (before the first one
as long as `solver.step_max`); with `inputs_at_step_end` = false the extrapolation is part of them.
"""
_STRUCTURE = """\
No output depends on an input of its instant: an input that is set after a step changes nothing before the next step has
been made, and so there are no algebraic loops at communication points (the dependencies in ModelStructure are empty).
Directional derivatives do not contradict this: they are those of the function that a step is, of the inputs it was made
with. During initialisation all outputs follow all inputs and parameters at once.

A tolerance that the host hands over at set-up is not used: it is a relative one, and the rope's error control knows
lengths and angles. The parameter `solver.tolerance` has its place. DefaultExperiment states the start value of
`accuracy.end_force`, in newtons.
"""
_ALONG = """\
`shape.tension` follows from the balance of momentum between the left end and the point, so it meets the end forces and
holds the waves and the damping too; in a loop wider than its suspension it can be negative. `shape.bending` and
`shape.torsion` are those of the elements (bending as root mean square along each), linear between their middles; the
bend at a clamped end is sharper than that. Models without torsion have no torsional stress; the rigid model has the
tension of its closed form, and the bending of its half circle. The points of `shape` move along the rope with its loop;
`station` is at places that stay in it, as wear and fatigue do: `station.first` and `station.last` choose the part.
"""
_ADDED_MASS = """\
`added_mass` is for hosts that want to step heavy coupling implicitly: how much the end's pull grows with an upward
acceleration a held over the last communication step H, with the speed a H and the way a H^2/2 that belong to it. In
directional derivatives at the step's end (`inputs_at_step_end` = true) it is
-(dfy/day + H dfy/dvy + H^2/2 dfy/dy); dfy/day alone holds `y` and `vy` and is far smaller. With
`inputs_at_step_end` = false dfy/day has the extrapolation in it and is -added_mass.
"""
_STEPS = """\
A communication step may be as short as the host likes. In a step below 1e-9 s nothing moves, doStep succeeds, and the
time is not lost: the next step begins where the rope is. (Loops with `h = min(H, T - t)` end with such a remainder.)

Inputs at the start of a step are extrapolated with constant acceleration, so at its end the rope's path misses the
motion by j H^3/6 at a jerk j. The next path corrects that; where the next step h is shorter than the H before, over
the time in which a jerk of 0.1 m/s^3 would miss as much, at most H, else h would ask for accelerations of j H^3/h^2.
With jerks of at most j (take 0.1 m/s^3 if it is less) and no step longer than H, in any order, the path stays
within 0.27 j H^3, 0.62 j H^2 and 3.4 j H of the motion's position, speed and acceleration; even steps of H have
0.26, 0.51 and 2.9. Steps at rest or at constant acceleration do not count for H: extrapolation misses nothing there,
and a trip after a long one is that after short ones.
The end force errs by up to twice the leg's mass times the error of the acceleration. Inputs at the
step's end (`inputs_at_step_end` = true) are met exactly, but for steps below 1e-5 s, which aim that far ahead, because
within them the rounding of a position would ask for large accelerations (tests/test_masters.py).
"""
_WARNINGS = """\
`status.warning` holds warnings about results that are valid, as long as they apply; the log has each of them once
(category logStatusWarning). `status.valid` stays true:

- *The rope has struck a body of its shaft* or *was pressed into* it, with time, depth and place: it was held there.
- *The rope has passed into a body of its shaft*, the same without contact (`contact.stiffness` = 0), and every
  result after that is one that a real rope cannot have. [In the shaft](shaft.md) tells what bodies there are.
- *The legs have passed through each other, or one of them through what hangs above the other* (`loop.crossings`), with
  the time and height of the first time. At rest, too: a long rope with the default `rope.Qb` and `rope.Qc` and locked
  swivels turns its loop over while it is initialised. `loop.clearance`, the distance of the present legs, may be large
  all the time: on a deep rope the long leg swings through the short side's conveyance and head ropes.
- *The rope is turned around itself*: `loop.turns` beyond half a turn.
- *Its legs have touched or pressed each other*, from when on, how far and where (`loop.overlap`), for all that follows.
- *The loop hangs yawed by more than 30 degrees at rest*, with the parameter that turns it most: the coupling `rope.Qb`,
  `rope.Qc`, `rope.installed_twist`, or the ends. A real rope is made to turn less; the published coupling on a
  rope of several hundred metres turns it that far.
- *The audit fails*: over each communication step the rope compares the change of its momentum and angular momentum with
  its end forces, end moments and weight (`audit.momentum` above 0.1 % of the largest end force, `audit.moment` above
  0.5 % of that times `layout.spacing`), and looks whether its time steps follow the waves of an abrupt change of an end
  force (`audit.force_change` above 5 % of it and `audit.steps_per_period` below 3) and its elements the sharpest bend
  (`audit.elements_per_bend` below 4). All are the worst so far, and 0 in the rigid model, which has no audit.
- *Accuracy was given up* because a communication step wanted more work than `solver.work_max` allows
  (`status.given_up`, `status.given_up_since`).
- *The model has no torsion*, though the rope carries torque: what it does not compute is 0 (below).
- *A guard sees nothing*: the model does not compute what it watches (torque, say).
- *A communication step above 20 ms with extrapolated inputs*: in the 90 m winding end forces are up to 2 % of the
  largest off at 50 ms, 0.1 % at 20 ms; in an emergency stop 25 % and 4 %.

What each fidelity computes (`status.fidelity`); the rest is 0, not a result, and exact only for a rope without torque:
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
`balance-rope export --outputs GROUP ...` chooses the outputs that the model description shows, `all` of them or groups;
{" and ".join(f"`{group}`" for group in ALWAYS)} are always there. Without the option it is all but
{", ".join(f"`{group}`" for group in GROUPS if group not in DEFAULT)}, which the demo's report draws. Results and value
references are the same: outputs that are not shown are not computed.
"""
_SHAPES = """\
FMI 3.0 has the arrays `shape.x` ... `shape.torsion` (81) and `mesh.counts` (5) as such and the choices as
enumerations with the same codes; the other names, and all value references, are the same. Exported with `--scalar` it
has no arrays: their elements are variables with the names and value references of FMI 2.0.
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
_TITLES = (("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs"))


def interface_page() -> str:
    """The page; the numbered shape points are folded into one row per quantity."""
    table = variables(rope_120())
    lines = ["# The FMU's variables", "", _INTRODUCTION, _ERRORS]
    lines += [_STRUCTURE, _SHAPES, _ALONG, _ADDED_MASS]
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
        lines += [f"## {title}", "", "| name | unit or type | start | |", "|---|---|---|---|"]
        lines += [f"| {' | '.join(row)} |" for row in _rows(v for v in table if v.causality == causality)]
        lines.append("")
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
    text = re.sub(r"`(.+?)`", r"<code>\1</code>", html.escape(text.strip(), quote=False))
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


if __name__ == "__main__":
    sys.stdout.write(interface_page())
