"""What contact must satisfy, measured."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from evidence.claims import Measurement
from evidence.rendering import DOCS
from evidence.tables import Table, read, rows

from .brushed import FINE, brushed, missed
from .crossed import force_error
from .neighbours import energy_missed, off_the_wall
from .plectoneme import grown, soft_rod
from .rebound import exact_speed, rebound
from .scenes import fallen, pulled, struck, touch_down
from .slack_rod import LENGTH, slack_table
from .turned import struck_legs, turned

#: s, steps of the rebound; and s/m, its damping
STEPS, DAMPING = (2e-3, 1e-3, 5e-4, 2.5e-4), 0.5


def checks() -> Iterator[tuple[str, Measurement]]:
    """Each with the case that it belongs to."""
    for case, measure in CASES.items():
        for measurement in measure():
            yield case, measurement


def _touch_down() -> Iterator[Measurement]:
    x = touch_down(EI=10.0, element=0.08, stiffness=1e7)
    off = float(np.abs(x.y - x.exact).max() / x.exact.max())
    yield Measurement("height in the bending layer, off by, of the largest", off, "1", "<", 0.01)
    yield Measurement("height half way up the leg, off by", abs(x.leg), "1", "<", 1e-4)
    yield Measurement("force of the floor, off by", abs(x.force), "1", "<", 1e-6)


def _fallen() -> Iterator[Measurement]:
    for EI, element, bound in ((1.0, 0.1, 0.1), (0.1, 0.05, 0.05)):
        x = fallen(EI, element, 0.8)
        what = f"impulse of the floor after 0.8 s, EI = {EI:g} N m^2, off by"
        yield Measurement(what, abs(float(x.impulse[-1] / x.exact[-1]) - 1.0), "1", "<", bound)


def _pulled() -> Iterator[Measurement]:
    for friction, bound in ((0.0, 1e-4), (0.2, 5e-4), (0.5, 3e-3)):
        x = pulled(friction, 0.1)
        yield Measurement(f"tension, friction {friction:g}, off by", abs(x.tight / x.exact - 1.0), "1", "<", bound)


def _brushed() -> Iterator[Measurement]:
    ours, fine = brushed(), brushed(*FINE)
    yield Measurement("samples inside the divider without a force", ours.gaps + fine.gaps, "1", "<", 1)
    what = f"impulse, off that of {FINE[0]} elements and steps of {1e3 * FINE[1]:g} ms by"
    yield Measurement(what, abs(ours.impulse / fine.impulse - 1.0), "1", "<", 0.01)
    yield Measurement("peak, off theirs by", abs(ours.peak / fine.peak - 1.0), "1", "<", 0.05)
    told = ours.told / missed(ours, fine)
    yield Measurement("error told of the pressure over that found", told, "1", ">", 1.0 / 3.0)
    yield Measurement("and at most", told, "1", "<", 3.0)


def _rebound() -> Iterator[Measurement]:
    exact = exact_speed(1.0, DAMPING)
    off = [rebound(1.0, DAMPING, 1e6, h).speed / exact - 1.0 for h in STEPS]
    yield Measurement(f"speed after it, steps of {1e3 * STEPS[-1]:g} ms, off by", abs(off[-1]), "1", "<", 1e-3)
    order = float(np.polyfit(np.log(STEPS), np.log(np.abs(off)), 1)[0])
    yield Measurement("order in the step", order, "1", ">", 1.8)
    for stiffness in (1e5, 1e7):
        h = STEPS[-1] * math.sqrt(1e6 / stiffness)
        off_by = abs(rebound(1.0, DAMPING, stiffness, h).speed / exact - 1.0)
        yield Measurement(f"speed after it, stiffness {stiffness:g} N/m^2, off by", off_by, "1", "<", 1e-3)
    deep = [rebound(1.0, DAMPING, k, STEPS[-1] * math.sqrt(1e6 / k)).depth for k in (1e4, 1e6)]
    yield Measurement("order of the depth in 1/stiffness", math.log10(deep[0] / deep[1]) / 2.0, "1", ">", 0.4)
    free = rebound(1.0, 0.0, 1e6, STEPS[-1])
    yield Measurement("energy unexplained without damping, of the kinetic", abs(free.unexplained), "1", "<", 1e-4)


def _struck() -> Iterator[Measurement]:
    for stiffness in (1e5, 1e6):
        x = struck(stiffness)
        what = f"energy unexplained, stiffness {stiffness:g} N/m^2, of the work done"
        yield Measurement(what, abs(x.unexplained) / x.work, "1", "<", 1e-3)


def _crossed() -> Iterator[Measurement]:
    for degrees, bound in ((90.0, 0.03), (30.0, 2e-3), (5.0, 1e-4)):
        yield Measurement(f"force at {degrees:g} degrees, off by", force_error(degrees), "1", "<", bound)


def _turned() -> Iterator[Measurement]:
    smooth, rough = turned(0.0), turned(0.2)
    yield Measurement("angle of the ply, off by", abs(smooth.angle / smooth.exact - 1.0), "1", "<", 0.02)
    for name, x in (("without friction", smooth), ("friction 0.2", rough)):
        growth = np.diff(np.interp(np.arange(1.0, 4.01, 0.25), x.turns, x.torque))
        yield Measurement(f"least growth of the torque per quarter turn, {name}", float(growth.min()), "N m", ">", 0.0)
        stiffer = float(growth[-4:].sum() / growth[:4].sum())
        yield Measurement(f"its growth in the fourth turn over that in the second, {name}", stiffer, "1", ">", 1.0)
        yield Measurement(f"energy unexplained, {name}, of the work done", abs(x.unexplained), "1", "<", 1e-3)
    yield Measurement("times that the legs passed through each other", smooth.crossings + rough.crossings, "1", "<", 1)


def _struck_legs() -> Iterator[Measurement]:
    for stiffness in (1e6, 1e7):
        what = f"energy unexplained, stiffness {stiffness:g} N/m^2, of the work done"
        yield Measurement(what, abs(struck_legs(stiffness)), "1", "<", 1e-3)


def elastica_table() -> Table:
    """The slack rod in PyElastica, which evidence.contact.elastica_rod measures."""
    return read(DOCS / "data" / "contact")["elastica"]


def _slack() -> Iterator[Measurement]:
    theirs, ours = elastica_table(), slack_table()
    coarse, fine = (rows(theirs, elements=float(n)) for n in np.unique(theirs["elements"]))
    buckled, looped = fine["pressed"] < 1.0, fine["pressed"] >= 1.0
    for name in ("torque", "pull"):
        off = np.abs(ours[name] - fine[name])[buckled].max() / np.abs(fine[name][buckled]).max()
        # straight pieces of 0.1 m err by about (l k)^2 / 12, the curvature k being up to 2.5/m
        yield Measurement(f"{name} before it jumps, off PyElastica's by", float(off), "1", "<", 5e-3)
    for name, what in (("torque", "torque"), ("pull", "pull"), ("pressed", "force of the legs")):
        # an error that falls with the square of its elements' length is a third of that
        change = np.abs(coarse[name] - fine[name])[looped]
        off = (np.abs(ours[name] - fine[name])[looped] / change).max()
        said = f"{what} with a loop, off PyElastica's by, of what twice its elements change"
        yield Measurement(said, float(off), "1", "<", 1.0)
    places = max(np.abs(ours[name] - fine[name])[looped].max() for name in ("first", "second"))
    yield Measurement("places where the loop closes, off by", float(places), "m", "<", LENGTH / fine["elements"][0])


def _plectoneme() -> Iterator[Measurement]:
    ours, exact = grown(), soft_rod(grown().found.tension)
    yield Measurement("turns of its strands about each other", ours.turns, "1", ">", 2.0)
    # that strands are soft makes 0.03 to 0.06; the weight grows with what hangs, which tells in the way of the ends
    for name, what, bound in (
        ("torque", "torque", 0.01),
        ("angle", "angle of its helices", 0.01),
        ("nearer", "way of the ends per turn", 0.02),
    ):
        off = getattr(ours.found, name) / getattr(exact, name) - 1.0
        yield Measurement(f"{what}, off the closed form by", abs(off), "1", "<", bound)
    yield Measurement("times that its strands passed through each other", ours.crossings, "1", "<", 1)


def _neighbours() -> Iterator[Measurement]:
    # the law begins softly within a part of the diameter, which the wall has twice
    yield Measurement("places afterwards, off those at a wall midway by", off_the_wall(5e-4), "1", "<", 0.02)
    long, short = (energy_missed(h) for h in (5e-4, 2.5e-4))
    yield Measurement("energy unexplained, steps of 0.25 ms, of the swing's", short, "1", "<", 1e-3)
    yield Measurement("its order in the step", math.log2(long / short), "1", ">", 1.8)


CASES = {
    "a rope that lies on a floor": _touch_down,
    "a rope that falls on a floor": _fallen,
    "a rope pulled half around a divider": _pulled,
    "a leg that brushes a thin divider": _brushed,
    "a rope that strikes a floor flat": _rebound,
    "a loop let down among bodies of every kind": _struck,
    "two strings that cross": _crossed,
    "legs turned slowly about each other": _turned,
    "legs that strike each other": _struck_legs,
    "a slack rod turned until it lies on itself": _slack,
    "a rod in tension wound into a plectoneme": _plectoneme,
    "two neighbouring ropes that swing against each other": _neighbours,
}
