"""docs/mesh_rule.md from the tables."""

from __future__ import annotations

import math

import numpy as np

from evidence.tables import Table, Tables
from rope_model.simulation import mesh

from . import laws
from .judging import distribution, is_resolved, misses, swing
from .laws import Laws
from .rule import Shares, judges, longest, shares, slip
from .scenes import FIT, JUDGE, KINDS
from .trips import ASKED

#: m, the errors at which the rule is held against the laws
HELD = (0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
#: columns of the runs that miss what was asked
MISSED = ("length [m]", "speed [m/s]", "achieved [m]", "at rest [m]")

HEAD = """# The lengths of the fitted mesh

This page is written by `make mesh-rule`; edit the generator, `evidence/mesh_rule`, and not the page.

`mesh.kind = auto` takes element lengths from the rope's own lengths and from `mesh.loop_error`, the error of the loop's
place that the mesh may bring (`rope_model/simulation/mesh.py`). Here is what its constants rest on: laws that follow
from the rope's equations, with coefficients fitted on ropes and trips from a seed, and the rule held against the laws,
and wound, on those of another seed. The published case is in neither. Ropes: 60 to 1200 m, 3 to 15 kg/m, EI 50 to
3000 N m^2, EA 1.1e7 to 2e7 N per kg/m, spacing 1.2 to 3 m, uncoupled, swivels locked. Trips: 4 to 20 m/s, 0.5 to
1.5 m/s^2, jerk 0.3 to 3 m/s^3, each also with an emergency stop of 5 m/s^2. Steps of 10 ms in all meshes, so that only
the mesh differs.
"""

LAWS = """The unit of length is w = (EI/(rho g))^(1/3), over which bending stiffness and weight balance: a free loop is
2.543 w wide and its smallest radius 0.912 w. A long rope hangs in that loop whatever its spacing, its legs lean a
little. x is the length of the loop's elements over w, S = EA w^2/EI.

- **Loop.** A cubic bends without stretching only where its curvature k is even; what is left, k k' l^3, is strain.
  N = B S x^4 weighs its energy against that of bending. For N >> 1 elements do not stretch, each has one shape left,
  its angle, and the chain converges with l^2 (membrane locking); for N << 1 with l^6. The loop hangs too high by
  {loop}.
- **Cover.** Up the leg the angle obeys EI psi'' = rho g s psi, Airy's equation, and fades out as exp(-2/3 (s/w)^(3/2)).
  Where elements of the loop's length end, and those of twice and four times the length begin, the loop's place is off
  by {cover}.
- **Ends.** The rope bends within the layer sqrt(EI/T) of its clamp. The clamp moment errs by
  {ends}.
- **Legs.** An element as long as sqrt(grading_length x), x from the loop, has all waves of one frequency lag by the
  same angle; what they lag adds up along the leg. The loop's place is off by {legs} on smooth
  trips, by {stopped} after an emergency stop.
"""

CLOSING = """What was asked and what the largest error of a trip was, on ropes and trips of the judging seed. Runs for
which two references differ by more than what is asked are left out.

{judged}

{swings}

{missed}

![The laws, their data, and asked against achieved errors](images/mesh_rule.png)

Data: {data}.
"""


def page(tables: Tables) -> str:
    """The whole page."""
    found = laws.fit(tables)
    judged = {asked: shares(found, judges(), asked) for asked in HELD}
    return "\n".join(
        [
            HEAD,
            "## The laws\n\n" + LAWS.format(**formulas(found)),
            _spread(found) + "\n",
            "## The rule against the laws\n\n" + _held(judged) + "\n",
            "## Constant by constant\n\n" + constants(tables) + "\n",
            "## Asked and achieved\n\n"
            + CLOSING.format(
                judged=_judged(tables["judge"]),
                swings=_swings(tables["judge"]),
                missed=_missed(tables["judge"]),
                data=", ".join(f"[{name}.csv](data/mesh_rule/{name}.csv)" for name in sorted(tables)),
            ),
        ]
    )


def summary(tables: Tables) -> str:
    """What the command prints."""
    found = laws.fit(tables)
    lines = [f"{name}: {text}" for name, text in formulas(found).items()]
    return "\n".join([*lines, _spread(found), "", _judged(tables["judge"]), "", _swings(tables["judge"])])


def formulas(found: Laws) -> dict[str, str]:
    """The laws with their fitted coefficients."""
    (A, B), (C, p, b), (D, q) = found.loop.values, found.cover.values, found.ends.values
    return {
        "loop": f"A w x^2 N/(1 + N), A = {A:.3g}, B = {B:.2g}",
        "cover": f"{C:.2g} w x^{p:.2f} exp(-{b:.2f} (cover/w)^(3/2))",
        "ends": f"{D:.1e} (element/layer)^{q:.1f}, up to {laws.RESOLVED:g} layers",
        "legs": f"{found.legs.values[0]:.1e} grading_length L",
        "stopped": f"{found.legs_stopped.values[0]:.1e} grading_length L",
    }


def _spread(found: Laws) -> str:
    words = ", ".join(
        f"{name} {math.exp(fit.spread):.2f} ({math.exp(fit.worst):.1f})"
        for name, fit in zip(("loop", "cover", "ends", "legs", "legs after a stop"), found, strict=True)
    )
    return f"Seed {FIT}; factor between fit and measurement, root mean square (largest): {words}."


def _held(judged: dict[float, Shares]) -> str:
    lines = [
        f"Ropes of seed {JUDGE}: median, and the worst of {next(iter(judged.values())).loop.size}.\n",
        "| `loop_error` | by the loop's elements / asked | by the cover / asked | error of the clamp moment |",
        "|---|---|---|---|",
    ]
    for asked, of in judged.items():
        cells = [f"{np.median(part):.2g}, {part.max():.2g}" for part in of[:2]]
        moment = f"{100 * np.median(of.moment):.2g} %, {100 * of.moment.max():.2g} %"
        lines.append(f"| {1e3 * asked:g} mm | {' | '.join(cells)} | {moment} |")
    kept = [asked for asked, of in judged.items() if of.loop.max() <= 1]
    return "\n".join(lines) + (
        f"\n\nThe loop's elements keep what is asked down to {1e3 * min(kept):g} mm on every rope; below, the rule's "
        "fifth power shortens them too little while they lock."
    )


def constants(tables: Tables) -> str:
    """The table of the rule's constants."""
    rows = [*_derived(), *_measured_at_rest(tables), *_measured_on_trips(tables)]
    return "\n".join(
        ["| constant | value | where from |", "|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)]
    )


def _derived() -> list[tuple[str, str, str]]:
    near = (
        f"a convention: ends that part by up to {100 * (1 - 2 * mesh.NEAREST):.0f} % of the rope's length; "
        "coarse_length is lowered, or equal elements are taken, until segment IV can follow there"
    )
    due = "derived: 1/2, where the neighbouring mesh fits as well, and 1/10 against trembling"
    legs = "a convention: two elements of l before the first of 2 l, as two of l/2 before the first of l"
    return [
        ("NATURAL_RADIUS", f"{mesh.NATURAL_RADIUS:g}", "derived: 1/1.09661, the elastica that hangs free"),
        ("NEAREST", f"{mesh.NEAREST:g}", near),
        ("DUE", f"{mesh.DUE:g}", due),
        ("LATEST", f"{mesh.LATEST:g}", "derived: 20 m/s for a step of 20 ms on elements of 1.6 m"),
        ("LEG_LENGTHS, GRADING", f"2, 3, 4, 6 ...; {mesh.GRADING}", legs),
    ]


def _measured_at_rest(tables: Tables) -> list[tuple[str, str, str]]:
    found = laws.fit(tables)
    at = {asked: shares(found, judges(), asked) for asked in (0.05, ASKED, 1e-3, 2e-4)}
    loop, cover = (", ".join(f"{of[k].max():.2g} at {1e3 * asked:g} mm" for asked, of in at.items()) for k in range(2))
    used, longer = slip(tables["loop"])
    aside = (
        f"{longest():.2f} w on a free loop; the loop slips aside by up to {used:.2g} of what it hangs too high on "
        f"shorter elements, by up to {longer:.2g} on longer ones"
    )
    fade = f"{mesh.FADE:g}, {mesh.FADE_ERROR:g} m, {mesh.FADE_DECADE:g}"
    return [
        (
            "LOOP_LENGTH, LOOP_ERROR",
            f"{mesh.LOOP_LENGTH:g}, {mesh.LOOP_ERROR:g}",
            f"a fifth power in place of the law; the loop's elements take up to {loop} of what is asked",
        ),
        ("LONGEST", f"{mesh.LONGEST:g}", aside),
        ("FADE, FADE_ERROR, FADE_DECADE", fade, f"the cover takes up to {cover} of what is asked"),
    ]


def _measured_on_trips(tables: Tables) -> list[tuple[str, str, str]]:
    found, t = laws.fit(tables), tables["parts"]
    ends, steps, stops = off(t, "ends", KINDS[0]), off(t, "steps", KINDS[0]), off(t, "steps", KINDS[1])
    moment = shares(found, judges(), ASKED).moment.max()
    legs, stopped = mesh.LEG_GRADING * found.legs.values[0], mesh.LEG_WAVES * found.legs_stopped.values[0]
    return [
        (
            "END_LENGTH",
            f"{mesh.END_LENGTH:g}",
            f"at {1e3 * ASKED:g} mm the clamp moment errs by up to {100 * moment:.2g} %, the loop is off by "
            f"{1e3 * np.median(ends):.2g} mm on a smooth trip, at most {1e3 * ends.max():.2g} mm",
        ),
        ("LEG_GRADING", f"{mesh.LEG_GRADING:g} m", f"legs take {legs:.2g} of what is asked on a smooth trip"),
        (
            "LEG_WAVES",
            f"{mesh.LEG_WAVES:g} m^2",
            f"{1e3 * stopped:.2g} mm after an emergency stop, where steps of 10 ms bring {1e3 * np.median(stops):.2g} "
            f"mm ({1e3 * np.median(steps):.2g} mm on a smooth trip)",
        ),
    ]


def off(t: Table, what: str, kind: str) -> laws.Array:
    """How far the loop's place is off by one part of the mesh or by the steps, m."""
    return np.asarray(t["off [m]"][(t["what"] == what) & (t["trip"] == kind)])


def _judged(t: Table) -> str:
    lines = [
        "| asked | trip | runs | achieved / asked: median | 90 % | worst | within | elements, median |",
        "|---" * 8 + "|",
    ]
    for asked in sorted(set(t["asked [m]"][is_resolved(t)].tolist()), reverse=True):
        for kind in KINDS:
            d = distribution(t, kind, asked)
            lines.append(
                f"| {1e3 * asked:g} mm | {kind} | {d.number} | {d.median:.2g} | {d.most:.2g} | {d.worst:.2g} | "
                f"{100 * d.within:.0f} % | {d.elements:.0f} |"
            )
    return "\n".join(lines)


def _swings(t: Table) -> str:
    words = []
    for kind in KINDS:
        median, most = swing(t, kind)
        words.append(f"{median:.2g} ({kind}; nine of ten below {most:.2g})")
    return f"The largest error of a trip over that at rest, median: {', '.join(words)}."


def _missed(t: Table) -> str:
    lines = [
        f"Beyond {1e3 * ASKED:g} mm:\n",
        "| rope | length / w | trip | largest speed | achieved | at rest |",
        "|---" * 6 + "|",
    ]
    for i in misses(t, ASKED):
        length, speed, achieved, rest = (t[name][i] for name in MISSED)
        lines.append(
            f"| {length:.0f} m | {length / t['w [m]'][i]:.0f} | {t['trip'][i]} | {speed:.1f} m/s | "
            f"{1e3 * achieved:.2g} mm | {1e3 * rest:.2g} mm |"
        )
    return "\n".join(lines)
